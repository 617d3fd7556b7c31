"""Unsafe findings: edges and nodes in and near obstacles, unknown cells and zones, off the map."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from planner.borders.ground import Ground
from planner.graph_audit.edge_lines import EdgeLines
from planner.graph_audit.findings import FindingList
from planner.graph_audit.unknown_lengths import length_in_cells
from planner.scene import FloatArray, Scene

RADIUS_SLACK = 1e-7
"""A clearance may be less than the radius by this part of it: roadmaps round as much."""
NOTICED = 1e-6
"""Smaller shares of an edge inside obstacles are rounding."""


def judge_edges(
    lines: EdgeLines,
    scene: Scene,
    ground: Ground,
    clearances: FloatArray,
    at: FloatArray,
    radius: float,
    findings: FindingList,
) -> None:
    """Add findings on edges in and near obstacles, off the map, and in unknown cells."""
    inside = _lengths_inside(lines, ground, clearances)
    unknown = scene.unknown if scene.unknown is not None and scene.unknown.mask.any() else None
    for k in _tight(lines, clearances, radius):
        name, line = lines.edges[k].name, lines.lines[k]
        place = (float(at[k, 0]), float(at[k, 1]))
        least = NOTICED * float(lines.lengths[k])
        solid = float(inside.get(k, 0.0))
        if solid <= least:
            findings.add("edge_near_obstacle", "edge", name, place, float(clearances[k]), radius)
            continue
        off = _length_off(line, ground.box)
        unseen = 0.0 if unknown is None else length_in_cells(unknown, line)
        # a turned map's rim is neither unknown nor, in truth, an obstacle
        seen = solid - off - unseen
        for kind, length in (
            ("edge_off_map", off),
            ("edge_in_unknown", unseen),
            ("edge_in_obstacle", seen),
        ):
            if length > least:
                findings.add(kind, "edge", name, place, length, 0.0)


def _tight(lines: EdgeLines, clearances: FloatArray, radius: float) -> list[int]:
    """Edges nearer than the radius; one without length is judged as its node."""
    tight: list[int] = np.flatnonzero(
        (clearances < radius * (1.0 - RADIUS_SLACK)) & (lines.lengths > 0.0)
    ).tolist()
    return tight


def _length_off(line: FloatArray, box: FloatArray) -> float:
    total = 0.0
    for a, b in pairwise(line):
        low, high = 0.0, 1.0
        for axis in range(2):
            step = b[axis] - a[axis]
            if step == 0.0:
                if not box[axis] <= a[axis] <= box[axis + 2]:
                    high = -1.0
                continue
            t = sorted(((box[axis] - a[axis]) / step, (box[axis + 2] - a[axis]) / step))
            low, high = max(low, t[0]), min(high, t[1])
        total += float(np.hypot(*(b - a))) * (1.0 - max(high - low, 0.0))
    return total


def judge_nodes(
    lines: EdgeLines, scene: Scene, ground: Ground, radius: float, findings: FindingList
) -> None:
    """Add findings on nodes in and near obstacles, off the map, and in unknown cells."""
    signed = ground.signed(lines.places)
    for k in np.flatnonzero(signed < radius * (1.0 - RADIUS_SLACK)).tolist():
        x, y = lines.places[k].tolist()
        gap = float(signed[k])
        kind, value, limit = "node_near_obstacle", gap, radius
        if scene.bounds_given and not scene.bounds.contains((x, y)):
            kind, value, limit = "node_off_map", -gap, 0.0
        elif gap < 0.0 and scene.unknown is not None and scene.unknown.holds(x, y):
            kind, value, limit = "node_in_unknown", -gap, 0.0
        elif gap < 0.0:
            kind, value, limit = "node_in_obstacle", -gap, 0.0
        findings.add(kind, "node", lines.node_names[k], (x, y), value, limit)


def _lengths_inside(lines: EdgeLines, ground: Ground, clearances: FloatArray) -> dict[int, float]:
    """Lengths within the ground's obstacles, by edge."""
    touching = np.flatnonzero(clearances <= 0.0).tolist()
    lengths = ground.lengths_inside([lines.lines[k] for k in touching])
    return dict(zip(touching, map(float, lengths), strict=True))


def judge_zones(
    lines: EdgeLines,
    zones: Ground,
    clearances: FloatArray,
    at: FloatArray,
    radius: float,
    findings: FindingList,
) -> None:
    """Add findings on edges and nodes in and near keep-out zones."""
    inside = _lengths_inside(lines, zones, clearances)
    for k in _tight(lines, clearances, radius):
        name, place = lines.edges[k].name, (float(at[k, 0]), float(at[k, 1]))
        length = float(inside.get(k, 0.0))
        if length > NOTICED * lines.lengths[k]:
            findings.add("edge_in_keepout", "edge", name, place, length, 0.0)
        else:
            findings.add("edge_near_keepout", "edge", name, place, float(clearances[k]), radius)
    signed = zones.signed(lines.places)
    for k in np.flatnonzero(signed < radius * (1.0 - RADIUS_SLACK)).tolist():
        x, y = lines.places[k].tolist()
        gap = float(signed[k])
        kind, limit = ("node_in_keepout", 0.0) if gap < 0.0 else ("node_near_keepout", radius)
        findings.add(kind, "node", lines.node_names[k], (x, y), abs(gap), limit)

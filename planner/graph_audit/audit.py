"""The audit: a route graph against a scene, keep-out zones and a robot's radius."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planner.borders.generators import check_radius
from planner.borders.ground import Ground
from planner.graph_audit.edge_lines import EdgeLines, lay_out
from planner.graph_audit.findings import FindingList, GraphFinding, Severity
from planner.graph_audit.nearby import find_nearby
from planner.graph_audit.structure import find_doubles, find_lengths, find_reach, find_taken_ids
from planner.graph_audit.unknown_lengths import length_in_cells
from planner.graph_files.route_graph import RouteEdge, RouteGraph
from planner.path import NoPath
from planner.roadmap.roadmap import build_roadmap
from planner.scene import FloatArray, Scene, Vec

TIGHT = 1e-7
"""A clearance may be less than the radius by this part of it: roadmaps round as much."""
NOTICED = 1e-6
"""Lengths inside obstacles below this part of an edge's are rounding."""


@dataclass(frozen=True, slots=True)
class GraphAudit:
    """Findings, the worst first, and the measured edges.

    ``lines`` are the edges' lines as robots drive them, ``clearances`` (m,) their exact clearances,
    ``places`` (m, 2) where these are least, ``zone_clearances`` (m,) the same to keep-out zones, or
    None. Edges that name a missing node are not measured. Lengths are in the scene's ``units``.
    """

    radius: float
    units: str
    graph: RouteGraph
    findings: tuple[GraphFinding, ...]
    edges: tuple[RouteEdge, ...]
    lines: tuple[FloatArray, ...]
    clearances: FloatArray
    places: FloatArray
    zone_clearances: FloatArray | None

    @property
    def safe(self) -> bool:
        """True if no finding is unsafe."""
        return not self.of("unsafe")

    def of(self, severity: Severity) -> tuple[GraphFinding, ...]:
        """Return the findings of a severity."""
        return tuple(one for one in self.findings if one.severity == severity)

    def __repr__(self) -> str:
        """Return one line; ``findings`` has the rest."""
        counts = ", ".join(f"{len(self.of(s))} {s}" for s in ("unsafe", "error", "warning"))
        return f"<GraphAudit of {len(self.edges)} edges: {counts}>"


def audit(
    graph: RouteGraph,
    scene: Scene,
    radius: float,
    *,
    keepout: Scene | None = None,
    goals: Sequence[Sequence[float]] = (),
    frame: str | None = None,
) -> GraphAudit:
    """Measure every edge of a route graph exactly, and find what is wrong with the graph.

    ``radius`` > 0 is the robot's, in the scene's units; the graph has the same frame and units.
    The objects of ``keepout`` are zones that the robot's body must not enter, see
    :func:`planner.load_mask`. ``goals`` are places (x, y) that a robot must reach from the graph. A
    graph of several frames needs the ``frame`` that the scene has. Raises ``ValueError`` for a
    radius, goal or frame that makes no sense. O(n log n) for n edges that lie near few others.
    """
    size = check_radius(radius)
    places = [_place(i, goal) for i, goal in enumerate(goals)]
    graph = _one_frame(graph, frame)
    findings = FindingList(scene.units)
    find_taken_ids(graph, findings)
    lines = lay_out(graph, size, findings)
    ground = Ground.of(scene, bounds=scene.bounds_given)
    clearances, at = ground.clearances(lines.lines)
    _judge_edges(lines, scene, ground, clearances, at, size, findings)
    _judge_nodes(lines, scene, ground, size, findings)
    zone_clearances = None
    if keepout is not None:
        zones = Ground.of(keepout, bounds=False)
        zone_clearances, near = zones.clearances(lines.lines)
        _judge_zones(lines, zones, zone_clearances, near, size, findings)
    find_doubles(lines, findings)
    find_lengths(lines, size, findings)
    find_nearby(lines, size, findings)
    part = find_reach(lines, findings)
    if places:
        _judge_goals(places, lines, part, scene, ground, size, findings)
    for array in (clearances, at, *lines.lines):
        array.setflags(write=False)
    return GraphAudit(
        size,
        scene.units,
        graph,
        findings.in_order(),
        lines.edges,
        lines.lines,
        clearances,
        at,
        zone_clearances,
    )


def _place(number: int, goal: Sequence[float]) -> Vec:
    x, y = (float(value) for value in goal[:2])
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueError(f"goals[{number}] = ({x:g}, {y:g}): must be finite")
    return x, y


def _one_frame(graph: RouteGraph, frame: str | None) -> RouteGraph:
    frames = graph.frames
    if frame is None and len(frames) > 1:
        raise ValueError(f"the graph has the frames {', '.join(map(repr, frames))}: name the map's")
    if frame is not None and frames and frame not in frames:
        raise ValueError(
            f"frame {frame!r}: the graph has no node in it: must be one of"
            f" {', '.join(map(repr, frames))}"
        )
    return graph if frame is None else graph.within(frame)


def _judge_edges(
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
    """Edges that are nearer than the radius; one without length is judged as its node."""
    tight: list[int] = np.flatnonzero(
        (clearances < radius * (1.0 - TIGHT)) & (lines.lengths > 0.0)
    ).tolist()
    return tight


def _length_off(line: FloatArray, box: FloatArray) -> float:
    """Length of a line outside a box, exact."""
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


def _judge_nodes(
    lines: EdgeLines, scene: Scene, ground: Ground, radius: float, findings: FindingList
) -> None:
    signed = ground.signed(lines.places)
    for k in np.flatnonzero(signed < radius * (1.0 - TIGHT)).tolist():
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
    """Lengths within the ground's obstacles, by edge, of the edges that touch one."""
    touching = np.flatnonzero(clearances <= 0.0).tolist()
    lengths = ground.lengths_inside([lines.lines[k] for k in touching])
    return dict(zip(touching, map(float, lengths), strict=True))


def _judge_zones(
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
    for k in np.flatnonzero(signed < radius * (1.0 - TIGHT)).tolist():
        x, y = lines.places[k].tolist()
        gap = float(signed[k])
        kind, limit = ("node_in_keepout", 0.0) if gap < 0.0 else ("node_near_keepout", radius)
        findings.add(kind, "node", lines.node_names[k], (x, y), abs(gap), limit)


def _judge_goals(
    goals: Sequence[Vec],
    lines: EdgeLines,
    part: set[int],
    scene: Scene,
    ground: Ground,
    radius: float,
    findings: FindingList,
) -> None:
    """Add findings on goals to which no path leads from the nearest safe node of the graph."""
    nodes = sorted(part)
    places = lines.places[nodes].reshape(-1, 2)
    places = places[ground.signed(places) >= radius * (1.0 - TIGHT)]
    roadmap = None
    for goal in goals:
        reason = "no node of its largest part is safe"
        if len(places):
            if roadmap is None:
                roadmap = build_roadmap(scene, radius * (1.0 - TIGHT))
            x, y = places[np.argmin(np.hypot(*(places - goal).T))].tolist()
            answer = roadmap.plan((x, y), goal)
            if not isinstance(answer, NoPath):
                continue
            reason = answer.reason
        findings.add("goal_unreachable", "goal", f"({goal[0]:g}, {goal[1]:g})", goal, other=reason)

"""The judge of tight turns: every pair of edges at every node."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from benchmarks.audit.distances import HALF_DIAGONAL, SIDE_M, Distances, Verdict, samples
from benchmarks.audit.planted import RADIUS_M, Point
from planner.graph_files.route_graph import RouteEdge

TURNING_M: Final = 0.4
SLACK: Final = 1e-4
Line = tuple[Point, Point]


def judge_turns(
    verdict: Verdict, edges: list[RouteEdge], lines: list[Line], solid: Distances, zones: Distances
) -> None:
    """Judge each turn from edge to edge: an arc that touches both, long enough and clear."""
    for i, into in enumerate(edges):
        a, b = lines[i]
        if not (a != b).any():
            continue
        outs = [k for k, edge in enumerate(edges) if edge.start == into.end]
        others = [k for k in outs if (lines[k][1] != a).any()] or outs
        for k in others:
            c = lines[k][1]
            if not (b != c).any():
                continue
            sure, perhaps = _tight(a, b, c, solid, zones)
            if perhaps:
                verdict.add("turn_too_tight", into.end, sure)


def _tight(a: Point, b: Point, c: Point, solid: Distances, zones: Distances) -> tuple[bool, bool]:
    """True twice if the turn a b c surely, and if it perhaps, is too tight."""
    before, after = (b - a) / math.dist(a, b), (c - b) / math.dist(b, c)
    angle = math.acos(float(np.clip(before @ after, -1.0, 1.0)))
    if angle < 1e-5:
        return False, angle > 1e-7
    shorter = min(math.dist(a, b), math.dist(b, c))
    needed = TURNING_M * math.tan(0.5 * angle)
    if needed > shorter * (1.0 - SLACK):
        return needed > shorter * (1.0 + SLACK), True
    # the centre lies on the bisector of the corner
    inward = after - before
    centre = b + inward / np.hypot(*inward) * TURNING_M / math.cos(0.5 * angle)
    ends = b - needed * before - centre, b + needed * after - centre
    t = np.linspace(0.0, 1.0, max(3, math.ceil(angle * TURNING_M / (0.5 * SIDE_M))))[:, None]
    # spherical interpolation between the arms
    arc = centre + (np.sin((1.0 - t) * angle) * ends[0] + np.sin(t * angle) * ends[1]) / math.sin(
        angle
    )
    low, high = _least([arc], solid, zones)
    corner = np.concatenate([samples(a, b)[0], samples(b, c)[0]])
    corner_low, corner_high = _least([corner], solid, zones)
    # a corner that is itself too near is for the edges' findings
    sure = high < min(RADIUS_M, corner_low) - SIDE_M
    return sure, low < min(RADIUS_M, corner_high) + SIDE_M


def _least(lines: list[Point], solid: Distances, zones: Distances) -> tuple[float, float]:
    """Bounds of the least distance of points to obstacles and zones."""
    points = np.concatenate(lines)
    least = min(float(one.between[one.index(points)].min()) for one in (solid, zones))
    if least == 0.0:
        return 0.0, 0.0
    return least - 2.0 * HALF_DIAGONAL - SIDE_M / 2, least - SIDE_M / 2 + HALF_DIAGONAL

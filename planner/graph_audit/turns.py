"""Turns that are too tight for a robot with a turning radius R.

- A turn by the angle t is driven as an arc of radius R that touches both pieces. It takes R tan(t /
  2) of each, and is too tight if a piece is shorter, or if the arc comes nearer to an obstacle than
  the robot's radius.
- Within an edge's line, the arcs at both ends of a piece must fit on it together; at a node, other
  arcs depend on the route and do not count.
- Turning back along the same line is no turn, unless there is no other edge.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from planner.borders.ground import Ground
from planner.borders.polyline import moves
from planner.graph_audit.edge_lines import EdgeLines
from planner.graph_audit.findings import FindingList
from planner.graph_audit.unsafe import RADIUS_SLACK
from planner.scene import FloatArray, Vec

STRAIGHT_RAD = 1e-6
"""Turns up to this angle are rounding."""
MEASURED_STEP_RAD = 0.05
"""Angle between the points at which an arc is measured; its chords leave it by 0.03 % of R."""


def find_tight_turns(
    lines: EdgeLines, ground: Ground, radius: float, turning_radius: float, findings: FindingList
) -> None:
    """Add findings on turns within edges and from edge to edge."""
    if turning_radius == 0.0:
        return
    limit = turning_radius * (1.0 - RADIUS_SLACK)
    for k in lines.once():
        edge, line = lines.edges[k], lines.lines[k][moves(lines.lines[k])]
        for at, widest in _bends(line, ground, radius, limit):
            findings.add("edge_bends_tightly", "edge", edge.name, at, widest, turning_radius)
    for e, f, node in _turns(lines):
        line, after = (one[moves(one)] for one in (e[1], f[1]))
        if len(line) < 2 or len(after) < 2:
            continue
        corner = np.array([line[-2], line[-1], after[1]])
        widest = _widest(corner, ground, radius, limit)
        if widest < limit:
            at = (float(line[-1, 0]), float(line[-1, 1]))
            names = lines.edges[e[0]].name, lines.edges[f[0]].name
            words = f"from edge {names[0]} to edge {names[1]}"
            name = lines.node_names[node]
            findings.add("turn_too_tight", "node", name, at, widest, turning_radius, words)


Driven = tuple[int, FloatArray]
"""An edge's number, and its line in the direction driven."""


def _turns(lines: EdgeLines) -> Iterator[tuple[Driven, Driven, int]]:
    """Yield edge, next edge and node of every turn, in one of its two directions."""
    arriving: dict[int, list[Driven]] = {}
    leaving: dict[int, list[Driven]] = {}
    for k, (edge, line) in enumerate(zip(lines.edges, lines.lines, strict=True)):
        a, b = lines.ends[k].tolist()
        ways = [(a, b, line)]
        if edge.both_ways:
            ways.append((b, a, np.ascontiguousarray(line[::-1])))
        for start, end, way in ways:
            arriving.setdefault(end, []).append((k, way))
            leaving.setdefault(start, []).append((k, way))
    done: set[tuple[int, bytes, bytes]] = set()
    for node, ins in arriving.items():
        for e, line in ins:
            outs = leaving.get(node, [])
            others = [one for one in outs if not np.array_equal(one[1], line[::-1])]
            for f, after in others or outs:
                own = (node, line.tobytes(), after.tobytes())
                back = (node, after[::-1].tobytes(), line[::-1].tobytes())
                if own not in done and back not in done:
                    done.add(own)
                    yield (e, line), (f, after), node


def _bends(
    line: FloatArray, ground: Ground, radius: float, limit: float
) -> Iterator[tuple[Vec, float]]:
    """Yield place and widest radius of the bends that are too tight."""
    if len(line) < 3:
        return
    tangents = np.array([_tangent(line[k - 1 : k + 2]) for k in range(1, len(line) - 1)])
    lengths = np.hypot(*np.diff(line, axis=0).T)
    shares = np.concatenate([[0.0], tangents, [0.0]])
    # arcs at both ends share a piece in proportion to what they need
    needed = np.array([a + b for a, b in pairwise(shares)])
    scale = np.where(needed > 0.0, lengths / np.where(needed > 0.0, needed, 1.0), np.inf)
    for k in range(1, len(line) - 1):
        widest = float(min(scale[k - 1], scale[k]))
        if widest >= limit and not _arc_is_clear(line[k - 1 : k + 2], ground, radius, limit):
            widest = 0.0
        if widest < limit:
            yield (float(line[k, 0]), float(line[k, 1])), widest


def _widest(corner: FloatArray, ground: Ground, radius: float, limit: float) -> float:
    """Largest radius that fits on the pieces; 0 if the arc with the limit is not clear."""
    tangent = _tangent(corner)
    if tangent == 0.0:
        return math.inf
    widest = float(np.hypot(*np.diff(corner, axis=0).T).min() / tangent)
    if widest >= limit and not _arc_is_clear(corner, ground, radius, limit):
        return 0.0
    return widest


def _angle(corner: FloatArray) -> float:
    u, v = np.diff(corner, axis=0)
    return math.atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])


def _tangent(corner: FloatArray) -> float:
    angle = abs(_angle(corner))
    return 0.0 if angle <= STRAIGHT_RAD else math.tan(0.5 * angle)


def _arc_is_clear(corner: FloatArray, ground: Ground, radius: float, turning: float) -> bool:
    """True if the arc at a corner keeps the radius, or is no worse than the corner itself."""
    angle = _angle(corner)
    if abs(angle) <= STRAIGHT_RAD:
        return True
    u = corner[1] - corner[0]
    u = u / np.hypot(*u)
    begin = corner[1] - turning * math.tan(0.5 * abs(angle)) * u
    side = math.copysign(1.0, angle)
    centre = begin + side * turning * np.array((-u[1], u[0]))
    count = max(3, math.ceil(abs(angle) / MEASURED_STEP_RAD) + 1)
    turned = np.linspace(0.0, angle, count)
    cos, sin = np.cos(turned)[:, None], np.sin(turned)[:, None]
    arm = begin - centre
    arc = centre + cos * arm + sin * np.array((-arm[1], arm[0]))
    least = min(radius, float(ground.clearances([corner])[0][0]))
    # chords of the arc lie inside of it
    slack = turning * (1.0 - math.cos(0.5 * abs(angle) / (count - 1)))
    return float(ground.clearances([arc])[0][0]) >= least * (1.0 - RADIUS_SLACK) - slack

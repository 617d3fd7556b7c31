"""Rounds a path's corners inside the free corridor, and proves the clearance again.

A corner is cut from a point before it to a point after it by a parabola that leaves and joins
the path along its own directions (a quadratic Bezier curve: its control point is where the two
tangents meet). The sharpest corners come first. A cut begins as long as the cuts beside it
allow and is halved until the exact clearance of the new piece is enough; where even the
shortest is not, the corner stays. For a robot with a turning radius cuts are arcs of at least
that radius, and a corner without room for one stays, to be turned on the spot.
Nothing is sampled: the clearance is that of the whole new polyline against every border, by the
callable that is given.

Units are the scene's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import numpy as np

from planner.path import Path
from planner.polyline import arc_lengths, fewer_vertices, points_at
from planner.scene import FloatArray, Vec

CORNER_RAD = math.radians(3.0)
"""A smaller turn is no corner: the samples of a smooth bisector turn less."""
LONGEST_CUT = 4.0
"""Robot radii before and after a corner: what lies further does not feel the corner."""
LONGEST_BEND = 2.0
"""The same in turning radii, where that is more: right angles take one."""
BEND_SPARE = 0.05
"""An arc is so much wider than the tightest that is asked for."""
HALVINGS = 7
SIMPLIFY = 0.01
"""Corners are sought on the path simplified within this part of the robot's radius."""
CURVE_TOLERANCE = 0.002
"""How far the chords may leave the parabola, as a part of the robot's radius."""

ROUNDING = 1e-12
"""A line cut in two may measure this part of its coordinates nearer than whole."""


class SmoothError(ValueError):
    """The path cannot be smoothed as asked; the message says why."""


class LeastClearance(Protocol):
    """The least clearance of a polyline and where it is, as ``Roadmap.path_clearance`` tells."""

    @property
    def distance(self) -> float:
        """The exact distance to the nearest border or wall."""
        ...

    @property
    def at(self) -> Vec:
        """The point of the polyline where it is."""
        ...


PathClearance = Callable[[FloatArray], LeastClearance]
PointClearance = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, slots=True)
class _Cut:
    """A stretch of the path, by lengths, and the points that replace it."""

    begin: float
    end: float
    points: FloatArray


def smooth_path(
    path: Path,
    path_clearance: PathClearance,
    clearance: PointClearance,
    *,
    keep: float | None = None,
    turning_radius: float = 0.0,
) -> Path:
    """The path with its corners rounded; stations stay where they are.

    ``keep`` is the clearance that every changed piece must have, or what the piece that it replaces
    had where that is less: the path's own least clearance where None. It is never less than the
    robot's radius, but for a path that is nearer by rounding. The answer's clearances are computed
    again. Alternatives are smoothed too. Raises :class:`SmoothError` where ``keep`` is below the
    radius or not finite.
    """
    floor = path.min_clearance if keep is None else keep
    radius = min(path.robot_radius, path.min_clearance)
    if not (math.isfinite(floor) and floor >= radius * (1.0 - 1e-9)):
        raise SmoothError(
            f"keep = {floor:g}: must be finite and >= the robot's radius {path.robot_radius:g}"
        )
    if not (math.isfinite(turning_radius) and turning_radius >= 0.0):
        raise SmoothError(f"turning_radius = {turning_radius:g}: must be >= 0 and finite")
    pieces = [path.points[:1]]
    stations = [0]
    for a, b in pairwise(path.stations):
        leg = _smooth_leg(
            path.points[a : b + 1], path.robot_radius, floor, path_clearance, turning_radius
        )
        pieces.append(leg[1:])
        stations.append(stations[-1] + len(leg) - 1)
    points = np.concatenate(pieces)
    least = path_clearance(points)
    rounding = ROUNDING * float(np.abs(points).max())
    lowest = max(min(floor, path.min_clearance) - rounding, radius)
    if least.distance < lowest:
        return path
    clearances = np.array(clearance(points), dtype=np.float64)
    for array in (points, clearances):
        array.setflags(write=False)
    return replace(
        path,
        points=points,
        clearances=clearances,
        length=float(arc_lengths(points)[-1]),
        min_clearance=float(least.distance),
        min_clearance_at=(float(least.at[0]), float(least.at[1])),
        stations=tuple(stations),
        alternatives=tuple(
            smooth_path(other, path_clearance, clearance, turning_radius=turning_radius)
            for other in path.alternatives
        ),
    )


def _smooth_leg(
    points: FloatArray,
    radius: float,
    floor: float,
    path_clearance: PathClearance,
    turning_radius: float,
) -> FloatArray:
    """One stretch between stations, corner after corner."""
    if len(points) < 3:
        return points
    lengths = arc_lengths(points)
    kept = fewer_vertices(points, SIMPLIFY * radius)
    steps = np.diff(points[kept], axis=0)
    direction = np.arctan2(steps[:, 1], steps[:, 0])
    turns = np.abs(math.pi - np.mod(math.pi - np.diff(direction), math.tau))
    sharpest = np.argsort(-turns, kind="stable")
    cuts: list[_Cut] = []
    for k in sharpest[turns[sharpest] > CORNER_RAD]:
        corner = float(lengths[kept[k + 1]])
        longest = max(LONGEST_CUT * radius, LONGEST_BEND * turning_radius)
        reach = min(_room(corner, cuts, float(lengths[-1])), longest)
        cut = _round_corner(
            points, lengths, corner, reach, radius, floor, path_clearance, turning_radius
        )
        if cut is not None:
            cuts.append(cut)
    return _with_cuts(points, lengths, sorted(cuts, key=lambda cut: cut.begin))


def _room(corner: float, cuts: list[_Cut], length: float) -> float:
    """How far a cut may reach to either side before it meets another one or the leg's end."""
    room = min(corner, length - corner)
    for cut in cuts:
        if cut.begin <= corner <= cut.end:
            return 0.0
        room = min(room, abs(corner - cut.begin), abs(corner - cut.end))
    return room


def _round_corner(
    points: FloatArray,
    lengths: FloatArray,
    corner: float,
    reach: float,
    radius: float,
    floor: float,
    path_clearance: PathClearance,
    turning_radius: float,
) -> _Cut | None:
    """The longest cut whose clearance is proved, None where there is none."""
    tolerance = CURVE_TOLERANCE * radius
    for _ in range(HALVINGS):
        if reach <= tolerance:
            return None
        if turning_radius > 0.0:
            curve = _bend(points, lengths, corner, reach, tolerance, turning_radius)
        else:
            curve = _parabola(points, lengths, corner, reach, tolerance)
        if curve is not None and path_clearance(curve).distance >= floor:
            return _Cut(corner - reach, corner + reach, curve)
        reach *= 0.5
    return None


def _tangents(
    points: FloatArray, lengths: FloatArray, corner: float, reach: float
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """The place ``reach`` before the corner, the one after it, and where their tangents meet.

    None where the tangents do not meet ahead of the first and behind the other.
    """
    begin, end = corner - reach, corner + reach
    a, b = points_at(points, lengths, np.array([begin, end]))
    first = min(int(np.searchsorted(lengths, begin, side="right")), len(points) - 1)
    last = max(int(np.searchsorted(lengths, end, side="left")), 1)
    leave, join = points[first] - points[first - 1], points[last] - points[last - 1]
    cross = float(leave[0] * join[1] - leave[1] * join[0])
    scale = float(np.hypot(*leave) * np.hypot(*join))
    if scale == 0.0 or abs(cross) <= 1e-9 * scale:
        return None
    gap = b - a
    ahead = float(gap[0] * join[1] - gap[1] * join[0]) / cross
    back = float(leave[0] * gap[1] - leave[1] * gap[0]) / cross
    if ahead <= 0.0 or back <= 0.0:
        return None
    return a, b, a + ahead * leave


def _parabola(
    points: FloatArray, lengths: FloatArray, corner: float, reach: float, tolerance: float
) -> FloatArray | None:
    """From ``reach`` before the corner to ``reach`` after it, tangent to the path at both.

    None where the tangents do not meet ahead of both ends, or where the curve is longer than
    what it replaces.
    """
    met = _tangents(points, lengths, corner, reach)
    if met is None:
        return None
    a, b, control = met
    # the chords of a parabola in n equal steps leave it by |a - 2 c + b| / (4 n^2)
    bend = float(np.hypot(*(a - 2.0 * control + b)))
    count = max(2, math.ceil(math.sqrt(bend / (4.0 * tolerance))))
    t = np.linspace(0.0, 1.0, min(count, 256) + 1)[:, None]
    curve: FloatArray = (1 - t) ** 2 * a + 2 * t * (1 - t) * control + t**2 * b
    return curve if arc_lengths(curve)[-1] <= 2.0 * reach else None


def _bend(
    points: FloatArray,
    lengths: FloatArray,
    corner: float,
    reach: float,
    tolerance: float,
    least_radius: float,
) -> FloatArray | None:
    """An arc of at least ``least_radius`` that joins both tangents, and what is left of them.

    From ``reach`` before the corner to ``reach`` after it; None where the tangents have no room
    for the arc, or where that would be longer than what it replaces.
    """
    met = _tangents(points, lengths, corner, reach)
    if met is None:
        return None
    a, b, control = met
    before, after = control - a, b - control
    room = min(float(np.hypot(*before)), float(np.hypot(*after)))
    leave, join = before / np.hypot(*before), after / np.hypot(*after)
    turn = math.atan2(leave[0] * join[1] - leave[1] * join[0], float(leave @ join))
    radius = room / math.tan(0.5 * abs(turn))
    # driven in chords, an arc is bent a little more than it is
    if radius < least_radius * (1.0 + BEND_SPARE):
        return None
    count = max(2, math.ceil(abs(turn) / math.sqrt(8.0 * tolerance / radius)))
    begin = control - room * leave
    side = np.array([-leave[1], leave[0]]) * math.copysign(1.0, turn)
    angle = np.linspace(0.0, abs(turn), min(count, 256) + 1)[:, None]
    arc = begin + radius * (np.sin(angle) * leave + (1.0 - np.cos(angle)) * side)
    curve = np.concatenate([a[None], arc, b[None]])
    curve = curve[np.concatenate([[True], np.hypot(*np.diff(curve, axis=0).T) > 1e-9 * radius])]
    return curve if arc_lengths(curve)[-1] <= 2.0 * reach else None


def _with_cuts(points: FloatArray, lengths: FloatArray, cuts: list[_Cut]) -> FloatArray:
    pieces = []
    done = -1.0
    for cut in cuts:
        pieces.append(points[(lengths > done) & (lengths < cut.begin)])
        pieces.append(cut.points)
        done = cut.end
    pieces.append(points[lengths > done])
    joined = np.concatenate(pieces)
    if lengths[-1] - done <= 0.0:
        joined = np.concatenate([joined, points[-1:]])
    moved = np.concatenate([[True], np.any(np.diff(joined, axis=0) != 0.0, axis=1)])
    result: FloatArray = joined[moved]
    return result

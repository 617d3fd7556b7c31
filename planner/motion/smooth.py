"""Rounded corners of a path inside the free corridor, with the clearance proved again.

A parabola cuts each corner, tangent to the path at both ends (a quadratic Bezier curve). The
sharpest corners come first. A cut begins with the greatest length that adjacent cuts allow, and is
halved until the exact clearance of the new piece suffices; if even the shortest fails, the corner
stays. For a robot with a turning radius, cuts are arcs of at least that radius; a corner without
room for one is turned on the spot. Units are the scene's.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import numpy as np

from planner.borders.polyline import arc_lengths, fewer_vertices, moves, points_at
from planner.motion.smooth_kernels import bend, parabola
from planner.path import Path
from planner.route.plan_request import preference_of
from planner.scene import FloatArray, Vec
from planner.shared.angles import wrap_angle
from planner.shared.arguments import as_float, of_kind

CORNER_RAD = math.radians(3.0)
"""A smaller turn is no corner: the samples of a smooth bisector turn less."""
LONGEST_CUT = 4.0
"""Robot radii before and after a corner: what lies further does not feel the corner."""
LONGEST_BEND = 2.0
"""The same in turning radii, where that is more: right angles take one."""
CUT_TRIES = 7
SIMPLIFY = 0.01
"""Corners are sought on the path simplified within this part of the robot's radius."""
CURVE_TOLERANCE = 0.002
"""Largest gap between the parabola and its chords, as a part of the robot's radius."""

LENGTH_ROUNDING = 1e-12
"""A line cut in two may measure this part of its coordinates nearer than whole."""


class SmoothError(ValueError):
    """A path that cannot be smoothed as asked; the message says why."""


class LeastClearance(Protocol):
    """The least clearance of a polyline and its place, as ``Roadmap.path_clearance`` reports."""

    @property
    def distance(self) -> float:
        """Exact distance to the nearest border or wall."""
        ...

    @property
    def at(self) -> Vec:
        """Place of this clearance."""
        ...


class Measured(Protocol):
    """The part of a :class:`planner.Roadmap` that measures paths."""

    @property
    def radius(self) -> float:
        """The robot's radius."""
        ...

    def path_clearance(self, polyline: FloatArray, /) -> LeastClearance:
        """Return the least clearance of a polyline (n, 2)."""
        ...

    def clearance(self, points: FloatArray, /) -> FloatArray:
        """Return the clearances (n,) of points (n, 2)."""
        ...

    def permits(self, polyline: FloatArray, keep: float, /) -> bool:
        """Return True if no zone forbids a polyline (n, 2) that keeps a distance from zones."""
        ...


PathClearance = Callable[[FloatArray], LeastClearance]
PointClearance = Callable[[FloatArray], FloatArray]
Permits = Callable[[FloatArray, float], bool]


def _always(_line: FloatArray, _keep: float) -> bool:
    return True


@dataclass(frozen=True, slots=True)
class _Cut:
    """A stretch of the path, by lengths, and the points that replace it."""

    begin: float
    end: float
    points: FloatArray


@dataclass(frozen=True, slots=True)
class _Rules:
    """Clearance of cuts: ``floor``, or if the path is ``nearer``, that of the piece replaced."""

    radius: float
    floor: float
    nearer: bool
    path_clearance: PathClearance
    turning_radius: float
    permits: Permits


def round_corners(
    path: Path,
    roadmap: Measured,
    *,
    prefer: str | float = "balanced",
    margin: float = 0.0,
    turning_radius: float = 0.0,
) -> Path:
    """Return the planned path with rounded corners, as ``clearway plan`` prints and times it.

    ``prefer`` and ``margin`` are as in ``roadmap.plan``, the source of ``path``. A preference for
    clearance keeps all of the path's least clearance, one for length only the radius and margin;
    between them a part of the difference may go. ``turning_radius`` is the robot's tightest bend.
    Length and clearances are measured again, also of the alternatives, which keep all of theirs.
    Raises ``ValueError`` on invalid options.
    """
    of_kind("path", path, Path)
    if not hasattr(roadmap, "path_clearance"):
        raise TypeError(f"roadmap is a {type(roadmap).__name__}: must be a Roadmap")
    bend_radius = as_float("turning_radius", turning_radius)
    spare = as_float("margin", margin)
    if not 0.0 <= spare < math.inf:
        raise SmoothError(f"margin = {margin}: must be >= 0 and finite")
    need = roadmap.radius + spare
    keep = need + preference_of(prefer) * max(path.min_clearance - need, 0.0)
    return smooth_path(
        path,
        roadmap.path_clearance,
        roadmap.clearance,
        keep=keep,
        turning_radius=bend_radius,
        permits=roadmap.permits,
    )


def smooth_path(
    path: Path,
    path_clearance: PathClearance,
    clearance: PointClearance,
    *,
    keep: float | None = None,
    turning_radius: float = 0.0,
    permits: Permits = _always,
) -> Path:
    """Return the path with rounded corners; stations stay in place.

    ``keep`` is the clearance of every changed piece, or that of the piece replaced if smaller; None
    means the path's own least clearance. It is at least the robot's radius, unless the path is
    nearer by rounding. ``permits`` is asked for every changed piece and for the whole, with the
    distance to keep, as in :class:`Measured`. Clearances are measured again; alternatives are
    smoothed too. Raises :class:`SmoothError` if ``keep`` is below the radius or not finite.
    """
    floor = path.min_clearance if keep is None else keep
    radius = min(path.robot_radius, path.min_clearance)
    if not (math.isfinite(floor) and floor >= radius * (1.0 - 1e-9)):
        raise SmoothError(
            f"keep = {floor:g}: must be finite and >= the robot's radius {path.robot_radius:g}"
        )
    if not (math.isfinite(turning_radius) and turning_radius >= 0.0):
        raise SmoothError(f"turning_radius = {turning_radius:g}: must be >= 0 and finite")
    rules = _Rules(
        path.robot_radius, floor, floor > path.min_clearance, path_clearance, turning_radius,
        permits,
    )  # fmt: skip
    pieces = [path.points[:1]]
    stations = [0]
    for a, b in pairwise(path.stations):
        leg = _smooth_leg(path.points[a : b + 1], rules)
        pieces.append(leg[1:])
        stations.append(stations[-1] + len(leg) - 1)
    points = np.concatenate(pieces)
    least = path_clearance(points)
    rounding = LENGTH_ROUNDING * float(np.abs(points).max())
    lowest = max(min(floor, path.min_clearance) - rounding, radius)
    if least.distance < lowest or not permits(points, radius):
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
            smooth_path(
                other, path_clearance, clearance, turning_radius=turning_radius, permits=permits
            )
            for other in path.alternatives
        ),
    )


def _smooth_leg(points: FloatArray, rules: _Rules) -> FloatArray:
    """Smooth one stretch between stations, corner by corner. O(n log n)."""
    if len(points) < 3:
        return points
    points = np.ascontiguousarray(points, dtype=np.float64)
    lengths = arc_lengths(points)
    kept = fewer_vertices(points, SIMPLIFY * rules.radius)
    steps = np.diff(points[kept], axis=0)
    direction = np.arctan2(steps[:, 1], steps[:, 0])
    turns = np.abs(wrap_angle(np.diff(direction)))
    sharpest = np.argsort(-turns, kind="stable")
    longest = max(LONGEST_CUT * rules.radius, LONGEST_BEND * rules.turning_radius)
    begins: list[float] = []
    cuts: list[_Cut] = []
    for k in sharpest[turns[sharpest] > CORNER_RAD]:
        corner = float(lengths[kept[k + 1]])
        after = bisect_right(begins, corner)
        reach = min(_free_length(corner, cuts, after, float(lengths[-1])), longest)
        cut = _round_corner(points, lengths, corner, reach, rules)
        if cut is not None:
            begins.insert(after, cut.begin)
            cuts.insert(after, cut)
    return _with_cuts(points, lengths, cuts)


def _free_length(corner: float, cuts: list[_Cut], after: int, length: float) -> float:
    """Largest reach of a cut to either side.

    ``after``: number of the first of the ordered ``cuts`` beyond the corner.
    """
    free = min(corner, length - corner)
    if after > 0:
        free = min(free, max(corner - cuts[after - 1].end, 0.0))
    if after < len(cuts):
        free = min(free, cuts[after].begin - corner)
    return free


def _round_corner(
    points: FloatArray, lengths: FloatArray, corner: float, reach: float, rules: _Rules
) -> _Cut | None:
    """Return the longest cut with proved clearance, or None."""
    tolerance = CURVE_TOLERANCE * rules.radius
    for _ in range(CUT_TRIES):
        if reach <= tolerance:
            return None
        if rules.turning_radius > 0.0:
            curve = bend(points, lengths, corner, reach, tolerance, rules.turning_radius)
        else:
            curve = parabola(points, lengths, corner, reach, tolerance)
        wide = len(curve) > 0 and _is_wide(curve, points, lengths, corner, reach, rules)
        if wide and rules.permits(curve, rules.floor):
            return _Cut(corner - reach, corner + reach, curve)
        reach *= 0.5
    return None


def _is_wide(
    curve: FloatArray,
    points: FloatArray,
    lengths: FloatArray,
    corner: float,
    reach: float,
    rules: _Rules,
) -> bool:
    """True if the curve has the clearance of ``rules``."""
    gap = rules.path_clearance(curve).distance
    if gap >= rules.floor or not rules.nearer:
        return gap >= rules.floor
    begin, end = corner - reach, corner + reach
    inner = slice(*np.searchsorted(lengths, [begin, end], side="right").tolist())
    a, b = points_at(points, lengths, np.array([begin, end]))
    return gap >= rules.path_clearance(np.concatenate([a[None], points[inner], b[None]])).distance


def _with_cuts(points: FloatArray, lengths: FloatArray, cuts: list[_Cut]) -> FloatArray:
    pieces = []
    done = 0
    for cut in cuts:
        pieces.append(points[done : np.searchsorted(lengths, cut.begin, side="left")])
        pieces.append(cut.points)
        done = int(np.searchsorted(lengths, cut.end, side="right"))
    pieces.append(points[done:])
    if done == len(points):
        pieces.append(points[-1:])
    joined = np.concatenate(pieces)
    result: FloatArray = joined[moves(joined)]
    return result

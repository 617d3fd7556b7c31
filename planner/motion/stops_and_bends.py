"""A path cut into legs at the robot's stops, with the limits between them.

- A corner of the path becomes a bend that leaves it by ``chord_tolerance``. The heading turns
  evenly from t before to t after it, ``EVEN`` of t = tolerance / tan(turn / 4) (at most half way to
  the next corner), and is averaged ``ease`` before and after, so that the curvature grows and falls
  evenly. The speed keeps the angular rate and the lateral and angular acceleration. Where it would
  be a crawl, or the bend tighter than the turning radius, a robot that can turn on the spot stops.
- Lengths are measured along a leg, from 0, in the scene's units.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planner.borders.polyline import arc_lengths, fewer_vertices, moves, points_at
from planner.path import Limits, Path
from planner.scene import FloatArray, IntArray
from planner.shared.angles import wrap_angle

Clearance = Callable[[FloatArray], FloatArray]
SpeedLimits = Callable[[FloatArray, FloatArray], FloatArray]

SHARP_TURN_RAD = math.radians(15.0)
"""A robot never stops for less of a turn than this."""
CRAWL = 0.25
"""A sharp corner that allows less than this part of the speed is turned on the spot."""
BEND_ROUNDING = 1e-6
"""A bend is as wide as the turning radius within this part of it."""
EVEN = 0.75
"""A corner turned evenly over this part of t, and then averaged, leaves the path no further."""
ANGULAR_SHARE = 0.5
"""The part of the angular acceleration for bends that begin and end; the rest for the speed's."""
_CELLS_PER_SPACING = 16
_LEAST_CELLS = 32
_MOST_CELLS = 20_000
_LEAST_WAYPOINTS = 4
"""Chords between two stops, so that a follower sees the speed rise and fall between them."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """A stretch between two stops: dense points, the heading's corners, stations passed."""

    points: FloatArray
    lengths: FloatArray
    clearances: FloatArray
    turn_at: FloatArray  # lengths at which the heading before averaging changes slope
    heading: FloatArray  # there, unwrapped
    ease: float  # half-width of the heading's averaging
    forced: FloatArray  # lengths that need a waypoint
    stations: dict[float, int]  # length -> station passed without a stop

    def headings(self, at: FloatArray) -> FloatArray:
        """Averaged, unwrapped heading at lengths ``at`` from 0 to the leg's.

        Mirroring it beyond the ends keeps it at the ends.
        """
        knots, values = self._beyond()
        steps = np.diff(knots)
        area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * steps)])
        low, high = (_integral(knots, values, area, at + d) for d in (-self.ease, self.ease))
        return (high - low) / (2.0 * self.ease)

    def curvatures(self, at: FloatArray) -> FloatArray:
        """Signed slope of the averaged heading: linear between the :meth:`breaks`."""
        knots, values = self._beyond()
        low, high = (np.interp(at + d, knots, values) for d in (-self.ease, self.ease))
        slopes: FloatArray = (high - low) / (2.0 * self.ease)
        return slopes

    def breaks(self) -> FloatArray:
        """Lengths at which the curvature's slope changes."""
        knots, _ = self._beyond()
        both = np.concatenate([knots - self.ease, knots + self.ease])
        inside: FloatArray = both[(both > 0.0) & (both < self.lengths[-1])]
        return inside

    def _beyond(self) -> tuple[FloatArray, FloatArray]:
        """The heading before averaging, mirrored beyond both ends."""
        at, value = self.turn_at, self.heading
        knots = [-at[:0:-1], at, 2.0 * at[-1] - at[-2::-1]]
        values = [2.0 * value[0] - value[:0:-1], value, 2.0 * value[-1] - value[-2::-1]]
        return np.concatenate(knots), np.concatenate(values)


@dataclass(frozen=True, slots=True)
class Stop:
    """A place of rest: a station, a sharp corner or an end."""

    vertex: int
    station: int | None
    heading: float | None
    dwell_s: float


class CutPath:
    """The path without repeated points, cut into legs at its stops."""

    def __init__(
        self,
        path: Path,
        limits: Limits,
        clearance: Clearance | None,
        dwells: tuple[float, ...],
        allowed: SpeedLimits | None = None,
    ) -> None:
        self.path = path
        self.limits = limits
        self.exact_clearance = clearance
        self.allowed = allowed
        self.slack = max(path.min_clearance - path.robot_radius, 0.0)
        points = np.asarray(path.points, dtype=np.float64).reshape(-1, 2)
        keep = moves(points)
        new_index = np.cumsum(keep) - 1
        self.points = points[keep]
        self.lengths = arc_lengths(self.points)
        self.clearances = np.asarray(path.clearances, dtype=np.float64)[keep]
        self.station_vertex = [int(new_index[s]) for s in path.stations]
        self.stops: list[Stop] = []
        self._find_stops(dwells)

    def _find_stops(self, dwells: tuple[float, ...]) -> None:
        last = len(self.station_vertex) - 1
        self.passed: dict[int, int] = {}
        at_stations = []
        for number, vertex in enumerate(self.station_vertex):
            heading = self.path.headings_rad[number]
            on_another = vertex in (self.station_vertex[number - 1 : number + 2 : 2])
            if number in (0, last) or heading is not None or dwells[number] > 0.0 or on_another:
                at_stations.append(Stop(vertex, number, heading, dwells[number]))
            else:
                self.passed[vertex] = number
        for stop in at_stations:
            if self.stops and self.limits.turns_on_spot:
                self._add_sharp_corners(self.stops[-1].vertex, stop.vertex)
            self.stops.append(stop)
        if self.limits.turns_on_spot and self.limits.turning_radius > 0.0:
            self._add_tight_bends()

    def _add_sharp_corners(self, first: int, last: int) -> None:
        if first == last:
            return
        vertices, turns, before, after = self._corners(first, last)
        for vertex, turn, spread in zip(vertices, np.abs(turns), before + after, strict=True):
            crawl = self._corner_speed(turn, spread) < CRAWL * self.limits.speed
            if turn >= SHARP_TURN_RAD and crawl:
                self.stops.append(self._standing_at(int(vertex)))

    def _add_tight_bends(self) -> None:
        """Add stops until no bend between them is too tight."""
        tightest = self._tightest()
        done = self.stops[:1]
        ahead = self.stops[:0:-1]
        while ahead:
            first, last = done[-1].vertex, ahead[-1].vertex
            tight = np.empty(0, np.intp)
            if first != last:
                vertices, turns, before, after = self._corners(first, last)
                tight = np.flatnonzero(np.abs(turns) > tightest * (before + after))
            if len(tight):
                ahead.append(self._standing_at(int(vertices[tight[0]])))
            else:
                done.append(ahead.pop())
        self.stops = done

    def _standing_at(self, vertex: int) -> Stop:
        return Stop(vertex, self.passed.pop(vertex, None), None, 0.0)

    def _tightest(self) -> float:
        return (1.0 + BEND_ROUNDING) / self.limits.turning_radius

    def too_tight(self, leg: Stretch) -> tuple[float, float, float] | None:
        """Place and radius of the leg's bend below the turning radius, if any."""
        if self.limits.turning_radius == 0.0 or not len(leg.lengths):
            return None
        at = np.concatenate([[0.0], leg.breaks(), leg.lengths[-1:]])
        curvature = np.abs(leg.curvatures(at))
        worst = int(np.argmax(curvature))
        if curvature[worst] <= self._tightest():
            return None
        ((x, y),) = points_at(leg.points, leg.lengths, at[worst : worst + 1]).tolist()
        return x, y, 1.0 / float(curvature[worst])

    def _corner_speed(self, turn: float, spread: float) -> float:
        curvature = turn / spread
        growth = curvature / spread
        return min(
            math.sqrt(self.limits.lateral_acceleration / curvature),
            self.limits.angular_rate_rad_s / curvature,
            math.sqrt(ANGULAR_SHARE * self.limits.angular_acceleration_rad_s2 / growth),
        )

    def _corners(
        self, first: int, last: int
    ) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
        """Corners between two vertices: vertex, turn, and the lengths before and after it.

        Vertices within a tenth of the chord tolerance of a straight line do not count, so the noise
        of a finely sampled path makes no corners.
        """
        span = slice(first, last + 1)
        kept = first + fewer_vertices(self.points[span], 0.1 * self.limits.chord_tolerance)
        steps = np.diff(self.points[kept], axis=0)
        direction = np.arctan2(steps[:, 1], steps[:, 0])
        turns = wrap_angle(np.diff(direction))
        half = 0.5 * np.diff(self.lengths[kept])
        with np.errstate(divide="ignore"):
            by_tolerance = EVEN * self.limits.chord_tolerance / np.tan(0.25 * np.abs(turns))
        before, after = np.minimum(half[:-1], by_tolerance), np.minimum(half[1:], by_tolerance)
        return kept[1:-1], turns, before, after

    def _ease(self, turns: FloatArray, spread: FloatArray, length: float) -> float:
        """Half-width of the heading's averaging that keeps every bend within the tolerance.

        Averaging moves an even bend of curvature k by k ease^2 / 6: a quarter of the tolerance.
        """
        turned = turns != 0.0
        curvature = np.abs(turns[turned]) / spread[turned]
        least = np.sqrt(1.5 * self.limits.chord_tolerance / curvature)
        return float(min(least.min(initial=math.inf), 0.5 * length))

    def legs(self) -> list[Stretch]:
        """Stretches between consecutive stops, one fewer than stops."""
        return [self._leg(before.vertex, after.vertex) for before, after in pairwise(self.stops)]

    def _leg(self, first: int, last: int) -> Stretch:
        if first == last:
            empty = np.empty(0)
            return Stretch(
                self.points[first : last + 1], empty, empty, empty, empty, 0.0, empty, {}
            )
        span = slice(first, last + 1)
        base = float(self.lengths[first])
        vertices, turns, before, after = self._corners(first, last)
        at = self.lengths[vertices] - base
        step = self._first_step(first, last)
        length = float(self.lengths[last]) - base
        turn_at = np.concatenate([[0.0], np.stack([at - before, at + after], 1).ravel()])
        gains = np.stack([np.zeros(len(turns)), turns], 1).ravel()
        heading = math.atan2(step[1], step[0]) + np.concatenate([[0.0], np.cumsum(gains)])
        stations = {
            float(self.lengths[v]) - base: n for v, n in self.passed.items() if first < v < last
        }
        return Stretch(
            points=self.points[span],
            lengths=self.lengths[span] - base,
            clearances=self.clearances[span],
            turn_at=np.append(turn_at, length),
            heading=np.append(heading, heading[-1]),
            ease=self._ease(turns, before + after, length),
            forced=np.array(sorted(stations)),
            stations=stations,
        )

    def _first_step(self, first: int, last: int) -> FloatArray:
        span = self.points[first : last + 1]
        kept = fewer_vertices(span, 0.1 * self.limits.chord_tolerance)
        step: FloatArray = span[kept[1]] - span[0]
        return step

    def chord_tolerance(self) -> float:
        """Largest distance of chords from the path that loses no clearance."""
        rounding = 1e-9 * self.path.robot_radius
        return max(min(self.limits.chord_tolerance, self.slack), rounding)

    def speed_limits(self, leg: Stretch, nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Speed and acceleration allowed in each cell between ``nodes`` along the leg.

        The turning rate is curvature times speed. It changes by growth of curvature times speed
        squared and by curvature times acceleration: each has its share of the limit.
        """
        limits = self.limits
        along = leg.curvatures(nodes)
        curvature = np.maximum(np.abs(along[:-1]), np.abs(along[1:]))
        growth = np.abs(np.diff(along)) / np.diff(nodes)
        if self.exact_clearance is None:
            clearances = np.interp(nodes, leg.lengths, leg.clearances)
        else:
            clearances = self.exact_clearance(points_at(leg.points, leg.lengths, nodes))
        # clearance falls at most by the distance driven: the least that both ends allow
        least = 0.5 * (clearances[:-1] + clearances[1:] - np.diff(nodes))
        spare = least - self.path.robot_radius
        slowing_over = limits.slow_clearance - self.path.robot_radius
        ease = (
            np.clip(spare / slowing_over, 0.0, 1.0) if slowing_over > 0.0 else np.ones(len(spare))
        )
        slowest = min(limits.slow_speed, limits.speed)
        speed = slowest + (limits.speed - slowest) * ease
        with np.errstate(divide="ignore", over="ignore"):
            by_rate = limits.angular_rate_rad_s / curvature
            by_grip = np.sqrt(limits.lateral_acceleration / curvature)
            spin = limits.angular_acceleration_rad_s2
            by_spin = np.sqrt(ANGULAR_SHARE * spin / growth)
            gentle = (1.0 - ANGULAR_SHARE) * spin / curvature
        speed = np.minimum.reduce([speed, by_rate, by_grip, by_spin])
        if self.allowed is not None:
            middles = points_at(leg.points, leg.lengths, 0.5 * (nodes[:-1] + nodes[1:]))
            speed = np.minimum(speed, self.allowed(middles, 0.5 * np.diff(nodes)))
        return speed, np.minimum(gentle, limits.acceleration)

    def waypoint_lengths(self, leg: Stretch) -> FloatArray:
        """Lengths along the leg of its waypoints, both ends included."""
        spacing = min(self.limits.spacing, float(leg.lengths[-1]) / _LEAST_WAYPOINTS)
        marks = np.concatenate([leg.lengths, leg.forced])
        fine = np.unique(marks)
        parts = np.ceil(np.diff(fine) / spacing).astype(int)
        parts = np.maximum(parts, 1)
        number = np.arange(int(parts.sum())) - np.repeat(np.cumsum(parts) - parts, parts)
        at = np.repeat(fine[:-1], parts) + number * np.repeat(np.diff(fine) / parts, parts)
        at = np.append(at, fine[-1])
        points = points_at(leg.points, leg.lengths, at)
        cuts = np.searchsorted(at, np.concatenate([[0.0], leg.forced, leg.lengths[-1:]]))
        chosen = [
            a + fewer_vertices(points[a : b + 1], self.chord_tolerance(), spacing * (1 + 1e-12))
            for a, b in pairwise(cuts.tolist())
        ]
        lengths: FloatArray = at[np.unique(np.concatenate(chosen))]
        return lengths


def _integral(
    knots: FloatArray, values: FloatArray, area: FloatArray, at: FloatArray
) -> FloatArray:
    """Integral up to ``at`` of values linear between knots, ``area`` up to each knot."""
    cell = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    width = knots[cell + 1] - knots[cell]
    gone = at - knots[cell]
    part = np.divide(gone, width, out=np.zeros_like(gone), where=width > 0.0)
    climbed = 0.5 * part * (values[cell + 1] - values[cell])
    total: FloatArray = area[cell] + gone * (values[cell] + climbed)
    return total


def speed_cells(leg: Stretch, spacing: float) -> FloatArray:
    """Ends (n,) of the cells of constant speed limit, from 0 to the leg's length."""
    length = float(leg.lengths[-1])
    wanted = math.ceil(min(length / spacing, _MOST_CELLS) * _CELLS_PER_SPACING - 1e-6)
    count = min(max(wanted, _LEAST_CELLS), _MOST_CELLS)
    nodes = np.unique(np.concatenate([leg.breaks(), np.linspace(0.0, length, count + 1)]))
    nodes = nodes[(nodes >= 0.0) & (nodes < length)]
    apart = np.diff(nodes, append=length) > 1e-9 * length
    apart[0] = True
    return np.append(nodes[apart], length)

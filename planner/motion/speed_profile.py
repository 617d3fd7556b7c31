"""Speed along one leg, from rest to rest, under limits on speed, acceleration and jerk.

Method. With T = 2 a / j:
1. Lower the speed limit V(s), a step function on cells of the leg, to
   W(s) = min{V(u) : |u - s| <= V(u) T}: slow places reach as far as they must (see 3).
2. Take the fastest profile under W with acceleration <= a, from rest to rest: two cones in v^2
   (Bobrow, Dubowsky and Gibson 1985, for one limit a).
3. Average its position over a time window of length T. The average of an acceleration within
   +-a lies within +-a and changes by at most 2 a / T = j. Its speed at s is
   (p(t + T/2) - p(t - T/2)) / T for a window whose path I contains s. If that exceeded V(s), I
   would be longer than V(s) T, and driving V(s) T of it next to s, at no more than W <= V(s),
   would alone take the time T. So every speed limit holds exactly.
4. So does a lower acceleration limit in single cells: at s the average covers places within
   V(s) T of it, where the raw profile keeps the limit of s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from planner.borders import polyline_kernels
from planner.scene import FloatArray

IndexArray: TypeAlias = NDArray[np.intp]

_STEPS = 16
"""Newton needs a handful; halving alone would still reach 1e-5 of a bracket."""


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """Position over time along a leg: ``times`` and ``speeds`` (n,) at ``lengths`` (n,).

    The acceleration is constant between two entries; ``area`` is the integral of the position over
    time. The robot drives the average of this over ``window_s``.
    """

    lengths: FloatArray
    speeds: FloatArray
    times: FloatArray
    area: FloatArray
    window_s: float

    @property
    def duration_s(self) -> float:
        """Duration from rest at the leg's start to rest at its end."""
        return float(self.times[-1]) + self.window_s

    def position(self, time_s: FloatArray) -> FloatArray:
        """Length along the leg at each time from 0 to ``duration_s``."""
        average = (self._area(time_s) - self._area(time_s - self.window_s)) / self.window_s
        positions: FloatArray = np.minimum(np.maximum(average, 0.0), self.lengths[-1])
        return positions

    def speed(self, time_s: FloatArray) -> FloatArray:
        """Speed at each time from 0 to ``duration_s``."""
        gone = self._raw_position(time_s) - self._raw_position(time_s - self.window_s)
        speeds: FloatArray = gone / self.window_s
        return speeds

    def time_at(self, lengths: FloatArray) -> FloatArray:
        """Time at each length, by Newton's steps inside a bracket."""
        breaks = np.sort(np.concatenate([self.times, self.times + self.window_s]))
        reached = np.maximum.accumulate(self.position(breaks))
        above = np.minimum(np.searchsorted(reached, lengths), len(breaks) - 1)
        low, high = breaks[np.maximum(above - 1, 0)], breaks[above]
        times: FloatArray = 0.5 * (low + high)
        for _ in range(_STEPS):
            off = self.position(times) - lengths
            low = np.where(off < 0.0, times, low)
            high = np.where(off < 0.0, high, times)
            speed = np.maximum(self.speed(times), 1e-200)
            newton = times - off / speed
            # a length at a bracket's end puts Newton's step outside by rounding only
            inside = np.minimum(np.maximum(newton, low), high)
            middle = 0.5 * (low + high)
            times = np.where(np.abs(newton - inside) > high - low, middle, inside)
        times[lengths <= 0.0] = 0.0
        times[lengths >= self.lengths[-1]] = self.duration_s
        return times

    def _cell(self, time_s: FloatArray) -> tuple[IndexArray, FloatArray, FloatArray]:
        """Each time's cell, the time since it began, the acceleration."""
        clamped = np.minimum(np.maximum(time_s, 0.0), self.times[-1])
        cell = np.searchsorted(self.times, clamped, side="right") - 1
        cell = np.minimum(cell, len(self.times) - 2)
        duration = self.times[cell + 1] - self.times[cell]
        acceleration = (self.speeds[cell + 1] - self.speeds[cell]) / duration
        return cell, clamped - self.times[cell], acceleration

    def _raw_position(self, time_s: FloatArray) -> FloatArray:
        cell, since, acceleration = self._cell(time_s)
        gone = since * (self.speeds[cell] + 0.5 * acceleration * since)
        positions: FloatArray = np.minimum(self.lengths[cell] + gone, self.lengths[-1])
        return positions

    def _area(self, time_s: FloatArray) -> FloatArray:
        cell, since, acceleration = self._cell(time_s)
        inside = self.area[cell] + since * (
            self.lengths[cell] + since * (0.5 * self.speeds[cell] + acceleration * since / 6.0)
        )
        after = np.maximum(time_s - self.times[-1], 0.0) * self.lengths[-1]
        areas: FloatArray = inside + after
        return areas


def plan_speed(
    lengths: FloatArray,
    limits: FloatArray,
    acceleration: float,
    jerk: float,
    gentle: FloatArray | None = None,
) -> SpeedProfile:
    """Plan the profile along cells with ends ``lengths`` (n + 1,) and speed ``limits`` (n,) > 0.

    ``lengths`` grow strictly from 0. ``gentle`` (n,) > 0 limits the acceleration of single cells
    below ``acceleration``. O(n log n).
    """
    window = 2.0 * acceleration / jerk
    reach = limits * window
    lowered = _reach_out(lengths, limits, reach)
    node = np.concatenate([[0.0], np.minimum(lowered[:-1], lowered[1:]), [0.0]])
    cone = 2.0 * acceleration * lengths
    if gentle is not None:
        gentle = _reach_out(lengths, np.minimum(gentle, acceleration), reach)
        cone = np.concatenate([[0.0], np.cumsum(2.0 * gentle * np.diff(lengths))])
        acceleration = float(gentle[0])
    squared = node * node
    squared = np.minimum.accumulate(squared - cone) + cone
    squared = np.minimum.accumulate((squared + cone)[::-1])[::-1] - cone
    speeds = np.sqrt(np.maximum(squared, 0.0))
    speeds[0] = speeds[-1] = 0.0
    if len(lengths) == 2:
        lengths, speeds = _with_middle(lengths, lowered, acceleration)
    durations = 2.0 * np.diff(lengths) / (speeds[:-1] + speeds[1:])
    times = np.concatenate([[0.0], np.cumsum(durations)])
    slopes = np.diff(speeds) / durations
    areas = durations * (lengths[:-1] + durations * (0.5 * speeds[:-1] + slopes * durations / 6.0))
    return SpeedProfile(lengths, speeds, times, np.concatenate([[0.0], np.cumsum(areas)]), window)


def _with_middle(
    lengths: FloatArray, limits: FloatArray, acceleration: float
) -> tuple[FloatArray, FloatArray]:
    """For a single cell, speed up to its middle, then slow down."""
    middle = 0.5 * float(lengths[1])
    top = min(float(limits[0]), math.sqrt(2.0 * acceleration * middle))
    return np.array([0.0, middle, lengths[1]]), np.array([0.0, top, 0.0])


def _reach_out(lengths: FloatArray, limits: FloatArray, reach: FloatArray) -> FloatArray:
    """Each cell's limit, lowered to that of any slower cell that reaches it."""
    first = np.searchsorted(lengths, lengths[:-1] - reach, side="right") - 1
    last = np.searchsorted(lengths, lengths[1:] + reach, side="left")
    return polyline_kernels.reach_out(limits, first, last)  # type: ignore[no-any-return]

"""Latency of pictures: the shift at which camera and wheels move alike.

For every latency of a grid, the camera's motion in a short window is compared with the wheels' in
the window earlier by that latency; the squared differences in units of their errors are summed up,
older ones fading. The least sum is the latency; others whose sum is not clearly larger are possible
too. Only a change of motion counts: a start, a stop, a turn. Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np

from navigation.witness.wheels import WheelTrack
from planner.scene import FloatArray

LONGEST_S: Final = 2.5
STEP_S: Final = 0.01
GRID_S: Final[FloatArray] = np.arange(0.0, LONGEST_S + STEP_S / 2, STEP_S)
WINDOW_S: Final = 0.2
LONGEST_WINDOW_S: Final = 0.45
"""Two pictures farther apart than this show too little of when something happened."""
SIGMA_M: Final = 0.002
SIGMA_RAD: Final = 0.02
"""Standard deviations of a window's motion: the camera's noise, and wheels that are off by a few
percent of 0.06 m and 0.4 rad, a window's motion at full speed."""
SURE: Final = 9.0
"""Three standard deviations, squared."""
FADE_S: Final = 6.0
"""Seconds of motion after which a window counts a third."""
NARROW_S: Final = 0.06
"""Largest error of a known latency."""
STILL_M: Final = 0.002
STILL_RAD: Final = 0.01
"""Least motion in a window, at any latency, for it to mean anything."""


@dataclass(frozen=True, slots=True)
class Latency:
    """An estimate and its possible error, seconds."""

    latency_s: float
    error_s: float


class LatencyEstimate:
    """Fed with the camera's poses, in order, once the wheels are known up to their times."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, float, float, float]] = deque()
        self._sums = np.zeros(len(GRID_S))
        self._count = 0.0
        self._overlaps = 0.0
        """Sum over the windows of their pictures, each of which begins another window."""

    def break_off(self) -> None:
        """Note that camera or wheels lost track: no window reaches over this moment."""
        self._seen.clear()

    def add(self, time_s: float, pose: tuple[float, float, float], wheels: WheelTrack) -> None:
        """Add a pose whose picture arrived, or was stamped, at ``time_s``."""
        seen = self._seen
        seen.append((time_s, *pose))
        while len(seen) > 1 and seen[1][0] <= time_s - WINDOW_S:
            seen.popleft()
        then_s, x, y, heading = seen[0]
        span_s = time_s - then_s
        if not WINDOW_S <= span_s <= LONGEST_WINDOW_S:
            return
        if wheels.oldest_s > then_s - LONGEST_S and not wheels.stood_first:
            return  # how the wheels turned before is unknown
        turned = math.remainder(pose[2] - heading, math.tau)
        middle = heading + turned / 2.0
        moved = (pose[0] - x) * math.cos(middle) + (pose[1] - y) * math.sin(middle)
        later, earlier = wheels.ways_at(time_s - GRID_S), wheels.ways_at(then_s - GRID_S)
        ways, turns = later[0] - earlier[0], later[1] - earlier[1]
        still = max(abs(moved), float(np.abs(ways).max())) < STILL_M
        if still and max(abs(turned), float(np.abs(turns).max())) < STILL_RAD:
            return
        fading = math.exp(-(time_s - seen[-2][0] if len(seen) > 1 else span_s) / FADE_S)
        self._sums *= fading
        self._count = self._count * fading + 1.0
        self._overlaps = self._overlaps * fading + len(seen) - 1
        self._sums += ((moved - ways) / SIGMA_M) ** 2 + ((turned - turns) / SIGMA_RAD) ** 2

    def estimate(self) -> Latency | None:
        """Latency; None while no motion has shown it."""
        if self._count < 3.0:
            return None
        least = int(np.argmin(self._sums))
        noise = max(1.0, float(self._sums[least]) / (2.0 * self._count))
        alike = self._overlaps / self._count
        possible = np.flatnonzero(self._sums <= self._sums[least] + SURE * alike * noise)
        low_s, high_s = GRID_S[possible[0]], GRID_S[possible[-1]]
        if possible[-1] == len(GRID_S) - 1 or high_s - low_s > 2.0 * NARROW_S:
            return None
        return Latency(self._between(least), max(float(high_s - low_s) / 2.0, STEP_S))

    def _between(self, least: int) -> float:
        if not 0 < least < len(GRID_S) - 1:
            return float(GRID_S[least])
        before, here, after = self._sums[least - 1 : least + 2]
        bend = before - 2.0 * here + after
        shift = 0.0 if bend <= 0.0 else 0.5 * (before - after) / bend
        return float(GRID_S[least] + STEP_S * shift)

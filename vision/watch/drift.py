"""Sequential test of movement, by how far something is seen from its former place.

Rules and units
- Pixels and seconds. Up to half the limit away it has not moved; at the limit it has.
- Page's test (Continuous inspection schemes, 1954) sums the logarithms of the two cases' likelihood
  ratios, never below 0. At ``DRIFT_THRESHOLD`` it has moved, back at 0 it has not. Movement began
  when the sum left 0.
- Frames must agree for ``REACTION_S``, however far off: a flash moves nothing.
- By Lorden's bound (Procedures for reacting to a change in distribution, 1971) the mean number of
  frames between false alarms is at least exp(``DRIFT_THRESHOLD``): ten years at 30 a second, if
  their noise is independent and at most ``noise_px``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from vision.calibration.calibration import FloatArray

DRIFT_THRESHOLD = 23.0
REACTION_S = 0.4
LEAST_NOISE_PX = 0.25
"""Movement of a picture by lamps, air and the sensor's warmth."""
_LONGEST_STEP_S = 0.1
"""Longest time that one frame represents."""


def step_limit(passed_s: float) -> float:
    """Most that one frame adds to the sum, or subtracts."""
    return DRIFT_THRESHOLD * min(max(passed_s, 0.0), _LONGEST_STEP_S) / REACTION_S


class DriftTest:
    """Tests of ``count`` quantities side by side; ``limit_px`` > 0."""

    def __init__(self, count: int, limit_px: float, noise_px: float = LEAST_NOISE_PX) -> None:
        self.limit_px = limit_px
        self.noise_px = noise_px
        self.sums: FloatArray = np.zeros(count)
        self.moved: NDArray[np.bool_] = np.zeros(count, dtype=np.bool_)
        self.since_s: FloatArray = np.full(count, math.nan)
        """Beginning of each movement; NaN without one."""

    def begin_moved(self, since_s: float) -> None:
        """Mark all as moved already."""
        self.sums[:], self.moved[:], self.since_s[:] = DRIFT_THRESHOLD, True, since_s

    def update(self, away_px: FloatArray, passed_s: float, now_s: float) -> None:
        """Take a frame's distances (n), ``passed_s`` after the last frame.

        NaN is unknown, inf too far to measure.
        """
        slope = 0.5 * self.limit_px / self.noise_px**2
        steps = slope * (away_px - 0.75 * self.limit_px)
        most = step_limit(passed_s)
        steps = np.clip(np.where(np.isnan(steps), 0.0, steps), -most, most)
        before = self.sums
        self.sums = np.clip(before + steps, 0.0, DRIFT_THRESHOLD)
        self.since_s = np.where((before == 0.0) & (self.sums > 0.0), now_s, self.since_s)
        self.moved = (self.sums >= DRIFT_THRESHOLD) | (self.moved & (self.sums > 0.0))
        self.since_s = np.where(self.sums == 0.0, math.nan, self.since_s)


def of_most(away_px: FloatArray) -> float:
    """Greatest distance that more than half of the distances (n) reach, n > 0.

    A camera moves all points.
    """
    return float(np.sort(away_px)[(len(away_px) + 1) // 2 - 1])

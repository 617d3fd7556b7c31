"""Sequential test of movement, by how far something is seen from its former place.

Rules and units
- Pixels and seconds. Up to half the limit away it has not moved; at the limit it has.
- Page's test (Continuous inspection schemes, 1954) sums the logarithms of the two cases' likelihood
  ratios, never below 0. At ``THRESHOLD`` it has moved, back at 0 it has not. Movement began when
  the sum left 0.
- One frame counts so little that ``REACTION_S`` of them must agree, however far off they are: a
  flash or a hand in a few pictures moves nothing.
- By Lorden's bound (Procedures for reacting to a change in distribution, 1971) the mean number of
  frames between false alarms is at least exp(``THRESHOLD``): with 30 a second, ten years, if the
  noise of frames is independent and at most ``noise_px``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from vision.calibration.calibration import FloatArray

THRESHOLD = 23.0
REACTION_S = 0.4
LEAST_NOISE_PX = 0.25
"""Lamps, air and the sensor's own warmth move a picture by so much without a pattern."""
_LONGEST_STEP_S = 0.1
"""However long no frame came, the next is one frame."""


def step_limit(passed_s: float) -> float:
    """Most that one frame adds to the sum, or takes off it."""
    return THRESHOLD * min(max(passed_s, 0.0), _LONGEST_STEP_S) / REACTION_S


class DriftTest:
    """Tests of ``count`` quantities side by side; ``limit_px`` > 0."""

    def __init__(self, count: int, limit_px: float, noise_px: float = LEAST_NOISE_PX) -> None:
        self.limit_px = limit_px
        self.noise_px = noise_px
        self.sums: FloatArray = np.zeros(count)
        self.moved: NDArray[np.bool_] = np.zeros(count, dtype=np.bool_)
        self.since_s: FloatArray = np.full(count, math.nan)
        """When each began to move; NaN for one that has not."""

    def begin_moved(self, since_s: float) -> None:
        """Mark all as moved already."""
        self.sums[:], self.moved[:], self.since_s[:] = THRESHOLD, True, since_s

    def update(self, away_px: FloatArray, passed_s: float, now_s: float) -> None:
        """Take a frame's distances (n), ``passed_s`` after the last frame.

        NaN is unknown, inf farther away than can be measured.
        """
        slope = 0.5 * self.limit_px / self.noise_px**2
        steps = slope * (away_px - 0.75 * self.limit_px)
        most = step_limit(passed_s)
        steps = np.clip(np.where(np.isnan(steps), 0.0, steps), -most, most)
        before = self.sums
        self.sums = np.clip(before + steps, 0.0, THRESHOLD)
        self.since_s = np.where((before == 0.0) & (self.sums > 0.0), now_s, self.since_s)
        self.moved = (self.sums >= THRESHOLD) | (self.moved & (self.sums > 0.0))
        self.since_s = np.where(self.sums == 0.0, math.nan, self.since_s)


def of_most(away_px: FloatArray) -> float:
    """Greatest distance that more than half of the distances (n) reach, n > 0.

    A camera moves all points; movement of fewer than half of them does not count here.
    """
    return float(np.sort(away_px)[(len(away_px) + 1) // 2 - 1])

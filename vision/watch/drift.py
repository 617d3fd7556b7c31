"""Has something moved? A sequential test on how far it is seen from where it was.

Rules and units
- Pixels and seconds. What is up to half the limit away has not moved; what is the limit away has.
- Page's test (Continuous inspection schemes, 1954): the logarithms of the likelihood ratios of
  the two are summed up, never below 0; at ``THRESHOLD`` it has moved, back at 0 it has not. The
  sum left 0 when it began to move.
- One frame counts so little that ``REACTION_S`` of them must agree, however far off they are: a
  flash or a hand in a few pictures moves nothing.
- By Lorden's bound (Procedures for reacting to a change in distribution, 1971) the mean number of
  frames between two false alarms is at least exp(``THRESHOLD``): with 30 a second, ten years, as
  long as the noise of one frame is independent of the next one's and no more than ``noise_px``.
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
    """The most that one frame adds to the sum, or takes off it."""
    return THRESHOLD * min(max(passed_s, 0.0), _LONGEST_STEP_S) / REACTION_S


class DriftTest:
    """Tests ``count`` quantities side by side; ``limit_px`` > 0."""

    def __init__(self, count: int, limit_px: float, noise_px: float = LEAST_NOISE_PX) -> None:
        self.limit_px = limit_px
        self.noise_px = noise_px
        self.sums: FloatArray = np.zeros(count)
        self.moved: NDArray[np.bool_] = np.zeros(count, dtype=np.bool_)
        self.since_s: FloatArray = np.full(count, math.nan)
        """When each began to move; NaN for one that has not."""

    def begin_moved(self, since_s: float) -> None:
        """All have moved already."""
        self.sums[:], self.moved[:], self.since_s[:] = THRESHOLD, True, since_s

    def update(self, away_px: FloatArray, passed_s: float, now_s: float) -> None:
        """Take the distances (n) of a frame ``passed_s`` after the last: NaN says nothing, inf
        that it is farther away than can be measured."""
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
    """Least distance that more than half of the things are away; (n) distances, n > 0.

    A camera moves them all; what happens to fewer than half of them moves this by nothing.
    """
    return float(np.sort(away_px)[(len(away_px) + 1) // 2 - 1])

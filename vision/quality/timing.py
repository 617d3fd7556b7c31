"""Timing of pictures: their rate, its jitter, and their age at arrival.

Rules and units
- Seconds; ``stamps_s`` are the times of exposure as the source knows them, ``arrivals_s`` those at
  which the program had the picture.
- The period is the slope of the stamps over the pictures' numbers; a gap counts as its number of
  periods.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planner.scene import FloatArray


@dataclass(frozen=True, slots=True)
class Timing:
    """Rate and regularity of some pictures.

    ``jitter_s`` is the stamps' standard deviation about an even rhythm, ``longest_gap_s`` the
    longest time between two, ``delay_s`` the median time from stamp to arrival.
    """

    pictures: int
    seconds: float
    rate_hz: float
    jitter_s: float
    longest_gap_s: float
    gaps: int
    """Number of pictures that the rhythm lacks."""
    delay_s: float


def timing_of(stamps_s: FloatArray, arrivals_s: FloatArray) -> Timing | None:
    """Timing of pictures in order, shapes (n,); None for fewer than three."""
    if len(stamps_s) < 3 or stamps_s[-1] <= stamps_s[0]:
        return None
    steps = np.diff(stamps_s)
    even = even_times(stamps_s)
    return Timing(
        pictures=len(stamps_s),
        seconds=float(stamps_s[-1] - stamps_s[0]),
        rate_hz=float((len(stamps_s) - 1) / (stamps_s[-1] - stamps_s[0])),
        jitter_s=float(np.std(stamps_s - even)),
        longest_gap_s=float(steps.max()),
        gaps=int(_numbers(stamps_s)[-1]) - (len(stamps_s) - 1),
        delay_s=float(np.median(arrivals_s - stamps_s)),
    )


def even_times(stamps_s: FloatArray) -> FloatArray:
    """Times of the even rhythm nearest to the stamps, (n,), without jitter."""
    numbers = _numbers(stamps_s)
    slope, begin = np.polyfit(numbers, stamps_s - stamps_s[0], 1)
    return np.asarray(stamps_s[0] + begin + slope * numbers, dtype=np.float64)


def _numbers(stamps_s: FloatArray) -> FloatArray:
    steps = np.diff(stamps_s)
    period_s = float(np.median(steps))
    if period_s <= 0.0:
        return np.arange(len(stamps_s), dtype=np.float64)
    counts = np.maximum(1.0, np.rint(steps / period_s))
    return np.concatenate([[0.0], np.cumsum(counts)])

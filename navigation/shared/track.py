"""Track of a robot in a buffer of fixed size, and the pieces of it that the robot drove.

Rows are time_s, x_m, y_m, heading_rad; one thread writes, any thread reads.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from planner.scene import FloatArray

BoolArray = NDArray[np.bool_]

MOST_ROWS: Final = 360_000
"""Two hours at 50 rows a second: 11 MB."""
UNSEEN_S: Final = 0.5
"""A robot's place is unknown after this time without a sighting."""
UNNOTICED_M: Final = 0.03
"""Distance that a robot may be off after a moment without a row: braking, noise, a late picture."""
FASTER: Final = 1.5
"""Times its greatest speed: no wheels did that."""


class Track:
    """The newest ``most_rows`` rows; the last moves until it is ``least_m`` from the one before."""

    def __init__(self, most_rows: int = MOST_ROWS, least_m: float = 0.0) -> None:
        self._least_m = least_m
        # filled, not empty: takes the memory now, not over hours
        self._rows = np.full((most_rows, 4), np.nan)
        self._count = 0
        self._lock = threading.Lock()

    def add(self, time_s: float, x_m: float, y_m: float, heading_rad: float) -> None:
        """Add a row; a full buffer drops its oldest."""
        with self._lock:
            if self._moves_the_last():
                self._count -= 1
            self._rows[self._count % len(self._rows)] = (time_s, x_m, y_m, heading_rad)
            self._count += 1

    def _moves_the_last(self) -> bool:
        if self._least_m == 0.0 or self._count < 2:
            return False
        size = len(self._rows)
        before, last = (self._rows[(self._count - n) % size, 1:3] for n in (2, 1))
        return math.dist(before, last) < self._least_m

    def rows(self) -> FloatArray:
        """A copy (n, 4), oldest first."""
        with self._lock:
            size = len(self._rows)
            if self._count <= size:
                return self._rows[: self._count].copy()
            return np.roll(self._rows, -(self._count % size), axis=0)


def driven_pieces(rows: FloatArray, fastest_m_s: float) -> list[FloatArray]:
    """Split a track (n, 4) into pieces (k >= 1, 4) where no robot so fast can have driven."""
    if not len(rows):
        return []
    passed_s = np.diff(rows[:, 0])
    moved_m = np.hypot(*np.diff(rows[:, 1:3], axis=0).T)
    begins = 1 + np.flatnonzero(_jumped(passed_s, moved_m, fastest_m_s))
    return np.split(rows, begins)


def with_breaks(pieces: Sequence[FloatArray]) -> FloatArray:
    """Join the pieces (k, m) of a track into one array (n, m), with rows of NaN between."""
    rows = [row for piece in pieces for row in (np.full((1, piece.shape[1]), np.nan), piece)]
    return np.vstack(rows[1:]) if rows else np.empty((0, 4))


def is_jump(
    before: tuple[float, float, float], after: tuple[float, float, float], fastest_m_s: float
) -> bool:
    """True if no wheels can have moved the robot from one (time_s, x_m, y_m) to the next."""
    passed_s, moved_m = after[0] - before[0], math.dist(before[1:], after[1:])
    return bool(_jumped(np.array(passed_s), np.array(moved_m), fastest_m_s))


def _jumped(passed_s: FloatArray, moved_m: FloatArray, fastest_m_s: float) -> BoolArray:
    too_far: BoolArray = moved_m > UNNOTICED_M + FASTER * fastest_m_s * passed_s
    unseen: BoolArray = (passed_s > UNSEEN_S) & (moved_m > UNNOTICED_M)
    return too_far | unseen

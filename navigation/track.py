"""Where a robot has been, in a buffer that never grows.

Rows of time_s, x_m, y_m, heading_rad; one thread writes, any thread reads.
"""

from __future__ import annotations

import math
import threading

import numpy as np

from planner.scene import FloatArray

MOST_ROWS = 360_000
"""Two hours at 50 rows a second: 11 MB."""


class Track:
    """The newest ``most_rows`` rows.

    With ``least_m`` the last row follows the robot until it is so far from the one before.
    """

    def __init__(self, most_rows: int = MOST_ROWS, least_m: float = 0.0) -> None:
        self._least_m = least_m
        # filled, not empty: the memory is taken now and not in the course of hours
        self._rows = np.full((most_rows, 4), np.nan)
        self._count = 0
        self._lock = threading.Lock()

    def add(self, time_s: float, x_m: float, y_m: float, heading_rad: float) -> None:
        """One more row; the oldest makes room where the buffer is full."""
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
        """A copy (n, 4), the oldest first."""
        with self._lock:
            size = len(self._rows)
            if self._count <= size:
                return self._rows[: self._count].copy()
            return np.roll(self._rows, -(self._count % size), axis=0)

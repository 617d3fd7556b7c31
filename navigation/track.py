"""Where a robot has been, in a buffer that never grows.

Rows of time_s, x_m, y_m, heading_rad; one thread writes, any thread reads.
"""

from __future__ import annotations

import threading

import numpy as np

from planner.scene import FloatArray

MOST_ROWS = 360_000
"""Two hours at 50 rows a second: 11 MB."""


class Track:
    """The newest ``most_rows`` rows."""

    def __init__(self, most_rows: int = MOST_ROWS) -> None:
        # filled, not empty: the memory is taken now and not in the course of hours
        self._rows = np.full((most_rows, 4), np.nan)
        self._count = 0
        self._lock = threading.Lock()

    def add(self, time_s: float, x_m: float, y_m: float, heading_rad: float) -> None:
        """One more row; the oldest makes room where the buffer is full."""
        with self._lock:
            self._rows[self._count % len(self._rows)] = (time_s, x_m, y_m, heading_rad)
            self._count += 1

    def rows(self) -> FloatArray:
        """A copy (n, 4), the oldest first."""
        with self._lock:
            size = len(self._rows)
            if self._count <= size:
                return self._rows[: self._count].copy()
            return np.roll(self._rows, -(self._count % size), axis=0)

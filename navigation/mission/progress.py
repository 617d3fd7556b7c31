"""Progress of a mission: a station visited, or its end nearer than ever.

States do not show it: a robot can hold, plan and drive in turns for ever. A new scene may lengthen
the remaining distance and restart the measurement, ``DETOURS`` times a station. Metres, seconds.
"""

from __future__ import annotations

import math
from typing import Final

STEP_M: Final = 0.02
"""Nearer by less is no progress: the camera's noise is a tenth of it."""
DETOURS: Final = 10
"""Most new scenes that may lengthen the path between two stations."""
LONGEST_LOOK_S: Final = 1.0
"""Longest time between two looks that counts: in a longer one this program did not run (a computer
that slept), so nothing was waited for."""


class Progress:
    """Time waited since the last progress; `look` once a cycle."""

    def __init__(self) -> None:
        self.waited_s = 0.0
        self._looked_s: float | None = None
        self._visited = 0
        self._least_m = math.inf
        self._revision = -1
        self._detours = 0

    def begin(self) -> None:
        """Begin a mission, or one that a person has resumed."""
        self.waited_s, self._visited = 0.0, 0
        self._next_station()

    def look(
        self, now_s: float, *, waits: bool, visited: int, left_m: float | None, revision: int
    ) -> None:
        """Take one cycle's facts; ``left_m`` only while it drives.

        ``revision`` is the scene's in which the path was planned.
        """
        passed_s = 0.0 if self._looked_s is None else now_s - self._looked_s
        self._looked_s = now_s
        if waits:
            self.waited_s += min(passed_s, LONGEST_LOOK_S)
        if visited > self._visited:
            self._visited, self.waited_s = visited, 0.0
            self._next_station()
        if left_m is None:
            return
        if revision != self._revision:
            if left_m > self._least_m and self._detours < DETOURS:
                self._detours += 1
                self._least_m = left_m
            self._revision = revision
        if left_m <= self._least_m - STEP_M:
            self._least_m, self.waited_s = left_m, 0.0

    def circled(self, seconds: float) -> None:
        """Count as waiting a time in which the robot moved and came no nearer."""
        self.waited_s += seconds

    def _next_station(self) -> None:
        self._least_m, self._revision, self._detours = math.inf, -1, 0

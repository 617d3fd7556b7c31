"""Whether a mission gets on: a station visited, or nearer to its end than ever.

States say nothing of that: a robot that holds, plans and drives in turns can do so for ever.
What counts is the way that is left. A new scene may make it longer and be measured from there,
but not time and again. Metres, seconds.
"""

from __future__ import annotations

import math
from typing import Final

STEP_M: Final = 0.02
"""Nearer by less is no progress: the camera's noise is a tenth of it."""
DETOURS: Final = 10
"""So many new scenes may lengthen the way between two stations."""


class Progress:
    """How long a mission has waited since it last got on; `look` once a cycle."""

    def __init__(self) -> None:
        self.waited_s = 0.0
        self._looked_s: float | None = None
        self._visited = 0
        self._least_m = math.inf
        self._revision = -1
        self._detours = 0

    def begin(self) -> None:
        """A new mission, or one that a person has sent on."""
        self.waited_s, self._visited = 0.0, 0
        self._next_station()

    def look(
        self, now_s: float, *, waits: bool, visited: int, left_m: float | None, revision: int
    ) -> None:
        """One cycle: whether the robot waits, and how far it still has to go, where it drives.

        ``revision`` is that of the scene that the way was planned in.
        """
        passed_s = 0.0 if self._looked_s is None else now_s - self._looked_s
        self._looked_s = now_s
        if waits:
            self.waited_s += passed_s
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

    def _next_station(self) -> None:
        self._least_m, self._revision, self._detours = math.inf, -1, 0

"""Certain knowledge that a robot is at rest: its wheels report, and their travel does not change.

An order to stop is no such proof. Metres, seconds.
"""

from __future__ import annotations

import math
from typing import Final

from navigation.link.drivers.robot_driver import Heard

STILL_M: Final = 0.001
"""Two counts of the coarsest encoder."""
STILL_S: Final = 0.2
"""Together 5 mm/s, which is less than most wheels can be driven at."""
FRESH_S: Final = 0.25
"""Age from which a report says nothing about the present."""


class Standing:
    """Rest of one robot's wheels; `look` after each report."""

    def __init__(self) -> None:
        self._place = (0.0, 0.0)
        self._since_s = self._newest_s = -math.inf
        self._from_s = -math.inf
        self._is_new = True

    def begin(self, now_s: float) -> None:
        """Forget all but the reports from now on."""
        self._from_s, self._is_new = now_s, True

    def look(self, heard: Heard) -> None:
        """Take the newest report."""
        came_s = heard.odometry_s
        if came_s is None or came_s < self._from_s or (came_s == self._newest_s):
            return
        self._newest_s = came_s
        here = (heard.left_m, heard.right_m)
        gone_m = max(abs(a - b) for a, b in zip(here, self._place, strict=True))
        if self._is_new or gone_m > STILL_M:
            self._place, self._since_s, self._is_new = here, came_s, False

    def is_known(self, now_s: float) -> bool:
        """True if the robot reports rest."""
        if self._is_new or now_s - self._newest_s > FRESH_S:
            return False
        return self._newest_s - self._since_s >= STILL_S

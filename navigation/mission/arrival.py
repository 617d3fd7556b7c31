"""Whether the robot stands where the mission ends: the camera has the last word.

The robot says that it has executed everything. When it has stood for a moment the camera looks
where; off the goal the last stretch is planned again, but not for ever. Metres, radians, seconds.
"""

from __future__ import annotations

import math

from navigation.mission.cycle import PilotSettings
from navigation.mission.mission import Event, Station


class Arrival:
    """Keeps since when the robot stands at its end, and how often that was corrected."""

    def __init__(self, settings: PilotSettings) -> None:
        self._settings = settings
        self._corrections = 0
        self._stands_since_s: float | None = None

    def begin(self) -> None:
        """A new mission, or one that a person has sent on."""
        self._corrections = 0

    def moves(self) -> None:
        """The robot does not stand at its end."""
        self._stands_since_s = None

    def stands(
        self, now_s: float, pose: tuple[float, float, float], goal: Station
    ) -> tuple[Event, str] | None:
        """The robot stands at its end: what becomes of the mission, once the camera is sure."""
        settings = self._settings
        if self._stands_since_s is None:
            self._stands_since_s = now_s
        if now_s - self._stands_since_s < settings.settle_s:
            return None
        off_m = math.dist(pose[:2], (goal.x, goal.y))
        off_rad = 0.0
        if goal.heading_rad is not None:
            off_rad = abs(math.remainder(pose[2] - goal.heading_rad, math.tau))
        if off_m <= settings.goal_tolerance_m and off_rad <= settings.goal_tolerance_rad:
            where = f"{off_m * 1e3:.1f} mm and {math.degrees(off_rad):.2f} deg from the goal"
            return Event.ARRIVED, f"the robot is at rest {where}"
        if self._corrections < settings.corrections:
            self._corrections += 1
            return Event.REPLAN, "correcting the last stretch"
        return Event.FAIL, (
            f"the robot says that it has arrived, the camera sees it {off_m * 1e3:.1f} mm and "
            f"{math.degrees(off_rad):.2f} deg away after {self._corrections} corrections"
        )

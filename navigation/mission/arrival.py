"""Arrival at the mission's end, confirmed by the camera once the robot is at rest.

Off the goal, the last stretch is planned again, a limited number of times. Metres, radians,
seconds.
"""

from __future__ import annotations

import math

from navigation.mission.cycle import PilotSettings
from navigation.mission.mission import Event, Station


class Arrival:
    """Time since when the robot is at rest at its end, and number of corrections."""

    def __init__(self, settings: PilotSettings) -> None:
        self._settings = settings
        self._corrections = 0
        self._stands_since_s: float | None = None

    def begin(self) -> None:
        """Begin a mission, or one that a person has resumed."""
        self._corrections = 0

    def moves(self) -> None:
        """Note that the robot is not at rest at its end."""
        self._stands_since_s = None

    def stands(
        self, now_s: float, pose: tuple[float, float, float], goal: Station
    ) -> tuple[Event, str] | None:
        """Judge a robot at rest at its end; return the mission's event once the camera is sure."""
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

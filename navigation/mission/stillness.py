"""Evidence that a robot ordered to drive moves, and comes nearer to its next target.

Camera and wheels are not compared here; the witness does that. Metres, radians, seconds.
"""

from __future__ import annotations

import math
from typing import Final

from navigation.mission.cycle import RobotReport
from navigation.mission.running_plan import RunningPlan
from navigation.mission.targets import Target
from navigation.witness import Evidence

MOTIONLESS: Final = (
    "it was ordered to drive, and neither its wheels nor the camera report a motion: "
    "check its motors, their power and its switch"
)
STILL_S: Final = 2.0
"""A robot begins within a second of its order; 3 s is what people are promised."""
MOVED_M, MOVED_RAD = 0.001, 0.01
"""Less in ``STILL_S`` is no motion: half of the slowest turn that the follower asks for, 1.25
mm/s at wheels 0.12 m apart."""
AT_M: Final = 0.03
"""Near enough to a target with a stay."""
FIRST_PAUSE_S: Final = 1.0
LONGEST_PAUSE_S: Final = 16.0


class RobotStillness:
    """Time without motion, and the number of such findings in a row."""

    def __init__(self) -> None:
        self._moved_s: float | None = None
        """None while it need not move."""
        self._driven_m = self._turned_rad = 0.0
        self._found = 0

    def reset(self) -> None:
        """Begin again: it is ordered nothing, or to be at rest."""
        self._moved_s = None

    def look(self, now_s: float, evidence: Evidence) -> bool:
        """Take one cycle in which it must drive; True if it has not moved for too long."""
        moved_m = evidence.driven_m - self._driven_m
        turned_rad = abs(evidence.wheels_rad - self._turned_rad)
        moved = moved_m > MOVED_M or turned_rad > MOVED_RAD
        if self._moved_s is None or moved:
            self._found = 0 if moved and self._moved_s is not None else self._found
            self._moved_s = now_s
            self._driven_m, self._turned_rad = evidence.driven_m, evidence.wheels_rad
        return now_s - self._moved_s > STILL_S

    def pause_s(self) -> float:
        """Count a finding; return the pause before the next try, longer each time."""
        self._found += 1
        self._moved_s = None
        return min(LONGEST_PAUSE_S, FIRST_PAUSE_S * 2.0 ** (self._found - 1))


NEARER_M: Final = 0.01
"""Nearer by less is the camera's noise: chosen."""


class Circling:
    """Time since when a moving robot has come no nearer to its next target."""

    def __init__(self, longest_s: float) -> None:
        self._longest_s = longest_s
        self._since_s: float | None = None
        self._target: tuple[int | None, int] = (-1, -1)
        self._least_m = math.inf

    def look(
        self,
        now_s: float,
        robot: RobotReport,
        plan: RunningPlan,
        pose: tuple[float, float, float] | None,
    ) -> bool:
        """Take one cycle; True if it has circled for too long, and the time begins again.

        ``pose``: None if it does not drive this plan, or was not seen.
        """
        left_m = None if pose is None else _to_go_m(robot, plan, pose[:2])
        target = robot.mission_id, plan.executed
        circles = left_m is not None and self._circles(now_s, target, left_m)
        if left_m is None or circles:
            self._since_s = None
        return circles

    def _circles(self, now_s: float, target: tuple[int | None, int], left_m: float) -> bool:
        """``target``: numbers of the mission on the wire and of the target in it."""
        nearer = target != self._target or left_m < self._least_m - NEARER_M
        if self._since_s is None or nearer:
            self._since_s, self._target, self._least_m = now_s, target, left_m
        return now_s - self._since_s > self._longest_s


def _to_go_m(robot: RobotReport, plan: RunningPlan, place_m: tuple[float, float]) -> float | None:
    """Distance of the next target; None if the robot need not move."""
    if plan.executed >= len(plan.targets) or robot.standing_reason is not None:
        return None
    if not is_to_move(robot, plan.targets[plan.executed], place_m):
        return None
    return math.dist(place_m, plan.left[0])


def is_to_move(robot: RobotReport, target: Target, place_m: tuple[float, float] | None) -> bool:
    """True unless the robot waits for more, or is where it is to stay."""
    if robot.waits:
        return False
    near = place_m is not None and math.dist(place_m, (target.x_m, target.y_m)) < AT_M
    return not (target.dwell_s > 0.0 and near)

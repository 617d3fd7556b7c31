"""The robot's decisions in SI units and on a clock without an end; sans-IO.

``clearway.robot`` decides. Seconds and metres become its whole numbers: microseconds modulo 2^30,
micrometres, eighths of mm/s. Time is the robot's clock, passed in; distances are the wheel
encoders'.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from firmware_protocol.robot.clearway.estimate import TIME
from firmware_protocol.robot.clearway.fixed import heading_of
from firmware_protocol.robot.clearway.robot import (
    ACCEPT_NEXT,
    EXEC_CRC,
    EXEC_NEXT,
    MISSION,
    PREFIX_CRC,
    Robot,
)
from firmware_protocol.robot.clearway.settings import Settings
from firmware_protocol.robot.clearway.states import RUN
from firmware_protocol.robot.clearway.waypoints import QUEUE_SIZE
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import RobotState, StopReason
from firmware_protocol.wire.values import UM_PER_M

LEAP_UM: Final = 1 << 20
"""1 m, the most that wheels travel in a cycle."""
STRIDE_US: Final = 1 << 28
"""4.5 minutes, the most that passes at once: after 17.9 the robot's clock comes round, and an
earlier lease would look young."""
EIGHTHS_PER_M: Final = 8_000
"""Eighths of mm/s, the unit of speeds inside."""


class WheelSpeeds(NamedTuple):
    """Setpoints of the wheel rims' speeds over the ground; ``powered`` False: motors off."""

    left_m_s: float
    right_m_s: float
    powered: bool


class ReportedPose(NamedTuple):
    """Position and heading, to the wire's resolution."""

    x_m: float
    y_m: float
    heading_rad: float


class RobotController:
    """All decisions of the robot; one :meth:`step` per control cycle (100 a second)."""

    def __init__(self, settings: DriveSettings | None = None) -> None:
        self.settings = settings or DriveSettings()
        self.robot = Robot(Settings(*self.settings.whole_numbers()))
        self._now_us: int | None = None
        self._wheels_um: tuple[int, int] | None = None

    def tick(self, now_s: float) -> None:
        """Watch the lease between two steps."""
        self.robot.tick(self.pass_time(now_s) & TIME)

    def pass_time(self, now_s: float) -> int:
        """Let time pass up to ``now_s``, however long; return it in microseconds."""
        now_us = _us(now_s)
        if self._now_us is not None:
            while now_us - self._now_us > STRIDE_US:
                self._now_us += STRIDE_US
                self.robot.tick(self._now_us & TIME)
        self._now_us = now_us
        return now_us

    def step(self, now_s: float, left_m: float, right_m: float) -> WheelSpeeds:
        """Run one cycle: from the wheels' travel since boot to their speeds."""
        self.robot.step(self.pass_time(now_s) & TIME, *self._travelled(left_m, right_m))
        return self.wheels

    def follow(self, now_s: float, left_m: float, right_m: float) -> None:
        """Decide for a cycle that ended at ``now_s``, without checking the lease or moving the
        wheels.

        For robots that report several cycles at once, after :meth:`tick`.
        """
        self.robot.follow(_us(now_s) & TIME, *self._travelled(left_m, right_m))

    def turn_wheels(self, now_s: float) -> WheelSpeeds:
        """Order the wheels by the decisions of :meth:`follow`."""
        self.robot.turn_wheels(_us(now_s) & TIME)
        return self.wheels

    def emergency_stop(self, reason: StopReason = StopReason.ESTOP_HOST) -> None:
        """Stop the wheels at once, latched until the host resets it in another session."""
        self.robot.emergency_stop(reason)

    def stand(self) -> None:
        """Stop without a ramp, for wheels out of reach; START drives again."""
        if self.robot.state == RUN:
            self.robot.pause()
        self.robot.freeze()

    @property
    def state(self) -> RobotState:
        """Present state."""
        return RobotState(self.robot.state)

    @property
    def reason(self) -> StopReason:
        """Last reason for not being in RUN."""
        return StopReason(self.robot.reason)

    @property
    def wheels(self) -> WheelSpeeds:
        """Orders to the motors: the last step's, or zero since an emergency stop."""
        robot = self.robot
        return WheelSpeeds(robot.left / EIGHTHS_PER_M, robot.right / EIGHTHS_PER_M, robot.powered)

    @property
    def pose(self) -> ReportedPose:
        """Estimated pose."""
        x_um, y_um, angle, _ = self.robot.estimate.pose
        heading_rad = max(-math.pi, min(math.pi, heading_of(angle) / 1e4))
        return ReportedPose(x_um / UM_PER_M, y_um / UM_PER_M, heading_rad)

    @property
    def mission(self) -> int:
        """Mission whose waypoints it takes; 0: none."""
        return self._number(MISSION)

    @property
    def accept_next(self) -> int:
        """Index of the next waypoint to take."""
        return self._number(ACCEPT_NEXT)

    @property
    def exec_next(self) -> int:
        """Index of the next waypoint to execute."""
        return self._number(EXEC_NEXT)

    @property
    def prefix_crc(self) -> int:
        """CRC over the mission's number and the waypoints taken."""
        return self._number(PREFIX_CRC)

    @property
    def exec_crc(self) -> int:
        """The same over the waypoints executed, in order."""
        return self._number(EXEC_CRC)

    @property
    def done(self) -> bool:
        """True if the mission's last waypoint is executed."""
        return self.robot.done

    @property
    def credit(self) -> int:
        """Free places in the queue."""
        return QUEUE_SIZE - self.robot.queue.count

    def _number(self, at: int) -> int:
        numbers = self.robot.numbers
        return numbers[at] | numbers[at + 1] << 16

    def _travelled(self, left_m: float, right_m: float) -> tuple[int, int]:
        """Travel of the wheels since the last cycle, at most a leap."""
        now_um = round(left_m * UM_PER_M), round(right_m * UM_PER_M)
        before_um, self._wheels_um = self._wheels_um or now_um, now_um
        left_um, right_um = now_um[0] - before_um[0], now_um[1] - before_um[1]
        return max(-LEAP_UM, min(LEAP_UM, left_um)), max(-LEAP_UM, min(LEAP_UM, right_um))


def _us(seconds: float) -> int:
    return round(seconds * 1e6)

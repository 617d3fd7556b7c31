"""Truth about a virtual loop's robot. Metres, radians, virtual seconds."""

from __future__ import annotations

import numpy as np

from firmware_protocol.wire.messages import ResetCause, StopReason
from navigation.simulator.drive_model import TruePose
from navigation.simulator.virtual_loop import VirtualLoop
from planner.scene import FloatArray

ROBOT_EVERY = 2
"""Every second of the loop's 10 ms is kept in the robot's track."""


class VirtualRobot:
    """True pose and track of the robot, and a person's actions on it."""

    def __init__(self, loop: VirtualLoop) -> None:
        self._loop = loop
        self._rows: list[tuple[float, float, float, float]] = []
        self._noted = 0

    def pose(self) -> TruePose:
        """Present pose."""
        return self._loop.drive.pose

    def track(self) -> FloatArray:
        """Track so far, every 20 ms."""
        return np.array(self._rows).reshape(-1, 4)

    def press_estop(self) -> None:
        """Press the emergency stop on the robot itself."""
        self._loop.robot.controller.emergency_stop(StopReason.ESTOP_LOCAL)

    def switch_off_and_on(self) -> None:
        """Cycle the power: nothing from earlier is left in its processor."""
        self._loop.boot(ResetCause.POWER_ON)

    def keep_track(self) -> None:
        """Take over the loop's notes since the last call."""
        noted = self._loop.track
        self._rows += noted[-self._noted % ROBOT_EVERY :: ROBOT_EVERY]
        self._noted += len(noted)
        noted.clear()

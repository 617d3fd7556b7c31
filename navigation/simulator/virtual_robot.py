"""Truth about a virtual loop's robot. Metres, radians, virtual seconds."""

from __future__ import annotations

import numpy as np

from navigation.simulator.drive_model import TruePose
from navigation.simulator.virtual_loop import VirtualLoop
from planner.scene import FloatArray

ROBOT_EVERY = 2
"""Every second of the loop's 10 ms is kept in the robot's track."""


class VirtualRobot:
    """True pose and track of the robot."""

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

    def keep_track(self) -> None:
        """Take over the loop's notes since the last call."""
        noted = self._loop.track
        self._rows += noted[-self._noted % ROBOT_EVERY :: ROBOT_EVERY]
        self._noted += len(noted)
        noted.clear()

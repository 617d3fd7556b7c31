"""The robot with our own firmware: the robot's end in Python, stepped every 2 ms.

It boots when made, and again at each processor reset. Metres, seconds.
"""

from __future__ import annotations

import random
from typing import Final

from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController, WheelSpeeds
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import ResetCause, StopReason
from navigation.simulator.drive_model import DriveModel
from navigation.simulator.twins.twin import Body, Twin

CONTROL_EVERY: Final = 5
"""Steps to one control cycle: 10 ms."""
BAUD: Final = 115_200


class ClearwayTwin(Twin):
    """Our own robot. ``boot_ids`` numbers its boots; ``model`` has its wheels' mechanics."""

    baud = BAUD
    has_frames = True

    def __init__(
        self,
        settings: DriveSettings | None = None,
        *,
        model: DriveModel | None = None,
        boot_ids: random.Random | None = None,
    ) -> None:
        model = model or DriveModel()
        self.body = Body(model.track_m, model.ticks_per_m, model.max_wheel_m_s)
        self._settings = settings or DriveSettings()
        self._boot_ids = boot_ids or random.SystemRandom()
        self._was_found = False
        self._steps = 0
        self._start(ResetCause.POWER_ON)

    def boot(self, now_s: float) -> None:
        """Keep the constructor's boot at the first call; reset the processor at later ones."""
        if self._was_found:
            self._start(ResetCause.EXTERNAL)
        self._was_found = True

    def _start(self, cause: ResetCause) -> None:
        self.controller = RobotController(self._settings)
        identity = Identity(self._boot_ids.randrange(1, 1 << 32), reset_cause=cause)
        self._connection = RobotConnection(identity, self.controller)

    def bump(self, pressed: bool) -> None:
        """Press or release the emergency stop on the robot."""
        if pressed:
            self.controller.emergency_stop(StopReason.ESTOP_LOCAL)

    def receive(self, data: bytes, now_s: float) -> None:
        """Take the host's frames, in any portions."""
        self._connection.receive_bytes(data, now_s)

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """Watch the lease, and make a control cycle when one is due."""
        self._steps += 1
        if self._steps % CONTROL_EVERY:
            self.controller.tick(now_s)
            return self.controller.wheels
        per_m = self.body.ticks_per_m
        return self.controller.step(now_s, left_ticks / per_m, right_ticks / per_m)

    def bytes_to_send(self, now_s: float) -> bytes:
        """Return the most urgent due frame."""
        return self._connection.next_frame(now_s)

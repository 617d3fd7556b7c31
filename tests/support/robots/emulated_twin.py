"""The robot with its real firmware: an emulated microcontroller, in lockstep with the robot's time.

Bytes go to the emulated UART at its true baud rate; the motor outputs drive the wheels, whose
travel turns the emulated encoders. The robot's settings are compiled in. While the robot is frozen
its clock and watchdog stop, and the motors keep their last order. Whoever made it closes it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.simulator.drive_model import DriveModel
from navigation.simulator.twins.twin import STEP_S, Body, Twin
from tests.support.robots.emulated_processor import (
    TICK_M,
    EmulatedProcessor,
    EmulatorError,
    Motors,
)


class EmulatedTwin(Twin):
    """The robot on the emulator that ``command`` starts (:mod:`emulated_processor`).

    EmulatorError if it cannot be started, and from :meth:`step` when it has ended.
    """

    baud = math.inf
    has_frames = True

    def __init__(self, command: Sequence[str | Path], *, model: DriveModel | None = None) -> None:
        model = model or DriveModel()
        self.body = Body(model.track_m, 1.0 / TICK_M, model.max_wheel_m_s)
        self.motors = Motors(0.0, 0.0, False, 0.0, 0.0)
        self._waiting = b""
        self._said = b""
        self._ticks: tuple[int, int] | None = None
        self._was_found = self._is_reset = self._is_closed = False
        self._processor = EmulatedProcessor(command)

    def boot(self, now_s: float) -> None:
        """Keep the constructor's start at the first call; reset the processor at later ones."""
        self._is_reset = self._was_found
        self._was_found = True
        self._ticks = None
        self._waiting = b""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes for the UART, for the next step."""
        self._waiting += data

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """Run the processor for STEP_S while its wheels travel as before; at rest once closed."""
        before = self._ticks or (left_ticks, right_ticks)
        self._ticks = left_ticks, right_ticks
        travel_m = ((left_ticks - before[0]) * TICK_M, (right_ticks - before[1]) * TICK_M)
        waiting, self._waiting = self._waiting, b""
        is_reset, self._is_reset = self._is_reset, False
        try:
            self.motors, said = self._processor.run(STEP_S, waiting, travel_m, is_reset)
        except EmulatorError:
            if not self._is_closed:
                raise
            return WheelSpeeds(0.0, 0.0, powered=False)
        self._said += said
        return WheelSpeeds(self.motors.left_m_s, self.motors.right_m_s, self.motors.powered)

    def bytes_to_send(self, now_s: float) -> bytes:
        """Return the bytes that the UART has sent."""
        said, self._said = self._said, b""
        return said

    def close(self) -> None:
        """End the emulator, even during a step."""
        self._is_closed = True
        self._processor.close()

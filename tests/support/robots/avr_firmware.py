"""The AVR binary as one more robot of the scenarios, beside Python and C in this process.

``AvrFirmware`` has the face of ``RobotConnection`` (and, as ``controller``, what the loops use of
``RobotController``), but knows the robot from outside only: its motors' outputs, and what its
UART says. So a state is known ``TOLD_S`` late, and everything it reports is kept for a judge.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable

from firmware_protocol.robot.connection import Identity
from firmware_protocol.robot.controller import WheelSpeeds
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame
from firmware_protocol.wire.messages import (
    Ack,
    HelloAck,
    ResetCause,
    RobotState,
    Status,
    StopReason,
    read_message,
)
from tests.support.robots.avr_robot import AvrRobot
from tests.support.robots.emulated_processor import EmulatedProcessor, Motors

TOLD_S = 0.03
"""A change is told within 10 ms, behind a frame under way, by a frame of 8 ms."""
OVERFLOW_S = 0.032768
"""One step of the upper half of the firmware's clock."""
LONGEST_S = 0.002
"""Time that passes at once in one call; more means that the processor was frozen meanwhile."""


class AvrBoard:
    """Boards to be switched on and reset, as ``robot_maker`` wants it; :meth:`close` at the end.

    One board at a time: a power-on replaces the last one.
    """

    def __init__(self, build: AvrRobot) -> None:
        self.command = build.command
        names = subprocess.run(
            ["avr-nm", build.command[1]], check=True, capture_output=True, text=True, timeout=60
        )
        lines = (line.split() for line in names.stdout.splitlines())
        self._addresses = {parts[-1]: int(parts[0], 16) for parts in lines if len(parts) == 3}
        self._processor: EmulatedProcessor | None = None

    def __call__(self, identity: Identity, settings: DriveSettings) -> AvrFirmware:
        assert settings == DriveSettings(), "the settings are compiled in"
        if identity.reset_cause is ResetCause.POWER_ON:
            self.close()
        return AvrFirmware(self)

    def processor(self, clock_s: float) -> tuple[EmulatedProcessor, bool, float]:
        """The running processor, whether to reset it, and what its clock says then.

        A new one begins with about ``clock_s``: its clock's upper half can be chosen.
        """
        if self._processor is not None:
            return self._processor, True, 0.0
        upper = int(clock_s / OVERFLOW_S)
        numbers = (self._addresses["main"], self._addresses["overflows"] & 0xFFFF, upper)
        self._processor = EmulatedProcessor([*self.command, *(str(n) for n in numbers)])
        return self._processor, False, upper * OVERFLOW_S

    def close(self) -> None:
        """Switch the board off."""
        if self._processor is not None:
            self._processor.close()
            self._processor = None


class AvrFirmware:
    """One boot of a board."""

    def __init__(self, board: AvrBoard) -> None:
        self.controller = AvrController(self)
        self.encoders_m: Callable[[], tuple[float, float]] = lambda: (0.0, 0.0)
        self.motors = Motors(0.0, 0.0, False, 0.0, 0.0)
        self.hello: HelloAck | None = None
        self.reports: list[Status] = []
        self.last: WireFrame | None = None
        self.accept_next = 0
        self._board = board
        self._processor: EmulatedProcessor | None = None
        self._parser = FrameParser(Sender.ROBOT)
        self._arrived = b""
        self._asked_s = 0.0
        self._owed_s = 0.0
        self._offset_s = 0.0
        self._travelled_m = (0.0, 0.0)

    @property
    def identity(self) -> Identity:
        """What the last report said; the boot id is 0 before the first."""
        return Identity(self.reports[-1].boot_id if self.reports else 0)

    @property
    def session(self) -> int | None:
        return None if self.last is None else self.last.session

    @property
    def session_errors(self) -> int:
        return self.reports[-1].counters.session_errors if self.reports else 0

    @property
    def clock_s(self) -> float:
        """What the robot's own clock says, without its wrap."""
        return self._offset_s + self.motors.now_s

    def receive_bytes(self, data: bytes, now_s: float) -> None:
        self._arrived += data

    def next_frame(self, now_s: float) -> bytes:
        """Let the processor run until its clock, were it never frozen, says so.

        What its UART has sent meanwhile, no whole frames: it has taken its time there.
        """
        reset = False
        if self._processor is None:
            self._processor, reset, clock_s = self._board.processor(now_s)
            self._asked_s = now_s - 0.001
            self._travelled_m = self.encoders_m()
        self._owed_s += min(now_s - self._asked_s, LONGEST_S)
        self._asked_s = now_s
        whole_s = round(self._owed_s, 6)
        self._owed_s -= whole_s
        now_m, before_m = self.encoders_m(), self._travelled_m
        self._travelled_m = now_m
        travel = (now_m[0] - before_m[0], now_m[1] - before_m[1])
        first = self.motors.now_s == 0.0
        self.motors, said = self._processor.run(whole_s, self._arrived, travel, reset)
        if first:
            self._offset_s = clock_s + whole_s - self.motors.now_s
        self._arrived = b""
        for frame in self._parser.feed(said):
            self._hear(frame)
        return said

    def quiet_s(self) -> float:
        """0: it is asked in every turn."""
        return 0.0

    def _hear(self, frame: WireFrame) -> None:
        self.last = frame
        match message := read_message(frame):
            case HelloAck():
                self.hello = message
            case Ack(accept_next):
                self.accept_next = accept_next
            case Status():
                self.reports.append(message)
                self.accept_next = message.accept_next


class AvrController:
    """What the loops and scenarios use of ``RobotController``, as far as it is told."""

    def __init__(self, robot: AvrFirmware) -> None:
        self._robot = robot

    def __getattr__(self, name: str) -> int:
        """A number of the last report, or of HELLO_ACK before the first, else 0."""
        told = self._robot.reports[-1] if self._robot.reports else self._robot.hello
        return 0 if told is None else int(getattr(told, name))

    @property
    def accept_next(self) -> int:
        return self._robot.accept_next

    @property
    def credit(self) -> int:
        return 0 if self._robot.last is None else self._robot.last.credit

    @property
    def state(self) -> RobotState:
        return RobotState(self.__getattr__("state"))

    @property
    def reason(self) -> StopReason:
        return self._robot.reports[-1].reason if self._robot.reports else StopReason.NONE

    @property
    def wheels(self) -> WheelSpeeds:
        return WheelSpeeds(*self._robot.motors[:3])

    def tick(self, now_s: float) -> None:
        """The firmware has gone on in ``next_frame``, and looks at its limits by itself."""

    def step(self, now_s: float, left_m: float, right_m: float) -> None:
        """The firmware takes its control steps by itself."""

"""The robot under the real MicroPython, with the face of ``RobotConnection``.

It runs in a process of its own, its heap locked in every call.
"""

from __future__ import annotations

import struct
import subprocess
from pathlib import Path
from typing import NamedTuple

from firmware_protocol.robot.clearway import link
from firmware_protocol.robot.connection import Identity
from firmware_protocol.robot.controller import EIGHTHS_PER_M, LEAP_UM, WheelSpeeds
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import RobotState, StopReason
from tests.support.robots.micropython_commands import SETTINGS, VIEW
from tests.support.robots.robot_pair import IDENTITY, Pair

CLEARWAY = Path(link.__file__).parent
SERVER = Path(__file__).with_name("micropython_commands.py")


class View(NamedTuple):
    """A robot's state; a 32-bit number has two halves."""

    halves: tuple[int, ...]
    x_um: int
    y_um: int
    left: int
    right: int
    heading: int
    session_errors: int
    session: int
    state: int
    reason: int
    credit: int
    powered: bool
    done: bool
    expected: int
    phase: int

    def number(self, index: int) -> int:
        """Mission, accepted, executed and the two CRCs, in this order."""
        return self.halves[2 * index] | self.halves[2 * index + 1] << 16


NUMBERS = ("mission", "accept_next", "exec_next", "prefix_crc", "exec_crc")


class Process:
    """Commands for a robot under the real MicroPython; ``interpreter`` starts it."""

    def __init__(self, interpreter: list[str]) -> None:
        command = [*interpreter, str(SERVER), str(CLEARWAY.parent)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def answer(self, letter: bytes, now_us: int, data: bytes) -> bytes:
        """Give a command and wait for its answer."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(letter + struct.pack("<IH", now_us, len(data)) + data)
        self._process.stdin.flush()
        (count,) = struct.unpack("<H", self._read(2))
        return self._read(count)

    def _read(self, count: int) -> bytes:
        assert self._process.stdout is not None
        data = self._process.stdout.read(count)
        assert len(data) == count, "MicroPython has ended"
        return data

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.communicate()


class MicroRobot:
    """One boot of a robot behind commands."""

    def __init__(
        self,
        commands: Process,
        identity: Identity,
        drive: DriveSettings | None = None,
    ) -> None:
        self.identity = identity
        self._commands = commands
        numbers = (drive or DriveSettings()).whole_numbers()
        who = (identity.boot_id, identity.reset_cause, identity.schema)
        self.ask(b"I", 0.0, struct.pack(SETTINGS, *who, *numbers))
        self.controller = MicroController(self)
        self.wheels_um: tuple[int, int] | None = None

    def ask(self, letter: bytes, now_s: float, data: bytes = b"") -> bytes:
        """One command at a time."""
        return self._commands.answer(letter, round(now_s * 1e6) & 0xFFFFFFFF, data)

    def view(self) -> View:
        """The state now."""
        values = struct.unpack(VIEW, self.ask(b"V", 0.0))
        return View(values[:10], *values[10:])

    def receive_bytes(self, data: bytes, now_s: float) -> None:
        for at in range(0, len(data), 0xFFFF):
            self.ask(b"R", now_s, data[at : at + 0xFFFF])

    def next_frame(self, now_s: float) -> bytes:
        return self.ask(b"F", now_s)

    def quiet_s(self) -> float:
        """0: it is asked in every turn."""
        return 0.0

    @property
    def session(self) -> int | None:
        return self.view().session or None

    @property
    def session_errors(self) -> int:
        return self.view().session_errors


class MicroController:
    """What the loops and scenarios use of ``RobotController``."""

    def __init__(self, robot: MicroRobot) -> None:
        self._robot = robot

    def __getattr__(self, name: str) -> int:
        view = self._robot.view()
        return view.number(NUMBERS.index(name)) if name in NUMBERS else int(getattr(view, name))

    @property
    def state(self) -> RobotState:
        return RobotState(self._robot.view().state)

    @property
    def reason(self) -> StopReason:
        return StopReason(self._robot.view().reason)

    @property
    def wheels(self) -> WheelSpeeds:
        view = self._robot.view()
        return WheelSpeeds(
            view.left / EIGHTHS_PER_M, view.right / EIGHTHS_PER_M, bool(view.powered)
        )

    def tick(self, now_s: float) -> None:
        self._robot.ask(b"T", now_s)

    def step(self, now_s: float, left_m: float, right_m: float) -> WheelSpeeds:
        now_um = (round(left_m * 1e6), round(right_m * 1e6))
        before_um = self._robot.wheels_um or now_um
        self._robot.wheels_um = now_um
        travel = [
            max(-LEAP_UM, min(LEAP_UM, now - before))
            for now, before in zip(now_um, before_um, strict=True)
        ]
        self._robot.ask(b"S", now_s, struct.pack("<ii", *travel))
        return self.wheels

    def emergency_stop(self, reason: StopReason = StopReason.ESTOP_HOST) -> None:
        self._robot.ask(b"E", 0.0, bytes([reason]))


class MicroPair(Pair):
    """The robot here and under MicroPython, in place of the one in C."""

    def __init__(self, process: Process, settings: DriveSettings | None = None) -> None:
        self._process = process
        super().__init__(settings)

    def other(self) -> MicroRobot:  # type: ignore[override]
        return MicroRobot(self._process, IDENTITY, self.settings)

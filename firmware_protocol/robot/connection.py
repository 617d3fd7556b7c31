"""The robot's end of the link, sans-IO: bytes in, decisions through the controller, bytes out.

``clearway.link``, shared with MicroPython boards, reads and answers the line.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from firmware_protocol.robot.clearway.estimate import TIME
from firmware_protocol.robot.clearway.link import SESSION_ERRORS, Link
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.messages import SCHEMA_HASH, ResetCause

EARLY_US: Final = 2
"""Times are rounded to 1 us."""


@dataclass(frozen=True, slots=True)
class Identity:
    """The robot's name tag; ``boot_id`` differs from boot to boot."""

    boot_id: int
    firmware: int = 0
    reset_cause: ResetCause = ResetCause.POWER_ON
    schema: int = SCHEMA_HASH


class RobotConnection:
    """Reader of the host's bytes for a controller, and reporter of its state, by ``link``."""

    def __init__(self, identity: Identity, controller: RobotController) -> None:
        self.identity = identity
        self.controller = controller
        self.link = Link(
            controller.robot, identity.boot_id, identity.reset_cause, identity.firmware
        )
        self.link.frames.schema = identity.schema.to_bytes(4, "little")

    def receive_bytes(self, data: bytes, now_s: float) -> None:
        """Take bytes from the line, in any portion, and act on their frames."""
        self.link.receive(bytearray(data), len(data), self._pass_time(now_s))
        while self.controller.robot.sum():
            pass  # a board spreads this over its rounds

    def next_frame(self, now_s: float) -> bytes:
        """Return the most urgent due frame, empty if none is; call when the line is free."""
        size = self.link.next_frame(self._pass_time(now_s))
        return bytes(self.link.frame[:size]) if size else b""

    def quiet_s(self) -> float:
        """Seconds for which no frame is due if nothing arrives and no cycle is run.

        Not positive if one may be due.
        """
        return (self.link.quiet_us() - EARLY_US) / 1e6

    @property
    def session(self) -> int | None:
        """The session opened by a host."""
        return self.link.session or None

    @property
    def session_errors(self) -> int:
        """Frames of another session, or of none, modulo 2**16."""
        return self.link.count[SESSION_ERRORS]

    def _pass_time(self, now_s: float) -> int:
        """The robot's clock, modulo 2^30."""
        now_us = self.controller.pass_time(now_s)
        self.link.turns = now_us >> 30 & 3
        return now_us & TIME

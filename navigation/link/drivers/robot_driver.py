"""Protocol of a driver: one robot, sans-IO, bytes in and events out.

Metres, seconds, metres a second; forwards is positive on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from navigation.config.known_robots import KnownRobot


@dataclass(slots=True)
class Heard:
    """Everything heard from a robot; its driver writes it, all others read."""

    identity: str | None = None
    """Description of the robot that answers; None until it has."""
    left_m: float = 0.0
    """Travel of each wheel since the driver was first opened."""
    right_m: float = 0.0
    odometry_s: float | None = None
    """Arrival of the newest travel; None before the first."""
    fault: str | None = None
    """Reason why the robot must not drive, to be read after its name; None while it may."""
    held: str | None = None
    """Reason why it cannot be driven now although it answers, which may pass; None while it can."""
    remark: str | None = None
    """Remark on a robot that may be driven, to be read after its name."""
    battery: float | None = None
    """Charge, from 0 to 1."""
    messages: int = 0
    """Whole, undamaged ones."""
    damaged: int = 0
    """Messages that were lost in part, or did not fit."""
    stranger: str | None = None
    """Name of `KNOWN_ROBOTS` that these words suggest."""


class RobotDriver(Protocol):
    """Driver of one robot; `driven_robot` calls it at least a hundred times a second."""

    robot: KnownRobot
    heard: Heard

    def open(self, now_s: float) -> None:
        """Make the robot stop and answer, as the port is open, for the first time or again."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the robot, in any portion, with anything in between."""

    def drive(self, left_m_s: float, right_m_s: float) -> None:
        """Set the wheels' speeds; both zero is a stop."""

    def clear_fault(self) -> None:
        """Let it drive again on a person's word; a fault that persists returns."""

    def bytes_to_send(self, now_s: float) -> bytes:
        """Bytes due; call once the line has taken the last ones."""

"""What a driver is: one robot's protocol, sans-IO, bytes in and events out.

A driver keeps no clock and opens nothing. It has an answer to four questions: which robot is this,
how far have its wheels turned, what is wrong with it, how full is its battery. Metres, seconds,
metres a second; forwards is positive on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from navigation.config.known_robots import KnownRobot


@dataclass(slots=True)
class Heard:
    """What a robot has told so far; its driver writes it, everybody else reads."""

    identity: str | None = None
    """Who answers, in words; None until it has."""
    left_m: float = 0.0
    """How far the wheels have travelled since the driver was opened first."""
    right_m: float = 0.0
    odometry_s: float | None = None
    """When the newest travel came; None before the first."""
    fault: str | None = None
    """Why the robot must not drive, to be read after its name; None while it may."""
    held: str | None = None
    """Why it cannot be driven now although it answers, which may pass; None while it can."""
    remark: str | None = None
    """A remark for people on a robot that may be driven, to be read after its name."""
    battery: float | None = None
    """How full, from 0 to 1."""
    messages: int = 0
    """Whole, undamaged ones."""
    damaged: int = 0
    """Messages that were lost in part, or did not fit."""
    stranger: str | None = None
    """A name of `KNOWN_ROBOTS` whose words these seem to be."""


class RobotDriver(Protocol):
    """One robot; `driven_robot` calls it, at least a hundred times a second."""

    robot: KnownRobot
    heard: Heard

    def open(self, now_s: float) -> None:
        """The port is open, for the first time or again: the robot is to stop, and to answer."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Bytes from the robot, in any portion, with anything in between."""

    def drive(self, left_m_s: float, right_m_s: float) -> None:
        """How fast the wheels are to turn from now on; both zero is a stop."""

    def clear_fault(self) -> None:
        """A person says that it may drive again; a fault that still holds comes back."""

    def bytes_to_send(self, now_s: float) -> bytes:
        """What is due on the line; called when the line has taken what came before."""
        ...

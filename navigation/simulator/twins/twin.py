"""What every twin is to its surroundings: bytes and wheels, and what a person does to the robot.

Metres, seconds of the robot's own clock; a wheel's travel is positive forwards.
"""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

from firmware_protocol.robot.controller import WheelSpeeds

ON_FOR_S: Final = 60.0
"""A robot that a program finds was switched on so long before."""


class Body(NamedTuple):
    """The mechanics that the vendor states."""

    track_m: float
    ticks_per_m: float
    """Of the encoders."""
    wheel_m_s: float
    """The fastest that a wheel turns."""


class Twin(Protocol):
    """A robot without its line and its floor."""

    body: Body
    baud: int

    def boot(self, now_s: float) -> None:
        """Power on, or a reset of its processor."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Bytes from the line."""

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """A few milliseconds pass: its encoders stand so; what its motors are to do."""
        ...

    def bytes_to_send(self, now_s: float) -> bytes:
        """What it puts on the line now; called whenever the line is free."""
        ...

    def bump(self, pressed: bool) -> None:
        """Something touches its bumper, or no longer does; nothing where it has none."""

    def lift(self, lifted: bool) -> None:
        """Its wheels lose the floor, or find it again; nothing where it cannot feel that."""

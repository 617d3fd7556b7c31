"""The face of every twin: bytes, wheels and a person's actions.

Metres, seconds of the robot's own clock; a wheel's travel is positive forwards.
"""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

from firmware_protocol.robot.controller import WheelSpeeds

ON_FOR_S: Final = 60.0
"""Time since a robot was switched on when a program finds it."""
STEP_S: Final = 0.002
"""Step of a twin's time, in real time."""


class Body(NamedTuple):
    """Mechanics stated by the vendor."""

    track_m: float
    ticks_per_m: float
    """The resolution of the encoders."""
    wheel_m_s: float
    """A wheel's highest speed."""


class Twin(Protocol):
    """A robot without its line and its floor; a twin inherits what it has no part for."""

    body: Body
    has_frames: bool
    """True if its line carries Clearway's frames, which faults may double, swap and cut."""

    baud: float
    """Baud rate of its line; infinity if it paces its bytes itself."""

    def boot(self, now_s: float) -> None:
        """Switch on, or reset its processor."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the line."""

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """Let ``STEP_S`` pass with these encoder counts; return the motors' orders."""

    def bytes_to_send(self, now_s: float) -> bytes:
        """Return the bytes for the line now; called whenever the line is free."""

    def bump(self, pressed: bool) -> None:
        """Touch or release its bumper, or its emergency stop, if it has one."""
        return

    def lift(self, lifted: bool) -> None:
        """Take the wheels off the floor, or put them back, for its sensor if it has one."""
        return

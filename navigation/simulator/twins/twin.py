"""The face of every twin: bytes and wheels, and what a person does to the robot.

Metres, seconds of the robot's own clock; a wheel's travel is positive forwards.
"""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

from firmware_protocol.robot.controller import WheelSpeeds

ON_FOR_S: Final = 60.0
"""A robot that a program finds was switched on so long before."""
STEP_S: Final = 0.002
"""Time goes on for a twin by steps of this length, in real time."""


class Body(NamedTuple):
    """The mechanics that the vendor states."""

    track_m: float
    ticks_per_m: float
    """The resolution of the encoders."""
    wheel_m_s: float
    """The fastest that a wheel turns."""


class Twin(Protocol):
    """A robot without its line and its floor."""

    body: Body
    has_frames: bool
    """True if its line carries Clearway's own frames, which faults may double, swap and cut."""

    @property
    def baud(self) -> float:
        """Bits a second of its line; infinity where it paces its bytes itself."""
        ...

    def boot(self, now_s: float) -> None:
        """Power on, or a reset of its processor."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Bytes from the line."""

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """A few milliseconds pass: its encoders stand so; what its motors are to do."""
        ...

    def bytes_to_send(self, now_s: float) -> bytes:
        """The bytes that it puts on the line now; called whenever the line is free."""
        ...

    def bump(self, pressed: bool) -> None:
        """Something touches its bumper, or no longer does; nothing where it has none.

        On a robot with an emergency stop a person presses that.
        """

    def lift(self, lifted: bool) -> None:
        """Its wheels lose the floor, or find it again; nothing where it cannot feel that."""

    def close(self) -> None:
        """End what it runs on outside this process, also in the midst of a step."""

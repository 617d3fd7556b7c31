"""Both robots, the Python one and the firmware in C, side by side in virtual time."""

from __future__ import annotations

from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.robot.controller import RobotController
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    RELIABLE,
    SCHEMA_HASH,
    Confirm,
    Hello,
    Message,
    read_message,
)
from tests.support.robots.c_robot import CRobot
from tests.support.robots.inside import nonce_of

TICK_S = 0.000998
"""No multiple of it is a limit of the protocol: float and integer clocks agree."""

IDENTITY = Identity(boot_id=0xCAFE)


class Pair:
    """Both robots, fed with the same bytes at the same times."""

    def __init__(self, settings: DriveSettings | None = None) -> None:
        self.settings = settings or DriveSettings()
        self.python = RobotConnection(IDENTITY, RobotController(self.settings))
        self.c = self.other()
        self.ticks = 5000
        self.wheels_m = [0.0, 0.0]
        self.session, self.sequence = 0, 0

    def other(self) -> CRobot:
        """The robot that is compared."""
        return CRobot(IDENTITY, self.settings)

    @property
    def now_s(self) -> float:
        return self.ticks * TICK_S

    def feed(self, data: bytes) -> None:
        self.python.receive_bytes(data, self.now_s)
        self.c.receive_bytes(data, self.now_s)

    def send(
        self, message: Message, sequence: int | None = None, reliable: bool | None = None
    ) -> None:
        numbered = message.TYPE in RELIABLE if reliable is None else reliable
        number = self.sequence if sequence is None else sequence
        frame = WireFrame(
            message.TYPE, self.session, message.pack(), number if numbered else 0, reliable=numbered
        )
        if numbered and sequence is None:
            self.sequence = (self.sequence + 1) % 256
        self.feed(encode_frame(frame, Sender.HOST))

    @property
    def clock_us(self) -> int:
        """The robots' clock, as the wire has it."""
        return round(self.now_s * 1e6) % (1 << 32)

    def hello(self, session: int) -> None:
        """Ask for a session, and give the challenge back."""
        self.session, self.sequence = session, 0
        self.send(Hello(SCHEMA_HASH))
        if self.python.session != session:
            self.send(Confirm(nonce_of(self.python)))

    def pass_time(self, ticks: int) -> None:
        for _ in range(ticks):
            self.ticks += 1
            self.python.controller.tick(self.now_s)
            self.c.controller.tick(self.now_s)
            if self.ticks % 10 == 0:
                self.step()
            self.compare()

    def freeze(self, seconds: float) -> None:
        """Neither processor does anything for so long; their clocks go on."""
        self.ticks += round(seconds / TICK_S)

    def step(self) -> None:
        wheels = self.python.controller.wheels
        for side in (0, 1):
            self.wheels_m[side] += wheels[side] * 10 * TICK_S
        left, right = (round(m * 1e6) / 1e6 for m in self.wheels_m)
        self.python.controller.step(self.now_s, left, right)
        self.c.controller.step(self.now_s, left, right)
        assert self.c.controller.wheels == self.python.controller.wheels

    def compare(self) -> None:
        while True:
            ours, theirs = self.python.next_frame(self.now_s), self.c.next_frame(self.now_s)
            if ours == theirs:
                if not ours:
                    return
                continue
            assert frame_in(ours) == frame_in(theirs)
            raise AssertionError("the same frame in other bytes")


def frame_in(data: bytes) -> tuple[WireFrame, Message | None] | None:
    """What a robot's bytes say, for the assertion's text."""
    frames = FrameParser(Sender.ROBOT).feed(data)
    return (frames[0], read_message(frames[0])) if frames else None

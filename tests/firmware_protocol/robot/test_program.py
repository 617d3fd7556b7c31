"""The program of a board, on a board of this file: its clock, and the time on the line."""

from __future__ import annotations

import struct

import pytest

from firmware_protocol.robot.clearway.estimate import TIME
from firmware_protocol.robot.clearway.program import Program
from firmware_protocol.robot.clearway.settings import Settings
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    SCHEMA_HASH,
    Challenge,
    Confirm,
    Hello,
    MessageType,
    TimeSync,
    TimeSyncReply,
)

MINUTE_US = 60_000_000


class Bench:
    """A board whose clock is set by hand; its wheels do not turn."""

    def __init__(self) -> None:
        self.whole_us = 5_000_000
        """Of a clock without an end."""
        self.waiting = b""
        self.said: list[bytes] = []
        self.program = Program(self, Settings(), lambda: self.whole_us & TIME, 0xCAFE)

    def read(self, buffer: bytearray) -> int:
        part, self.waiting = self.waiting[: len(buffer)], self.waiting[len(buffer) :]
        buffer[: len(part)] = part
        return len(part)

    def can_write(self) -> bool:
        return True

    def write(self, view: memoryview) -> None:
        self.said.append(bytes(view))

    def travel_um(self, side: int) -> int:
        return 0

    def drive(self, left: int, right: int, powered: bool) -> None:
        """Its wheels do not turn."""

    def stop_pressed(self) -> bool:
        return False

    def ask(self, kind: MessageType, payload: bytes) -> None:
        self.waiting = encode_frame(WireFrame(kind, 3, payload), Sender.HOST)
        self.program.round()
        for _ in range(4):
            self.whole_us += 100
            self.program.round()

    def answer(self, kind: MessageType) -> WireFrame:
        parser = FrameParser(Sender.ROBOT)
        frames = [frame for data in self.said for frame in parser.feed(data)]
        self.said.clear()
        return next(frame for frame in frames if frame.kind == kind)

    def open_session(self) -> None:
        self.ask(MessageType.HELLO, Hello(SCHEMA_HASH).pack())
        challenge = Challenge.unpack(self.answer(MessageType.CHALLENGE).payload)
        self.ask(MessageType.CONFIRM, Confirm(challenge.nonce).pack())

    def told_us(self) -> int:
        """The robot's time as its line has it: when the question came."""
        began_us = self.whole_us
        self.ask(MessageType.TIMESYNC, TimeSync(1).pack())
        reply = TimeSyncReply.unpack(self.answer(MessageType.TIMESYNC_REPLY).payload)
        assert reply.robot_received_us == began_us % 2**32
        return reply.robot_received_us


def test_the_time_on_the_line_has_32_bits_though_the_boards_clock_has_30() -> None:
    bench = Bench()
    bench.open_session()
    for _ in range(40):
        bench.whole_us += 4 * MINUTE_US
        bench.told_us()
    assert bench.whole_us > 2 * 2**32, "it has come round more than once"


@pytest.mark.parametrize("turn", [1, 2, 4])
def test_a_clock_that_is_set_back_has_not_come_round(turn: int) -> None:
    """Also where the steps back and forth lead over the end of a turn."""
    bench = Bench()
    bench.open_session()
    while bench.whole_us < turn * (TIME + 1):
        bench.whole_us += 4 * MINUTE_US
        bench.told_us()
    for step_us in (300, -2_000, 7_000, -5_000):
        bench.whole_us = turn * (TIME + 1) + step_us
        bench.told_us()


def test_an_order_of_a_minute_ago_is_not_obeyed() -> None:
    bench = Bench()
    bench.open_session()
    stamp_us = bench.told_us()
    bench.whole_us += MINUTE_US
    bench.ask(MessageType.LEASE, struct.pack("<IHHB", stamp_us, 500, 0, 3))
    assert not bench.program.robot.lease_valid

"""A robot that says anything at any time: no order of its frames and of ours is an error here."""

import random
from collections import Counter
from collections.abc import Callable
from functools import cache

import pytest

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.state import LinkState
from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import Ack, Challenge, HelloAck, Status, TimeSyncReply
from tests.firmware_protocol.host.table import Table, line


class Overheard(Table):
    """Every frame that a robot sends to the host, kept."""

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self.frames: list[WireFrame] = []
        self._parser = FrameParser(Sender.ROBOT)

    def to_host(self, data: bytes) -> list[bytes]:
        self.frames += self._parser.feed(data)
        return [data]


def true_frames() -> list[WireFrame]:
    """What an honest robot sends: greeted, driving, stopped, rebooted, of another version."""
    table = Overheard(1)
    table.run(0.4)
    table.host.upload(line(count=6), table.now_s)
    table.run(1.0)
    table.host.estop()
    table.run(0.3)
    table.host.reset_estop(table.now_s)
    table.run(0.5)
    table.boot(2)
    table.run(1.5)
    table.boot(3, schema=7)
    table.run(4.0)
    return table.frames


@cache
def true_by_kind() -> dict[int, list[WireFrame]]:
    """By kind, so that a greeting comes as often as one of a thousand reports."""
    frames = true_frames()
    return {
        kind: list({frame.payload: frame for frame in frames if frame.kind == kind}.values())
        for kind in (HelloAck.TYPE, Challenge.TYPE, Ack.TYPE, Status.TYPE, TimeSyncReply.TYPE)
    }


def a_lie(rng: random.Random, host: HostConnection) -> WireFrame:
    """One of those in the host's own session, now and then with other bytes in it."""
    frames = true_by_kind()
    true = rng.choice(frames[rng.choice(list(frames))])
    payload = bytearray(true.payload)
    if payload and rng.random() < 0.4:
        payload[rng.randrange(len(payload))] = rng.randrange(256)
    return WireFrame(
        true.kind, host._sessions.present, bytes(payload), true.sequence,
        rng.choice((true.acknowledged, rng.randrange(256))), rng.randrange(256),
        true.reliable, rng.random() < 0.1,
    )  # fmt: skip


def an_order(rng: random.Random, host: HostConnection, now_s: float) -> Callable[[], object]:
    """What a program may ask of the link; a LocalError is its own mistake and changes nothing."""
    return rng.choice(
        (
            lambda: host.upload(line(rng.randrange(1, 9), rng.randrange(1, 60)), now_s),
            lambda: host.start(now_s), host.pause, host.clear, host.estop,
            lambda: host.reset_estop(now_s), lambda: host.lease(now_s, 0.5, True),
            host.close, lambda: host.open(now_s),
        )
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_nothing_that_a_robot_says_raises(seed: int) -> None:
    rng = random.Random(seed)
    host, now_s, met = HostConnection(random.Random(seed)), 0.0, Counter[LinkState]()
    host.open(now_s)
    for _ in range(1500):
        now_s += rng.choice((0.0, 0.002, 0.02, 0.02, 0.4))
        host.receive_bytes(encode_frame(a_lie(rng, host), Sender.ROBOT), now_s)
        host.tick(now_s)
        host.bytes_to_send(now_s)
        if rng.random() < 0.05:
            before = host.state
            try:
                an_order(rng, host, now_s)()
            except LocalError:
                assert host.state is before
        if host.state is LinkState.CLOSED and rng.random() < 0.3:
            host.open(now_s)
        while host.next_event() is not None:
            pass
        met[host.state] += 1
    assert len(met) >= 5, met


def test_the_lies_reach_every_state() -> None:
    rng, host, now_s = random.Random(99), HostConnection(random.Random(99)), 0.0
    host.open(now_s)
    met = {host.state}
    for step in range(20_000):
        now_s += rng.choice((0.002, 0.02, 0.4))
        if step % 50 == 0:
            host.upload(line(step + 1, 2), now_s)
        host.receive_bytes(encode_frame(a_lie(rng, host), Sender.ROBOT), now_s)
        host.tick(now_s)
        host.bytes_to_send(now_s)
        met.add(host.state)
    assert met >= set(LinkState) - {LinkState.CLOSED, LinkState.DRAIN}, set(LinkState) - met

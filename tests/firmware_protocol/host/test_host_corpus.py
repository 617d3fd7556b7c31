"""The fuzzers' kept inputs into the host's end: nothing raises, and portions do not matter."""

import random

import pytest

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.state import LinkState
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame, encode_frame
from tests.support.wire.corpus import inputs


@pytest.mark.parametrize("name", ["link", "robot"])
def test_the_host_survives_the_corpus_raw_and_in_whole_frames(name: str) -> None:
    host, now_s = HostConnection(random.Random(1)), 0.0
    host.open(now_s)
    for stream in inputs(name):
        kind = stream[0] if stream else 0
        frame = WireFrame(
            kind, host._sessions.present, stream[:112], acknowledged=len(stream) % 256
        )
        for data in (stream, encode_frame(frame, Sender.ROBOT)):
            now_s += 0.01
            host.receive_bytes(data, now_s)
            host.tick(now_s)
            host.bytes_to_send(now_s)
        while host.next_event() is not None:
            pass
    assert host.parser.counters.frames >= len(inputs(name))
    assert host.counters.nonsense > 0, "frames of nonsense have reached the messages"
    assert host.state is not LinkState.CLOSED


@pytest.mark.parametrize("name", ["link", "robot"])
def test_the_corpus_parses_alike_whole_and_byte_by_byte(name: str) -> None:
    stream = b"".join(inputs(name))
    for sender in Sender:
        whole, bytewise = FrameParser(sender), FrameParser(sender)
        frames = whole.feed(stream)
        assert [frame for value in stream for frame in bytewise.feed(bytes([value]))] == frames
        assert whole.counters == bytewise.counters

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.framing import (
    HEADER_BYTES,
    MAX_PAYLOAD,
    MAX_WIRE,
    OVERHEAD,
    FrameParser,
    Sender,
    WireFrame,
    encode_frame,
)

BYTE = st.integers(0, 255)
FRAMES = st.builds(
    WireFrame,
    kind=BYTE,
    session=st.integers(0, 0xFFFF),
    payload=st.binary(max_size=MAX_PAYLOAD),
    sequence=BYTE,
    acknowledged=BYTE,
    credit=BYTE,
    reliable=st.booleans(),
    nak=st.booleans(),
)
SENDERS = st.sampled_from(Sender)


@given(st.lists(FRAMES, max_size=5), SENDERS)
def test_frames_survive_the_wire_whole(frames: list[WireFrame], sender: Sender) -> None:
    parser = FrameParser(sender)
    assert parser.feed(b"".join(encode_frame(f, sender) for f in frames)) == frames
    assert parser.counters.faults == 0


@given(st.lists(FRAMES, max_size=3), SENDERS)
def test_frames_survive_the_wire_byte_by_byte(frames: list[WireFrame], sender: Sender) -> None:
    parser, read = FrameParser(sender), []
    for value in b"".join(encode_frame(f, sender) for f in frames):
        read += parser.feed(bytes([value]))
    assert read == frames


@given(FRAMES, st.binary(max_size=300), st.binary(max_size=300))
def test_frame_is_found_among_garbage(frame: WireFrame, before: bytes, after: bytes) -> None:
    parser = FrameParser(Sender.HOST)
    stream = before + encode_frame(frame, Sender.HOST) + after
    assert frame in parser.feed(stream)


@given(st.binary(max_size=2000), st.lists(st.integers(0, 2000), max_size=10))
def test_portions_do_not_matter(stream: bytes, cuts: list[int]) -> None:
    whole, cut = FrameParser(Sender.ROBOT), FrameParser(Sender.ROBOT)
    at = 0
    read: list[WireFrame] = []
    for end in [*sorted(cuts), len(stream)]:
        read += cut.feed(stream[at:end])
        at = max(at, end)
    assert read == whole.feed(stream)
    assert cut.counters == whole.counters


@given(FRAMES)
def test_frame_has_no_zero_inside_and_the_stated_size(frame: WireFrame) -> None:
    wire = encode_frame(frame, Sender.HOST)
    assert wire[0] == wire[-1] == 0
    assert 0 not in wire[1:-1]
    assert len(wire) == len(frame.payload) + OVERHEAD <= MAX_WIRE


@given(FRAMES, st.data())
def test_a_damaged_frame_is_never_taken(frame: WireFrame, draw: st.DataObject) -> None:
    wire = bytearray(encode_frame(frame, Sender.HOST))
    at = draw.draw(st.integers(1, len(wire) - 2))
    match draw.draw(st.sampled_from(["flip", "drop", "double"])):
        case "flip":
            wire[at] ^= 1 << draw.draw(st.integers(0, 7))
        case "drop":
            del wire[at]
        case "double":
            wire.insert(at, wire[at])
    parser = FrameParser(Sender.HOST)
    read = parser.feed(bytes(wire))
    if bytes(wire) == encode_frame(frame, Sender.HOST):
        assert read == [frame]  # a doubled code byte may give the same frame
    else:
        assert read == []
        assert parser.counters.faults >= 1


def test_an_echo_is_counted_and_not_taken() -> None:
    parser = FrameParser(Sender.ROBOT)
    assert parser.feed(encode_frame(WireFrame(1, 2, b"x"), Sender.HOST)) == []
    assert parser.counters.echoes == 1


def test_every_kind_of_fault_has_its_own_count() -> None:
    parser = FrameParser(Sender.HOST)
    good = encode_frame(WireFrame(0x20, 1, b"abc"), Sender.HOST)
    parser.feed(b"\0\x05ab\0")  # COBS points beyond the end
    parser.feed(b"\0\x03ab\0")  # too short for a header
    parser.feed(good[:-2] + bytes([good[-2] ^ 1 or 2]) + b"\0")
    parser.feed(b"\0" + b"\x01" * 400 + b"\0")
    parser.feed(encode_frame(WireFrame(0x20, 1, version=2), Sender.HOST))
    count = parser.counters
    assert (count.cobs_errors, count.short_frames, count.crc_errors) == (1, 1, 1)
    assert (count.oversize, count.version_errors, count.frames) == (1, 1, 0)
    assert parser.feed(good) != []
    assert count.faults == 5


def test_a_wrong_length_byte_is_refused() -> None:
    from cobs import cobs

    from firmware_protocol.wire.crc import crc32c

    body = bytes([0x10, 0x20, 0, 0, 0, 0, 0, 5]) + b"abc"
    check = crc32c(b"H" + body).to_bytes(4, "little")
    parser = FrameParser(Sender.HOST)
    assert parser.feed(b"\0" + cobs.encode(body + check) + b"\0") == []
    assert parser.counters.length_errors == 1


def test_hello_is_read_from_any_version() -> None:
    frame = WireFrame(0x01, 9, b"??", version=7)
    assert FrameParser(Sender.HOST).feed(encode_frame(frame, Sender.HOST)) == [frame]


@pytest.mark.parametrize(
    "frame",
    [
        WireFrame(1, 0, bytes(MAX_PAYLOAD + 1)),
        WireFrame(256, 0),
        WireFrame(1, 0x10000),
        WireFrame(1, 0, sequence=-1),
    ],
)
def test_what_does_not_fit_is_refused(frame: WireFrame) -> None:
    with pytest.raises(LocalError):
        encode_frame(frame, Sender.HOST)


def test_the_header_has_the_documented_layout() -> None:
    from cobs import cobs

    frame = WireFrame(0x10, 0xABCD, b"\x07", 3, 4, 5, reliable=True, nak=True)
    raw = cobs.decode(encode_frame(frame, Sender.HOST)[1:-1])
    assert raw[:HEADER_BYTES] == bytes([0x13, 0x10, 0xCD, 0xAB, 3, 4, 5, 1])

import json

import pytest

from firmware_protocol.wire.crc import crc32c
from firmware_protocol.wire.framing import FrameParser, Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import read_message
from tests.support.wire import protocol_vectors

GOLDEN = json.loads(protocol_vectors.GOLDEN.read_text())


def test_the_wire_has_not_changed() -> None:
    assert protocol_vectors.GOLDEN.read_text() == protocol_vectors.text()


@pytest.mark.parametrize("vector", GOLDEN["frames"], ids=lambda v: v["name"])
def test_golden_frame_is_read_and_written(vector: dict[str, object]) -> None:
    sender = Sender[str(vector["sender"]).upper()]
    wire = bytes.fromhex(str(vector["wire"]))
    (frame,) = FrameParser(sender).feed(wire)
    for key in ("session", "sequence", "acknowledged", "credit", "reliable", "nak"):
        assert getattr(frame, key) == vector[key]
    assert frame.kind == vector["type"]
    assert frame.payload.hex() == vector["payload"]
    message = read_message(frame)
    assert message.pack() == frame.payload
    again = WireFrame(
        frame.kind,
        frame.session,
        message.pack(),
        frame.sequence,
        frame.acknowledged,
        frame.credit,
        frame.reliable,
        frame.nak,
    )
    assert encode_frame(again, sender) == wire


def test_golden_prefix_crcs_hold() -> None:
    mission = GOLDEN["mission"]
    running = crc32c(mission["id"].to_bytes(4, "little"))
    assert running == mission["seed"] == mission["prefix_crcs"][0]
    for record, expected in zip(mission["records"], mission["prefix_crcs"][1:], strict=True):
        running = crc32c(bytes.fromhex(record), running)
        assert running == expected

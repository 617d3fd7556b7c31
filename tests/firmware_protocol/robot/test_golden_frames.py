"""The golden vectors of the wire on the robot's own codec, which shares no code with the host's."""

from __future__ import annotations

import json

import pytest

from firmware_protocol.robot.clearway.frames import Frames
from firmware_protocol.robot.clearway.link import CRC_ERRORS, FORMAT_ERRORS, FRAMES, NAK, Link
from firmware_protocol.robot.clearway.robot import NO_POSE_MS, Robot
from firmware_protocol.robot.clearway.settings import Settings
from firmware_protocol.robot.clearway.states import HOLD, RUN
from firmware_protocol.robot.clearway.waypoints import QUEUE_SIZE
from firmware_protocol.robot.clearway.wire import SCHEMA_HASH, array
from firmware_protocol.wire.messages import ResetCause, StatusFlag
from tests.support.wire import protocol_vectors

GOLDEN = json.loads(protocol_vectors.GOLDEN.read_text())
VECTORS = {vector["name"]: vector for vector in GOLDEN["frames"]}
OF_HOST = [vector for vector in GOLDEN["frames"] if vector["sender"] == "host"]
NONCE = 0xC0FFEE01
NUMBERS = (7, 40, 9, 0x12345678, 0x9ABCDEF0)
"""Mission, accepted, executed and the two CRCs of the vectors' robot."""


@pytest.mark.parametrize("vector", OF_HOST, ids=lambda vector: vector["name"])
def test_a_golden_frame_of_the_host_is_read(vector: dict[str, object]) -> None:
    link = Link(Robot(Settings()), 1)
    wire = bytearray.fromhex(str(vector["wire"]))
    link.receive(wire, len(wire), 0)
    assert [link.count[one] for one in (FRAMES, CRC_ERRORS, FORMAT_ERRORS)] == [1, 0, 0]
    body = bytes(link._buffer[: link._filled])
    assert body[8:-4].hex() == vector["payload"]


def frames_like(vector: dict[str, int]) -> tuple[Robot, Frames]:
    """The robot of the vectors, and its frames with this one's header."""
    robot = Robot(Settings())
    robot.numbers[:] = array("H", [half for n in NUMBERS for half in (n & 0xFFFF, n >> 16)])
    frames = Frames(robot, 0xCAFEF00D, ResetCause.BROWN_OUT, 0x01020304)
    frames.expected = vector["acknowledged"]
    robot.queue.count = QUEUE_SIZE - vector["credit"]
    return robot, frames


def assert_golden(frames: Frames, size: int, vector: dict[str, int]) -> None:
    assert bytes(frames.frame[:size]).hex() == vector["wire"]


def test_the_robots_greeting_is_golden() -> None:
    vector = VECTORS["hello answered"]
    robot, frames = frames_like(vector)
    robot.state = HOLD
    assert_golden(frames, frames.hello_ack(vector["session"]), vector)


def test_the_robots_challenge_is_golden() -> None:
    vector = VECTORS["challenge"]
    _, frames = frames_like(vector)
    nonce = array("H", (NONCE & 0xFFFF, NONCE >> 16))
    assert_golden(frames, frames.challenge(vector["session"], nonce), vector)


def test_the_robots_acknowledgement_is_golden() -> None:
    vector = VECTORS["acknowledgement"]
    robot, frames = frames_like(vector)
    robot.numbers[2] = 36
    assert_golden(frames, frames.ack(vector["session"], NAK), vector)


def test_the_robots_time_is_golden() -> None:
    vector = VECTORS["time reply"]
    _, frames = frames_like(vector)
    host, then, clock = (bytearray(n.to_bytes(4, "little")) for n in (0xFFFFFFFF, 0, 250))
    assert_golden(frames, frames.time(vector["session"], host, then, clock), vector)


def test_the_robots_status_is_golden(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some of it no robot would say together; what says it is put in its place."""
    vector = VECTORS["status"]
    robot, frames = frames_like(vector)
    robot.state, robot.reason, robot.speed = RUN, 0, -300 * 8
    frames.result, frames.command = 1, 3
    robot.estimate.pose[:] = array("i", (-1_250_000, 750_000, 0x4000, 0))
    flags = StatusFlag.MOVING | StatusFlag.PERMIT | StatusFlag.POSE_KNOWN
    said = {"flags": flags, "turning_mrad_s": 500, "lease_left_ms": 450, "pose_age_ms": NO_POSE_MS}
    for name, number in said.items():
        monkeypatch.setattr(robot, name, lambda number=number: number)
    clock = bytearray((0xFFFFFFFE).to_bytes(4, "little"))
    counters = array("H", (1, 2, 3, 4, 5, 6, 7, 65_535))
    assert_golden(frames, frames.status(vector["session"], clock, counters), vector)


def test_the_schema_is_golden() -> None:
    assert int.from_bytes(SCHEMA_HASH, "little") == GOLDEN["schema"]

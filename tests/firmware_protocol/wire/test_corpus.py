"""What the fuzzers found worth keeping, run again: in C under sanitizers, and on both robots.

``firmware/fuzz.c`` says what an input's bytes mean, ``tests/support/wire/corpus.py`` where they
come from.
"""

from __future__ import annotations

import struct
import subprocess
from pathlib import Path

import pytest

from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    Clear,
    Lease,
    LeaseFlag,
    MessageType,
    PoseFix,
    Start,
)
from firmware_protocol.wire.values import heading_from_wire
from tests.support.robots.c_robot import FIRMWARE, missing_tool
from tests.support.robots.inside import expected_of
from tests.support.robots.robot_pair import Pair
from tests.support.wire.corpus import CORPUS, inputs

SESSION = 7

pytestmark = pytest.mark.skipif(
    missing_tool() is not None, reason=f"needs {missing_tool()} to build the firmware"
)


@pytest.fixture(scope="module")
def build(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("replay")
    command = ["make", "-s", "-C", str(FIRMWARE), "replay", f"BUILD={folder}"]
    subprocess.run(command, check=True, timeout=180)
    return folder


@pytest.mark.parametrize("name", ["link", "robot"])
def test_the_corpus_breaks_no_rule_and_no_sanitizer_complains(build: Path, name: str) -> None:
    text = (CORPUS / f"{name}.txt").read_text()
    command = [str(build / f"replay_{name}")]
    done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("part", range(4))
def test_any_bytes_of_the_corpus_leave_both_robots_alike(part: int) -> None:
    for stream in inputs("link")[part::4]:
        pair = Pair()
        pair.hello(SESSION)
        pair.send(Clear(2, 9))
        while stream:
            length = stream[0] % 61 + 1
            pair.feed(stream[:length])
            pair.pass_time(5)
            stream = stream[length:]


@pytest.mark.parametrize("part", range(8))
def test_the_deeds_of_the_corpus_leave_both_robots_alike(part: int) -> None:
    running = 0
    for stream in inputs("robot")[part::24]:  # a third of them: the rest would take too long
        pair = Pair()
        pair.hello(SESSION)
        pair.send(Clear(2, 9))
        while len(stream) >= 2:
            length = min(stream[1], 112, len(stream) - 2)
            do(pair, stream[0], stream[1], stream[2 : 2 + length])
            pair.compare()
            running += pair.python.controller.state.name == "RUN"
            stream = stream[2 + length :]
    assert running > 0, "the corpus drives"


def do(pair: Pair, deed: int, length: int, rest: bytes) -> None:
    """One deed as ``fuzz.c`` reads it; time passes in this test's own steps."""
    control = pair.python.controller
    pair.sequence = expected_of(pair.python)
    match deed & 7:
        case 0:
            pair.feed(rest)
        case 1:
            kind = rest[0] if rest else 0
            frame = WireFrame(kind, SESSION, rest, pair.sequence, reliable=bool(deed & 0x10))
            pair.feed(encode_frame(frame, Sender.HOST))
        case 2:
            count = min(len(rest) // 16 % 7, 6)
            head = struct.pack("<IIBB", control.mission, control.accept_next, count, 0)
            payload = head + rest[: 16 * count]
            frame = WireFrame(MessageType.WAYPOINTS, SESSION, payload, pair.sequence, reliable=True)
            pair.feed(encode_frame(frame, Sender.HOST))
        case 3:
            lease(pair, LeaseFlag.PERMIT | LeaseFlag.ODOMETRY)
            pair.send(Start(1, control.mission, control.exec_next))
        case 4:
            lease(pair, LeaseFlag(deed >> 6))
            pair.pass_time(10 * (deed >> 3 & 7))
        case 5:
            pair.pass_time(10 * (deed >> 3))
        case 6:
            see(pair, rest)
        case _ if deed > 0xF0:
            pair.feed(ESTOP_FRAME)
        case _ if deed > 0xE0:
            pair.send(Clear(2, length))
        case _:
            pair.pass_time(length)


def lease(pair: Pair, flags: LeaseFlag) -> None:
    pair.send(Lease(0.5, flags, 0.01, pair.clock_us))


def see(pair: Pair, rest: bytes) -> None:
    """A pose, where the bytes are one."""
    if len(rest) >= 12:
        x_um, y_um = (int.from_bytes(rest[at : at + 4], "little", signed=True) for at in (0, 4))
        heading = int.from_bytes(rest[8:10], "little", signed=True) % 31416
        if -(2**31) not in (x_um, y_um):
            heading_rad = heading_from_wire(heading)
            assert heading_rad is not None
            seen_us = pair.clock_us - 100 * int.from_bytes(rest[10:12], "little")
            pair.send(PoseFix(x_um / 1e6, y_um / 1e6, heading_rad, seen_us % 2**32))

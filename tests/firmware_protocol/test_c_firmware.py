"""The C firmware against the robot in Python: same bytes in, same bytes out."""

import ctypes
import random
import re
import subprocess
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.wire.crc import crc32c
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    SCHEMA_HASH,
    Clear,
    Confirm,
    Hello,
    Lease,
    LeaseFlag,
    MessageType,
    Pause,
    PoseFix,
    ResetEstop,
    RobotState,
    Start,
    TimeSync,
    Waypoint,
    Waypoints,
)
from firmware_protocol.wire.mission import Mission
from navigation.link.serial_link import SerialLink
from tests.support.robots.c_robot import FIRMWARE, CRobot, library, missing_tool
from tests.support.robots.inside import expected_of, nonce_of
from tests.support.robots.robot_pair import Pair
from tests.support.waiting import wait_until
from tests.support.wire.fault_scenarios import SCENARIOS, robot_maker

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        missing_tool() is not None, reason=f"needs {missing_tool()} to build the firmware"
    ),
]

MISSION = Mission(9, [Waypoint(0.02 * i, 0.001 * i, 0.3) for i in range(60)])


def random_deed(pair: Pair, rng: random.Random) -> None:
    control = pair.python.controller
    command = rng.randrange(1, 0x10000)
    match rng.randrange(18):
        case 0:
            pair.hello(rng.randrange(1, 12))
        case 1:
            pair.send(Clear(command, rng.choice([0, 9, 9, 9, 10])))
        case 2 | 3 | 4:
            first = rng.choice([control.accept_next, rng.randrange(60)])
            records = MISSION.records[first : first + rng.randrange(1, 7)]
            if records:
                pair.send(Waypoints(9, first, records))
        case 5:
            pair.send(Start(command, 9, rng.choice([control.exec_next, 3])))
        case 6:
            pair.send(Pause(command))
        case 7 | 8:
            flags = rng.choice([LeaseFlag.PERMIT | LeaseFlag.ODOMETRY, LeaseFlag.PERMIT])
            given_us = pair.clock_us - rng.choice([0, 4_000, 200_000, 500_000, -15_000, -30_000])
            given_us = rng.choice([given_us % 2**32] * 9 + [rng.getrandbits(32)])
            pair.send(Lease(rng.random(), flags, rng.choice([0.05, 0.9]), given_us))
        case 9:
            pose = control.pose
            offset = rng.choice([0.0, 0.01, 0.3])
            age_us = rng.choice([round(rng.random() * 3e5)] * 9 + [-10_000, 600_000, 2**31])
            seen_us = (pair.clock_us - age_us) % 2**32
            pair.send(PoseFix(pose.x_m + offset, pose.y_m, pose.heading_rad, seen_us))
        case 10:
            pair.send(TimeSync(rng.getrandbits(32)))
        case 11:
            wire = bytearray(encode_frame(WireFrame(rng.randrange(256), pair.session), Sender.HOST))
            wire[rng.randrange(len(wire))] ^= 1 << rng.randrange(8)
            pair.feed(bytes(wire))
        case 12:
            payload = rng.randbytes(rng.randrange(113))
            kind = rng.choice([*MessageType, rng.randrange(256)])
            number = rng.choice([expected_of(pair.python), rng.randrange(256)])
            reliable = rng.random() < 0.5
            if kind != MessageType.ESTOP:
                frame = WireFrame(kind, pair.session, payload, number, reliable=reliable)
                pair.feed(encode_frame(frame, Sender.HOST))
        case 13:
            session = rng.choice([pair.session, pair.session, rng.randrange(1, 12)])
            kind, payload = rng.choice(
                [
                    (MessageType.HELLO, Hello(SCHEMA_HASH).pack()),
                    (MessageType.CONFIRM, Confirm(rng.getrandbits(32)).pack()),
                    (MessageType.CONFIRM, Confirm(nonce_of(pair.python)).pack()),
                ]
            )
            pair.feed(encode_frame(WireFrame(kind, session, payload), Sender.HOST))
        case 14:
            pair.feed(rng.randbytes(rng.randrange(400)))
        case _:
            begin_to_drive(pair, rng)


def begin_to_drive(pair: Pair, rng: random.Random) -> None:
    """What a sane host does, from whatever the fuzzing has left."""
    control = pair.python.controller
    pair.sequence = expected_of(pair.python)
    if control.mission != 9 or control.done:
        pair.send(Clear(1, 0))
        pair.send(Clear(2, 9))
    first = control.accept_next
    records = MISSION.records[first : first + 6]
    if records:
        pair.send(Waypoints(9, first, records))
    for _ in range(rng.randrange(1, 8)):
        pair.send(Lease(0.5, LeaseFlag.PERMIT | LeaseFlag.ODOMETRY, 0.05, pair.clock_us))
        pair.send(Start(3, 9, control.exec_next))
        pair.pass_time(100)


@pytest.mark.parametrize("seed", range(40))
def test_both_robots_answer_alike_whatever_the_host_does(seed: int) -> None:
    rng, least_m_s = random.Random(seed), (0.01, 0.0, 0.03, 0.2)[seed % 4]
    pair = Pair(DriveSettings(least_wheel_m_s=least_m_s))
    pair.hello(20)
    for deed in range(150):
        random_deed(pair, rng)
        if deed % 50 == 49 and seed % 4 == 0:
            pair.feed(ESTOP_FRAME)
            pair.pass_time(30)
            pair.hello(30 + deed)
            pair.send(ResetEstop(1))
        pair.pass_time(rng.choice([1, 3, 20, 60]))


def test_a_robot_that_brakes_sees_the_line_of_its_new_mission() -> None:
    """The line to the next waypoint is measured once; with the queue it has to be forgotten."""
    pair = Pair()
    pair.hello(20)
    begin_to_drive(pair, random.Random(1))
    x_m, y_m, _ = pair.python.controller.pose
    beside = Mission(10, [Waypoint(x_m - 0.02, y_m - 0.1 * i, 0.3) for i in range(3, 6)])
    assert pair.python.controller.wheels.left_m_s > 0.0
    pair.send(Clear(5, beside.id))
    pair.send(Waypoints(beside.id, 0, beside.records))
    pair.pass_time(100)
    assert pair.python.controller.exec_next == 0, "none of them lies on its way"


@given(st.binary(max_size=600), st.lists(st.integers(0, 600), max_size=6))
@settings(max_examples=200, deadline=None)
def test_any_bytes_in_any_portions_leave_both_alike(stream: bytes, cuts: list[int]) -> None:
    pair = Pair()
    pair.hello(3)
    at = 0
    for end in [*sorted(cuts), len(stream)]:
        pair.feed(stream[at:end])
        at = max(at, end)
        pair.pass_time(4)
    pair.send(Clear(1, 77))
    pair.pass_time(60)
    assert pair.python.controller.mission == pair.c.controller.mission


@given(st.binary(max_size=130), st.integers(0, 0xFFFFFFFF))
def test_crc_is_the_same_in_c(data: bytes, running: int) -> None:
    length, start = ctypes.c_uint16(len(data)), ctypes.c_uint32(running)
    assert library().cw_crc32c(data, length, start) == crc32c(data, running)


def test_the_c_headers_have_the_schema_and_the_emergency_stop() -> None:
    text = (FIRMWARE / "wire.h").read_text()
    (schema,) = re.findall(r"CW_SCHEMA_HASH 0x([0-9a-f]+)ul", text)
    assert int(schema, 16) == SCHEMA_HASH
    frame = (ctypes.c_uint8 * 15).in_dll(library(), "cw_estop_frame")
    assert bytes(frame) == ESTOP_FRAME


def test_the_interrupts_matcher_finds_the_emergency_stop_and_nothing_else() -> None:
    match = library().cw_estop_match
    match.restype = ctypes.c_bool
    matched = ctypes.c_uint8(0)

    def found(data: bytes) -> int:
        return sum(match(ctypes.byref(matched), ctypes.c_uint8(byte)) for byte in data)

    assert found(b"\x00\x03\x10" + ESTOP_FRAME) == 1
    assert found(ESTOP_FRAME[1:]) == 1, "the last zero is the next frame's first"
    assert found(ESTOP_FRAME * 3) == 3
    rng = random.Random(1)
    for _ in range(200):
        frame = WireFrame(
            rng.randrange(256), rng.getrandbits(16), rng.randbytes(rng.randrange(113))
        )
        assert found(encode_frame(frame, Sender.HOST)) == 0


def test_a_robot_in_c_fits_into_small_memory() -> None:
    assert library().cw_twin_robot_size() < 1024


def test_the_pairs_drive_in_the_differential_test() -> None:
    """The comparison above is worth little unless the robots run in it."""
    running = 0
    for seed in range(10):
        rng, pair = random.Random(seed), Pair()
        pair.hello(20)
        for _ in range(150):
            random_deed(pair, rng)
            pair.pass_time(rng.choice([1, 3, 20, 60]))
            running += pair.python.controller.state is RobotState.RUN
    assert running > 100


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_c_firmware_survives(name: str) -> None:
    token = robot_maker.set(lambda identity, drive: CRobot(identity, drive))  # type: ignore[arg-type,return-value]
    try:
        outcome = SCENARIOS[name](5)
    finally:
        robot_maker.reset(token)
    assert "executed" in outcome or "said so" in outcome


def test_the_firmware_as_a_process_drives_a_mission_under_the_sanitizers(tmp_path: Path) -> None:
    """Over a real pseudo-terminal, on odometry: the process has no camera above it."""
    command = ["make", "-s", "-C", str(FIRMWARE), "host", f"BUILD={tmp_path}"]
    subprocess.run(command, check=True, timeout=120)
    process = subprocess.Popen([tmp_path / "robot"], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        with SerialLink(process.stdout.readline().strip()) as link:
            end_s = time.monotonic() + 20.0
            waypoints = [Waypoint(0.02 * i, 0.0, 0.4) for i in range(40)]
            mission = None
            while not link.snapshot().mission_done and time.monotonic() < end_s:
                link.lease(True, odometry=True)
                if mission is None and link.snapshot().down_reason is None:
                    mission = link.upload(5, waypoints)
                time.sleep(0.02)  # a control loop's period: the lease has to be given again
            snapshot = link.snapshot()
            assert snapshot.mission_done
            assert snapshot.status is not None
            assert mission is not None
            assert snapshot.status.exec_crc == mission.prefix_crc(40)
            assert abs(snapshot.status.x_m - 0.78) < 0.01
            link.estop()
            assert wait_until(lambda: link.snapshot().estopped)
        process.terminate()
        assert process.wait(timeout=10) == 0, "a sanitizer complained"
    finally:
        process.kill()
        process.communicate()

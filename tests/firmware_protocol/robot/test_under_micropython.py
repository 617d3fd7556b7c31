"""The robot under the real MicroPython: the same bytes as here, with the heap locked.

A call of the robot that allocates ends the test.
"""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.robot.clearway import link, wire
from firmware_protocol.robot.connection import Identity
from firmware_protocol.wire.crc import crc32c
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import ESTOP_FRAME, ResetEstop, RobotState
from tests.firmware_protocol.test_c_firmware import random_deed
from tests.support.robots.micropython_interpreter import interpreter
from tests.support.robots.micropython_robot import MicroPair, MicroRobot, Process
from tests.support.wire.fault_scenarios import SCENARIOS, robot_maker

needs_micropython = pytest.mark.skipif(
    interpreter() is None, reason="needs MicroPython: .ci/micropython"
)


SETTINGS = DriveSettings(least_wheel_m_s=0.03)


def compare(pair: MicroPair, seed: int, deeds: int) -> int:
    """How often they ran; fails where they answer differently."""
    rng, running = random.Random(seed), 0
    pair.hello(20)
    for deed in range(deeds):
        random_deed(pair, rng)
        if deed % 50 == 49 and seed % 4 == 0:
            pair.feed(ESTOP_FRAME)
            pair.pass_time(30)
            pair.hello(30 + deed)
            pair.send(ResetEstop(1))
        pair.pass_time(rng.choice([1, 3, 20, 60]))
        running += pair.python.controller.state is RobotState.RUN
    return running


@needs_micropython
def test_it_answers_alike_whatever_the_host_does(process: Process) -> None:
    assert sum(compare(MicroPair(process, SETTINGS), seed, 100) for seed in range(20, 24)) > 20


@needs_micropython
@pytest.mark.parametrize("name", SCENARIOS)
def test_it_survives_under_micropython_without_allocating(name: str, process: Process) -> None:
    token = robot_maker.set(lambda identity, drive: MicroRobot(process, identity, drive))  # type: ignore[arg-type,return-value]
    try:
        outcome = SCENARIOS[name](5)
    finally:
        robot_maker.reset(token)
    assert "executed" in outcome or "said so" in outcome


@needs_micropython
def test_a_call_that_allocates_would_end_it() -> None:
    """The lock that the tests above rely on."""
    found = interpreter()
    assert found is not None
    process = Process([found])
    robot = MicroRobot(process, Identity(boot_id=1))
    with pytest.raises(AssertionError, match="MicroPython has ended"):
        robot.ask(b"S", 0.0, b"")  # unpacking nothing raises, which allocates
    process.close()


@given(st.binary(max_size=200), st.integers(0, 0xFFFFFFFF))
def test_the_check_is_that_of_the_line(data: bytes, running: int) -> None:
    halves = wire.array("H", (running & 0xFFFF, running >> 16))
    wire.check_bytes(halves, 0, bytearray(data), 0, len(data))
    assert halves[0] | halves[1] << 16 == crc32c(data, running)


def test_the_matcher_finds_the_emergency_stop_and_nothing_else() -> None:
    def found(data: bytes) -> int:
        matched, count = 0, 0
        for byte in data:
            matched = link.estop_match(matched, byte)
            count += matched == len(ESTOP_FRAME)
        return count

    assert found(b"\x00\x03\x10" + ESTOP_FRAME) == 1
    assert found(ESTOP_FRAME[1:]) == 0
    assert found(ESTOP_FRAME * 3) == 3

"""Faults of the line: rough, cut, echoing, at another speed, shared, with old or void frames."""

from __future__ import annotations

import random
from collections.abc import Callable
from unittest.mock import patch

import numpy as np

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.state import LinkState
from firmware_protocol.robot.connection import Identity
from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    SCHEMA_HASH,
    MessageType,
    RobotState,
    StopReason,
)
from navigation.simulator.line_faults import FaultSpec
from tests.support.robots.avr_firmware import AvrFirmware
from tests.support.wire.fault_witness import DEAD_MAN_S, STOP_S, Witness, join_line, robot_maker


def rough(spec: str) -> Callable[[int], str]:
    def scenario(seed: int) -> str:
        witness = Witness(seed, FaultSpec.parse(spec))
        witness.begin()
        return witness.finish()

    return scenario


def cable_pulled(seed: int) -> str:
    witness = Witness(seed)
    witness.begin_and_drive()
    witness.loop.knobs.cable = False
    witness.judge_standing(DEAD_MAN_S + STOP_S)
    cut = (StopReason.LEASE_LAPSED, StopReason.POSE_STALE, StopReason.DISARMED)
    assert witness.loop.robot.controller.reason in cut
    assert witness.loop.host.why_down(witness.loop.now_s) is not None
    witness.loop.knobs.cable = True
    witness.connect()
    witness.judge_standing(0.1)
    return witness.finish()


def last_acknowledgement_lost(seed: int) -> str:
    witness = Witness(seed, count=30)
    witness.begin()
    control = witness.loop.robot.controller
    while control.accept_next < 30:
        witness.loop.tick()
    carry = witness.loop._faulty[1].carry
    witness.loop._faulty[1].carry = lambda data, now_s: b""  # type: ignore[method-assign]
    witness.loop.run(0.1 + seed % 5 * 0.05)
    witness.loop._faulty[1].carry = carry  # type: ignore[method-assign]
    return witness.finish()


def late_frames_of_an_old_session(seed: int) -> str:
    witness = Witness(seed)
    loop = witness.loop
    old: list[bytes] = []
    put = loop.to_robot.put

    def recording(data: bytes, now_s: float) -> None:
        old.append(data)
        put(data, now_s)

    loop.to_robot.put = recording  # type: ignore[method-assign]
    witness.begin_and_drive(0.3)
    loop.to_robot.put = put  # type: ignore[method-assign]
    loop.knobs.cable = False
    loop.run(1.0)
    loop.knobs.cable = True
    witness.connect()
    for data in random.Random(seed).sample(old, len(old)):
        witness.inject(data)
    witness.judge_standing(STOP_S)
    assert loop.robot.session_errors > 0
    return witness.finish()


def sequence_wraps(seed: int) -> str:
    witness = Witness(seed, FaultSpec(drop=0.0005), count=1700, spacing_m=0.001)
    witness.begin()
    return witness.finish(60.0)


def second_host(seed: int) -> str:
    """A second program takes the robot: it stops, and the first says so and keeps still."""
    witness = Witness(seed)
    loop = witness.loop
    witness.begin_and_drive()
    first, second = join_line(loop, 7000 + seed)
    witness.connect()
    witness.judge_standing(STOP_S)
    assert second.state.is_up
    assert first.why_down(loop.now_s) == "another host has taken the robot over"
    second.upload(witness.mission, loop.now_s)
    return witness.finish()


def wrong_baud_rate(seed: int) -> str:
    witness = Witness(seed)
    rng = np.random.default_rng(seed)
    # a robot says nothing before it has a session: let one go on at the wrong rate
    witness.connect()
    witness.loop.host = HostConnection(random.Random(seed), witness.loop.baud)
    witness.loop.host.open(witness.loop.now_s)
    for line in witness.loop._faulty:
        line.carry = lambda data, now_s: bytes(  # type: ignore[method-assign]
            rng.integers(0, 256, max(1, len(data) // 12) if data else 0, dtype=np.uint8)
        )
    witness.loop.run(3.0)
    why = witness.loop.host.why_down(witness.loop.now_s)
    assert why is not None
    assert "baud" in why, why
    assert witness.state is RobotState.IDLE
    return "refused and said so"


def line_echoes(seed: int) -> str:
    witness = Witness(seed)
    witness.loop.knobs.echo = True
    witness.loop.knobs.frozen = True
    witness.loop.run(3.0)
    why = witness.loop.host.why_down(witness.loop.now_s)
    assert why is not None
    assert "echoes" in why, why
    witness.loop.knobs.frozen = witness.loop.knobs.echo = False
    witness.begin()
    return "said so; then " + witness.finish()


def schema_mismatch(seed: int) -> str:
    make = robot_maker.get()
    schema = SCHEMA_HASH ^ (1 << seed % 32)
    token = robot_maker.set(lambda _identity, settings: make(Identity(1, schema=schema), settings))
    witness = Witness(seed)
    robot_maker.reset(token)
    robot: object = witness.loop.robot
    if isinstance(robot, AvrFirmware):  # its schema is compiled in: the host has the other one
        with patch("firmware_protocol.host.connection.SCHEMA_HASH", schema):
            witness.loop.run(1.0)
    else:
        witness.loop.run(1.0)
    why = witness.loop.host.why_down(witness.loop.now_s)
    assert why is not None
    assert "schema" in why, why
    assert witness.loop.host.state is LinkState.REFUSED
    assert witness.state is RobotState.BOOT
    # the right firmware is put on it: it is found without a word from anybody
    if not isinstance(robot, AvrFirmware):
        witness.loop.make_robot = make
        witness.boot()
    witness.connect(4.0)
    witness.begin()
    return "said so; then " + witness.finish()


def frames_of_nonsense(seed: int) -> str:
    """Whole frames with wrong lengths, counts and types change nothing."""
    witness = Witness(seed)
    witness.begin_and_drive(0.2)
    loop, rng = witness.loop, np.random.default_rng(seed)
    session = loop.robot.session or 0
    control = loop.robot.controller
    for _ in range(300):
        before = (control.mission, control.accept_next)
        kind = int(rng.choice([0x10, 0x20, 0x21, 0x22, 0x55, 0x91]))
        size = int(rng.integers(0, 113))
        payload = bytes(rng.integers(0, 256, size, dtype=np.uint8))
        if kind in (0x20, 0x21, 0x22) and size in (4, 5, 12):
            continue
        frame = WireFrame(kind, session, payload, sequence=int(rng.integers(256)))
        witness.inject(encode_frame(frame, Sender.HOST))
        # where time passes meanwhile the mission goes on, and its chain tells
        assert witness.told_s or (control.mission, control.accept_next) == before
    for count in (0, 7, 255):
        payload = bytes(8) + bytes([count, 0]) + bytes(16)
        for sequence in range(256):
            frame = WireFrame(MessageType.WAYPOINTS, session, payload, sequence)
            witness.inject(encode_frame(frame, Sender.HOST))
    return witness.finish()

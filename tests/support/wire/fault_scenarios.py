"""Every fault of the serial link as a scenario in virtual time, judged by the executed chain.

A scenario takes a seed and returns what happened in a word, or raises AssertionError. The
judge does not trust the robot's counters alone: ``Witness`` notes every record that the robot
executes, in order, and every moment in which it moves.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from unittest.mock import patch

import numpy as np

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import CommandEnded, MissionVoid, RobotRebooted
from firmware_protocol.host.state import LinkState
from firmware_protocol.robot.connection import Identity
from firmware_protocol.wire.framing import Frame, Sender, encode_frame
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    SCHEMA_HASH,
    CommandResult,
    MessageType,
    ResetCause,
    RobotState,
    StopReason,
)
from navigation.simulator.line_faults import FaultSpec
from tests.support.robots.avr_firmware import AvrFirmware
from tests.support.wire.fault_witness import DEAD_MAN_S, STOP_S, Witness, robot_maker
from tests.support.wire.hostile_scenarios import HOSTILE

__all__ = ["SCENARIOS", "robot_maker"]


def _rough(spec: str) -> Callable[[int], str]:
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


def processor_freezes(seed: int) -> str:
    """The watchdog resets a frozen processor after a quarter of a second."""
    witness = Witness(seed)
    witness.begin_and_drive()
    witness.loop.knobs.frozen = True
    witness.loop.run(0.25)
    witness.loop.knobs.frozen = False
    witness.boot(ResetCause.WATCHDOG)
    witness.judge_standing(STOP_S)
    return _new_mission_after_reboot(witness)


def short_freeze(seed: int) -> str:
    witness = Witness(seed)
    witness.begin_and_drive()
    for _ in range(3):
        witness.loop.knobs.frozen = True
        witness.loop.run(0.1)
        witness.loop.knobs.frozen = False
        witness.loop.run(0.4)
    return witness.finish()


def processor_resets(seed: int) -> str:
    witness = Witness(seed)
    witness.begin_and_drive(0.1 + seed % 10 * 0.1)
    witness.boot()
    witness.judge_standing(STOP_S)
    return _new_mission_after_reboot(witness)


def _new_mission_after_reboot(witness: Witness) -> str:
    loop = witness.loop
    rebooted = loop.run(5.0, lambda: any(isinstance(e, RobotRebooted) for e in loop.events))
    assert rebooted, witness.describe()
    assert any(isinstance(event, MissionVoid) for event in loop.events)
    assert witness.executed == [], "a rebooted robot has executed waypoints of before"
    loop.run(0.3)
    witness.mission = witness.new_mission(2000 + witness.seed)
    witness.give()
    witness.finish()
    return "stopped and said so; new mission executed"


def reset_between_accept_and_ack(seed: int) -> str:
    witness = Witness(seed)
    witness.begin()
    control = witness.loop.robot.controller
    before = 6 * (1 + seed % 4)
    line = witness.loop._faulty[1]
    carry = line.carry
    line.carry = lambda data, now_s: (  # type: ignore[method-assign]
        carry(data, now_s) if control.accept_next < before else b""
    )
    while control.accept_next < before:
        witness.loop.tick()
    line.carry = carry  # type: ignore[method-assign]
    witness.boot()
    return _new_mission_after_reboot(witness)


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


def clocks_wrap(seed: int) -> str:
    wrap_s = 2**32 / 1e6
    witness = Witness(seed, options={"robot_clock_offset_s": wrap_s - 1.5, "start_s": wrap_s - 2.0})
    witness.begin()
    outcome = witness.finish()
    loop = witness.loop
    assert loop.robot_s > wrap_s
    offset_s = witness.robot_clock_s - loop.now_s
    assert abs(loop.host.clock.offset_s(loop.now_s) - offset_s) < 1e-3
    return outcome


def host_killed(seed: int) -> str:
    """A new process knows the mission from its journal and goes on with it."""
    witness = Witness(seed)
    loop = witness.loop
    for kill in range(3):
        if kill == 0:
            witness.begin()
            loop.run((seed % 7) * 0.05)
            boot_id = loop.robot.identity.boot_id
        loop.host = HostConnection(random.Random(100 * seed + kill), loop.baud, boot_id)
        loop.host.open(loop.now_s)
        loop.host.upload(witness.mission, loop.now_s, start=False)
        witness.connect()
        witness.judge_standing(STOP_S)
        loop.host.start(loop.now_s)
        loop.run(0.3)
    return witness.finish()


def control_loop_hangs(seed: int) -> str:
    """Poses still flow, leases do not."""
    witness = Witness(seed)
    witness.begin_and_drive()
    witness.loop.knobs.lease = False
    lapsed = witness.reaches(RobotState.HOLD, 0.52)
    assert lapsed, witness.describe()
    witness.judge_standing(STOP_S, StopReason.LEASE_LAPSED)
    witness.loop.knobs.lease = True
    witness.judge_standing(1.0)
    return witness.finish()


def silence_disarms(seed: int) -> str:
    witness = Witness(seed)
    witness.begin_and_drive()
    witness.loop.knobs.lease = False
    witness.judge_standing(2.1, StopReason.DISARMED)
    witness.loop.knobs.lease = True
    witness.judge_standing(0.3)
    return witness.finish()


def camera_goes_blind(seed: int) -> str:
    witness = Witness(seed)
    witness.begin_and_drive()
    witness.loop.knobs.camera = False
    held = witness.reaches(RobotState.HOLD, 0.65)
    assert held, witness.describe()
    witness.judge_standing(STOP_S, StopReason.POSE_STALE)
    witness.loop.knobs.camera = True
    witness.judge_standing(0.5)
    return witness.finish()


def permit_withdrawn(seed: int) -> str:
    witness = Witness(seed)
    witness.begin_and_drive()
    witness.loop.knobs.permit = False
    witness.judge_standing(0.12 + STOP_S, StopReason.NO_PERMIT)
    witness.loop.knobs.permit = True
    witness.judge_standing(0.5)
    return witness.finish()


def second_host(seed: int) -> str:
    """A second program takes the robot: it stops, and the first says so and keeps still."""
    witness = Witness(seed)
    loop = witness.loop
    witness.begin_and_drive()
    first = loop.host
    loop.host = second = HostConnection(random.Random(7000 + seed), loop.baud)
    second.open(loop.now_s)
    carry = loop._faulty[1].carry

    def both(data: bytes, now_s: float) -> bytes:
        arrived = carry(data, now_s)
        first.receive_bytes(arrived, now_s)
        first.tick(now_s)
        hello = first.bytes_to_send(now_s)
        if hello:
            loop.to_robot.put(hello, now_s)
        return arrived

    loop._faulty[1].carry = both  # type: ignore[method-assign]
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


def reset_on_open(seed: int) -> str:
    """Many boards reset when the host opens the port, and talk first."""
    witness = Witness(seed)
    loop = witness.loop
    banner = b"\r\nBootloader v4.4\r\nready\0\x07\xff" * (1 + seed % 3)
    loop.knobs.frozen = True
    loop.run(0.2 + seed % 5 * 0.2)
    loop.knobs.frozen = False
    witness.boot()
    loop.to_host.put(banner, loop.now_s)
    loop.robot.receive_bytes(banner, loop.robot_s)
    witness.begin()
    return witness.finish()


def brown_out_loop(seed: int) -> str:
    witness = Witness(seed)
    witness.begin_and_drive()
    for _ in range(6):
        witness.boot(ResetCause.BROWN_OUT)
        witness.loop.run(0.35 + seed % 4 * 0.15)
        assert witness.state is not RobotState.RUN
        assert witness.executed == []
    return _new_mission_after_reboot(witness)


def estop_under_full_load(seed: int) -> str:
    """Full queue and full window: the wheels are told zero within 15 ms."""
    witness = Witness(seed, count=2000, spacing_m=0.001)
    witness.begin_and_drive(0.5 + seed % 13 * 0.0071)
    loop = witness.loop
    assert loop.robot.controller.credit < 12
    loop.host.estop()
    asked_s = loop.now_s
    while loop.wheels.powered and loop.now_s < asked_s + 0.05:
        loop.tick()
    assert loop.now_s - asked_s <= 0.015, loop.now_s - asked_s
    while witness.state is not RobotState.ESTOP:
        loop.tick()
    witness.judge_standing(STOP_S)
    witness.judge_chain(whole=False)
    assert any(isinstance(event, MissionVoid) for event in loop.events)
    assert not loop.host.estop_pending
    return _leave_estop(witness)


def estop_after_a_truncated_frame(seed: int) -> str:
    witness = Witness(seed)
    witness.begin_and_drive(0.2)
    frame = encode_frame(Frame(MessageType.WAYPOINTS, 1, bytes(106)), Sender.HOST)
    cut = 1 + seed * 5 % (len(frame) - 2)
    witness.inject(frame[:cut] + ESTOP_FRAME)
    assert witness.reaches(RobotState.ESTOP)
    witness.judge_standing(STOP_S, StopReason.ESTOP_HOST)
    return _leave_estop(witness)


def estop_on_a_bad_line(seed: int) -> str:
    witness = Witness(seed, FaultSpec(drop=0.01, flip=0.002))
    witness.begin()
    witness.loop.run(2.0)
    witness.loop.host.estop()
    stopped = witness.loop.run(0.5, lambda: witness.state is RobotState.ESTOP)
    assert stopped
    confirmed = witness.loop.run(2.0, lambda: not witness.loop.host.estop_pending)
    assert confirmed
    return "stopped and said so"


def _leave_estop(witness: Witness) -> str:
    loop = witness.loop
    # the latch: neither a start nor a mission moves the robot
    loop.host.upload(witness.new_mission(4000 + witness.seed), loop.now_s)
    witness.judge_standing(0.5)
    assert witness.state is RobotState.ESTOP
    loop.host.reset_estop(loop.now_s)
    left = loop.run(2.0, lambda: witness.state is RobotState.IDLE)
    assert left, witness.describe()
    witness.judge_standing(0.5)
    witness.count = 30
    witness.spacing_m = 0.02
    witness.executed.clear()
    witness.mission = witness.new_mission(3000 + witness.seed)
    witness.give()
    witness.finish()
    return "stopped and said so; new mission executed"


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


def clocks_drift(seed: int) -> str:
    drift = (-1.0) ** seed * 150e-6
    witness = Witness(seed, options={"robot_clock_drift": drift, "robot_clock_offset_s": 77.0})
    witness.begin()
    outcome = witness.finish()
    loop = witness.loop
    loop.run(30.0)
    error_s = loop.host.clock.offset_s(loop.now_s) - (witness.robot_clock_s - loop.now_s)
    assert abs(error_s) < 0.5e-3, error_s
    assert abs(loop.host.clock.drift - drift) < 40e-6, loop.host.clock.drift
    return outcome


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
        frame = Frame(kind, session, payload, sequence=int(rng.integers(256)))
        witness.inject(encode_frame(frame, Sender.HOST))
        # where time passes meanwhile the mission goes on, and its chain tells
        assert witness.told_s or (control.mission, control.accept_next) == before
    for count in (0, 7, 255):
        payload = bytes(8) + bytes([count, 0]) + bytes(16)
        for sequence in range(256):
            frame = Frame(MessageType.WAYPOINTS, session, payload, sequence)
            witness.inject(encode_frame(frame, Sender.HOST))
    return witness.finish()


def replaced_while_driving(seed: int) -> str:
    """A new mission while the old one runs: stop, clear, go on with the new one only."""
    witness = Witness(seed, FaultSpec(drop=0.0005 * (seed % 3)))
    witness.begin_and_drive(0.6)
    witness.loop.run(0.2)
    witness.judge_chain(whole=False)
    witness.executed.clear()
    witness.mission = witness.new_mission(4000 + seed)
    control = witness.loop.robot.controller
    witness.give()
    witness.loop.run(5.0, lambda: control.mission == witness.mission.id)
    first = set(witness.mission.records)
    witness.executed[:] = [record for record in witness.executed if record in first]
    return witness.finish()


def paused(seed: int) -> str:
    witness = Witness(seed)
    witness.begin_and_drive(0.5)
    witness.loop.host.pause()
    witness.judge_standing(STOP_S, StopReason.PAUSED)
    return witness.finish()


def start_without_a_lease(seed: int) -> str:
    witness = Witness(seed)
    witness.loop.knobs.lease = False
    witness.begin()
    witness.judge_standing(2.5)
    ended = CommandEnded(MessageType.START, CommandResult.NO_LEASE)
    assert ended in witness.loop.events
    witness.loop.knobs.lease = True
    return witness.finish()


SCENARIOS: dict[str, Callable[[int], str]] = {
    "no fault": _rough(""),
    "byte loss 0.1 %": _rough("drop=0.001"),
    "byte loss 1 %": _rough("drop=0.01"),
    "bit flips 0.1 % of bytes": _rough("flip=0.001"),
    "noise bytes 0.1 %": _rough("noise=0.001"),
    "spans lost in 3 % of frames": _rough("span=0.03"),
    "10 % of frames doubled": _rough("dup=0.1"),
    "10 % of frames swapped": _rough("swap=0.1"),
    "mixed": _rough("drop=0.001,flip=0.0005,noise=0.0005,span=0.005,dup=0.02,swap=0.02"),
    "stalls of 0.2 s, then bursts": _rough("stall=0.2@1"),
    "stalls of 0.8 s, then bursts": _rough("stall=0.8@4"),
    "cable pulled and plugged in": cable_pulled,
    "processor frozen 0.1 s": short_freeze,
    "processor frozen, watchdog": processor_freezes,
    "processor reset": processor_resets,
    "reset between accept and acknowledgement": reset_between_accept_and_ack,
    "last acknowledgement lost": last_acknowledgement_lost,
    "late frames of an old session": late_frames_of_an_old_session,
    "sequence numbers wrap": sequence_wraps,
    "clocks wrap": clocks_wrap,
    "clocks drift 150 ppm": clocks_drift,
    "host killed three times": host_killed,
    "second host on the line": second_host,
    "wrong baud rate": wrong_baud_rate,
    "line echoes": line_echoes,
    "reset on open, boot banner": reset_on_open,
    "brown-out loop": brown_out_loop,
    "schema mismatch": schema_mismatch,
    "nonsense in whole frames": frames_of_nonsense,
    "e-stop, full queue and window": estop_under_full_load,
    "e-stop after a truncated frame": estop_after_a_truncated_frame,
    "e-stop on a bad line": estop_on_a_bad_line,
    "control loop hangs, poses flow": control_loop_hangs,
    "silence disarms": silence_disarms,
    "camera goes blind": camera_goes_blind,
    "permit withdrawn": permit_withdrawn,
    "paused and started again": paused,
    "start without a lease": start_without_a_lease,
    "mission replaced while driving": replaced_while_driving,
    **HOSTILE,
}

"""Faults on the host's side, and its orders on a bad line: kills, permits, emergency stops."""

from __future__ import annotations

import random

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import CommandEnded, MissionVoid
from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    CommandResult,
    MessageType,
    RobotState,
    StopReason,
)
from navigation.simulator.line_faults import FaultSpec
from tests.support.wire.fault_witness import STOP_S, Witness


def host_killed(seed: int) -> str:
    """A new process knows the mission from its journal and goes on with it."""
    witness = Witness(seed)
    loop = witness.loop
    for kill in range(3):
        if kill == 0:
            witness.begin()
            loop.run((seed % 7) * 0.05)
        loop.host = HostConnection(random.Random(100 * seed + kill), loop.baud)
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
    frame = encode_frame(WireFrame(MessageType.WAYPOINTS, 1, bytes(106)), Sender.HOST)
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

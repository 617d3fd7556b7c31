"""Faults of the robot's processor: freezes, resets, brown-outs, clocks."""

from __future__ import annotations

from firmware_protocol.host.events import MissionVoid, RobotRebooted
from firmware_protocol.wire.messages import (
    ResetCause,
    RobotState,
)
from tests.support.wire.fault_witness import STOP_S, Witness


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

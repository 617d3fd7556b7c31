"""The line of any twin: what waits in it, and what ends with it."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.robot.controller import WheelSpeeds
from firmware_protocol.wire.messages import RobotState, StopReason
from navigation.config import load_config
from navigation.run.devices import simulated
from navigation.run.devices.world_clock import WallClock
from navigation.run.simulation import Simulation
from navigation.simulator.line_faults import FaultSpec, FaultSpecError
from navigation.simulator.robot import RING_BYTES, SimulatedRobot
from navigation.simulator.twins.clearway import ClearwayTwin
from navigation.simulator.twins.twin import Body
from planner.scene import SceneError

CONFIGS = Path(__file__).parents[3] / "configs"


class PlainTwin:
    """It drives straight on, and notes what it hears and what is done to it."""

    body = Body(0.12, 4000.0, 0.8)
    baud = math.inf
    has_frames = False

    def __init__(self) -> None:
        self.heard: list[bytes] = []
        self.boots = self.steps = 0

    def boot(self, now_s: float) -> None:
        self.boots += 1

    def receive(self, data: bytes, now_s: float) -> None:
        self.heard.append(data)

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        self.steps += 1
        return WheelSpeeds(0.2, 0.2, powered=True)

    def bytes_to_send(self, now_s: float) -> bytes:
        return b""

    def bump(self, pressed: bool) -> None:
        """It feels nothing."""

    def lift(self, lifted: bool) -> None:
        """It feels nothing."""


class Clock:
    """Time that passes when a test says so."""

    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def robot_of(twin: PlainTwin, clock: Clock, faults: str = "") -> SimulatedRobot:
    rng = np.random.default_rng(1)
    return SimulatedRobot(twin=twin, rng=rng, faults=FaultSpec.parse(faults), clock=clock)


def test_what_comes_during_a_freeze_waits_in_a_buffer_of_256_bytes() -> None:
    twin, clock = PlainTwin(), Clock()
    robot = robot_of(twin, clock, "freeze=0.1@0.1")
    host = os.open(robot.port, os.O_RDWR | os.O_NOCTTY)
    robot.switched_on()
    for _ in range(75):
        clock.now_s += 0.002
        if twin.steps == 49 and not twin.heard:
            os.write(host, b"before")
        robot.turn()
    assert b"".join(twin.heard) == b"before"
    assert twin.steps < 60, "it is frozen"
    os.write(host, bytes(range(200)) + bytes(200))
    for _ in range(75):
        clock.now_s += 0.002
        robot.turn()
    late = b"".join(twin.heard)[len(b"before") :]
    assert late == (bytes(range(200)) + bytes(200))[:RING_BYTES]
    os.close(host)
    robot.stop()


def test_a_reset_boots_the_robot_once_more_and_forgets_what_waited() -> None:
    twin, clock = PlainTwin(), Clock()
    robot = robot_of(twin, clock, "reset=0.1")
    robot.switched_on()
    for _ in range(100):
        clock.now_s += 0.002
        robot.turn()
    assert twin.boots == 2
    robot.stop()


def test_a_person_presses_the_emergency_stop_on_a_robot_of_ours() -> None:
    twin = ClearwayTwin()
    robot = SimulatedRobot(twin=twin, rng=np.random.default_rng(1))
    robot.switched_on()
    robot.bump(False)
    assert twin.controller.state is RobotState.BOOT
    robot.bump()
    assert twin.controller.state is RobotState.ESTOP
    assert twin.controller.reason is StopReason.ESTOP_LOCAL
    robot.stop()


def test_faults_of_whole_frames_are_refused_where_the_line_has_none() -> None:
    with pytest.raises(FaultSpecError, match="dup"):
        robot_of(PlainTwin(), Clock(), "dup=0.1")


# A whole simulation of two robots.


def open_files() -> int:
    """Number of files that this process has open: a robot's pseudo-terminal has two."""
    return len(os.listdir("/proc/self/fd"))


def test_a_simulation_without_its_arena_opens_no_line() -> None:
    config = load_config(CONFIGS / "alcove.yaml")
    assert config.simulation is not None
    nothing = config.simulation.model_copy(update={"arena": None, "arena_text": "nonsense"})
    before = open_files()
    with pytest.raises(SceneError):
        Simulation(config.model_copy(update={"simulation": nothing}), WallClock())
    assert open_files() == before


def test_a_robot_that_cannot_be_made_ends_those_that_were(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[ClearwayTwin] = []

    class SecondFails(ClearwayTwin):
        def __init__(self, *given: object, **named: object) -> None:
            if made:
                raise OSError("no more pseudo-terminals")
            super().__init__(*given, **named)  # type: ignore[arg-type]
            made.append(self)

    monkeypatch.setattr(simulated, "ClearwayTwin", SecondFails)
    before = open_files()
    with pytest.raises(OSError, match="no more"):
        Simulation(load_config(CONFIGS / "alcove.yaml"), WallClock())
    assert len(made) == 1
    assert open_files() == before

"""The line and the thread of any twin: what waits, what ends, and who is held up."""

from __future__ import annotations

import math
import os
import shlex
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.robot.controller import WheelSpeeds
from firmware_protocol.wire.messages import RobotState, StopReason
from navigation.config import Config, load_config
from navigation.link.serial_port import PortError
from navigation.run.devices import simulated
from navigation.run.devices.world_clock import WallClock
from navigation.run.simulation import Simulation
from navigation.simulator.emulated_processor import EmulatorError
from navigation.simulator.line_faults import FaultSpec, FaultSpecError
from navigation.simulator.robot import END_S, RING_BYTES, SimulatedRobot
from navigation.simulator.twins.clearway import ClearwayTwin
from navigation.simulator.twins.emulated import EmulatedTwin
from navigation.simulator.twins.twin import Body
from planner.scene import SceneError
from tests.support.waiting import wait_until

CONFIGS = Path(__file__).parents[3] / "configs"


class PlainTwin:
    """It drives straight on, and notes what it hears and what is done to it."""

    body = Body(0.12, 4000.0, 0.8)
    baud = math.inf
    has_frames = False

    def __init__(self, ends_after: int | None = None) -> None:
        self.heard: list[bytes] = []
        self.boots = self.steps = 0
        self.is_closed = False
        self._ends_after = ends_after

    def boot(self, now_s: float) -> None:
        self.boots += 1

    def receive(self, data: bytes, now_s: float) -> None:
        self.heard.append(data)

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        self.steps += 1
        if self.steps == self._ends_after:
            raise EmulatorError("the emulator has ended")
        return WheelSpeeds(0.2, 0.2, powered=True)

    def bytes_to_send(self, now_s: float) -> bytes:
        return b""

    def bump(self, pressed: bool) -> None:
        """It feels nothing."""

    def lift(self, lifted: bool) -> None:
        """It feels nothing."""

    def close(self) -> None:
        self.is_closed = True


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


@pytest.mark.timed  # measures how soon a thousand turns return
def test_a_robot_whose_twin_has_ended_stands_and_its_turns_return_at_once() -> None:
    twin, clock = PlainTwin(ends_after=200), Clock()
    robot = robot_of(twin, clock)
    robot.switched_on()
    while twin.steps < 200:
        clock.now_s += 0.002
        robot.turn()
    there = robot.pose()
    clock.now_s += 5.0
    began_s = time.perf_counter()
    assert [robot.turn() for _ in range(1000)] == [math.inf] * 1000
    assert robot.pose() == there
    assert time.perf_counter() - began_s < 0.4, "nobody waits for it"
    assert twin.steps == 200
    assert robot.late_since_s() == math.inf
    robot.stop()
    assert twin.is_closed


def test_the_thread_of_a_robot_whose_twin_has_ended_is_over() -> None:
    robot = SimulatedRobot(twin=PlainTwin(ends_after=3), rng=np.random.default_rng(1))
    robot.start()
    assert robot._thread is not None
    robot._thread.join(10.0)
    assert not robot._thread.is_alive()
    robot.stop()


def test_a_port_that_cannot_be_opened_leaves_no_twin_behind() -> None:
    twin = PlainTwin()
    with pytest.raises(PortError):
        SimulatedRobot(twin=twin, rng=np.random.default_rng(1), port="/dev/tty_that_is_not_there")
    assert twin.is_closed


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


# Emulators in a whole simulation of two robots.

EMULATOR = """
import os, struct, sys, time
read, write = sys.stdin.buffer.read, sys.stdout.buffer.write
number = sum(name.startswith("started") for name in os.listdir(sys.argv[1]))
open(os.path.join(sys.argv[1], f"started{number}"), "w").close()
while head := read(11):
    if number == 0 and sys.argv[2] == "hangs":
        time.sleep(600)  # hanging
    read(struct.unpack("<IhhBH", head)[4])
    write(struct.pack("<BBBIIH", 51, 51, 1, 0, 0, 0))
    sys.stdout.buffer.flush()
"""
"""It drives straight on; the first one that is started hangs where the second word says so."""


def emulated(folder: Path, word: str = "runs", command: str | None = None) -> Config:
    """Two robots, each on an emulator of its own."""
    program = folder / "emulator.py"
    program.write_text(EMULATOR)
    if command is None:
        command = shlex.join([sys.executable, str(program), str(folder), word])
    config = load_config(CONFIGS / "alcove.yaml")
    assert config.simulation is not None
    robot = config.simulation.robot.model_copy(update={"emulator": command})
    simulation = config.simulation.model_copy(update={"robot": robot})
    return config.model_copy(update={"simulation": simulation})


def started(folder: Path) -> int:
    """How many emulators have been started."""
    return len(list(folder.glob("started*")))


def test_an_emulator_that_hangs_holds_up_no_other_robot_and_not_the_end(tmp_path: Path) -> None:
    simulation = Simulation(emulated(tmp_path, "hangs"), WallClock())
    first, second = simulation.robots.values()
    assert wait_until(lambda: started(tmp_path) == 2, 30.0)
    simulation.start()
    assert wait_until(lambda: sum(len(one.track()) > 20 for one in (first, second)) == 1, 30.0)
    ended = threading.Thread(target=simulation.stop)
    ended.start()
    ended.join(3 * END_S + 10.0)
    assert not ended.is_alive()


def test_a_simulation_without_its_arena_starts_no_robot(tmp_path: Path) -> None:
    config = emulated(tmp_path)
    assert config.simulation is not None
    nothing = config.simulation.model_copy(update={"arena": None, "arena_text": "nonsense"})
    with pytest.raises(SceneError):
        Simulation(config.model_copy(update={"simulation": nothing}), WallClock())
    time.sleep(0.3)  # an emulator would have started by then
    assert started(tmp_path) == 0


def test_a_robot_that_cannot_be_made_ends_those_that_were(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[EmulatedTwin] = []
    closed: list[EmulatedTwin] = []

    class SecondFails(EmulatedTwin):
        def __init__(self, *given: object, **named: object) -> None:
            if made:
                raise EmulatorError("emulator: no such file")
            super().__init__(*given, **named)  # type: ignore[arg-type]
            made.append(self)

        def close(self) -> None:
            closed.append(self)
            super().close()

    monkeypatch.setattr(simulated, "EmulatedTwin", SecondFails)
    with pytest.raises(EmulatorError):
        Simulation(emulated(tmp_path), WallClock())
    assert closed == made
    assert len(made) == 1

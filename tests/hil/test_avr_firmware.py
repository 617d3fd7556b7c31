"""The AVR binary on an emulated ATmega328P at its true baud rate."""

import random
from collections.abc import Iterator

import numpy as np
import pytest

from firmware_protocol.host import HostConnection
from firmware_protocol.host_events import Event, MissionDone, RobotRebooted
from firmware_protocol.messages import RobotState, Waypoint
from firmware_protocol.mission import Mission
from navigation.simulator.emulated_processor import Motors
from navigation.simulator.line_faults import FaultSpec, FaultyLine
from tests.support.avr_robot import AvrRobot, missing_tools

pytestmark = pytest.mark.skipif(missing_tools() is not None, reason=f"needs {missing_tools()}")

TICK_S = 0.001
LAG_S = 0.05


@pytest.fixture(scope="module")
def avr() -> Iterator[AvrRobot]:
    with AvrRobot() as robot:
        yield robot


class Bench:
    """Host, line, processor, motors and encoders, in lockstep."""

    def __init__(self, avr: AvrRobot, faults: str = "") -> None:
        self.avr, self.now_s = avr, 0.0
        self.host = HostConnection(random.Random(1))
        self.host.open(0.0)
        rng = np.random.default_rng(1)
        self.lines = [FaultyLine(FaultSpec.parse(faults), rng) for _ in range(2)]
        self.waiting = b""
        self.speed = [0.0, 0.0]
        self.lease = True
        self.events: list[Event] = []
        self.motors = Motors(0.0, 0.0, False, 0.0, 0.0)
        self.tick(reset=True)

    def tick(self, reset: bool = False) -> None:
        travel = (self.speed[0] * TICK_S, self.speed[1] * TICK_S)
        self.motors, data = self.avr.run(TICK_S, self.waiting, travel, reset)
        for side in (0, 1):
            self.speed[side] += TICK_S / LAG_S * (self.motors[side] - self.speed[side])
        self.now_s += TICK_S
        if round(self.now_s / TICK_S) % 50 == 0 and self.lease:
            self.host.lease(self.now_s, 0.5, True, odometry=True)
        self.host.receive_bytes(self.lines[1].carry(data, self.now_s), self.now_s)
        self.host.tick(self.now_s)
        self.waiting = self.lines[0].carry(self.host.bytes_to_send(self.now_s), self.now_s)
        while (event := self.host.next_event()) is not None:
            self.events.append(event)

    def state(self) -> RobotState | None:
        return None if self.host.status is None else self.host.status.state

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def begin(self, mission: Mission) -> None:
        self.run(0.1)
        assert self.host.state.is_up
        self.host.upload(mission, self.now_s)
        self.run(0.4)
        assert self.state() is RobotState.RUN


def line(count: int = 50) -> Mission:
    return Mission(5, [Waypoint(0.02 * i, 0.0, 0.4) for i in range(count)])


@pytest.mark.parametrize("faults", ["", "drop=0.001,flip=0.0005,dup=0.01"])
def test_a_mission_is_driven_to_its_end(avr: AvrRobot, faults: str) -> None:
    bench, mission = Bench(avr, faults), line()
    bench.begin(mission)
    for _ in range(12):
        bench.run(0.5)
        if MissionDone(5) in bench.events:
            break
        if bench.state() is RobotState.HOLD:
            bench.host.start(bench.now_s)
    status = bench.host.status
    assert status is not None
    assert MissionDone(5) in bench.events
    assert status.exec_crc == mission.prefix_crc(50)
    assert abs(status.x_m - 0.98) < 0.005
    assert status.counters.overruns == 0


def test_the_emergency_stop_switches_the_motors_off_and_stays(avr: AvrRobot) -> None:
    bench = Bench(avr)
    bench.begin(line())
    assert bench.motors.powered
    asked_s = bench.motors.now_s
    bench.host.estop()
    bench.run(0.1)
    assert not bench.motors.powered
    assert 0.0 < bench.motors.off_s - asked_s < 0.015
    assert bench.state() is RobotState.ESTOP
    bench.run(0.5)
    assert not bench.motors.powered


def test_the_dead_man_stops_the_motors(avr: AvrRobot) -> None:
    bench = Bench(avr)
    bench.begin(line())
    bench.lease = False
    bench.run(0.55)
    assert bench.state() is RobotState.HOLD
    bench.run(1.1)
    assert abs(bench.motors.left_m_s) + abs(bench.motors.right_m_s) == 0.0


def test_a_reset_forgets_the_mission_and_is_noticed(avr: AvrRobot) -> None:
    bench = Bench(avr)
    bench.begin(line())
    bench.tick(reset=True)
    bench.run(1.0)
    assert any(isinstance(event, RobotRebooted) for event in bench.events)
    assert bench.state() is RobotState.IDLE
    assert not bench.motors.powered


def test_the_build_fits_the_processor(avr: AvrRobot) -> None:
    assert avr.flash_bytes <= 16_384, "half of what the processor has"
    assert avr.ram_bytes <= 1536

"""The AVR binary on an emulated ATmega328P at its true baud rate."""

from collections.abc import Iterator

import pytest

from firmware_protocol.host.events import MissionDone, RobotRebooted
from firmware_protocol.wire.messages import RobotState, Waypoint
from firmware_protocol.wire.mission import Mission
from tests.support.robots.avr_bench import AvrBench
from tests.support.robots.avr_robot import AvrRobot, missing_tools

pytestmark = pytest.mark.skipif(missing_tools() is not None, reason=f"needs {missing_tools()}")


@pytest.fixture(scope="module")
def avr() -> Iterator[AvrRobot]:
    with AvrRobot() as robot:
        yield robot


class Bench(AvrBench):
    """One that begins with a mission."""

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
    bench, mission = Bench(avr, faults=faults), line()
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
    bench.until(lambda: bench.state() is RobotState.HOLD, 0.6)
    # noticed at once or behind a control step of 5 ms, told by a frame of 8 ms behind another
    assert 0.5 <= bench.now_s - bench.leased_s < 0.525
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
    assert avr.flash_bytes <= 12_700, "8 KiB are wanted; docs/firmware.md has what takes them"
    assert avr.ram_bytes <= 1536

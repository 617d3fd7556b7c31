"""Each driver with its twin, in virtual time: the two readings of a vendor's document must meet."""

from __future__ import annotations

import math

import pytest

from firmware_protocol.wire.messages import RobotState, StopReason
from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.driven_robot import FRESH_S
from navigation.link.drivers.drivers import DRIVERS
from navigation.simulator.line_faults import FaultSpec
from navigation.simulator.twins.kinds import TWINS
from navigation.simulator.twins.waveshare import HEARTBEAT_MS
from tests.support.robots.driven_bench import (
    PORT,
    DrivenBench,
    assert_at_goal,
    drive_off,
    scaled_goal,
)

NAMES = tuple(KNOWN_ROBOTS)
BAD_LINE = "drop=0.001,flip=0.0005,noise=0.0005"


def test_every_robot_has_a_driver_and_a_twin() -> None:
    assert set(DRIVERS) == set(TWINS) == set(KNOWN_ROBOTS)


@pytest.mark.parametrize("name", NAMES)
def test_driver_and_twin_meet_at_the_goal(name: str) -> None:
    bench = DrivenBench(name)
    bench.get_ready()
    bench.send(5, *scaled_goal(name))
    bench.run_until(lambda: bench.is_done, 40.0)
    assert_at_goal(bench, name)
    word = bench.robot.word(bench.now_s)
    assert (word.silence, word.fault, word.remark) == (None, None, "")
    assert word.identity is not None
    assert word.identity.startswith(bench.known.title)
    assert word.battery is not None
    assert 0.5 < word.battery < 1.0
    assert bench.robot.driver.heard.damaged == 0


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", range(3))
def test_a_bad_line_delays_but_does_not_mislead(name: str, seed: int) -> None:
    """Damaged in both directions: driven on only while the wheels report, and to the goal."""
    bench = DrivenBench(name, seed=seed, faults=FaultSpec.parse(BAD_LINE))
    bench.get_ready()
    bench.send(5, *scaled_goal(name))
    for _ in range(60):
        bench.run(1.0)
        if bench.is_done:
            break
        if bench.state in (RobotState.HOLD, RobotState.IDLE):
            bench.host.start(bench.now_s)  # as the pilot does after an outage
    assert bench.is_done
    # an order that was damaged at the very end may turn it for a moment: the pilot looks again
    assert math.dist(bench.drive.pose[:2], scaled_goal(name)[-1]) <= 0.020
    assert bench.robot.driver.heard.damaged > 0


@pytest.mark.parametrize("name", NAMES)
def test_a_lease_that_lapses_stops_the_robot(name: str) -> None:
    bench = DrivenBench(name)
    drive_off(bench, name)
    bench.leases = False
    began_s = bench.now_s
    bench.run_until(lambda: not bench.drive.moving, 3.0)
    assert bench.now_s - began_s < 0.5 + 1.2
    assert bench.robot.controller.reason is StopReason.LEASE_LAPSED


@pytest.mark.parametrize("name", NAMES)
def test_a_cable_that_is_pulled_and_put_back_keeps_the_mission(name: str) -> None:
    bench = DrivenBench(name)
    drive_off(bench, name)
    executed = bench.robot.controller.exec_next
    bench.plugged = False
    bench.run(2.0)
    assert bench.silence is not None
    assert f"the {bench.known.title} on {PORT} has gone silent" in bench.silence
    assert bench.state is not RobotState.RUN
    bench.plugged = True
    bench.run(3.0)
    assert bench.silence is None
    assert not bench.drive.moving, "it never drives on by itself"
    assert bench.robot.controller.mission == 5
    assert bench.robot.controller.exec_next >= executed
    bench.host.start(bench.now_s)
    bench.run_until(lambda: bench.is_done, 60.0)
    x, y, _ = bench.drive.pose
    assert math.dist((x, y), scaled_goal(name)[-1]) <= 0.010


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_that_starts_anew_loses_its_counts_and_not_its_way(name: str) -> None:
    bench = DrivenBench(name)
    drive_off(bench, name)
    before = bench.robot.driver.heard.left_m
    bench.reboot()
    bench.run(5.0)
    assert bench.silence is None
    after = bench.robot.driver.heard.left_m
    assert abs(after - before) < bench.known.wheel_m_s * 5.0, "no jump"
    if not bench.is_done and bench.state is not RobotState.RUN:
        bench.host.start(bench.now_s)
    bench.run_until(lambda: bench.is_done, 60.0)
    x, y, _ = bench.drive.pose
    assert math.dist((x, y), scaled_goal(name)[-1]) <= 0.010


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_that_is_off_is_named_and_nothing_is_driven(name: str) -> None:
    bench = DrivenBench(name)
    bench.switched_on = False
    bench.run(2.0)
    assert bench.silence is not None
    assert f"the {bench.known.title} on {PORT} does not answer: {bench.known.help}" == bench.silence
    assert bench.host.status is None, "the wire is silent, as if its cable were pulled"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("speaks", NAMES)
def test_another_robot_on_the_port_is_not_driven(name: str, speaks: str) -> None:
    if name == speaks:
        return
    bench = DrivenBench(name, speaks=speaks)
    bench.run(3.0)
    assert bench.silence is not None
    assert PORT in bench.silence
    assert bench.known.title in bench.silence
    assert bench.drive.pose == (0.0, 0.0, 0.0)
    assert bench.host.status is None


@pytest.mark.parametrize("name", NAMES)
def test_garbage_on_the_port_is_called_so(name: str) -> None:
    bench = DrivenBench(name, baud=9600)
    bench.switched_on = False
    noise = bytes(range(256)) * 2
    for _ in range(20):
        bench.run(0.1)
        bench.robot.receive_from_robot(noise, bench.now_s)
    bench.run(0.1)
    assert bench.silence is not None
    assert f"bytes come from {PORT} that are no words of" in bench.silence
    assert f"(serial.baud is 9600, its own is {bench.known.baud})" in bench.silence


@pytest.mark.parametrize("name", NAMES)
def test_bytes_may_come_one_by_one(name: str) -> None:
    """The driver hears the same whole, byte by byte, and with garbage before."""
    whole, single = DRIVERS[name](), DRIVERS[name]()
    bench = DrivenBench(name)
    said = bytearray()
    take = bench.robot.driver.receive

    def listen(data: bytes, now_s: float) -> None:
        said.extend(data)
        take(data, now_s)

    bench.robot.driver.receive = listen  # type: ignore[method-assign]
    bench.get_ready()
    bench.run(1.0)
    for driver in (whole, single):
        driver.open(0.0)
    single.receive(b"\x13\x17garbage\xff\xff\xfd\r\n", 0.0)
    whole.receive(bytes(said), 1.0)
    for value in said:
        single.receive(bytes([value]), 1.0)
    assert single.heard.identity == whole.heard.identity is not None
    assert single.heard.messages >= whole.heard.messages - 1
    assert single.heard.messages > 10


def test_wheels_are_not_driven_on_what_they_no_longer_report() -> None:
    """Only the way back is cut: the robot hears, but is not heard."""
    bench = DrivenBench("create2")
    drive_off(bench, "create2")
    bench.lines = (bench.lines[0], _Dead(bench.lines[1]))
    began_s = bench.now_s
    bench.run_until(lambda: not bench.drive.moving, 2.0)
    assert bench.now_s - began_s < FRESH_S + 0.4


class _Dead:
    """A direction of a line that carries nothing."""

    def __init__(self, line: object) -> None:
        self.line = line

    def carry(self, _data: bytes, _now_s: float) -> bytes:
        return b""


# What the robots feel.


def test_a_bumper_is_an_emergency_stop_until_a_person_resets_it() -> None:
    bench = DrivenBench("create2")
    drive_off(bench, "create2")
    bench.twin.bump(True)
    bench.run(0.6)
    assert bench.state is RobotState.ESTOP
    assert not bench.drive.moving
    word = bench.robot.word(bench.now_s)
    assert word.fault == "iRobot Create 2: its bumper is pressed"
    bench.host.reset_estop(bench.now_s)
    bench.run(1.0)
    assert bench.state is RobotState.ESTOP, "it is pressed still"
    bench.twin.bump(False)
    bench.run(1.0)
    assert bench.state is RobotState.ESTOP, "nobody has said that it may go on"
    bench.host.reset_estop(bench.now_s)
    bench.run(1.5)
    assert bench.state is RobotState.IDLE
    assert bench.robot.word(bench.now_s).fault is None


# Who stops the robot when its driver is gone: the robot's own watchdog, where it has one.


@pytest.mark.parametrize("name", NAMES)
def test_a_driver_that_is_gone_is_noticed_by_robots_with_a_watchdog_only(name: str) -> None:
    bench = DrivenBench(name, slip=0.0)
    bench.get_ready()
    bench.send(5, (3.0, 0.0), (6.0, 0.0))
    bench.run(2.5)
    assert bench.drive.moving
    bench.driver_lives = False
    bench.run(0.3)
    assert bench.drive.moving
    bench.run(1.2)
    has_watchdog = KNOWN_ROBOTS[name].watchdog_s is not None
    assert bench.drive.moving is not has_watchdog
    assert HEARTBEAT_MS == 3000, "the driver has set a shorter one"


@pytest.mark.parametrize("name", NAMES)
def test_a_second_program_that_takes_part_of_the_bytes_is_suspected(name: str) -> None:
    """One that does not lock the port: every fiftieth byte goes to it."""
    bench = DrivenBench(name, faults=FaultSpec.parse("drop=0.02"))
    bench.run(1.0)
    said = set()
    for _ in range(60):
        bench.run(0.05)
        word = bench.robot.word(bench.now_s)
        said.add(word.remark or word.silence)
    assert any("a second program" in str(sentence) for sentence in said), said


def test_a_battery_that_is_nearly_empty_is_said() -> None:
    bench = DrivenBench("create2")
    bench.get_ready()
    bench.robot.driver.heard.battery = 0.1
    remark = bench.robot.word(bench.now_s).remark
    assert remark == "the iRobot Create 2's battery is nearly empty: charge it"


def test_two_reports_of_one_moment_are_one_step() -> None:
    """A step in which no time has passed would divide its travel by nothing."""
    bench = DrivenBench("create2")
    drive_off(bench, "create2")
    heard = bench.robot.driver.heard
    for _ in range(2):
        heard.left_m, heard.right_m = heard.left_m + 0.001, heard.right_m + 0.001
        heard.odometry_s = bench.now_s + 1e-9 * heard.left_m
        bench.robot.tick(bench.now_s)
    bench.run(0.1)
    assert bench.state is RobotState.RUN
    assert bench.robot._given == pytest.approx((heard.left_m, heard.right_m))

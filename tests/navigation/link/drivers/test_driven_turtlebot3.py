"""A TurtleBot3 behind its driver, in virtual time: motors, torque, and its three builds."""

from __future__ import annotations

import math

import pytest

from firmware_protocol.wire.messages import RobotState
from navigation.simulator.twins.turtlebot3 import (
    BURGER,
    WAFFLE,
    WITH_MANIPULATOR,
    Turtlebot3Twin,
)
from tests.support.robots.driven_bench import DrivenBench, assert_at_goal, drive_off, scaled_goal


@pytest.mark.parametrize(
    ("build", "name"),
    [(BURGER, "Burger"), (WAFFLE, "Waffle"), (WITH_MANIPULATOR, "Waffle with OpenMANIPULATOR")],
)
def test_each_build_is_named_and_reaches_its_goal(build: int, name: str) -> None:
    bench = DrivenBench("turtlebot3", twin=Turtlebot3Twin(build))
    bench.get_ready()
    bench.send(5, *scaled_goal("turtlebot3"))
    bench.run_until(lambda: bench.is_done, 60.0)
    assert_at_goal(bench, "turtlebot3")
    assert bench.robot.word(bench.now_s).identity == f"TurtleBot3 {name}, firmware 10"


def test_a_build_that_is_not_known_is_said_and_not_driven() -> None:
    bench = DrivenBench("turtlebot3")
    bench.twin._table[2] = 4  # type: ignore[attr-defined]
    bench.run(2.0)
    assert "says that it is model 4" in str(bench.silence)
    assert bench.host.status is None


def test_motors_that_were_off_when_the_board_started_need_its_reset_button() -> None:
    twin = Turtlebot3Twin()
    twin.power_motors(False)
    bench = DrivenBench("turtlebot3", twin=twin)
    bench.run(2.5)
    fault = str(bench.robot.word(bench.now_s).fault)
    assert "press RESET on the OpenCR board" in fault
    twin.power_motors(True)
    bench.host.reset_estop(bench.now_s)
    bench.run(2.5)
    assert "press RESET" in str(bench.robot.word(bench.now_s).fault), "their power alone is no help"
    bench.reboot()
    bench.run(1.5)
    bench.host.reset_estop(bench.now_s)
    bench.run(2.5)
    assert bench.robot.word(bench.now_s).fault is None
    drive_off(bench, "turtlebot3")


def test_motors_that_lost_their_power_are_said_and_get_their_torque_back_with_the_re_arm() -> None:
    twin = Turtlebot3Twin()
    bench = DrivenBench("turtlebot3", twin=twin)
    drive_off(bench, "turtlebot3")
    twin.power_motors(False)
    bench.run(1.5)
    assert bench.state is RobotState.ESTOP
    assert "its motors have no torque" in str(bench.robot.word(bench.now_s).fault)
    twin.power_motors(True)
    bench.run(3.0)
    assert bench.state is RobotState.ESTOP
    assert not bench.drive.moving, "nothing is switched on without a person"
    bench.host.reset_estop(bench.now_s)
    bench.run(2.0)
    assert not bench.drive.moving
    assert bench.robot.word(bench.now_s).fault is None
    x, y, _ = bench.drive.pose
    goal = (x + 0.3, y + 0.05)
    bench.send(6, (x + 0.15, y), goal)
    bench.run_until(lambda: bench.is_done, 60.0)
    assert math.dist(bench.drive.pose[:2], goal) <= 0.010

"""Robots whose processor stood still for minutes or hours, and clocks that wrapped meanwhile.

The firmware's clock has 32 bits of microseconds, 71.6 minutes; a MicroPython board's has 30, and
what runs on this computer knows the hours. All have to answer alike, whatever came first after the
freeze.
"""

import random

import pytest

from firmware_protocol.robot.clearway.estimate import TIME
from firmware_protocol.robot.clearway.robot import DISARMED
from firmware_protocol.robot.clearway.states import IDLE
from firmware_protocol.wire.messages import Lease, LeaseFlag, PoseFix, RobotState, Start, StopReason
from tests.firmware_protocol.test_c_firmware import begin_to_drive
from tests.support.robots.c_robot import missing_tool
from tests.support.robots.inside import expected_of
from tests.support.robots.robot_pair import TICK_S, Pair

pytestmark = pytest.mark.skipif(
    missing_tool() is not None, reason=f"needs {missing_tool()} to build the firmware"
)

MINUTES = (1.0, 20.0, 35.7, 35.9, 40.0, 55.0, 71.0, 71.5)
LONGER_MINUTES = (71.7, 107.5, 143.0, 178.9)
"""The firmware's clock has come round: it knows that its lease is over, not for how long."""


def see(pair: Pair) -> None:
    """The camera sees the robot where it is."""
    pose = pair.python.controller.pose
    pair.send(PoseFix(pose.x_m, pose.y_m, pose.heading_rad, pair.clock_us))


def driving_pair(seed: int = 1) -> Pair:
    """Both robots drive, on poses and not on odometry alone."""
    pair = Pair()
    pair.hello(20)
    begin_to_drive(pair, random.Random(seed))
    see(pair)
    pair.send(Lease(0.5, LeaseFlag.PERMIT, 0.0, pair.clock_us))
    pair.pass_time(5)
    assert pair.c.controller.state is RobotState.RUN
    return pair


@pytest.mark.parametrize("minutes", MINUTES)
@pytest.mark.parametrize("first", ["tick", "step", "start"])
def test_no_lease_and_no_pose_outlives_a_freeze(minutes: float, first: str) -> None:
    pair = driving_pair()
    pair.freeze(60.0 * minutes)
    if first == "step":
        pair.step()
    elif first == "start":
        pair.sequence = expected_of(pair.python)
        pair.send(Start(9, 9, pair.python.controller.exec_next))
    else:
        pair.pass_time(1)
    for robot in (pair.python, pair.c):
        assert robot.controller.state in (RobotState.HOLD, RobotState.IDLE)
        assert robot.controller.reason in (StopReason.LEASE_LAPSED, StopReason.DISARMED)
    pair.pass_time(200)


@pytest.mark.parametrize("minutes", [0.5, 1.0, 9.0, 16.0, 17.0])
@pytest.mark.parametrize("first", ["tick", "step"])
def test_no_lease_outlives_a_freeze_of_a_board_whose_clock_has_30_bits(
    minutes: float, first: str
) -> None:
    pair = driving_pair()
    board = pair.python.controller.robot
    now_us = board.now_us + round(60e6 * minutes) & TIME
    if first == "step":
        board.step(now_us, 0, 0)
    else:
        board.tick(now_us)
    assert board.state == IDLE
    assert board.reason == DISARMED


@pytest.mark.parametrize("minutes", LONGER_MINUTES)
def test_no_lease_outlives_a_freeze_in_which_the_clock_came_round(minutes: float) -> None:
    pair = driving_pair()
    pair.freeze(60.0 * minutes)
    for robot in (pair.python, pair.c):
        robot.controller.tick(pair.now_s)
        assert robot.controller.reason in (StopReason.LEASE_LAPSED, StopReason.DISARMED)


@pytest.mark.parametrize("minutes", MINUTES)
def test_a_pose_of_before_a_freeze_starts_nothing(minutes: float) -> None:
    """A lease that comes first says that the camera is well; the robot knows better."""
    pair = driving_pair()
    pair.freeze(60.0 * minutes)
    pair.send(Lease(0.5, LeaseFlag.PERMIT, 0.0, pair.clock_us))
    pair.sequence = expected_of(pair.python)
    pair.send(Start(9, 9, pair.python.controller.exec_next))
    for robot in (pair.python, pair.c):
        assert robot.controller.state is not RobotState.RUN
    pair.pass_time(60)


@pytest.mark.parametrize("seed", range(6))
def test_both_robots_agree_for_three_hours_with_freezes(seed: int) -> None:
    rng, pair, drives = random.Random(seed), Pair(), 0
    pair.hello(20)
    began_s = pair.now_s
    while pair.now_s < began_s + 3.0 * 3600.0:
        begin_to_drive(pair, rng)
        see(pair)
        pair.pass_time(rng.choice([1, 20, 60]))
        drives += pair.c.controller.state is RobotState.RUN
        pair.freeze(rng.choice([0.6, 2.1, 17.0, 60.0 * rng.choice(MINUTES), rng.random() * 4200.0]))
        pair.pass_time(rng.choice([1, 5, 700]))
        assert pair.c.controller.state is not RobotState.RUN
    assert drives > 3
    assert TICK_S * pair.ticks > 2.0 * 2**32 / 1e6, "the clock has wrapped twice"

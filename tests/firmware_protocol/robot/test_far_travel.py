"""A robot that drives far without a camera pose: its counters end where the firmware's do."""

from __future__ import annotations

import math

import pytest

from firmware_protocol.robot.clearway.estimate import TRAVEL_MAX
from firmware_protocol.wire.messages import PoseFix
from tests.support.robots.c_robot import missing_tool
from tests.support.robots.micropython_interpreter import interpreter
from tests.support.robots.micropython_robot import MicroPair, Process
from tests.support.robots.robot_pair import Pair

CYCLE_M = 0.9
"""Hardly less than wheels are believed to travel in a cycle."""
OFF_RAD = 0.001
"""So little is off after so long a way that a drift is learnt from it."""
BENDS = {"straight on": 0.0, "round and round": 0.004}
"""The right wheel travels so much more in a cycle."""

needs_c = pytest.mark.skipif(missing_tool() is not None, reason=f"needs {missing_tool()}")
needs_micropython = pytest.mark.skipif(
    interpreter() is None, reason="needs MicroPython: .ci/micropython"
)


def drive_far(pair: Pair, metres: float, bend_m: float) -> None:
    """Drive so far or, straight on, a kilometre: further out a number needs the heap."""
    end_m = 1000.0 if bend_m == 0.0 else math.inf
    for _ in range(round(min(metres, end_m) / CYCLE_M)):
        pair.ticks += 10
        pair.wheels_m[0] += CYCLE_M
        pair.wheels_m[1] += CYCLE_M + bend_m
        left_m, right_m = (round(m, 6) for m in pair.wheels_m)
        pair.python.controller.step(pair.now_s, left_m, right_m)
        pair.c.controller.step(pair.now_s, left_m, right_m)
        pair.compare()


def see_it_a_little_off(pair: Pair) -> None:
    """A camera pose where the robot is, but for its heading."""
    x_m, y_m, heading_rad = pair.python.controller.pose
    pair.send(PoseFix(x_m, y_m, heading_rad + OFF_RAD, pair.clock_us))


def compare_far_drives(pair: Pair, metres: float, bend_m: float) -> None:
    """Learn a drift from a drive of so many metres, and show it in the next few."""
    pair.hello(3)
    see_it_a_little_off(pair)
    estimate = pair.python.controller.robot.estimate
    drive_far(pair, metres, bend_m)
    assert (estimate.travel_um == TRAVEL_MAX) is (metres > 1e-6 * TRAVEL_MAX)
    drift = estimate._drift
    see_it_a_little_off(pair)
    assert estimate._drift != drift, "the fix is one to learn from"
    drive_far(pair, 20.0, bend_m)


@needs_c
@pytest.mark.parametrize("bend_m", BENDS.values(), ids=list(BENDS))
@pytest.mark.parametrize("metres", [100.0, 1000.0, 2500.0])
def test_a_kilometre_without_a_pose_leaves_both_robots_alike(metres: float, bend_m: float) -> None:
    compare_far_drives(Pair(), metres, bend_m)


@needs_micropython
@pytest.mark.parametrize("bend_m", BENDS.values(), ids=list(BENDS))
def test_a_kilometre_without_a_pose_takes_no_heap(process: Process, bend_m: float) -> None:
    compare_far_drives(MicroPair(process), 1200.0, bend_m)

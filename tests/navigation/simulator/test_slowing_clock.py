"""The clock of a simulated world: it follows the wall, and waits for who is late."""

from __future__ import annotations

import math
import os
import random
import threading
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.host.connection import HostConnection
from navigation.simulator.robot import SimulatedRobot
from navigation.simulator.slowing_clock import (
    LONGEST_GAP_S,
    PATIENCE_S,
    READS_SLACK_S,
    SHARED_VALUES,
    SlowingClock,
)
from tests.support.waiting import wait_until

SLACK_S = 0.02


@dataclass
class Wall:
    """A wall's clock that is set on by hand."""

    now_s: float = 1000.0

    def __call__(self) -> float:
        return self.now_s


@dataclass
class Late:
    """A part with work that is not done since a moment, or none."""

    since_s: float = math.inf

    def __call__(self) -> float:
        return self.since_s


@dataclass
class Started:
    wall: Wall = field(default_factory=Wall)
    part: Late = field(default_factory=Late)

    def __post_init__(self) -> None:
        self.clock = SlowingClock(wall=self.wall)
        self.clock.waits_for("part", self.part, SLACK_S)

    def after(self, seconds: float) -> float:
        """What the clock shows when so much more of the wall's time has passed."""
        self.wall.now_s += seconds
        return self.clock() - 1000.0


def test_it_is_the_wall_s_while_nobody_is_late() -> None:
    started = Started()
    assert started.after(0.0) == 0.0
    assert started.after(12.5) == 12.5
    assert started.clock.lost_s == 0.0


def test_it_passes_what_is_not_done_by_the_slack_at_most() -> None:
    started = Started()
    started.part.since_s = 1000.0 + started.after(1.0)
    assert started.after(0.01) == pytest.approx(1.01)
    assert started.after(0.5) == pytest.approx(1.0 + SLACK_S)


def test_what_was_lost_is_not_made_up_for() -> None:
    started = Started()
    started.part.since_s = 1000.0 + started.after(1.0)
    started.after(0.5)
    started.part.since_s = math.inf
    assert started.after(0.0) == pytest.approx(1.0 + SLACK_S)
    assert started.after(0.3) == pytest.approx(1.3 + SLACK_S)
    assert started.clock.lost_s == pytest.approx(0.5 - SLACK_S)


def test_who_hangs_is_not_waited_for_any_longer() -> None:
    started = Started()
    started.part.since_s = 1000.0 + started.after(1.0)
    step_s = LONGEST_GAP_S / 2.0
    for _ in range(round(PATIENCE_S / step_s) - 1):
        assert started.after(step_s) <= 1.0 + SLACK_S + 1e-9
    started.after(LONGEST_GAP_S)
    before_s = started.clock()
    started.after(5.0)
    assert started.clock() - before_s == pytest.approx(5.0)


def test_who_moves_again_is_waited_for_again() -> None:
    started = Started()
    started.part.since_s = 1000.0 + started.after(1.0)
    for _ in range(round(PATIENCE_S / LONGEST_GAP_S) + 1):
        started.after(LONGEST_GAP_S)  # it hangs
    started.part.since_s = moved_s = started.clock()
    started.after(0.5)
    assert started.clock() == pytest.approx(moved_s + SLACK_S)


def test_a_program_that_was_stopped_and_continued_loses_nothing() -> None:
    started = Started()
    started.part.since_s = 1000.0 + started.after(1.0)
    assert started.after(3600.0) == pytest.approx(1.0 + SLACK_S)
    assert started.clock.lost_s == pytest.approx(3600.0 - SLACK_S)


def test_a_part_that_takes_another_s_name_takes_its_place() -> None:
    started = Started()
    started.part.since_s = 1000.0
    started.clock.waits_for("part", lambda: math.inf, SLACK_S)
    assert started.after(0.5) == pytest.approx(0.5)


def test_the_thread_that_is_waited_for_holds_it_by_not_reading_it() -> None:
    wall = Wall()
    clock = SlowingClock(wall=wall)
    clock.waits_for_this_thread()
    seen = []

    def look() -> None:
        seen.append(clock() - 1000.0)

    wall.now_s += 0.5
    for _ in range(2):
        other = threading.Thread(target=look)
        other.start()
        other.join()
    assert seen == pytest.approx([READS_SLACK_S] * 2), "another thread's reading does not count"
    assert clock() - 1000.0 == pytest.approx(READS_SLACK_S)
    wall.now_s += 0.05
    assert clock() - 1000.0 == pytest.approx(READS_SLACK_S + 0.05)


def test_two_processes_have_one_clock() -> None:
    wall, shared = Wall(), [0.0] * SHARED_VALUES
    here = SlowingClock(shared, wall=wall)
    there = SlowingClock(shared, side=1, wall=wall)
    part = Late()
    there.waits_for("part", part, SLACK_S)
    part.since_s = there()
    there()  # what it has to do is known in both from here on
    wall.now_s += 0.5
    assert here() - 1000.0 == pytest.approx(SLACK_S)
    assert there() - 1000.0 == pytest.approx(SLACK_S)
    part.since_s = math.inf
    there()
    wall.now_s += 0.1
    assert here() == there()
    assert here() - 1000.0 == pytest.approx(SLACK_S + 0.1)


@given(
    turns=st.lists(
        st.tuples(
            st.floats(0.0, 0.3),
            st.lists(st.one_of(st.just(math.inf), st.floats(0.0, 1.0)), min_size=3, max_size=3),
            st.integers(0, 1),
        ),
        max_size=40,
    )
)
def test_it_never_goes_back_and_never_faster_than_the_wall(
    turns: list[tuple[float, list[float], int]],
) -> None:
    wall, shared = Wall(), [0.0] * SHARED_VALUES
    clocks = [SlowingClock(shared, side, wall) for side in (0, 1)]
    parts = [Late() for _ in range(3)]
    for i, part in enumerate(parts):
        clocks[i % 2].waits_for(str(i), part, 0.01 * i)
    last_s = [clock() for clock in clocks]
    for passed_s, behind, side in turns:
        before_s = wall.now_s
        wall.now_s += passed_s
        for part, ago_s in zip(parts, behind, strict=True):
            part.since_s = before_s - ago_s
        now_s = clocks[side]()
        assert last_s[side] <= now_s <= wall.now_s
        last_s[side] = now_s


def test_a_robot_whose_reports_nobody_reads_is_late() -> None:
    wall = Wall()
    clock = SlowingClock(wall=wall)
    robot = SimulatedRobot(rng=np.random.default_rng(1), clock=clock)
    host = os.open(robot.port, os.O_RDWR | os.O_NOCTTY)
    os.set_blocking(host, False)
    greeting = HostConnection(random.Random(1))
    greeting.open(clock())
    try:
        robot.switched_on()
        os.write(host, greeting.bytes_to_send(clock()))

        def turn() -> float:
            wall.now_s += 0.01
            robot.turn()
            return robot.late_since_s()

        # the kernel hands bytes through a pseudo-terminal when it gets to it
        assert wait_until(lambda: turn() < clock() - 0.1), "it has answered the greeting"
        unread_since_s = robot.late_since_s()

        def turn_with_a_reader() -> float:
            with suppress(BlockingIOError):
                os.read(host, 4096)
            return turn()

        assert wait_until(lambda: turn_with_a_reader() > unread_since_s + 0.1)
        robot.switched_off()
        assert robot.late_since_s() == math.inf
    finally:
        os.close(host)
        robot.stop()

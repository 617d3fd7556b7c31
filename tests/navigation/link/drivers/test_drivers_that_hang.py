"""Drivers that hang, are killed, are slow or loop, in real time: the daemon stops their robots.

Their bounds hold beside busy programs too: `python -m benchmarks.robots --hung --load 6`.
"""

from __future__ import annotations

import os
import signal
import time

import pytest

from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.link_snapshot import doubt_of_stop
from tests.support.robots.troubled_drivers import (
    PATIENCE_S,
    TROUBLES,
    drive_into,
    driven,
    set_off,
)
from tests.support.waiting import wait_until

pytestmark = pytest.mark.timed
"""A driver without a beat for 0.2 s is ended: beside other workers that happens to every one."""

HANGS = [*((name, "frozen") for name in KNOWN_ROBOTS), *(("create2", one) for one in TROUBLES[1:])]
"""Each maker's stop, and each trouble; `python -m benchmarks.robots --hung` measures all pairs."""


@pytest.mark.parametrize(("name", "trouble"), HANGS)
def test_a_robot_stands_within_0_3_s_of_its_drivers_last_beat(name: str, trouble: str) -> None:
    measured = drive_into(trouble, name)
    assert measured.speed_m_s > 0.5 * KNOWN_ROBOTS[name].speed_m_s, "it drove"
    assert measured.driven_m <= measured.bar_m


@pytest.mark.parametrize("number", [signal.SIGSTOP, signal.SIGKILL])
def test_a_driver_that_was_ended_is_started_again_and_drives_nothing(
    number: signal.Signals,
) -> None:
    with driven("create2") as bench:
        set_off(bench, "create2")
        first, restarts = bench.pid, bench.driver.restarts
        os.kill(first, number)
        assert wait_until(lambda: bench.driver.restarts > restarts, PATIENCE_S)
        assert wait_until(lambda: bench.driver.pid not in (None, first), PATIENCE_S)
        assert wait_until(lambda: bench.link.snapshot().down_reason is None, PATIENCE_S)
        assert not bench.twin.moving
        where = bench.twin.pose().x_m
        time.sleep(0.3)  # long enough to see it drive on
        assert bench.twin.pose().x_m == pytest.approx(where, abs=0.002)


@pytest.mark.parametrize("name", ["create2", "epuck2"])
def test_a_program_that_ends_while_its_driver_hangs_leaves_a_robot_that_stands(name: str) -> None:
    with driven(name) as bench:
        set_off(bench, name)
        os.kill(bench.pid, signal.SIGSTOP)
        began_s = time.monotonic()
        assert bench.driver.stop() is None, "it was heard to stand"
        assert time.monotonic() - began_s < 3.0
        assert wait_until(lambda: not bench.twin.moving, 0.2), "but for its last millimetre"


def test_a_robot_that_is_not_heard_to_stand_at_the_end_is_named() -> None:
    with driven("create2") as bench:
        set_off(bench, "create2")
        bench.twin.unplug()
        began_s = time.monotonic()
        said = bench.driver.stop()
        assert time.monotonic() - began_s < 4.0
        assert said is not None
        assert said.startswith(f"the iRobot Create 2 on {bench.twin.port} was ordered to stand")


def test_no_process_is_started_before_a_robot_is_heard_to_stand() -> None:
    with driven("create2") as bench:
        set_off(bench, "create2")
        first, restarts = bench.pid, bench.driver.restarts
        bench.twin.unplug()
        os.kill(first, signal.SIGSTOP)
        assert wait_until(
            lambda: "has not been heard to" in str(bench.link.snapshot().down_reason), PATIENCE_S
        )
        assert (bench.driver.restarts, bench.pid) == (restarts + 1, first)
        assert bench.twin.moving, "a Create 2 has no watchdog"
        bench.twin.unplug(False)
        assert wait_until(lambda: not bench.twin.moving, PATIENCE_S)
        assert wait_until(lambda: bench.driver.pid not in (None, first), PATIENCE_S)
        assert wait_until(lambda: bench.link.snapshot().down_reason is None, PATIENCE_S)


@pytest.mark.parametrize("hangs", [False, True])
def test_a_stop_is_called_one_when_the_wheels_are_heard_to_stand(hangs: bool) -> None:
    with driven("create2") as bench:
        set_off(bench, "create2")
        assert not bench.driver.word().stands
        if hangs:
            os.kill(bench.pid, signal.SIGSTOP)
        bench.link.estop()
        assert wait_until(
            lambda: bench.twin.moving < (doubt_of_stop(bench.link.snapshot()) is None), PATIENCE_S
        ), doubt_of_stop(bench.link.snapshot())


def test_a_stop_that_cannot_reach_the_robot_is_never_called_one() -> None:
    with driven("create2") as bench:
        set_off(bench, "create2")
        bench.twin.unplug()
        bench.link.estop()
        end_s = time.monotonic() + 1.5
        while time.monotonic() < end_s:
            assert doubt_of_stop(bench.link.snapshot()) is not None
            time.sleep(0.01)  # the pace at which it is looked for
        assert "has gone silent" in str(doubt_of_stop(bench.link.snapshot()))

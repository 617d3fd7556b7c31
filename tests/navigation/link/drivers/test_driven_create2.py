"""A Create 2 behind its driver, in virtual time: few speeds, counts without a sign, chargers."""

from __future__ import annotations

import math

import pytest

from firmware_protocol.wire.messages import RobotState
from navigation.link.drivers import create2
from navigation.simulator.line_faults import FaultSpec
from navigation.simulator.twins.create2 import Create2Twin, OpenInterfaceMode
from tests.support.robots.driven_bench import DrivenBench, assert_at_goal, drive_off, scaled_goal


@pytest.mark.parametrize("seed", range(3))
def test_a_create_turns_to_its_goal_s_heading_though_its_slowest_speed_is_39_mm_s(
    seed: int,
) -> None:
    bench = DrivenBench("create2", seed=seed)
    bench.get_ready()
    bench.send(5, (0.02, 0.0), (0.1, 0.0))
    bench.run_until(lambda: bench.is_done, 30.0)
    bench.send(6, (0.1, 0.02), (0.1, 0.15))
    bench.run(1.0)
    assert not bench.is_done
    bench.run_until(lambda: bench.is_done, 40.0)
    x, y, heading = bench.drive.pose
    assert math.dist((x, y), (0.1, 0.15)) <= 0.006
    assert abs(math.degrees(heading)) <= 1.0


@pytest.mark.parametrize("lag_s", [0.025, 0.1])
def test_a_create_s_wheels_may_lag_otherwise(lag_s: float) -> None:
    """The driver takes 50 ms to know which way a wheel turns."""
    bench = DrivenBench("create2", lag_s=lag_s)
    bench.get_ready()
    bench.send(5, *scaled_goal("create2"))
    bench.run_until(lambda: bench.is_done, 40.0)
    assert_at_goal(bench, "create2")


def test_a_create_s_travel_is_right_though_its_counts_have_no_sign() -> None:
    """On the spot one wheel alternates between backwards and a stop, in which it counts up."""
    bench = DrivenBench("create2", slip=0.0)
    bench.get_ready()
    bench.leases = False
    driver = bench.robot.driver
    bench.robot.tick = lambda now_s: driver.drive(-0.013, 0.021)  # type: ignore[method-assign]
    begun, heard = bench.drive.encoders_m, (driver.heard.left_m, driver.heard.right_m)
    bench.run(5.0)
    bench.robot.tick = lambda now_s: driver.drive(0.0, 0.0)  # type: ignore[method-assign]
    bench.run(0.5)
    left, right = (now - was for now, was in zip(bench.drive.encoders_m, begun, strict=True))
    assert left == pytest.approx(-0.065, abs=0.004), "as fast as it should in the mean"
    assert right == pytest.approx(0.105, abs=0.004)
    assert driver.heard.left_m - heard[0] == pytest.approx(left, abs=0.002)
    assert driver.heard.right_m - heard[1] == pytest.approx(right, abs=0.002)


def test_a_create_that_is_pushed_reports_no_travel_of_its_own() -> None:
    """Its counts go up either way: the camera alone knows, and the two disagree."""
    bench = DrivenBench("create2")
    bench.get_ready()
    bench.run(1.0)
    before = bench.robot.driver.heard.left_m
    for _ in range(100):
        left, right = bench.zero
        bench.zero = (left + 2, right + 2)  # pushed backwards, by two counts in 10 ms
        bench.run(0.01)
    assert bench.robot.driver.heard.left_m == before


# A Create 2 and its chargers.


def test_a_create_on_its_home_base_charges_until_it_is_to_drive() -> None:
    bench = DrivenBench("create2")
    assert isinstance(bench.twin, Create2Twin)
    bench.twin.dock(True)
    bench.run(3.0)
    charge_mah = bench.twin.charge_mah
    bench.run(20.0)
    assert bench.twin.charge_mah - charge_mah == pytest.approx(20 / 3600 * 1_250, rel=0.01)
    word = bench.robot.word(bench.now_s)
    assert (word.silence, word.fault) == (None, None)
    assert "is on its charger and rests" in word.remark
    bench.send(5, *scaled_goal("create2"))
    bench.run(1.5)
    bench.twin.dock(False)
    assert bench.twin.mode is OpenInterfaceMode.SAFE
    assert bench.robot.word(bench.now_s).remark == ""
    bench.run_until(lambda: bench.is_done, 40.0)
    assert_at_goal(bench, "create2")


def test_a_create_that_rests_is_kept_awake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(create2, "AWAKE_S", 2.0)
    bench = DrivenBench("create2")
    assert isinstance(bench.twin, Create2Twin)
    bench.twin.dock(True)
    bench.get_ready()
    bench.twin._sleep_s = 5.0
    for _ in range(150):
        bench.run(0.1)
        assert bench.silence is None
    assert not bench.twin.asleep
    assert "is on its charger and rests" in bench.robot.word(bench.now_s).remark


@pytest.mark.parametrize("seed", range(3))
def test_a_line_that_stalls_joins_both_bursts_of_the_greeting_and_delays_it(seed: int) -> None:
    bench = DrivenBench("create2", seed=seed, faults=FaultSpec.parse("stall=0.1@0.5"))
    bench.get_ready()
    assert isinstance(bench.twin, Create2Twin)
    bench.run(2.0)
    assert bench.twin.mode is OpenInterfaceMode.SAFE


def test_a_create_that_drives_onto_its_home_base_rests_there() -> None:
    bench = DrivenBench("create2")
    assert isinstance(bench.twin, Create2Twin)
    bench.get_ready()
    bench.send(5, *scaled_goal("create2"))
    bench.run_until(lambda: bench.is_done, 40.0)
    bench.twin.dock(True)
    bench.run(8.0)
    assert bench.twin.mode is OpenInterfaceMode.PASSIVE
    assert "is on its charger and rests" in bench.robot.word(bench.now_s).remark
    assert not bench.twin.asleep


def test_a_create_with_the_charger_s_cable_charges_and_says_to_pull_it_out() -> None:
    bench = DrivenBench("create2")
    assert isinstance(bench.twin, Create2Twin)
    bench.get_ready()
    bench.twin.plug_in(True)
    bench.run(2.0)
    charge_mah, said = bench.twin.charge_mah, set()
    for _ in range(100):
        bench.run(0.1)
        said.add(bench.silence)
    assert len(said) == 1, "one sentence that stays"
    assert "pull the cable out" in str(said)
    assert bench.twin.charge_mah - charge_mah == pytest.approx(10 / 3600 * 1_250, rel=0.01)
    bench.twin.plug_in(False)
    bench.run(1.5)
    assert bench.silence is None
    assert bench.twin.mode is OpenInterfaceMode.SAFE


def test_a_create_whose_battery_was_out_starts_up_and_is_greeted_again() -> None:
    bench = DrivenBench("create2")
    bench.get_ready()
    bench.reboot()
    bench.run(1.0)
    assert "starts up" in str(bench.silence)
    bench.run(4.0)
    assert bench.silence is None
    assert isinstance(bench.twin, Create2Twin)
    assert bench.twin.mode is OpenInterfaceMode.SAFE


def test_a_create_that_is_lifted_leaves_safe_mode_and_comes_back() -> None:
    bench = DrivenBench("create2")
    drive_off(bench, "create2")
    bench.twin.lift(True)
    bench.run(1.0)
    assert isinstance(bench.twin, Create2Twin)
    assert (bench.twin.mode, bench.state) == (OpenInterfaceMode.PASSIVE, RobotState.ESTOP)
    assert "a wheel hangs in the air" in str(bench.robot.word(bench.now_s).fault)
    bench.twin.lift(False)
    bench.run(0.5)
    bench.host.reset_estop(bench.now_s)
    bench.run(2.0)
    assert bench.state is RobotState.IDLE
    bench.send(6, (0.2, 0.0), (0.5, 0.0))
    bench.run(3.0)
    assert bench.twin.mode is OpenInterfaceMode.SAFE
    assert bench.drive.moving


def test_a_create_that_sleeps_says_which_button_wakes_it() -> None:
    bench = DrivenBench("create2")
    assert isinstance(bench.twin, Create2Twin)
    bench.twin.asleep = True
    bench.run(2.0)
    assert "press CLEAN to wake it" in str(bench.silence)
    bench.twin.press_clean(bench.now_s)
    bench.run(2.0)
    assert bench.silence is None


def test_a_create_is_kept_awake_for_longer_than_its_five_minutes() -> None:
    bench = DrivenBench("create2")
    assert isinstance(bench.twin, Create2Twin)
    bench.get_ready()
    bench.twin._sleep_s = 2.0
    bench.run(6.0)
    assert not bench.twin.asleep

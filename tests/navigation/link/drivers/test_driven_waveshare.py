"""A Waveshare UGV behind its driver, in virtual time: its type, its encoders, its two firmwares."""

from __future__ import annotations

import json
import math

import pytest

from firmware_protocol.wire.messages import RobotState
from navigation.link.drivers.drivers import new_driver
from navigation.link.drivers.waveshare import WaveshareDriver
from navigation.simulator.twins.waveshare import WaveshareTwin
from tests.support.robots.driven_bench import DrivenBench, assert_at_goal, scaled_goal


def test_a_ugv_that_starts_again_on_its_way_is_told_again_which_robot_it_is() -> None:
    """By the type that it has after a start it would drive backwards."""
    bench = DrivenBench("waveshare")
    bench.get_ready()
    bench.send(5, *scaled_goal("waveshare"))
    bench.run(2.5)
    assert isinstance(bench.twin, WaveshareTwin)
    bench.reboot()
    assert bench.twin.main_type == 1
    before = bench.drive.encoders_m
    bench.run(4.0)
    assert bench.twin.main_type == 3
    assert min(bench.drive.encoders_m) > min(before) - 0.001
    bench.host.start(bench.now_s)
    bench.run_until(lambda: bench.is_done, 60.0)
    assert math.dist(bench.drive.pose[:2], scaled_goal("waveshare")[-1]) <= 0.010


def test_a_type_that_was_lost_on_the_line_is_sent_again() -> None:
    driver, twin = WaveshareDriver(), WaveshareTwin()
    driver.open(0.0)
    driver.receive(b'{"T":1001,"L":0,"R":0,"v":12.0}\n', 0.01)
    lost = driver.bytes_to_send(0.02) + driver.bytes_to_send(1.1)
    assert b'{"T":900,"main":3,"module":0}' in lost
    for tick in range(30):
        now_s = 1.1 + tick / 20
        driver.receive(b'{"T":1001,"L":0,"R":0,"v":12.0}\n', now_s)
        twin.receive(driver.bytes_to_send(now_s), now_s)
    assert twin.main_type == 3


@pytest.mark.parametrize(("model", "main"), [("ugv01", 3), ("ugv_rover", 2), ("rasp_rover", 1)])
def test_each_model_has_its_number(model: str, main: int) -> None:
    driver, twin = new_driver("waveshare", model), WaveshareTwin()
    driver.open(0.0)
    twin.receive(driver.bytes_to_send(0.0), 0.0)
    assert twin.main_type == main


def test_a_ugv_with_the_firmware_for_ros_reaches_its_goal_and_has_its_battery() -> None:
    bench = DrivenBench("waveshare", twin=WaveshareTwin(is_for_ros=True))
    bench.get_ready()
    bench.send(5, *scaled_goal("waveshare"))
    bench.run_until(lambda: bench.is_done, 40.0)
    assert_at_goal(bench, "waveshare")
    assert bench.robot.word(bench.now_s).battery == pytest.approx((11.9 - 9.0) / 3.6)


@pytest.mark.parametrize(
    ("volts", "share"), [(12.6, 1.0), (1260, 1.0), (9.2, 0.0556), (920, 0.0556), (8.0, 0.0)]
)
def test_a_battery_is_in_volts_or_in_hundredths(volts: float, share: float) -> None:
    driver = WaveshareDriver()
    report = {"T": 1001, "L": 0, "R": 0, "v": volts}
    driver.receive(json.dumps(report).encode() + b"\n", 0.0)
    assert driver.heard.battery == pytest.approx(share, abs=0.001)


def test_a_robot_without_encoders_is_stopped_before_it_is_far_and_says_why() -> None:
    """Its regulator hears nothing and gives full power, whatever was ordered."""
    bench = DrivenBench("waveshare", twin=WaveshareTwin(has_encoders=False))
    bench.get_ready()
    bench.send(5, *scaled_goal("waveshare"))
    bench.run(3.0)
    assert bench.state is RobotState.ESTOP
    assert not bench.drive.moving
    assert math.dist(bench.drive.pose[:2], (0.0, 0.0)) < 0.35
    fault = str(bench.robot.word(bench.now_s).fault)
    assert "it has no encoders (a WAVE ROVER), robot.model names another robot" in fault
    bench.host.reset_estop(bench.now_s)
    bench.run(1.0)
    assert bench.state is RobotState.IDLE, "a person may try again"


def test_a_robot_that_has_counted_once_is_not_said_to_have_no_encoders() -> None:
    driver = WaveshareDriver()
    for tick in range(300):
        now_s = tick / 100
        speed = 0.1 if tick == 50 else 0.0
        driver.receive(json.dumps({"T": 1001, "L": speed, "R": 0.0}).encode() + b"\n", now_s)
        driver.drive(0.1 if tick > 40 else 0.0, 0.1)
        driver.bytes_to_send(now_s)
        if tick < 40:
            driver.drive(0.0, 0.0)
            driver.bytes_to_send(now_s)
    assert driver.heard.fault is None

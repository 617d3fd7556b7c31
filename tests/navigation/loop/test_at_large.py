"""A robot behind a driver whose cable is out: what still stops it, and where it may be."""

from __future__ import annotations

import math
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from firmware_protocol.host.state import LinkState
from navigation.config import load_config
from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.fleet.members import Member
from navigation.link.link_snapshot import LinkSnapshot
from navigation.link.robot_link import RobotLink
from navigation.loop.robot import ControlledRobot
from navigation.loop.seeing.eye_settings import reach_m, stop_s
from navigation.loop.traffic.coordinated import BRAKES_S, STOOD_S, member
from navigation.mission.cycle import Orders
from vision.markers.markers import RobotPose

CONFIG = load_config(Path(__file__).parents[3] / "configs" / "epuck2.yaml", environment={})
UP = LinkSnapshot(LinkState.STREAM, None, 0.0)
DOWN = LinkSnapshot(LinkState.STREAM, "the cable is out", 1.0)
FOR_EVER_S = 1e6


class Wire:
    """Takes poses, and does nothing."""

    def pose_fix(self, *_pose: float) -> None:
        pass


def seen_at(driver: str, times_s: list[float], speed_m_s: float = 0.0) -> ControlledRobot:
    """A robot of a kind, seen at these times."""
    own = CONFIG.robot.model_copy(update={"driver": driver})
    robot = ControlledRobot(
        "ada", CONFIG.model_copy(update={"robot": own}), cast("RobotLink", Wire()), 1
    )
    for now_s in times_s:
        pose = RobotPose(own.marker_id, 0.5, 0.3, 0.0, now_s, np.zeros((4, 2)), vx=speed_m_s)
        robot.sees({own.marker_id: pose}, now_s)
    return robot


def at(robot: ControlledRobot, now_s: float, snapshot: LinkSnapshot) -> Member:
    return member(robot, now_s, Orders(permit=False), snapshot)


@pytest.mark.parametrize("driver", ["clearway", *KNOWN_ROBOTS])
def test_only_one_without_a_watchdog_may_be_anywhere_and_only_unseen_and_unheard(
    driver: str,
) -> None:
    robot = seen_at(driver, [10.0], speed_m_s=0.1)
    robot.permitted_s = 10.0
    without = driver != "clearway" and KNOWN_ROBOTS[driver].watchdog_s is None
    assert not at(robot, 10.1, DOWN).at_large, "it is seen"
    assert not at(robot, 20.0, UP).at_large, "its driver reports"
    assert at(robot, 20.0, DOWN).at_large == without
    assert at(robot, FOR_EVER_S, DOWN).at_large == without


def test_one_that_was_seen_to_stand_with_nothing_to_drive_by_still_stands() -> None:
    lease_s = CONFIG.safety.lease_s + BRAKES_S
    robot = seen_at("epuck2", [10.0, 10.0 + lease_s, 10.1 + lease_s + STOOD_S])
    robot.permitted_s = 10.0
    lost = at(robot, FOR_EVER_S, DOWN)
    assert (lost.at_large, lost.stands) == (False, True)
    robot.permitted_s = 11.0  # it may have set out since
    assert at(robot, FOR_EVER_S, DOWN).at_large


def test_one_with_a_watchdog_drives_on_for_as_long_beyond_its_lease() -> None:
    robot = seen_at("turtlebot3", [10.0], speed_m_s=0.1)
    body, watchdog_s = robot.config.robot, KNOWN_ROBOTS["turtlebot3"].watchdog_s
    assert watchdog_s is not None
    least_m = reach_m(body, CONFIG.safety)
    assert at(robot, 12.0, UP).reach_m == least_m
    assert at(robot, 12.0, DOWN).reach_m == pytest.approx(least_m + watchdog_s * body.speed_m_s)
    stops_s = 10.0 + stop_s(body, CONFIG.safety)
    assert at(robot, stops_s + 0.01, UP).stands
    assert not at(robot, stops_s + watchdog_s - 0.01, DOWN).stands
    assert at(robot, stops_s + watchdog_s + 0.01, DOWN).stands


def test_our_firmware_keeps_its_lease_whatever_becomes_of_the_cable() -> None:
    robot = seen_at("clearway", [10.0], speed_m_s=0.1)
    assert math.isclose(at(robot, 12.0, DOWN).reach_m, reach_m(robot.config.robot, CONFIG.safety))

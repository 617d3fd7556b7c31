"""A stop with a heading on wheels that do not turn below some speed, with each of the robots."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from firmware_protocol.robot.connection import Identity, RobotConnection
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.messages import RobotState, StopReason, Waypoint, WaypointFlag
from firmware_protocol.wire.mission import Mission
from navigation.simulator.drive_model import DriveModel
from navigation.simulator.virtual_loop import python_robot
from tests.support.robots.c_robot import CRobot, missing_tool
from tests.support.runs.scenario_loop import ScenarioLoop

END = WaypointFlag.STOP | WaypointFlag.END
GOAL = (0.30, 0.05)
HEADING_RAD = 1.0
STARTS = 1.25
"""A wheel is sure to turn at so much of its dead zone: it sticks by a fifth of it."""
RobotMaker = Callable[[Identity, DriveSettings], RobotConnection]
ROBOTS: dict[str, RobotMaker] = {
    "python": python_robot,
    "c": CRobot,  # type: ignore[dict-item]
}


def drive(dead_zone_m_s: float, least_m_s: float, make: RobotMaker, track_m: float) -> ScenarioLoop:
    """Up to a stop with a heading, and whatever became of it after 30 s."""
    loop = ScenarioLoop(
        seed=4,
        model=DriveModel(track_m=track_m * 1.01, left_scale=1.01, dead_zone_m_s=dead_zone_m_s),
        settings=DriveSettings(track_m=track_m, least_wheel_m_s=least_m_s),
        make_robot=make,
    )
    assert loop.run(3.0, lambda: loop.host.clock.ready and loop.host.status is not None)
    places = [Waypoint(0.1, 0.0, 0.2), Waypoint(0.2, 0.0, 0.2)]
    places.append(Waypoint(*GOAL, 0.0, heading_rad=HEADING_RAD, flags=END))
    loop.host.upload(Mission(5, places), loop.now_s, True)
    loop.run(30.0, lambda: loop.robot.controller.reason in ENDS)
    return loop


ENDS = (StopReason.MISSION_DONE, StopReason.STUCK)


DEAD_ZONES_M_S = (0.0, 0.002, 0.005, 0.02, 0.04, 0.08)
CASES = [(robot, zone, 0.12) for robot in ROBOTS for zone in DEAD_ZONES_M_S]
CASES += [("python", zone, 0.053) for zone in (0.005, 0.02, 0.04)]


@pytest.mark.parametrize(("robot", "dead_zone_m_s", "track_m"), CASES)
def test_a_stop_with_a_heading_is_reached(robot: str, dead_zone_m_s: float, track_m: float) -> None:
    if robot == "c" and missing_tool() is not None:
        pytest.skip(f"needs {missing_tool()} to build the firmware")
    least_m_s = max(DriveSettings().least_wheel_m_s, STARTS * dead_zone_m_s)
    loop = drive(dead_zone_m_s, least_m_s, ROBOTS[robot], track_m)
    assert loop.robot.controller.reason is StopReason.MISSION_DONE
    x, y, heading = loop.drive.pose
    assert math.dist((x, y), GOAL) < 0.004
    assert abs(math.degrees(heading - HEADING_RAD)) < 1.0


def test_without_pulses_a_stop_with_a_heading_is_never_reached() -> None:
    """What the pulses are for, and that these wheels are as bad as real ones."""
    loop = drive(0.005, 0.0, python_robot, 0.12)
    assert loop.robot.controller.reason is StopReason.STUCK
    assert loop.robot.controller.state is RobotState.HOLD

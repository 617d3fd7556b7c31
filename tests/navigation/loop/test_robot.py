"""What the control loop does for a driven robot it does for one of several too."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import numpy as np
import pytest

from firmware_protocol.host.state import LinkState
from navigation.config import load_config
from navigation.link.link_snapshot import LinkSnapshot
from navigation.link.robot_link import RobotLink
from navigation.loop.robot import ControlledRobot
from navigation.loop.run_state import StageTimes
from navigation.loop.seeing.arena_view import ArenaView
from navigation.loop.seeing.eye import Glimpse
from vision.markers.markers import RobotPose

CONFIG = load_config(Path(__file__).parents[3] / "configs" / "simulation.yaml", environment={})
CORNERS_PX = np.zeros((4, 2))


class Wire:
    """Keeps the poses that would go out."""

    def __init__(self) -> None:
        self.captured_s = list[float]()

    def pose_fix(self, _x_m: float, _y_m: float, _heading_rad: float, captured_s: float) -> None:
        self.captured_s.append(captured_s)


class Look:
    """Of a view only what a state is made of."""

    frame = None
    glimpse = Glimpse(0.0, {}, None, None)


@pytest.fixture
def robot() -> ControlledRobot:
    return ControlledRobot("anna", CONFIG, cast("RobotLink", Wire()), 1)


def pose(captured_s: float, before_frame_s: float = 0.0) -> RobotPose:
    number = CONFIG.robot.marker_id
    return RobotPose(number, 1.0, 0.5, 0.0, captured_s, CORNERS_PX, before_frame_s=before_frame_s)


def test_the_witness_dates_a_marker_by_the_rows_that_show_it(
    robot: ControlledRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A rolling shutter exposes a marker's rows before the frame's own time."""
    dated_s = list[float]()
    monkeypatch.setattr(robot.witness, "saw", lambda _pose, frame_s: dated_s.append(frame_s))
    seen = pose(10.0 - 0.02, before_frame_s=0.02)
    robot.sees({seen.id: seen}, 10.0)
    assert robot.pose is seen
    assert dated_s == [10.0 - 0.02]
    assert cast("Wire", robot.link).captured_s == [10.0 - 0.02]


def test_of_other_robots_it_is_told_nothing(robot: ControlledRobot) -> None:
    robot.sees({CONFIG.robot.marker_id + 1: pose(10.0)}, 10.0)
    assert robot.pose is None
    assert cast("Wire", robot.link).captured_s == []


def test_people_are_told_what_its_driver_remarks(robot: ControlledRobot) -> None:
    snapshot = LinkSnapshot(LinkState.STREAM, None, 0.0, remark="its battery is nearly empty")
    view = cast("ArenaView", Look())
    state = robot.state(1.0, view, snapshot, None, StageTimes(), ("the disk is full", ""), None)
    assert state.troubles == ("the disk is full", "its battery is nearly empty")
    assert state.sentence == robot.pilot.mission.reason
    waits = robot.state(1.0, view, snapshot, None, StageTimes(), (), "waits for bob")
    assert waits.sentence == "waits for bob"

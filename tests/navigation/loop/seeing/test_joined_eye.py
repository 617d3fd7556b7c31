"""The eye of several cameras, frame by frame: a camera may be lost at any time.

Cameras and robot are the simulator's; which frames come is the test's. The oracle knows of a camera
only when its last frame came: what only a silent one sees must be an obstacle in the newest scene,
and what a camera that is heard sees must not.
"""

from __future__ import annotations

import math
from itertools import count

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from navigation.config.several.each_camera import each_camera
from navigation.loop.seeing.eye import Glimpse
from navigation.loop.seeing.joined.joined_eye import MISSED_FRAMES, START_S
from navigation.loop.seeing.joined.joined_parts import joined_eye
from navigation.run.calibrations import floor_plan_of
from navigation.simulator.arena import SimulatedArena, load_arena
from navigation.simulator.picture.camera import make_camera
from planner.scene import CircleRecord, Scene, SceneObject
from tests.support.runs.two_cameras import config_of
from tests.vision.joined.floor_truth import outlines_of
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

CONFIG = config_of((2.2, 1.6))
PLAN = floor_plan_of(CONFIG)
ARENA = load_arena(CONFIG)
STALE_S = CONFIG.safety.frame_stale_s
PERIOD_S = 1.0 / 30.0
IN_BOTH = (1.42, 0.98, 0.5)
PLACES = {"left": (0.12, 0.9), "right": (2.28, 0.9)}
"""Floor that only one of the cameras sees, without obstacles."""


class Stage:
    """Two simulated cameras, the eye, and a clock that goes from frame to frame."""

    def __init__(self) -> None:
        assert PLAN is not None
        self.pose = IN_BOTH
        self.eye = joined_eye(CONFIG, PLAN)
        self.cameras = {
            name: make_camera(
                one, ARENA, [(one.robot, lambda _at_s: self.pose)], lambda: 0.0, lambda _: None
            )
            for name, one in each_camera(CONFIG).items()
        }
        self.rng = np.random.default_rng(5)
        self.numbers = count()
        self.now_s = 0.0
        self.scene: Scene | None = None
        self.glimpse: Glimpse | None = None
        self.reported: list[RobotPose] = []

    def round(self, *silent: str) -> None:
        """A frame of each camera but the silent ones."""
        for index, (name, camera) in enumerate(self.cameras.items()):
            if name in silent:
                continue
            image = camera.render([self.pose], self.rng)
            time_s = self.now_s + 0.5 * index * PERIOD_S
            frame = Frame(image, time_s, next(self.numbers), name)
            self.glimpse = self.eye.look(frame, lambda poses: self.reported.extend(poses.values()))
            self.scene = self.glimpse.scene or self.scene
        self.now_s += PERIOD_S

    def is_closed(self, name: str) -> bool:
        """Whether the floor that only this camera sees is an obstacle in the newest scene."""
        assert self.scene is not None
        x, y = PLACES[name]
        return float(SimulatedArena(self.scene).clearances([(x, y)])[0]) < 0.0


def rounds_until_lost() -> int:
    return max(MISSED_FRAMES, math.ceil(STALE_S / PERIOD_S)) + 2


@settings(max_examples=6, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    losses=st.lists(
        st.tuples(st.sampled_from(["left", "right"]), st.integers(0, 5), st.integers(1, 14)),
        min_size=1,
        max_size=3,
    )
)
def test_a_camera_may_be_lost_at_any_time(losses: list[tuple[str, int, int]]) -> None:
    stage = Stage()
    for _ in range(6):
        stage.round()
    for name, before, silent in losses:
        for _ in range(before):
            stage.round()
        for number in range(1, silent + 1):
            stage.round(name)
            if number >= rounds_until_lost():
                assert stage.is_closed(name)
            if number * PERIOD_S < STALE_S:
                assert not stage.is_closed(name)
            other = "right" if name == "left" else "left"
            assert not stage.is_closed(other)
        for _ in range(4):
            stage.round()
        assert not stage.is_closed(name)
        assert stage.glimpse is not None
        assert not any(stage.glimpse.troubles.values())


def test_the_scene_of_both_is_the_arena_and_never_the_robot() -> None:
    stage = Stage()
    for _ in range(4):
        stage.round()
    assert stage.scene is not None
    assert len(stage.scene.objects) == len(ARENA.scene.objects)
    assert PLAN is not None
    border = np.concatenate(outlines_of(stage.scene))
    assert np.abs(ARENA.clearances(border)).max() < PLAN.calibration.metres_per_pixel


def test_a_camera_that_never_comes_is_waited_for_and_then_closed() -> None:
    stage = Stage()
    rounds = math.floor(START_S / PERIOD_S)
    for _ in range(rounds):
        stage.round("left")
    assert stage.scene is None
    for _ in range(4):
        stage.round("left")
    assert stage.scene is not None
    assert stage.is_closed("left")
    assert not stage.is_closed("right")


def test_a_robot_where_nothing_is_seen_holds_and_elsewhere_does_not() -> None:
    stage = Stage()
    stage.pose = (0.15, 0.9, 0.0)  # seen by the left camera only
    for _ in range(5):
        stage.round()
    assert stage.glimpse is not None
    assert stage.glimpse.hold is None
    for _ in range(rounds_until_lost()):
        stage.round("left")
    assert stage.glimpse.hold is not None
    assert "no camera sees the floor: left is lost" in stage.glimpse.hold
    for _ in range(4):
        stage.round()
    assert stage.glimpse.hold is None


@pytest.mark.parametrize("name", ["left", "right"])
def test_an_obstacle_that_comes_is_seen_in_either_part(name: str) -> None:
    stage = Stage()
    for _ in range(4):
        stage.round()
    x, y = PLACES[name]
    stranger = SceneObject(99, (CircleRecord((x, y), 0.06),))
    scene = ARENA.scene
    changed = Scene(scene.units, scene.bounds, (*scene.objects, stranger))
    for camera in stage.cameras.values():
        camera.set_scene(changed)
    for _ in range(4):
        stage.round()
    assert stage.scene is not None
    assert len(stage.scene.objects) == len(scene.objects) + 1
    assert stage.is_closed(name)


def test_people_see_one_picture_and_the_marker_in_it() -> None:
    stage = Stage()
    for _ in range(4):
        stage.round()
    assert PLAN is not None
    assert stage.glimpse is not None
    assert stage.glimpse.picture is not None
    assert stage.glimpse.picture.size == PLAN.calibration.size
    (pose,) = stage.glimpse.poses.values()
    assert math.dist((pose.x, pose.y), IN_BOTH[:2]) < 0.003
    x, y = pose.corners_px.mean(axis=0)
    marker = stage.glimpse.picture.image[int(y) - 8 : int(y) + 8, int(x) - 8 : int(x) + 8]
    assert marker.min() < 80 < 150 < marker.max()


@pytest.mark.parametrize("place", [IN_BOTH, (0.3, 0.9, 0.5), (2.1, 0.9, 0.5)])
def test_a_pose_that_is_told_early_has_its_marker_where_the_joined_picture_shows_it(
    place: tuple[float, float, float],
) -> None:
    """The page draws where the robot's top is seen: once through one camera's pixels, 0.6 m off."""
    stage = Stage()
    stage.pose = place
    for _ in range(3):
        stage.round()
    assert PLAN is not None
    assert len(stage.reported) >= 2
    for pose in stage.reported:
        ((x, y),) = PLAN.calibration.arena_from_image(pose.corners_px.mean(axis=0, keepdims=True))
        # a marker 0.12 m above the floor leans outwards, by no more than its height here
        assert math.dist((x, y), place[:2]) < 0.15

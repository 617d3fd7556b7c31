"""The eye over the simulated arena: obstacles and robot told apart, changes noticed."""

from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from navigation.config import load_config
from navigation.loop.seeing.eye import Eye, Glimpse
from navigation.loop.seeing.eye_settings import eye_settings, marked_robots
from navigation.simulator.arena import load_arena
from navigation.simulator.picture.camera import SimulatedCamera, make_camera
from navigation.simulator.picture.pinhole import pinhole_of
from planner.scene import CircleRecord, SceneObject
from vision.camera.camera import Frame
from vision.markers.markers import MarkerTracker

CONFIG = load_config(Path(__file__).parents[4] / "configs" / "simulation.yaml", environment={})
TRUTH = load_arena(CONFIG)


class Arena:
    """An eye over a simulated arena in which the robot is put where a test wants it."""

    def __init__(self) -> None:
        self.pose = (0.2, 0.2, 0.8)
        self.camera: SimulatedCamera = make_camera(
            CONFIG,
            TRUTH,
            [(CONFIG.robot, lambda _at_s: self.pose)],
            clock=lambda: 0.0,
            wait=lambda _s: None,
        )
        calibration = pinhole_of(CONFIG).calibration()
        tracker = MarkerTracker(calibration, marked_robots(CONFIG), CONFIG.robot.dictionary)
        self.eye = Eye(calibration, tracker, eye_settings(CONFIG))
        self._rng = np.random.default_rng(3)
        self._number = count()

    def look(self, pose: tuple[float, float, float] | None = None) -> Glimpse:
        self.pose = pose or self.pose
        number = next(self._number)
        picture = self.camera.render([self.pose], self._rng)
        return self.eye.look(Frame(picture, number / 30.0, number, "test"))

    def first_scene(self) -> Glimpse:
        for _ in range(5):
            glimpse = self.look()
            if glimpse.scene is not None:
                return glimpse
        pytest.fail("five frames and no scene")


@pytest.fixture
def arena() -> Arena:
    return Arena()


def test_the_scene_holds_the_obstacles_and_never_the_robot(arena: Arena) -> None:
    scene = arena.first_scene().scene
    assert scene is not None
    assert scene.units == "m"
    assert len(scene.objects) == len(TRUTH.scene.objects) == 7


def test_the_pose_is_that_of_the_robot(arena: Arena) -> None:
    robot = CONFIG.robot.marker_id
    for x in np.linspace(0.2, 0.3, 4):
        glimpse = arena.look((float(x), 0.25, 1.0))
    pose = glimpse.poses[robot]
    assert np.hypot(pose.x - 0.3, pose.y - 0.25) < 0.001
    assert abs(pose.heading_rad - 1.0) < 0.01


def test_a_driving_robot_is_no_change_even_beside_an_obstacle(arena: Arena) -> None:
    arena.first_scene()
    clearance = TRUTH.clearances(np.array([[0.72, 1.52], [1.42, 0.95]]))
    assert (clearance < 0.3).all()
    places = np.linspace((0.2, 0.2), (0.3, 0.9), 30).tolist()
    places += np.linspace((0.3, 0.9), (0.15, 1.2), 20).tolist()
    for x, y in places:
        glimpse = arena.look((x, y, 1.2))
        assert glimpse.scene is None, (x, y, glimpse.change)


def test_a_new_obstacle_is_reported_within_three_frames(arena: Arena) -> None:
    before = arena.first_scene().scene
    assert before is not None
    for _ in range(10):
        assert arena.look().scene is None
    box = SceneObject(99, (CircleRecord((1.2, 1.7), 0.05),))
    truth = TRUTH.scene
    arena.camera.set_scene(replace(truth, objects=(*truth.objects, box)))
    scenes = [glimpse.scene for glimpse in (arena.look(), arena.look(), arena.look())]
    found = next(scene for scene in scenes if scene is not None)
    assert len(found.objects) == 8
    assert sum(any(o is k for k in before.objects) for o in found.objects) == 7, "fitted again"
    assert found.border_pixels < 0.3 * before.border_pixels
    record = min(
        (r for o in found.objects for r in o.records if isinstance(r, CircleRecord)),
        key=lambda r: r.radius,
    )
    assert np.hypot(record.center[0] - 1.2, record.center[1] - 1.7) < 0.003
    assert record.radius == pytest.approx(0.05, abs=0.003)


def test_without_the_robot_there_is_no_scene_and_later_the_old_one_stays(arena: Arena) -> None:
    far_away = (30.0, 30.0, 0.0)
    for _ in range(5):
        glimpse = arena.look(far_away)
        assert (glimpse.scene, dict(glimpse.poses)) == (None, {})
    arena.look((0.2, 0.2, 0.0))
    assert arena.first_scene().scene is not None
    for _ in range(5):
        assert arena.look(far_away).scene is None

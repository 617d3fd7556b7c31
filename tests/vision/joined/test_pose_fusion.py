"""Poses of several cameras as one: at one time, by their accuracy, and no two truths at once."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.vision.joined.floor_truth import camera
from vision.joined.pose_fusion import SETTLED, TOGETHER_S, PoseFusion, carried
from vision.markers.marked_robot import MarkedRobot, RobotPose

LEFT, RIGHT = camera(0.62, 0.62), camera(1.40, 0.58)
ROBOT = MarkedRobot(7, 0.09, 0.12)
APART_M = 0.02


def fusion(apart_m: float = APART_M) -> PoseFusion:
    return PoseFusion((LEFT, RIGHT), ("left", "right"), [ROBOT], apart_m)


def seen(x: float, y: float, time_s: float, heading: float = 0.0, vx: float = 0.0) -> RobotPose:
    return RobotPose(7, x, y, heading, time_s, np.zeros((4, 2)), vx, 0.0)


def followed(both: PoseFusion, camera: int, pose: RobotPose) -> None:
    """The camera has followed the robot for a while when it sees it at this pose."""
    for number in range(SETTLED, 0, -1):
        time_s = pose.captured_s - number / 30.0
        both.take(camera, [replace(pose, x=pose.at(time_s)[0], captured_s=time_s)])
    both.take(camera, [pose])


def test_one_camera_alone_says_what_it_saw() -> None:
    pose = seen(0.5, 0.5, 1.0, 0.3, 0.1)
    assert fusion().take(0, [pose]) == (pose,)


@settings(max_examples=40, deadline=None)
@given(
    x=st.floats(0.9, 1.1), speed=st.floats(-0.5, 0.5), late=st.floats(0.001, 0.1),
    heading=st.floats(-math.pi, math.pi),
)  # fmt: skip
def test_sightings_of_different_times_are_brought_to_the_newest(
    x: float, speed: float, late: float, heading: float
) -> None:
    both = fusion()
    followed(both, 0, seen(x, 0.5, 1.0, heading, speed))
    (pose,) = both.take(1, [seen(x + speed * late, 0.5, 1.0 + late, heading, speed)])
    assert pose.captured_s == 1.0 + late
    assert math.dist((pose.x, pose.y), (x + speed * late, 0.5)) < 1e-9
    assert abs(math.remainder(pose.heading_rad - heading, math.tau)) < 1e-9
    assert not both.contradictions


def test_a_camera_that_has_only_just_seen_it_does_not_slow_it_down() -> None:
    """A new track knows no velocity yet; the robot drives all the same."""
    both = fusion()
    followed(both, 0, seen(1.0, 0.5, 1.0, vx=0.3))
    (pose,) = both.take(1, [seen(1.003, 0.5, 1.01, vx=0.0)])
    assert pose.vx == pytest.approx(0.3)
    (pose,) = both.take(0, [seen(1.01, 0.5, 1.0 + 1 / 30.0, vx=0.3)])
    assert math.dist((pose.x, pose.y), (1.01, 0.5)) < 1e-4


def test_the_camera_that_sees_better_counts_for_more() -> None:
    both = fusion()
    followed(both, 0, seen(0.700, 0.6, 1.0))  # almost below the left camera
    (pose,) = both.take(1, [seen(0.704, 0.6, 1.0 + 1e-6)])
    assert 0.700 < pose.x < 0.7015


def test_a_camera_is_less_sure_along_its_line_of_sight() -> None:
    covariance, heading = fusion().uncertainty(0, seen(1.6, 0.62, 1.0))
    assert covariance[0, 0] > 2.0 * covariance[1, 1]
    assert 0.0 < heading < 0.01


@pytest.mark.parametrize("noise", [(0.2e-3, 0.2e-3), (0.2e-3, 1.0e-3)])
def test_two_cameras_are_no_worse_than_one(noise: tuple[float, float]) -> None:
    """By the cameras' own noise: the fused poses of a robot that drives against its true ones."""
    rng = np.random.default_rng(1)
    both, off, alone = fusion(), [], []
    for number in range(300):
        time_s, index = number / 60.0, number % 2
        true = np.array([0.9 + 0.05 * time_s, 0.6])
        measured = true + rng.normal(0.0, noise[index], 2)
        (pose,) = both.take(index, [seen(*measured, time_s, vx=0.05)])
        off.append(math.dist((pose.x, pose.y), true))
        if index == 0:
            alone.append(math.dist(measured, true))
    assert np.mean(np.square(off)) <= 1.1**2 * max(np.mean(np.square(alone)), max(noise) ** 2)


def test_poses_that_disagree_are_said_with_both_places_and_the_number() -> None:
    both = fusion()
    for number in range(3):
        both.take(0, [seen(1.00, 0.5, number / 30.0)])
        both.take(1, [seen(1.05, 0.5, number / 30.0 + 0.015)])
    sentence = both.contradictions[7]
    assert "by right" in sentence
    assert "by left" in sentence
    assert "50 mm apart, the limit is 20" in sentence


def test_a_single_sighting_out_of_place_is_no_contradiction_and_it_ends() -> None:
    both = fusion()
    both.take(0, [seen(1.00, 0.5, 0.0)])
    both.take(1, [seen(1.05, 0.5, 0.01)])
    assert not both.contradictions
    both.take(0, [seen(1.00, 0.5, 0.03)])
    assert both.contradictions
    both.take(1, [seen(1.001, 0.5, 0.04)])
    assert not both.contradictions


def test_a_lost_camera_contradicts_nobody() -> None:
    both = fusion()
    for number in range(3):
        both.take(0, [seen(1.00, 0.5, number / 30.0)])
        both.take(1, [seen(1.05, 0.5, number / 30.0 + 0.015)])
    both.forget(1)
    assert not both.contradictions
    pose = seen(1.0, 0.5, 0.11)
    assert both.take(0, [pose]) == (pose,)


def test_what_was_seen_long_ago_takes_no_part() -> None:
    both = fusion()
    both.take(0, [seen(1.00, 0.5, 1.0)])
    late = seen(1.05, 0.5, 1.0 + 1.1 * TOGETHER_S)
    assert both.take(1, [late]) == (late,)
    assert not both.contradictions


def test_pictures_that_overtake_each_other_never_turn_time_back() -> None:
    both = fusion()
    both.take(0, [seen(1.0, 0.5, 1.0)])
    assert both.take(1, [seen(1.0, 0.5, 0.99)]) == ()


def test_a_pose_is_carried_on_for_a_moment_only() -> None:
    pose = seen(1.0, 0.5, 1.0, vx=0.5)
    assert carried(pose, 1.1).x == pytest.approx(1.05)
    assert carried(pose, 9.0, 0.2).x == pytest.approx(1.1)
    assert carried(replace(pose, vx=0.0), 2.0).x == 1.0

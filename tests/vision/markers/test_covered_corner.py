"""Markers of which a corner or a part of a side is covered: right where they are whole.

The truth is where the marker was painted; covers are painted over the finished picture.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.support.drawn.boards import marker_patch, render
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame, Image
from vision.joined.pose_fusion import PoseFusion
from vision.markers.marked_robot import MarkedRobot, RobotPose
from vision.markers.markers import MarkerTracker
from vision.markers.reading import find_markers
from vision.markers.tracking import TrackLimits, wrap

PIXEL_M = 0.002
PLAN = Calibration.from_scale(PIXEL_M, (200, 200))
SIDE_PX = 80.0
MARKER = MarkedRobot(7, SIDE_PX * PIXEL_M, limits=TrackLimits())


def drawn(
    heading_rad: float, noise: float, seed: int
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """A marker of 80 px in the picture's middle, and its corners (4, 2) in pixels."""
    place = (0.2, 0.2, heading_rad)
    patch = marker_patch(cv2.aruco.DICT_4X4_50, 7, MARKER.marker_size_m, place)
    image = render(PLAN, [patch], rng=np.random.default_rng(seed), noise=noise)
    square = np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]) * MARKER.marker_size_m
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    return image.copy(), PLAN.image_from_arena(square @ np.array([(c, s), (-s, c)]) + (0.2, 0.2))


def dab(image: Image, at: NDArray[np.float64], radius_px: float, grey: int) -> None:
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]]
    image[np.hypot(columns - at[0], rows - at[1]) <= radius_px] = grey


def strip(
    image: Image, start: NDArray[np.float64], end: NDArray[np.float64], wide_px: float, grey: int
) -> None:
    """Cover what is nearer to a stretch than half ``wide_px``."""
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]]
    off = np.stack([columns - start[0], rows - start[1]], axis=2)
    along = end - start
    share = np.clip((off @ along) / (along @ along), 0.0, 1.0)
    near = np.hypot(*(off - share[..., None] * along).transpose(2, 0, 1)) <= 0.5 * wide_px
    image[near] = grey


def tracked(image: Image) -> RobotPose | None:
    tracker = MarkerTracker(PLAN, [MARKER])
    for i in range(4):
        found = tracker.update(Frame(image, i / 30.0, i, "drawn"))
        if found:
            return found[0]
    return None


@pytest.mark.parametrize("grey", [220, 40])
@pytest.mark.parametrize("radius_px", [3.0, 6.0, 7.0])
@pytest.mark.parametrize("corner", range(4))
def test_a_covered_corner_is_where_its_two_sides_meet(
    corner: int, radius_px: float, grey: int
) -> None:
    image, true_px = drawn(0.3 + corner, 2.0, corner)
    dab(image, true_px[corner], radius_px, grey)
    (marker,) = find_markers(image, "DICT_4X4_50")
    assert marker.remark == ""
    assert np.abs(marker.corners_px - true_px).max() < 0.1
    pose = tracked(image)
    assert pose is not None
    assert math.dist((pose.x, pose.y), (0.2, 0.2)) < 0.1 * PIXEL_M
    assert abs(wrap(pose.heading_rad - 0.3 - corner)) < 0.002


@pytest.mark.parametrize("grey", [220, 40])
def test_a_quarter_of_a_side_that_is_covered_makes_the_error_larger(grey: int) -> None:
    whole, true_px = drawn(0.4, 2.0, 1)
    image = whole.copy()
    strip(image, true_px[0], 0.75 * true_px[0] + 0.25 * true_px[1], 10.0, grey)
    (before,) = find_markers(whole, "DICT_4X4_50")
    (after,) = find_markers(image, "DICT_4X4_50")
    assert before.error_px is not None
    assert after.error_px is not None
    assert after.error_px > 1.3 * before.error_px
    assert np.abs(after.corners_px - true_px).max() < 3.0 * after.error_px


@pytest.mark.parametrize("grey", [220, 40])
def test_half_a_side_that_is_covered_is_said_where_no_floor_is_known(grey: int) -> None:
    image, true_px = drawn(0.4, 2.0, 1)
    strip(image, true_px[0], 0.5 * (true_px[0] + true_px[1]), 10.0, grey)
    (marker,) = find_markers(image, "DICT_4X4_50")
    assert marker.remark == "a side is partly hidden or has no contrast"
    assert marker.error_px is None


@pytest.mark.parametrize("grey", [220, 40])
def test_a_marker_with_half_a_side_covered_is_where_its_cells_are(grey: int) -> None:
    image, true_px = drawn(0.4, 2.0, 1)
    strip(image, true_px[0], 0.5 * (true_px[0] + true_px[1]), 10.0, grey)
    pose = tracked(image)
    assert pose is not None
    assert np.abs(pose.corners_px - true_px).max() < min(0.1, 3.0 * pose.corner_error_px)
    (marker,) = find_markers(image, "DICT_4X4_50", calibration=PLAN)
    assert marker.remark == ""
    assert marker.error_px == pytest.approx(pose.corner_error_px, rel=0.2)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.floats(-math.pi, math.pi),
    st.integers(0, 3),
    st.floats(0.0, 20.0),
    st.floats(0.0, 0.6),
    st.sampled_from([20, 40, 120, 200, 230]),
    st.floats(0.0, 8.0),
    st.integers(0, 1000),
)
def test_the_error_covers_the_truth_whatever_is_covered(
    heading_rad: float,
    corner: int,
    radius_px: float,
    covered: float,
    grey: int,
    noise: float,
    seed: int,
) -> None:
    image, true_px = drawn(heading_rad, noise, seed)
    dab(image, true_px[corner], radius_px, grey)
    start, end = true_px[corner], true_px[(corner + 1) % 4]
    if covered > 0.05:
        strip(image, start, start + covered * (end - start), 8.0, grey)
    for marker in find_markers(image, "DICT_4X4_50"):
        if marker.error_px is not None:
            off_px = float(np.abs(marker.corners_px - true_px).max())
            assert off_px < 4.0 * marker.error_px
    pose = tracked(image)
    if pose is not None:
        off_px = math.dist((pose.x, pose.y), (0.2, 0.2)) / PIXEL_M
        assert off_px < 3.0 * pose.corner_error_px


def test_a_pose_with_a_larger_error_weighs_less_beside_another_camera_s() -> None:
    fusion = PoseFusion([PLAN], ["a"], [MARKER], 0.05)
    sharp = RobotPose(7, 0.2, 0.2, 0.0, 1.0, np.zeros((4, 2)))
    covered = RobotPose(7, 0.2, 0.2, 0.0, 1.0, np.zeros((4, 2)), corner_error_px=1.0)
    place, turn = fusion.uncertainty(0, sharp)
    place_covered, turn_covered = fusion.uncertainty(0, covered)
    assert np.trace(place_covered) > 2.0 * np.trace(place)
    assert turn_covered > 100.0 * turn

"""Markers of which sides are covered, wholly or in part: the cells inside are the witness.

The truth is where the marker was painted. Covers are painted before blur and noise, as a strip of
tape on the marker is.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.drawn.boards import marker_patch, render
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.markers.marked_robot import MarkedRobot, RobotPose
from vision.markers.marker_pattern import pattern_bits
from vision.markers.marker_search import dictionary_by_name
from vision.markers.markers import MarkerTracker
from vision.markers.reading import find_markers
from vision.markers.sighting import RobotMarker
from vision.markers.tracking import TrackLimits, Velocity, wrap

PIXEL_M = 0.002
SIZE_PX = 160
PLAN = Calibration.from_scale(PIXEL_M, (SIZE_PX, SIZE_PX))
FINE = 4
"""Points along each side of a pixel at which a cover is drawn."""
BOOKS = ("DICT_4X4_50", "DICT_5X5_100", "DICT_APRILTAG_36h11")
FloatArray = NDArray[np.float64]


class Painted:
    """A marker in about the picture's middle, drawn by ``rng``, and what is painted over it."""

    def __init__(
        self, rng: np.random.Generator, side_px: float, dictionary: str = "DICT_4X4_50"
    ) -> None:
        self.rng, self.side_px, self.dictionary = rng, side_px, dictionary
        self.id, self.heading_rad = int(rng.integers(50)), float(rng.uniform(-math.pi, math.pi))
        middle_px = 0.5 * SIZE_PX + rng.uniform(-5.0, 5.0, 2)
        self.x, self.y = (float(v) for v in PLAN.arena_from_image([middle_px])[0])
        place, side_m = (self.x, self.y, self.heading_rad), side_px * PIXEL_M
        patch = marker_patch(getattr(cv2.aruco, dictionary), self.id, side_m, place)
        self._grey = render(PLAN, [patch], blur=0.0).astype(np.float64)
        square = np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]) * side_m
        c, s = math.cos(self.heading_rad), math.sin(self.heading_rad)
        floor = square @ np.array([(c, s), (-s, c)]) + (self.x, self.y)
        self.corners_px = PLAN.image_from_arena(floor)

    def cover(self, start: FloatArray, end: FloatArray, wide_px: float, grey: float) -> None:
        """Paint over what is nearer to a stretch than half ``wide_px``."""
        at = (np.arange(SIZE_PX * FINE) + 0.5) / FINE - 0.5
        off = np.stack(np.meshgrid(at, at), axis=2) - start
        along = end - start
        share = np.clip((off @ along) / max(along @ along, 1e-9), 0.0, 1.0)
        gap = np.hypot(*(off - share[..., None] * along).transpose(2, 0, 1))
        near = (gap <= 0.5 * wide_px).reshape(SIZE_PX, FINE, SIZE_PX, FINE).mean(axis=(1, 3))
        self._grey = self._grey * (1.0 - near) + grey * near

    def cover_side(
        self, side: int, wide_px: float, grey: float, off_px: float = 0.0, part: float = 1.0
    ) -> None:
        """Cover a side, or its first ``part``, by a strip with its middle ``off_px`` outwards."""
        start, end = self.corners_px[side], self.corners_px[(side + 1) % 4]
        along = end - start
        shift = off_px * np.array([along[1], -along[0]]) / self.side_px
        last = 1.2 if part == 1.0 else part
        self.cover(start + shift - 0.2 * along, start + shift + last * along, wide_px, grey)

    def picture(self, blur_px: float, noise: float) -> NDArray[np.uint8]:
        seen = cv2.GaussianBlur(self._grey, (0, 0), blur_px)
        seen = seen + self.rng.normal(0.0, noise, seen.shape)
        return np.clip(np.rint(seen), 0, 255).astype(np.uint8)

    def tracked(self, blur_px: float = 0.7, noise: float = 2.0) -> RobotPose | None:
        """The last pose in three pictures."""
        robot = MarkedRobot(self.id, self.side_px * PIXEL_M, limits=TrackLimits(confirm=1))
        tracker = MarkerTracker(PLAN, [robot], self.dictionary)
        poses: tuple[RobotPose, ...] = ()
        for i in range(3):
            image = self.picture(blur_px, noise)
            poses = tracker.update(Frame(image, i / 30.0, i, "drawn")) or poses
        return poses[0] if poses else None

    def off_px(self, pose: RobotPose) -> float:
        """The larger of the errors of the middle and of the worst corner."""
        middle = math.dist((pose.x, pose.y), (self.x, self.y)) / PIXEL_M
        return max(middle, float(np.abs(pose.corners_px - self.corners_px).max()))


@pytest.mark.parametrize("grey", [160.0, 200.0, 230.0])
@pytest.mark.parametrize("wide_px", [3.0, 4.0, 8.0])
def test_a_strip_along_a_whole_side_does_not_move_the_marker(wide_px: float, grey: float) -> None:
    for side in range(4):
        marker = Painted(np.random.default_rng([side, round(wide_px)]), 80.0)
        marker.cover_side(side, wide_px, grey)
        pose = marker.tracked()
        assert pose is not None
        assert math.dist((pose.x, pose.y), (marker.x, marker.y)) < 0.05 * PIXEL_M
        assert abs(wrap(pose.heading_rad - marker.heading_rad)) < 0.002
        assert marker.off_px(pose) < 3.0 * pose.corner_error_px


def test_strips_along_all_four_sides_do_not_shrink_the_marker() -> None:
    """All four sides are straight, square, and agree with one another: only the cells know."""
    marker = Painted(np.random.default_rng(5), 80.0)
    for side in range(4):
        marker.cover_side(side, 5.0, 200.0)
    pose = marker.tracked()
    assert pose is not None
    assert marker.off_px(pose) < min(0.2, 3.0 * pose.corner_error_px)


def test_a_square_whose_cells_are_not_where_its_sides_are_is_refused_with_a_reason() -> None:
    """A dark square with the code in a corner of it: what decoded it is trusted for no place."""
    square = np.full((SIZE_PX, SIZE_PX), 200, np.uint8)
    square[40:120, 40:120] = 35
    square[44:84, 44:84][10:30, 10:30] = 200
    square.setflags(write=False)
    robot = MarkedRobot(7, 80.0 * PIXEL_M)
    bits = pattern_bits(dictionary_by_name("DICT_4X4_50"), 7)
    corners_px = np.array([(39.5, 39.5), (119.5, 39.5), (119.5, 119.5), (39.5, 119.5)])
    refusals: list[str] = []
    one = RobotMarker(robot, bits, PLAN, 0.0)
    assert one.look(square, corners_px, Velocity(), refusals) is None
    assert refusals == ["marker 7: its cells are not where its sides are"]


def _cover_at_random(marker: Painted, rng: np.random.Generator) -> None:
    grey = float(rng.choice([20, 40, 60, 120, 160, 200, 230]))
    side, kind = int(rng.integers(4)), int(rng.integers(4))
    wide_px = rng.uniform(2.0, 14.0)
    off_px = rng.uniform(-0.5, 0.5) * wide_px
    if kind == 0:
        marker.cover_side(side, wide_px, grey, off_px)
    elif kind == 1:
        marker.cover_side(side, wide_px, grey, off_px, part=rng.uniform(0.1, 0.95))
    elif kind == 2:
        marker.cover_side(side, 0.7 * wide_px, grey, 0.7 * off_px)
        marker.cover_side((side + int(rng.integers(1, 4))) % 4, 0.7 * wide_px, grey, -0.7 * off_px)
    else:
        at = marker.corners_px[side] + rng.uniform(-3.0, 3.0, 2)
        marker.cover(at, at, rng.uniform(2.0, 0.5 * marker.side_px), grey)


def test_no_pose_is_off_by_more_than_three_of_its_own_standard_errors() -> None:
    seen = 0
    for seed in range(100):
        rng = np.random.default_rng([34, seed])
        marker = Painted(rng, rng.uniform(35.0, 95.0), BOOKS[rng.choice(3, p=[0.6, 0.2, 0.2])])
        _cover_at_random(marker, rng)
        pose = marker.tracked(rng.uniform(0.4, 1.2), float(rng.choice([0, 1, 2, 5, 8])))
        if pose is not None:
            seen += 1
            assert marker.off_px(pose) < 3.0 * pose.corner_error_px, seed
    assert seen >= 40


def test_a_marker_that_is_read_with_a_calibration_is_where_its_cells_are() -> None:
    marker = Painted(np.random.default_rng(3), 70.0)
    marker.cover_side(2, 6.0, 220.0)
    image = marker.picture(0.7, 2.0)
    (read,) = find_markers(image, "DICT_4X4_50", calibration=PLAN)
    assert read.error_px is not None
    assert read.size_m == pytest.approx(70.0 * PIXEL_M, abs=0.1 * PIXEL_M)
    assert np.abs(read.corners_px - marker.corners_px).max() < 3.0 * read.error_px

"""A marker that is followed without a search: its pose, and what is never taken for it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.support.drawn.boards import DARK, LIGHT, Patch, marker_patch, render
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.markers import markers
from vision.markers.marked_robot import MarkedRobot
from vision.markers.marker_pattern import pattern_bits
from vision.markers.marker_search import dictionary_by_name, find_with, finder_of
from vision.markers.markers import MarkerTracker
from vision.markers.sighting import RobotMarker, Sighting
from vision.markers.tracking import Pose, Velocity, wrap

SIZE = (200, 200)
BOOK = dictionary_by_name("DICT_4X4_50")
Picture = NDArray[np.uint8]
SLOW = [HealthCheck.too_slow]


def overhead() -> Calibration:
    """A tilted camera with a lens, 2 m above the floor, 2 mm a pixel."""
    turn = cv2.Rodrigues(np.array([0.06, -0.04, 0.03]))[0] @ np.diag([1.0, -1.0, -1.0])
    pose = np.column_stack([turn, -turn @ np.array([0.2, 0.2, 2.0])])
    matrix = [[1000.0, 0.0, 98.0], [0.0, 1002.0, 102.0], [0.0, 0.0, 1.0]]
    return Calibration.from_camera(SIZE, matrix, [-0.25, 0.08, 0.001, -0.001, 0.0], pose)


CAMERA = overhead()
PIXEL_M = CAMERA.metres_per_pixel
MIDDLE: Pose = (*(float(v) for v in CAMERA.arena_from_image([(99.5, 99.5)])[0]), 0.0)  # type: ignore[assignment]


def at(dx_px: float, dy_px: float, heading: float) -> Pose:
    """A pose so many pixels of the floor from the picture's middle."""
    return MIDDLE[0] + dx_px * PIXEL_M, MIDDLE[1] + dy_px * PIXEL_M, heading


def marker(side_px: float, marker_id: int = 7) -> RobotMarker:
    robot = MarkedRobot(marker_id, side_px * PIXEL_M)
    return RobotMarker(robot, pattern_bits(BOOK, marker_id), CAMERA, 0.0)


def patch_of(one: RobotMarker, pose: Pose) -> Patch:
    return marker_patch(cv2.aruco.DICT_4X4_50, one.robot.id, one.robot.marker_size_m, pose)


def picture(*patches: Patch, noise: float = 5.0, seed: int = 0) -> Picture:
    rng = np.random.default_rng(seed)
    image = render(CAMERA, patches, noise=noise, rng=rng, samples=3)
    image.setflags(write=False)
    return image


def follow(image: Picture, one: RobotMarker, expected: Pose) -> Sighting | None:
    image.setflags(write=False)
    return one.follow(image, expected, Velocity())


def is_at(found: Sighting, pose: Pose, side_px: float) -> bool:
    """Whether a sighting is where the marker is, and turned as it is."""
    near = math.dist(found.pose[:2], pose[:2]) < 0.2 * PIXEL_M
    return near and abs(wrap(found.pose[2] - pose[2])) < 0.2 / side_px * 2.0


@settings(max_examples=40, deadline=None, suppress_health_check=SLOW)
@given(
    st.floats(30.0, 80.0),
    st.floats(-math.pi, math.pi),
    st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)),
    st.sampled_from([0.0, 5.0, 10.0]),
    st.integers(0, 49),
)
def test_a_marker_near_to_where_it_should_be_is_followed_to_the_pose_that_a_search_gives(
    side_px: float, heading: float, off: tuple[float, float], noise: float, marker_id: int
) -> None:
    one, pose = marker(side_px, marker_id), at(0.3, -0.4, heading)
    image = picture(patch_of(one, pose), noise=noise, seed=marker_id)
    found = follow(image, one, at(0.3 + off[0], -0.4 + off[1], heading + 0.01))
    assert found is not None
    seen = [quad for i, quad in find_with(finder_of(BOOK, 23, 15.0), image) if i == marker_id]
    assert len(seen) == 1
    searched = one.look(image, seen[0], Velocity(), [])
    assert searched is not None
    assert np.abs(found.corners_px - searched.corners_px).max() < 5e-3
    assert math.dist(found.pose[:2], searched.pose[:2]) < 1e-3 * PIXEL_M


@settings(max_examples=40, deadline=None, suppress_health_check=SLOW)
@given(st.integers(0, 49), st.integers(0, 35), st.floats(-3.0, 3.0), st.floats(30.0, 80.0))
def test_a_marker_with_one_cell_wrong_is_not_followed(
    marker_id: int, cell: int, heading: float, side_px: float
) -> None:
    one, pose = marker(side_px, marker_id), at(0.0, 0.0, heading)
    patch = patch_of(one, pose)
    cells = patch.cells.copy()
    row, column = 1 + cell // 6, 1 + cell % 6
    cells[row, column] = LIGHT + DARK - cells[row, column]
    assert follow(picture(patch), one, pose) is not None
    assert follow(picture(replace(patch, cells=cells)), one, pose) is None


@settings(max_examples=20, deadline=None, suppress_health_check=SLOW)
@given(st.integers(0, 49), st.sampled_from([1, 2, 3]), st.floats(-3.0, 3.0), st.floats(30.0, 80.0))
def test_a_marker_turned_by_right_angles_is_not_taken_for_the_upright_one(
    marker_id: int, turns: int, heading: float, side_px: float
) -> None:
    one = marker(side_px, marker_id)
    turned = at(0.0, 0.0, wrap(heading + turns * math.pi / 2.0))
    assert follow(picture(patch_of(one, turned)), one, at(0.0, 0.0, heading)) is None


@settings(max_examples=60, deadline=None, suppress_health_check=SLOW)
@given(
    st.integers(0, 49), st.floats(0.5, 2.0), st.floats(-math.pi, math.pi),
    st.floats(-3.0, 3.0), st.floats(30.0, 80.0),
)  # fmt: skip
def test_a_marker_displaced_by_half_a_cell_to_two_is_found_where_it_is_or_not_at_all(
    marker_id: int, cells: float, toward: float, heading: float, side_px: float
) -> None:
    one, pose = marker(side_px, marker_id), at(0.0, 0.0, heading)
    off_px = cells * side_px / 6.0
    expected = at(off_px * math.cos(toward), off_px * math.sin(toward), heading)
    found = follow(picture(patch_of(one, pose)), one, expected)
    assert found is None or is_at(found, pose, side_px)


def test_no_other_marker_of_the_dictionary_is_followed_in_any_orientation() -> None:
    one = marker(45.0, 3)
    for other in range(50):
        for turns in range(4):
            if other == 3 and turns == 0:
                continue
            pose = at(0.0, 0.0, 0.2 + turns * math.pi / 2.0)
            image = picture(patch_of(marker(45.0, other), pose), seed=other)
            assert follow(image, one, at(0.0, 0.0, 0.2)) is None, f"marker {other}, turned {turns}"


@pytest.mark.parametrize("toward", range(8))
@pytest.mark.parametrize("covered", [0.25, 0.5, 0.75])
@pytest.mark.parametrize("grey", [DARK, 120.0, LIGHT])
def test_a_marker_that_is_partly_covered_is_not_followed(
    toward: int, covered: float, grey: float
) -> None:
    """By a straight edge from each of eight directions, over a share of its width."""
    one, pose = marker(48.0), at(0.0, 0.0, 0.3)
    image = picture(patch_of(one, pose)).copy()
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    angle = toward * math.pi / 4.0 - 0.3
    along = (columns - 99.5) * math.cos(angle) + (rows - 99.5) * math.sin(angle)
    image[along > 48.0 * (0.5 - covered)] = round(grey)
    assert follow(image, one, pose) is None


@pytest.mark.parametrize(
    "gone", ["nothing", "dark", "noise", "inverted", "washed out", "all light cells", "all dark"]
)
def test_a_marker_that_is_gone_is_not_followed(gone: str) -> None:
    one, pose = marker(48.0), at(0.0, 0.0, 0.3)
    patch = patch_of(one, pose)
    rng = np.random.default_rng(2)
    image = {
        "nothing": lambda: picture(),
        "dark": lambda: picture(patch) // 20,
        "noise": lambda: rng.integers(0, 256, SIZE[::-1]).astype(np.uint8),
        "inverted": lambda: (255 - picture(patch)).astype(np.uint8),
        "washed out": lambda: (190 + picture(patch) // 25).astype(np.uint8),
        "all light cells": lambda: picture(
            replace(patch, cells=np.pad(np.full((4, 4), LIGHT), 2, constant_values=DARK))
        ),
        "all dark": lambda: picture(replace(patch, cells=np.pad(np.full((6, 6), DARK), 1))),
    }[gone]()
    assert follow(image, one, pose) is None


@pytest.mark.parametrize("smeared_cells", [0.0, 0.5, 1.0, 1.5, 2.0, 3.0])
def test_a_smeared_marker_is_where_the_middle_of_its_motion_is_or_not_followed(
    smeared_cells: float,
) -> None:
    one, pose = marker(48.0), at(0.0, 0.0, 0.0)
    length = max(1, round(smeared_cells * 8.0)) | 1
    kernel = np.full((1, length), 1.0 / length)
    image = cv2.filter2D(picture(patch_of(one, pose), noise=0.0), -1, kernel).astype(np.uint8)
    found = follow(image, one, pose)
    assert found is None or math.dist(found.pose[:2], pose[:2]) < 0.2 * PIXEL_M
    assert found is not None or smeared_cells > 0.5


@pytest.mark.parametrize("heading", [0.0, 0.4, 2.5])
def test_neighbours_that_touch_are_each_followed_to_their_own_place(heading: float) -> None:
    """Markers side by side, with the one cell of paper between them that both need."""
    first, second = marker(42.0, 11), marker(42.0, 12)
    apart = 42.0 * 7.0 / 6.0
    here = at(0.0, 0.0, heading)
    there = at(apart * math.cos(heading), apart * math.sin(heading), heading)
    image = picture(patch_of(first, here), patch_of(second, there))
    for one, mine, other in ((first, here, there), (second, there, here)):
        found = follow(image, one, mine)
        assert found is not None
        assert is_at(found, mine, 42.0)
        assert follow(image, one, other) is None


def test_a_followed_robot_is_not_searched_for_and_one_that_was_lifted_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    robot = MarkedRobot(7, 48.0 * PIXEL_M)
    tracker = MarkerTracker(CAMERA, [robot])
    one = marker(48.0)
    searched: list[int] = []
    plain = markers.find_with

    def counted(*given: Any) -> Any:
        searched.append(1)
        return plain(*given)

    monkeypatch.setattr(markers, "find_with", counted)
    still, lifted = picture(patch_of(one, at(0.0, 0.0, 0.5))), picture()
    carried = picture(patch_of(one, at(30.0, 10.0, -2.0)))
    for i in range(12):
        searched.clear()
        found = tracker.update(Frame(still, i / 30.0, i, "t"))
        if i > 2:
            assert len(found) == 1
            assert len(searched) == ((i + 1) % 6 == 0), "but now and then for a second one"
    assert tracker.update(Frame(lifted, 12 / 30.0, 12, "t")) == ()
    assert len(searched) > 1
    poses = [tracker.update(Frame(carried, i / 30.0, i, "t")) for i in range(13, 18)]
    assert poses[-1], "carried, it is found again"
    assert math.dist((poses[-1][0].x, poses[-1][0].y), at(30.0, 10.0, 0.0)[:2]) < 0.2 * PIXEL_M


def test_driven_by_acceleration_and_turns_a_robot_is_followed_all_the_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Ten pictures a second of a robot with 0.5 m/s2 and 6 rad/s2, as configured ones have."""
    robot = MarkedRobot(7, 40.0 * PIXEL_M)
    tracker, one = MarkerTracker(CAMERA, [robot]), marker(40.0)
    poses = []
    x = heading = speed = turn = 0.0
    for i in range(24):
        for _ in range(10):
            speed = min(speed + 0.5 * 0.01, 0.1) if i > 4 else 0.0
            turn = min(turn + 6.0 * 0.01, 1.2) if i > 12 else 0.0
            x, heading = x + speed * 0.01, heading + turn * 0.01
        poses.append((MIDDLE[0] - 0.08 + x, MIDDLE[1], heading))
    plain, followed = RobotMarker.follow, []

    def counted(self: RobotMarker, *given: Any) -> Any:
        found = plain(self, *given)
        followed.append(found is not None)
        return found

    monkeypatch.setattr(RobotMarker, "follow", counted)
    for i, pose in enumerate(poses):
        found = tracker.update(Frame(picture(patch_of(one, pose), seed=i), i / 10.0, i, "t"))
        if i > 1:
            assert len(found) == 1
            assert math.dist((found[0].x, found[0].y), pose[:2]) < 0.1 * PIXEL_M
    assert sum(followed) >= len(followed) - 1


def test_no_clutter_is_followed() -> None:
    """Pictures of 30 grey rectangles, and of a checkered floor: nothing in them is a marker."""
    rng, one = np.random.default_rng(6), marker(45.0)
    for number in range(300):
        image = np.full(SIZE[::-1], 200, np.uint8)
        for _ in range(30):
            center = rng.uniform(60, 140, 2).tolist()
            box = cv2.boxPoints((center, rng.uniform(4, 50, 2).tolist(), rng.uniform(0, 90)))
            cv2.fillPoly(image, [box.astype(np.int32)], int(rng.choice([35, 200, 90])))
        if number % 10 == 0:
            rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
            image = np.where((rows // 7 + columns // 7) % 2, 200, 35).astype(np.uint8)
        expected = at(0.0, 0.0, float(rng.uniform(-3, 3)))
        assert follow(cv2.GaussianBlur(image, (0, 0), 0.8).astype(np.uint8), one, expected) is None


@pytest.mark.parametrize(("off_px", "is_followed"), [(60.0, True), (85.0, False), (300.0, False)])
def test_a_marker_that_leaves_the_picture_is_not_followed(off_px: float, is_followed: bool) -> None:
    one, pose = marker(40.0), at(off_px, 0.0, 0.0)
    assert (follow(picture(patch_of(one, pose)), one, pose) is not None) == is_followed


@pytest.mark.parametrize("rim", [DARK, 80.0])
def test_a_marker_without_light_around_it_is_not_followed(rim: float) -> None:
    one, pose = marker(48.0), at(0.0, 0.0, 0.3)
    cells = patch_of(one, pose).cells
    dark = np.pad(cells[1:-1, 1:-1], 1, constant_values=rim)
    assert follow(picture(replace(patch_of(one, pose), cells=dark)), one, pose) is None


@pytest.mark.parametrize("least", [1.0, 0.6, 0.3])
def test_a_marker_in_dim_or_uneven_light_is_followed(least: float) -> None:
    one, pose = marker(48.0), at(0.0, 0.0, 0.3)
    shade = np.linspace(1.0, least, SIZE[0])[None, :]
    image = (picture(patch_of(one, pose)) * shade).astype(np.uint8)
    found = follow(image, one, pose)
    assert found is not None
    assert is_at(found, pose, 48.0)
    assert follow((image // 3).astype(np.uint8), one, pose) is not None

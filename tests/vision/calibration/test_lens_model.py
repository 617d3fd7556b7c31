"""Both lens models against OpenCV's own, how far they reach, and what is blind beyond it."""

from __future__ import annotations

import math
import re

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import vision
from planner.scene import Bounds, PolygonRecord
from tests.vision.calibration.cameras import (
    CAMERA,
    LENS,
    SIZE,
    distorted,
    overhead,
    pose_of,
    undistorted,
)
from vision.calibration.blind import blind_pixels, blind_plan
from vision.calibration.calibration import Calibration, CalibrationError
from vision.calibration.calibration_file import calibration_text, parse_calibration
from vision.calibration.lens_model import LEAST_STRETCH, lens_arrays
from vision.watch.refit import KnownScene

WIDE = np.array([[150.0, 0.0, 322.0], [0.0, 151.0, 238.0], [0.0, 0.0, 1.0]])
FOUR = (-0.04, 0.012, -0.006, 0.001)
ABOVE = pose_of((0.05, 0.08, 0.3), (1.0, 0.8, 1.5))
TERMS = st.tuples(*[st.floats(-width, width) for width in (0.1, 0.05, 0.02, 0.01)])


def fisheye(terms: tuple[float, ...] = FOUR, pose: NDArray = ABOVE) -> Calibration:
    return Calibration.from_camera(SIZE, WIDE, terms, pose, "fisheye")


def rays(ideal: NDArray, camera: NDArray) -> NDArray:
    return np.asarray((ideal - camera[:2, 2]) / np.array([camera[0, 0], camera[1, 1]]))


def disc(reach: float, count: int = 400) -> NDArray:
    """Normalised points all over the disc of a lens's reach, evenly in angle to the view."""
    rng = np.random.default_rng(0)
    angle = math.atan(reach) * rng.uniform(0.0, 1.0, count)
    turn = rng.uniform(0.0, math.tau, count)
    return np.tan(angle)[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])


@settings(max_examples=60, deadline=None)
@given(TERMS)
def test_a_fisheye_s_pixels_are_opencv_s_up_to_180_degrees(terms: tuple[float, ...]) -> None:
    lens = lens_arrays("fisheye", np.eye(3), terms)
    points = disc(lens.reach)
    space = np.column_stack([points, np.ones(len(points))]).reshape(-1, 1, 3)
    seen, _ = cv2.fisheye.projectPoints(space, np.zeros(3), np.zeros(3), np.eye(3), np.array(terms))
    assert np.abs(distorted(points, lens) - seen.reshape(-1, 2)).max() < 1e-12


@settings(max_examples=60, deadline=None)
@given(TERMS)
def test_a_fisheye_is_undone_within_all_of_its_reach(terms: tuple[float, ...]) -> None:
    lens = lens_arrays("fisheye", np.eye(3), terms)
    points = disc(0.999999 * lens.reach)
    back = undistorted(distorted(points, lens), lens)
    angles = [np.arctan(np.hypot(*p.T)) for p in (points, back)]
    assert np.abs(angles[1] - angles[0]).max() < 1e-9


@settings(max_examples=60, deadline=None)
@given(st.floats(-0.4, 0.3), st.floats(-0.2, 0.2), st.floats(-0.01, 0.01), st.floats(-0.1, 0.1))
def test_brown_s_model_is_undone_within_all_of_its_reach(
    k1: float, k2: float, p: float, k3: float
) -> None:
    lens = lens_arrays("brown", np.eye(3), [k1, k2, p, -p, k3])
    points = disc(0.999 * min(lens.reach, 2.0))
    back = undistorted(distorted(points, lens), lens)
    assert np.abs(back - points).max() < 1e-6


def test_undistorted_pixels_are_opencv_s() -> None:
    pixels = np.random.default_rng(1).uniform((0, 0), SIZE, (500, 2))
    ideal = fisheye().undistort_points(pixels)
    radius = np.hypot(*((pixels - WIDE[:2, 2]) / np.array([WIDE[0, 0], WIDE[1, 1]])).T)
    oracle = cv2.fisheye.undistortPoints(
        pixels.reshape(-1, 1, 2), WIDE, np.array(FOUR),
        criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-12),
    ).reshape(-1, 2)  # fmt: skip
    near = radius < 1.3
    assert np.abs(rays(ideal[near], WIDE) - oracle[near]).max() < 1e-8
    beyond = radius > 1.62  # theta_d of 90 degrees is 1.56 here
    assert beyond.any()
    assert np.isnan(ideal[beyond]).all()


def test_places_beyond_the_reach_have_no_pixel_and_no_ghost() -> None:
    folded = Calibration.from_camera(SIZE, CAMERA, [-0.9], ABOVE)
    far = folded.arena_from_image([(325.0, 236.0)]) + np.array([[3.0, 0.0], [0.0, 9.0], [-40.0, 0]])
    assert np.isnan(folded.image_from_arena(far)).all()
    tilted = fisheye(pose=pose_of((0.5, 0.0, 0.0), (0.0, 0.0, 1.0)))
    horizon = tilted.arena_from_image(np.random.default_rng(0).uniform((0, 0), SIZE, (4000, 2)))
    seen = horizon[np.isfinite(horizon[:, 0])]
    assert len(seen) < 4000
    assert np.abs(tilted.arena_from_image(tilted.image_from_arena(seen)) - seen).max() < 1e-4


@pytest.mark.parametrize(
    ("model", "terms"),
    [("fisheye", (0.05, -0.3, 0.0, 0.0)), ("brown", (-0.9, 0.0, 0.0, 0.0, 0.0))],
)
def test_a_folded_lens_s_reach_ends_before_the_fold(model: str, terms: tuple[float, ...]) -> None:
    lens = lens_arrays(model, np.eye(3), terms)
    radii = lens.reach * np.linspace(0.0, 1.0, 2000)
    seen = distorted(np.column_stack([radii, np.zeros(2000)]), lens)[:, 0]
    by = np.arctan(radii) if model == "fisheye" else radii
    assert (np.diff(seen) / np.diff(by)).min() >= 0.99 * LEAST_STRETCH
    assert np.isnan(distorted(np.array([[1.01 * lens.reach, 0.0]]), lens)).all()


# Files.


def test_a_fisheye_s_file_is_read_as_it_was_written() -> None:
    written = fisheye()
    read = parse_calibration(calibration_text(written))
    assert (read.lens_model, read.distortion.tolist()) == ("fisheye", list(FOUR))
    assert calibration_text(read) == calibration_text(written)


def test_a_file_without_the_key_is_brown_s() -> None:
    text, count = re.subn(r"lens_model: brown\n", "", calibration_text(overhead()))
    assert count == 1
    assert parse_calibration(text).lens_model == "brown"
    assert np.array_equal(parse_calibration(text).distortion, LENS)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("lens_model: fisheye", "lens_model: brow", "lens_model: 'brow': must be brown or fisheye"),
        ("0.001]", "0.001, 0.0]", "distortion: 5 terms: the fisheye model has 4"),
        (", 0.001]", "]", "distortion: 3 terms: the fisheye model has 4"),
        ("-0.04", "-2.0", "the lens model folds within the picture"),
        ("lens_model: fisheye", "lens_model: [brown]", "lens_model: must be text"),
    ],
)
def test_a_wrong_lens_in_a_file_is_named_with_its_place(old: str, new: str, said: str) -> None:
    text = calibration_text(fisheye())
    assert old in text
    with pytest.raises(CalibrationError, match=r"^c\.yaml:1[0-9]:") as caught:
        parse_calibration(text.replace(old, new, 1), "c.yaml")
    assert said in str(caught.value)


# What is blind.


def test_a_lens_that_shows_all_of_its_picture_is_blind_nowhere() -> None:
    assert blind_pixels(overhead()) is None
    assert blind_pixels(Calibration.from_scale(0.01, (200, 100))) is None


@pytest.mark.parametrize("model", ["fisheye", "brown"])
def test_every_pixel_that_is_not_blind_looks_at_floor_and_back(model: str) -> None:
    one = fisheye() if model == "fisheye" else Calibration.from_camera(SIZE, CAMERA, [-0.9], ABOVE)
    blind = blind_pixels(one)
    assert blind is not None
    assert 0.1 < blind.mean() < 0.7
    ys, xs = np.nonzero(~blind)
    # what a profile across an edge beside the mask looks at
    pixels = np.column_stack([xs, ys])[::17] + np.array([3.0, -3.0])
    places = one.arena_from_image(pixels)
    assert np.isfinite(places).all()
    assert np.abs(one.image_from_arena(places) - pixels).max() < 1e-6
    folded = np.isnan(one.arena_from_image(np.argwhere(np.ones_like(blind))[::7, ::-1])[:, 0])
    assert blind.ravel()[::7][folded].all()


def test_ground_that_the_lens_hides_is_an_obstacle_and_said() -> None:
    one = fisheye()
    blind = blind_pixels(one)
    assert blind is not None
    picture = np.full(SIZE[::-1], 200, np.uint8)
    picture[blind] = np.random.default_rng(0).integers(0, 255, int(blind.sum()))
    cv2.circle(picture, (250, 180), 12, 30, -1)
    bounds = Bounds(-14.0, -14.0, 16.0, 16.0)
    scene = vision.extract(picture, calibration=one, bounds=bounds)
    assert any("% of the picture is unknown" in remark for remark in scene.remarks)
    plan = blind_plan(one, bounds)
    assert plan is not None
    (unseen,) = [o for o in scene.objects if o.holes]
    assert (len(scene.objects), len(unseen.records), len(unseen.holes)) == (2, 1, 1)
    (hole,) = unseen.holes[0]
    assert isinstance(hole, PolygonRecord)
    # the seen ground lies in the picture, all along the hole's border
    inside = np.rint(one.image_from_arena([edge.start for edge in hole.edges])).astype(int)
    assert not blind[inside[:, 1], inside[:, 0]].any()
    # a change elsewhere keeps it
    cv2.circle(picture, (320, 240), 12, 30, -1)
    fitted = KnownScene.of(scene, one).refitted(picture, [(306, 226, 28, 28)])
    assert fitted is not None
    assert unseen.records in [o.records for o in fitted.scene.objects]
    assert len(fitted.scene.objects) == 3


def test_a_scene_within_what_is_seen_has_only_its_obstacles() -> None:
    one = fisheye()
    picture = np.full(SIZE[::-1], 200, np.uint8)
    picture[blind_pixels(one)] = 0
    cv2.circle(picture, (320, 240), 12, 30, -1)
    scene = vision.extract(picture, calibration=one, bounds=(0.0, 0.0, 2.0, 1.6))
    assert len(scene.objects) == 1
    assert any("outside the bounds" in remark for remark in scene.remarks)


def test_bounds_of_which_nothing_is_seen_are_refused() -> None:
    with pytest.raises(vision.PictureError, match="nothing within the bounds is seen"):
        vision.extract(
            np.full(SIZE[::-1], 200, np.uint8), calibration=fisheye(), bounds=(40, 40, 50, 50)
        )

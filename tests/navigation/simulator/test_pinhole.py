"""The simulated camera's geometry: places and pixels, the lens, the whole arena in the picture."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.config import Config, load_config
from navigation.simulator.picture.pinhole import Pinhole, distort, pinhole_of, undistort

# Geometry.


@cache
def _laboratory_pinhole() -> Pinhole:
    return pinhole_of(load_config("configs/simulation.yaml", {}))


@given(st.floats(0.0, 2.4), st.floats(0.0, 1.8), st.floats(0.0, 0.3))
def test_projection_agrees_with_opencv(x: float, y: float, z: float) -> None:
    pinhole = _laboratory_pinhole()
    turn, _ = cv2.Rodrigues(np.array(pinhole.camera_from_arena))
    shift = -pinhole.camera_from_arena @ pinhole.position_m
    expected, _ = cv2.projectPoints(
        np.array([[x, y, z]]), turn, shift, np.array(pinhole.matrix), np.array(pinhole.distortion)
    )
    assert pinhole.image_from_arena([[x, y, z]]) == pytest.approx(expected.reshape(-1, 2), abs=1e-8)


def test_pixels_and_places_are_each_other_s_inverse(pinhole: Pinhole) -> None:
    pixels = np.random.default_rng(0).uniform((-0.5, -0.5), (1279.5, 959.5), (200, 2))
    for height_m in (0.0, 0.12):
        there = pinhole.arena_from_image(pixels, height_m)
        assert pinhole.image_from_arena(there, height_m) == pytest.approx(pixels, abs=1e-7)


@given(st.floats(-0.3, 0.1), st.floats(-0.05, 0.05), st.floats(-0.001, 0.001))
def test_distortion_is_undone(k1: float, k2: float, p1: float) -> None:
    terms = np.array([k1, k2, p1, -p1, 0.0])
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (20, 2))
    assert undistort(distort(points, terms), terms) == pytest.approx(points, abs=1e-10)


def test_a_lens_that_folds_the_picture_over_is_refused() -> None:
    with pytest.raises(ValueError, match="folds over"):
        undistort(np.array([[2.0, 0.0]]), np.array([-1.0, 0.0, 0.0, 0.0, 0.0]))


def test_the_true_calibration_maps_as_the_pinhole_does(pinhole: Pinhole) -> None:
    calibration = pinhole.calibration()
    pixels = np.random.default_rng(2).uniform((0, 0), (1279, 959), (50, 2))
    for height_m in (0.0, 0.12):
        expected = pinhole.arena_from_image(pixels, height_m)
        assert calibration.arena_from_image(pixels, height_m) == pytest.approx(expected, abs=1e-8)


def test_the_whole_arena_and_robots_at_its_walls_are_in_the_picture(
    config: Config, pinhole: Pinhole
) -> None:
    x0, y0, x1, y1 = config.arena.bounds_m
    corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    for height_m in (0.0, config.robot.marker_height_m):
        seen = pinhole.image_from_arena(corners, height_m)
        assert (seen > 1).all()
        assert (seen < (1278, 958)).all()

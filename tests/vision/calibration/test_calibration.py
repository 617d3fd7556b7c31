"""Pixels and metres: the model against OpenCV's own, the file, and both estimations."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.vision.calibration.cameras import CAMERA, LENS, SIZE, overhead, pixels, pose_of
from vision.calibration.calibration import Calibration, CalibrationError, camera_center
from vision.calibration.calibration_file import (
    calibration_text,
    load_calibration,
    parse_calibration,
    save_calibration,
)


@pytest.mark.parametrize("height", [0.0, 0.12, 1.0])
def test_the_projection_is_opencv_s(height: float) -> None:
    calibration = overhead()
    places = calibration.arena_from_image(pixels(), height)
    pose = pose_of((0.05, 0.08, 0.3), (1.0, 0.8, 2.5))
    space = np.column_stack([places, np.full(len(places), height)])
    seen, _ = cv2.projectPoints(space, cv2.Rodrigues(pose[:, :3])[0], pose[:, 3], CAMERA, LENS)
    assert np.abs(seen.reshape(-1, 2) - pixels()).max() < 1e-6


@settings(max_examples=60)
@given(
    st.floats(-0.3, 0.15),
    st.floats(-0.05, 0.1),
    st.floats(-0.002, 0.002),
    st.floats(0.0, 1.5),
    st.tuples(*[st.floats(-0.2, 0.2)] * 3),
)
def test_there_and_back_is_the_identity(
    k1: float, k2: float, p1: float, height: float, turn: tuple[float, float, float]
) -> None:
    try:
        calibration = Calibration.from_camera(
            SIZE, CAMERA, [k1, k2, p1, -p1, 0.0], pose_of(turn, (1.0, 0.8, 2.5))
        )
    except CalibrationError:
        assume(False)
    back = calibration.image_from_arena(calibration.arena_from_image(pixels(), height), height)
    assert np.abs(back - pixels()).max() < 1e-6


def test_the_parallax_is_that_of_similar_triangles() -> None:
    calibration = Calibration.from_scale(0.002, (1000, 800), (1.0, 0.8, 2.5))
    floor = calibration.arena_from_image([(900.0, 100.0)])[0]
    high = calibration.arena_from_image([(900.0, 100.0)], 0.1)[0]
    away = floor - (1.0, 0.8)
    assert high - floor == pytest.approx(-away * 0.1 / 2.5)


def test_a_plan_to_scale_has_its_origin_at_the_lower_left_corner_and_y_up() -> None:
    calibration = Calibration.from_scale(0.01, (200, 100))
    places = calibration.arena_from_image([(-0.5, 99.5), (199.5, -0.5), (0.0, 0.0)])
    assert places == pytest.approx(np.array([(0.0, 0.0), (2.0, 1.0), (0.005, 0.995)]))
    assert calibration.metres_per_pixel == pytest.approx(0.01)
    assert calibration.image_from_arena(np.empty((0, 2))).shape == (0, 2)


def test_the_camera_s_place_follows_from_the_homography() -> None:
    calibration = overhead()
    found = camera_center(calibration.camera_matrix, calibration.arena_from_pixel)
    assert found == pytest.approx((1.0, 0.8, 2.5), abs=1e-9)


def test_heights_need_a_camera_s_place_and_stay_below_it() -> None:
    with pytest.raises(CalibrationError, match="camera's own place is unknown"):
        Calibration.from_scale(0.01, (20, 10)).arena_from_image([(0, 0)], 0.1)
    with pytest.raises(CalibrationError, match=r"below the camera at 2\.500 m"):
        overhead().arena_from_image([(0, 0)], 2.5)


def test_what_no_camera_can_be_is_refused() -> None:
    good = overhead()
    upright = pose_of((0.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    cases = [
        (lambda: Calibration.from_camera(SIZE, CAMERA, [-1.5], upright), "folds"),
        (lambda: Calibration.from_camera(SIZE, CAMERA, [0.0] * 6, upright), "at most 5"),
        (lambda: Calibration.from_camera(SIZE, -CAMERA, LENS, upright), "focal"),
        (lambda: Calibration(SIZE, CAMERA, LENS, np.zeros((3, 3))), "does not map"),
        (lambda: Calibration(SIZE, CAMERA, LENS, np.eye(3)), "mirrors"),
        (lambda: Calibration(SIZE, CAMERA, LENS, np.full((3, 3), np.nan)), "finite"),
        (lambda: Calibration((0, 4), CAMERA, LENS, good.arena_from_pixel), "size"),
        (
            lambda: Calibration.from_camera(
                SIZE, CAMERA, LENS, pose_of((1.4, 0.0, 0.0), (0.0, 0.0, 2.0))
            ),
            "horizon",
        ),
        (lambda: Calibration.from_scale(0.0, SIZE), "must be > 0"),
    ]
    for make, message in cases:
        with pytest.raises(CalibrationError, match=message):
            make()


def test_a_calibration_cannot_be_changed() -> None:
    calibration = overhead()
    for array in (calibration.camera_matrix, calibration.distortion, calibration.arena_from_pixel):
        with pytest.raises(ValueError, match="read-only"):
            array.flat[0] = 1.0


def test_a_file_is_read_as_it_was_written(tmp_path: Path) -> None:
    written = overhead()
    save_calibration(written, tmp_path / "c.yaml")
    read = load_calibration(tmp_path / "c.yaml")
    assert np.array_equal(read.arena_from_pixel, written.arena_from_pixel)
    assert np.array_equal(read.camera_matrix, written.camera_matrix)
    assert np.array_equal(read.distortion, written.distortion)
    assert (read.size, read.camera_center_m) == (written.size, written.camera_center_m)
    assert calibration_text(read) == calibration_text(written)


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        (r"size: \[640, 480\]", "size: [640]", "5:7", "must be 2"),
        (r"size: \[640, 480\]", "size: [640, 4.5]", "5:7", "whole pixels"),
        (r"size: \[640", "size: [w", "5:8", "'w' is no number"),
        ("schema: clearway", "schema: other", "4:9", "schema"),
        ("distortion:", "distorsion:", "10:1", "unknown key 'distorsion'"),
        ("622.0", "1e999", "8:9", "finite"),
        ("622.0", "-622.0", "7:1", "focal"),
        ("remarks: ..", "remarks: 3", ":", "list"),
        (r"- \[620", "- {620", "7:", "expected"),
        ("lens_rms_px: null", "lens_rms_px: null\nlens_rms_px: 1", ":1", "twice"),
    ],
)
def test_an_error_in_a_file_names_its_line_and_column(
    old: str, new: str, where: str, what: str
) -> None:
    text, count = re.subn(old, new, calibration_text(overhead()), count=1)
    assert count == 1
    with pytest.raises(CalibrationError) as caught:
        parse_calibration(text, "c.yaml")
    assert "c.yaml:" in str(caught.value)
    assert where in str(caught.value)
    assert what in str(caught.value)


@given(st.text(max_size=200))
def test_any_text_is_a_calibration_or_a_clear_error(text: str) -> None:
    with pytest.raises(CalibrationError):
        parse_calibration(text)


@settings(max_examples=150)
@given(st.integers(0, 600), st.sampled_from(["", "x", "0", "-", "[", "\n", "1e999", "\t", "&a "]))
def test_a_damaged_file_is_read_or_clearly_refused(place: int, patch: str) -> None:
    text = calibration_text(overhead())
    try:
        read = parse_calibration(text[:place] + patch + text[place + 1 :])
    except CalibrationError:
        return
    assert np.isfinite(read.arena_from_image(pixels())).all()

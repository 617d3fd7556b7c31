"""The arena's calibration from measured points: exact, robust, and frank about what is unknown."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.support.drawn.boards import chessboard_patch, render
from tests.vision.calibration.cameras import CAMERA, LENS, SIZE, overhead, pixels
from vision.calibrate.board import BoardSpec, BoardView, find_board
from vision.calibrate.lens import Lens
from vision.calibrate.survey import Survey, board_survey, fit_arena, read_survey
from vision.calibration.calibration import CalibrationError
from vision.calibration.calibration_file import (
    load_calibration,
)

# The arena.

TRUE_LENS = Lens(SIZE, CAMERA, LENS, 0.1, 5, (), ())


def survey(n: int, seed: int = 0, noise_px: float = 0.0) -> Survey:
    rng = np.random.default_rng(seed)
    seen = rng.uniform((20, 20), (620, 460), (n, 2))
    places = overhead().arena_from_image(seen)
    return Survey(
        seen + rng.normal(0, noise_px, (n, 2)), places, tuple(f"point {i}" for i in range(n))
    )


@pytest.mark.parametrize("n", [4, 5, 6, 9, 40])
def test_exact_points_give_the_exact_calibration(n: int) -> None:
    fit = fit_arena(survey(n), SIZE, TRUE_LENS)
    assert all(fit.used)
    assert fit.calibration.camera_center_m == pytest.approx((1.0, 0.8, 2.5), abs=1e-4)
    error = fit.calibration.arena_from_image(pixels()) - overhead().arena_from_image(pixels())
    # OpenCV takes the points in single precision.
    assert np.abs(error).max() < 1e-5
    assert (fit.calibration.arena_rms_m is None) == (n == 4)


@settings(max_examples=25, deadline=None)
@given(
    st.integers(7, 14),
    st.integers(0, 10**6),
    st.floats(0.03, 3.0),
    st.floats(-math.pi, math.pi),
)
def test_a_bad_point_is_named_and_left_out(n: int, seed: int, away_m: float, angle: float) -> None:
    good = survey(n, seed, noise_px=0.2)
    hull = cv2.contourArea(cv2.convexHull(good.pixels.astype(np.float32)))
    assume(hull > 60000.0)
    bad = seed % n
    assume(cv2.contourArea(cv2.convexHull(np.delete(good.pixels, bad, 0).astype(np.float32))) > 6e4)
    places = good.places_m.copy()
    places[bad] += away_m * np.array([math.cos(angle), math.sin(angle)])
    fit = fit_arena(Survey(good.pixels, places, good.names), SIZE, TRUE_LENS)
    assert not fit.used[bad]
    assert sum(fit.used) >= n - 2
    assert any(r.startswith(f"point {bad}: left out") for r in fit.calibration.remarks)
    off = float(np.linalg.norm(fit.residuals_m[bad]))
    assert off == pytest.approx(away_m, rel=0.5, abs=0.01)


def test_two_bad_points_of_twelve_are_both_named() -> None:
    good = survey(12, 5, 0.2)
    places = good.places_m.copy()
    places[[2, 7]] = places[[7, 2]]
    fit = fit_arena(Survey(good.pixels, places, good.names), SIZE, TRUE_LENS)
    assert [i for i, used in enumerate(fit.used) if not used] == [2, 7]


def test_the_arena_s_residual_meets_the_target() -> None:
    calibration = fit_arena(survey(20, 1, 0.1), SIZE, TRUE_LENS).calibration
    error = calibration.arena_from_image(pixels()) - overhead().arena_from_image(pixels())
    assert np.linalg.norm(error, axis=1).mean() < 0.0005


def test_few_points_say_what_they_cannot_show() -> None:
    assert any("fit any error" in r for r in fit_arena(survey(4), SIZE).calibration.remarks)
    assert any("which is wrong" in r for r in fit_arena(survey(5), SIZE).calibration.remarks)


def test_without_a_lens_the_given_height_is_used() -> None:
    assert fit_arena(survey(8), SIZE).calibration.camera_center_m is None
    center = fit_arena(survey(8), SIZE, camera_height_m=2.2).calibration.camera_center_m
    assert center is not None
    assert center[2] == 2.2


@pytest.mark.parametrize("n", [4, 5, 8, 15])
@pytest.mark.parametrize("how", ["x", "y", "swapped", "order"])
def test_mirrored_points_are_said_to_be_mirrored(n: int, how: str) -> None:
    good = survey(n, 2, 0.2) if how != "order" else corners_of_the_arena()
    places = {
        "x": good.places_m * (-1.0, 1.0),
        "y": good.places_m * (1.0, -1.0),
        "swapped": good.places_m[:, ::-1],
        "order": good.places_m[::-1],
    }[how].copy()
    if n >= 8 and how != "order":
        places[3] += 0.5  # a bad point besides must not hide it
    with pytest.raises(CalibrationError, match="the surveyed points are mirrored"):
        fit_arena(Survey(good.pixels, places, good.names), SIZE, TRUE_LENS)


def corners_of_the_arena() -> Survey:
    """Four corners, clockwise in the picture."""
    seen = np.array([(100.0, 90.0), (540.0, 95.0), (530.0, 400.0), (110.0, 390.0)])
    return Survey(seen, overhead().arena_from_image(seen), ("a", "b", "c", "d"))


@pytest.mark.parametrize("pair", [(0, 1), (1, 2), (2, 3), (3, 0)])
def test_two_exchanged_corners_of_four_are_said_to_be_crossed(pair: tuple[int, int]) -> None:
    good = corners_of_the_arena()
    places = good.places_m.copy()
    places[list(pair)] = places[list(pair[::-1])]
    with pytest.raises(CalibrationError, match="crossed"):
        fit_arena(Survey(good.pixels, places, good.names), SIZE, TRUE_LENS)


def test_useless_surveys_are_refused() -> None:
    good = survey(8)
    line = np.stack([np.arange(8.0), 2.0 * np.arange(8.0)], axis=1)
    cases = [
        (survey(3), "3 surveyed points"),
        (Survey(line, good.places_m, good.names), "pixels lie in one line"),
        (Survey(good.pixels, line, good.names), "places lie in one line"),
        (Survey(good.pixels, good.places_m * (1.0, -1.0), good.names), "mirrored"),
        (Survey(good.pixels, good.places_m * np.nan, good.names), "finite"),
    ]
    for bad, message in cases:
        with pytest.raises(CalibrationError, match=message):
            fit_arena(bad, SIZE)
    with pytest.raises(CalibrationError, match="640x480"):
        fit_arena(good, (320, 240), TRUE_LENS)
    with pytest.raises(CalibrationError, match="camera height"):
        fit_arena(good, SIZE, TRUE_LENS, -1.0)


def test_a_board_on_the_floor_places_the_arena() -> None:
    calibration = overhead()
    patch = chessboard_patch((9, 6), 0.12, (1.0, 0.8, 0.4))
    image = render(calibration, [patch], samples=2)
    view = find_board(image, BoardSpec("chessboard", 9, 6, 0.12), "floor")
    assert isinstance(view, BoardView)
    first = overhead().arena_from_image(view.corners_px[:1])[0]
    along = overhead().arena_from_image(view.corners_px[8:9])[0] - first
    heading = math.atan2(along[1], along[0])
    fit = fit_arena(board_survey(view, (first[0], first[1]), heading), SIZE, TRUE_LENS)
    error = fit.calibration.arena_from_image(pixels()) - calibration.arena_from_image(pixels())
    assert np.linalg.norm(error, axis=1).mean() < 0.001


def test_a_survey_file_is_read_and_its_errors_name_the_line(tmp_path: Path) -> None:
    path = tmp_path / "p.csv"
    path.write_text("px,py,x_m,y_m\n# a comment\n1,2,0.5,0.25\n\n3; 4; 1; 2  # the door\n")
    read = read_survey(path)
    assert read.pixels.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert read.places_m.tolist() == [[0.5, 0.25], [1.0, 2.0]]
    assert read.names == ("line 3", "line 5")
    for text, message in [
        ("1,2,3\n", r"p\.csv:1: must be four"),
        ("1,2,3,4\n1,2,x,4\n", r"p\.csv:2: must be px"),
        ("1,2,3,nan\n", r"p\.csv:1: must be four"),
        ("a\nb\n", r"p\.csv:2: must be px"),
    ]:
        path.write_text(text)
        with pytest.raises(CalibrationError, match=message):
            read_survey(path)
    with pytest.raises(CalibrationError, match="cannot be read"):
        read_survey(tmp_path / "none.csv")


def test_files_as_spreadsheets_write_them_are_read_and_those_without_end_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "points.csv"
    for text in ("10;20;0.5;0.25\r\n", "px;py;x_m;y_m\r\n10;20;0.5;0.25\r\n"):
        path.write_bytes(b"\xef\xbb\xbf" + text.encode())
        read = read_survey(path)
        np.testing.assert_array_equal(read.pixels, [(10.0, 20.0)])
        np.testing.assert_array_equal(read.places_m, [(0.5, 0.25)])
    monkeypatch.setattr("vision.calibration.calibration_file.MOST_BYTES", 1000)
    for reader in (read_survey, load_calibration):
        with pytest.raises(CalibrationError, match="/dev/zero: more than 1000 bytes"):
            reader("/dev/zero")

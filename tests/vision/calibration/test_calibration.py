"""Pixels and metres: the model against OpenCV's own, the file, and both estimations."""

from __future__ import annotations

import math
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.support.drawn.boards import chessboard_patch, render
from vision.calibrate.board import BoardSpec, BoardView, NoBoard, find_board, find_boards
from vision.calibrate.lens import Lens, estimate_lens
from vision.calibrate.survey import Survey, board_survey, draw_residuals, fit_arena, read_survey
from vision.calibration.calibration import Calibration, CalibrationError, camera_center
from vision.calibration.calibration_file import (
    calibration_text,
    load_calibration,
    parse_calibration,
    save_calibration,
)
from vision.camera.sources import read_picture

SIZE = (640, 480)
CAMERA = np.array([[620.0, 0.0, 325.0], [0.0, 622.0, 236.0], [0.0, 0.0, 1.0]])
LENS = np.array([-0.25, 0.07, 0.001, -0.0008, 0.01])
FLIP = np.diag([1.0, -1.0, -1.0])


def pose_of(turn: tuple[float, float, float], center: tuple[float, float, float]) -> NDArray:
    rotation = cv2.Rodrigues(np.array(turn))[0] @ FLIP
    return np.column_stack([rotation, -rotation @ np.array(center)])


def overhead(lens: NDArray = LENS) -> Calibration:
    return Calibration.from_camera(SIZE, CAMERA, lens, pose_of((0.05, 0.08, 0.3), (1.0, 0.8, 2.5)))


def pixels(n: int = 200, seed: int = 0) -> NDArray:
    return np.random.default_rng(seed).uniform((0, 0), SIZE, (n, 2))


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


# The lens.


def views(n: int = 12, noise: float = 0.1, seed: int = 0, tilt: float = 0.5) -> list[BoardView]:
    """A board of 9x6 corners of 25 mm before the camera, turned every way."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(9), np.arange(6))
    board = np.stack([x.ravel() * 0.025, -y.ravel() * 0.025], axis=1)
    found = []
    while len(found) < n:
        turn = rng.uniform(-tilt, tilt, 3)
        rotation = cv2.Rodrigues(turn)[0] @ FLIP
        middle = np.array([*rng.uniform(-0.08, 0.08, 2), rng.uniform(0.3, 0.45)])
        space = np.column_stack([board - board.mean(axis=0), np.zeros(54)])
        seen, _ = cv2.projectPoints(space, cv2.Rodrigues(rotation)[0], middle, CAMERA, LENS)
        corners = seen.reshape(-1, 2)
        if corners.min() < 5 or (corners > np.array(SIZE) - 5).any():
            continue
        corners = corners + rng.normal(0.0, noise, corners.shape)
        found.append(BoardView(f"picture {len(found)}", SIZE, corners, board))
    return found


def test_the_lens_is_found_again() -> None:
    lens = estimate_lens(views())
    assert lens.rms_px == pytest.approx(0.1 * math.sqrt(2.0), rel=0.1)
    assert lens.camera_matrix[0, 0] == pytest.approx(620.0, rel=0.004)
    grid = pixels()
    true = overhead().undistort_points(grid)
    upright = pose_of((0.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    found = Calibration.from_camera(SIZE, lens.camera_matrix, lens.distortion, upright)
    # Up to a shift and a scale, which the homography takes in, the pictures agree.
    drift = found.undistort_points(grid) - true
    fitted = np.column_stack([true, np.ones(len(true))])
    rest = drift - fitted @ np.linalg.lstsq(fitted, drift, rcond=None)[0]
    assert np.sqrt((rest**2).mean()) < 0.15


def test_bad_pictures_are_named_and_left_out() -> None:
    good = views()
    rng = np.random.default_rng(3)
    spoiled = BoardView(
        "blurred.png", SIZE, good[4].corners_px + rng.normal(0, 3, (54, 2)), good[4].points_m
    )
    other = BoardView("small.png", (320, 240), good[0].corners_px, good[0].points_m)
    lens = estimate_lens([*good[:4], spoiled, other, *good[5:]])
    assert [r.split(":")[0] for r in lens.remarks] == ["small.png", "blurred.png"]
    assert "blurred.png" not in [name for name, _ in lens.used]
    assert lens.rms_px < 0.2


def test_too_little_is_an_error_and_not_a_lens() -> None:
    with pytest.raises(CalibrationError, match="2 usable pictures"):
        estimate_lens(views(2))
    with pytest.raises(CalibrationError, match="0 usable pictures"):
        estimate_lens([])
    with pytest.raises(CalibrationError, match="do not determine the focal length"):
        estimate_lens(views(5, tilt=0.002))
    with pytest.raises(CalibrationError, match="terms = 3"):
        estimate_lens(views(4), 3)


def test_a_rendered_chessboard_is_found_to_hundredths_of_a_pixel() -> None:
    calibration = overhead()
    patch = chessboard_patch((9, 6), 0.12, (1.0, 0.8, 0.4))
    image = render(calibration, [patch], rng=np.random.default_rng(0), noise=3.0)
    view = find_board(image, BoardSpec("chessboard", 9, 6, 0.12), "floor")
    assert isinstance(view, BoardView)
    c, s = math.cos(0.4), math.sin(0.4)
    centred = view.points_m - view.points_m.mean(axis=0)
    errors = []
    for sign in (1.0, -1.0):
        places = sign * centred @ np.array([[c, s], [-s, c]]) + (1.0, 0.8)
        errors.append(
            np.linalg.norm(calibration.image_from_arena(places) - view.corners_px, axis=1)
        )
    best = min(errors, key=lambda e: float(e.mean()))
    assert np.sqrt((best**2).mean()) < 0.05


def test_a_rendered_charuco_board_is_found() -> None:
    book = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    for rows in (7, 6):
        board = cv2.aruco.CharucoBoard((5, rows), 0.04, 0.02, book)
        image = cv2.copyMakeBorder(
            board.generateImage((400, 80 * rows)), 30, 30, 30, 30, cv2.BORDER_CONSTANT, value=255
        ).astype(np.uint8)
        view = find_board(image, BoardSpec("charuco", 5, rows, 0.04), "b")
        assert isinstance(view, BoardView)
        assert len(view.corners_px) == 4 * (rows - 1)
        scale = 80 / 0.04
        flat = np.column_stack([view.corners_px[:, 0], -view.corners_px[:, 1]])
        shift = flat - view.points_m * scale
        assert np.abs(shift - shift.mean(axis=0)).max() < 0.3


def test_pictures_without_the_board_are_named() -> None:
    blank = np.full((240, 320), 128, np.uint8)
    for spec in (BoardSpec("chessboard", 9, 6, 0.02), BoardSpec("charuco", 5, 7, 0.02)):
        found, missing = find_boards([("a.png", blank), ("b.png", blank[:10, :10])], spec)
        assert found == []
        assert [m.name for m in missing] == ["a.png", "b.png"]
        assert isinstance(missing[0], NoBoard)
        assert "too small" in missing[1].reason
    with pytest.raises(CalibrationError, match="dictionary"):
        find_board(blank, BoardSpec("charuco", 5, 7, 0.02, dictionary="DICT_NONE"), "a")
    with pytest.raises(CalibrationError, match="smaller than the square"):
        BoardSpec("charuco", 5, 7, 0.02, 0.02)
    with pytest.raises(CalibrationError, match="board of 1x6"):
        BoardSpec("chessboard", 1, 6, 0.02)


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


def test_the_residual_map_shows_every_point() -> None:
    good = survey(9)
    places = good.places_m.copy()
    places[3] += 0.4
    fit = fit_arena(Survey(good.pixels, places, good.names), SIZE, TRUE_LENS)
    for background in (
        None,
        np.full((480, 640), 90, np.uint8),
        np.full((480, 640, 3), 9, np.uint8),
    ):
        picture = draw_residuals(fit, background)
        assert picture.shape == (480, 640, 3)
        red = (picture[..., 2] > 180) & (picture[..., 1] < 60)
        x, y = np.round(good.pixels[3]).astype(int)
        assert red[y - 6 : y + 7, x - 6 : x + 7].any()


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


def test_the_real_chessboards_reach_a_fifth_of_a_pixel(real_data: Path) -> None:
    files = sorted((real_data / "calibration").glob("*.jpg"))
    spec = BoardSpec("chessboard", 9, 6, 0.025)
    found, missing = find_boards([(p.name, read_picture(p)) for p in files], spec)
    assert (len(found), len(missing)) == (13, 0)
    lens = estimate_lens(found)
    assert lens.rms_px <= 0.20
    assert len(lens.used) == 13


def test_every_corner_of_the_real_charuco_board_is_found(real_data: Path) -> None:
    image = read_picture(real_data / "markers" / "choriginal.jpg")
    view = find_board(image, BoardSpec("charuco", 5, 7, 0.04, 0.02), "choriginal.jpg")
    assert isinstance(view, BoardView)
    assert len(view.corners_px) == 24

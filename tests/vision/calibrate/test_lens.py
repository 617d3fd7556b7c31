"""The lens is found again from pictures of boards, drawn and real, and bad pictures are named."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.support.drawn.boards import chessboard_patch, render
from tests.vision.calibration.cameras import CAMERA, FLIP, LENS, SIZE, overhead, pixels, pose_of
from vision.calibrate.board import BoardSpec, BoardView, NoBoard, find_board, find_boards
from vision.calibrate.lens import estimate_lens, fit_lens
from vision.calibration.calibration import Calibration, CalibrationError
from vision.camera.sources import read_picture

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


def test_the_same_pictures_are_fitted_once_and_nobody_can_change_the_fit() -> None:
    """The search for foreign pictures asks for many fits again."""
    some = views(6)
    fit = fit_lens(some, 2)
    assert fit_lens(list(some), 2) is fit
    assert fit_lens(some, 4) is not fit
    assert fit_lens(views(6), 2) is not fit
    with pytest.raises(ValueError, match="read-only"):
        fit.camera_matrix[0, 0] = 1.0


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

"""Of both models the one is chosen that foretells views left out, and its lens is the true one."""

from __future__ import annotations

import math
from collections.abc import Callable

import cv2
import numpy as np
import pytest

from tests.vision.calibrate.test_lens import views as brown_views
from tests.vision.calibration.cameras import distorted
from vision.calibrate.board import BoardView
from vision.calibrate.lens import estimate_lens
from vision.calibrate.lens_choice import choose_lens
from vision.calibrate.suspects import mirrored, upside_down
from vision.calibration.calibration import CalibrationError
from vision.calibration.lens_model import lens_arrays

SIZE = (1280, 960)
WIDE = np.array([[330.0, 0.0, 645.0], [0.0, 331.0, 476.0], [0.0, 0.0, 1.0]])
FOUR = np.array([-0.04, 0.012, -0.006, 0.001])


def fisheye_views(
    n: int = 12, noise: float = 0.1, seed: int = 0, matrix: np.ndarray = WIDE
) -> list[BoardView]:
    """A board of 9x6 corners all around a fisheye, up to 90 degrees to its view."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(9), np.arange(6))
    board = np.stack([x.ravel() * 0.04, -y.ravel() * 0.04], axis=1)
    space = np.column_stack([board - board.mean(axis=0), np.zeros(54)])
    found: list[BoardView] = []
    while len(found) < n:
        way = rng.normal(size=3) * (1.0, 1.0, 0.5)
        way[2] = abs(way[2])
        way /= np.linalg.norm(way)
        right = np.cross((0.0, 1.0, 0.1), -way)
        right /= np.linalg.norm(right)
        facing = np.column_stack([right, np.cross(-way, right), -way])
        turn = facing @ cv2.Rodrigues(rng.uniform(-0.5, 0.5, 3))[0]
        seen_from = space @ turn.T + way * rng.uniform(0.25, 0.45)
        angle = np.arctan2(np.hypot(seen_from[:, 0], seen_from[:, 1]), seen_from[:, 2])
        if angle.max() > math.radians(89.0):
            continue
        seen, _ = cv2.fisheye.projectPoints(
            seen_from.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix, FOUR
        )
        corners = seen.reshape(-1, 2)
        if corners.min() < 5 or (corners > np.array(SIZE) - 5).any():
            continue
        corners = corners + rng.normal(0.0, noise, corners.shape)
        found.append(BoardView(f"picture {len(found)}", SIZE, corners, board))
    return found


def test_a_fisheye_is_chosen_and_found_again_up_to_80_degrees() -> None:
    lens = choose_lens(fisheye_views())
    residuals = dict(lens.left_out_px)
    assert (lens.model, lens.terms) == ("fisheye", 4)
    assert residuals["fisheye"] == pytest.approx(0.1 * math.sqrt(2.0), rel=0.1)
    assert residuals["brown"] > 10.0 * residuals["fisheye"]
    assert lens.camera_matrix[0, 0] == pytest.approx(330.0, rel=0.002)
    angle = np.radians(np.linspace(0.0, 80.0, 33))[:, None]
    turn = np.linspace(0.0, math.tau, 12, endpoint=False)
    rays = np.stack([np.tan(angle) * np.cos(turn), np.tan(angle) * np.sin(turn)], axis=-1)
    seen = [
        distorted(
            rays.reshape(-1, 2) * matrix[[0, 1], [0, 1]] + matrix[:2, 2],
            lens_arrays("fisheye", matrix, terms),
        )
        for matrix, terms in ((WIDE, FOUR), (lens.camera_matrix, lens.distortion))
    ]
    assert np.sqrt(((seen[1] - seen[0]) ** 2).mean()) < 0.1


def test_a_narrow_lens_stays_brown_s_with_both_numbers() -> None:
    lens = choose_lens(brown_views())
    assert lens.model == "brown"
    assert [name for name, _ in lens.left_out_px] == ["brown", "fisheye"]
    assert dict(lens.left_out_px)["brown"] == pytest.approx(0.1 * math.sqrt(2.0), rel=0.1)
    again = estimate_lens(brown_views())
    assert again.distortion == pytest.approx(lens.distortion, abs=1e-5)


def test_bad_pictures_of_a_fisheye_are_named_and_left_out() -> None:
    good = fisheye_views(8)
    rng = np.random.default_rng(3)
    spoiled = BoardView(
        "blurred.png", SIZE, good[4].corners_px + rng.normal(0, 3, (54, 2)), good[4].points_m
    )
    lens = estimate_lens([*good[:4], spoiled, *good[5:]], None, "fisheye")
    assert [r.split(":")[0] for r in lens.remarks] == ["blurred.png"]
    assert lens.rms_px < 0.2


@pytest.mark.parametrize(("over", "way"), [(mirrored, "mirrored"), (upside_down, "upside down")])
def test_a_fisheyes_picture_that_was_turned_over_is_said_to_be(
    over: Callable[[BoardView], BoardView], way: str
) -> None:
    aside = WIDE + np.array([[0.0, 0.0, 60.0], [0.0, 0.0, -50.0], [0.0, 0.0, 0.0]])
    views = fisheye_views(8, matrix=aside)  # a lens whose centre is the picture's shows nothing
    lens = estimate_lens([*views[:3], over(views[3]), *views[4:]], 2, "fisheye")
    assert [f"the picture is {way}" in remark for remark in lens.remarks] == [True]
    assert views[3].name in lens.remarks[0]
    assert lens.rms_px < 0.2


def test_more_than_a_third_of_a_fisheyes_pictures_is_not_left_out() -> None:
    views = fisheye_views(8)
    rng = np.random.default_rng(4)
    spoiled = [
        BoardView(v.name, SIZE, v.corners_px + rng.normal(0, 3 + i, (54, 2)), v.points_m)
        for i, v in enumerate(views[:3])
    ]
    with pytest.raises(CalibrationError, match="3 of 8 pictures do not belong to the others"):
        estimate_lens([*spoiled, *views[3:]], 2, "fisheye")


def test_what_cannot_be_fitted_is_said() -> None:
    with pytest.raises(CalibrationError, match="2 usable pictures"):
        choose_lens(fisheye_views(2))
    with pytest.raises(CalibrationError, match=r"terms = 5: must be 0, 1, 2 or 4 \(fisheye\)"):
        estimate_lens(fisheye_views(3), 5, "fisheye")
    with pytest.raises(CalibrationError, match="lens model 'wide': must be brown or fisheye"):
        estimate_lens(fisheye_views(3), None, "wide")
    # three views leave two: fewer than a lens is fitted to
    assert estimate_lens(fisheye_views(3), 0, "fisheye").left_out_rms_px is None

"""Pictures that do not belong to the others are named with what is wrong with them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from tests.vision.calibrate.views import (
    CAMERA,
    FLIP,
    LENS,
    OTHER_CAMERA,
    SIZE,
    board_points,
    seen,
    views,
)
from vision.calibrate.board import BoardSpec, BoardView, NoBoard, find_board, find_boards
from vision.calibrate.left_out import residuals_px, rms_px
from vision.calibrate.lens import estimate_for, estimate_lens
from vision.calibrate.suspects import mirrored, suspects, upside_down
from vision.calibration.calibration import CalibrationError
from vision.camera.sources import read_picture


def drawn_mirrored(view: BoardView) -> BoardView:
    """What the board's search finds in a mirrored picture: rows and columns as if nothing was."""
    corners = view.corners_px.reshape(6, 9, 2)[:, ::-1].reshape(-1, 2)
    return BoardView(view.name, view.size, corners * (-1.0, 1.0) + (639.0, 0.0), view.points_m)


@pytest.mark.parametrize("seed", range(2))
def test_pictures_of_one_camera_are_not_suspected(seed: int) -> None:
    for own in (views(14, seed=seed), views(6, noise_px=0.3, seed=seed), views(4, seed=seed)):
        assert suspects(own, estimate_for(own)) == []


def wide_views(count: int, seed: int) -> list[BoardView]:
    """Views of a wide lens (100 degrees), whose distortion takes all five terms."""
    camera = np.array([[270.0, 0.0, 322.0], [0.0, 271.0, 238.0], [0.0, 0.0, 1.0]])
    lens = np.array([-0.3, 0.12, 0.001, -0.0008, -0.02])
    rng = np.random.default_rng(seed)
    found: list[BoardView] = []
    while len(found) < count:
        turn = cv2.Rodrigues(rng.uniform(-0.5, 0.5, 3))[0] @ FLIP
        middle = np.array([*rng.uniform(-0.15, 0.15, 2), rng.uniform(0.12, 0.25)])
        corners = seen((turn, middle), camera, lens)
        if corners.min() > 8 and (corners < np.array(SIZE) - 9.0).all():
            noisy = corners + rng.normal(0.0, 0.1, corners.shape)
            found.append(BoardView(f"wide {len(found)}", SIZE, noisy, board_points()))
    return found


@pytest.mark.parametrize("seed", [0, 2])
def test_no_picture_of_a_wide_lens_is_suspected(seed: int) -> None:
    lens = estimate_lens(wide_views(10, seed))
    assert [remark for remark in lens.remarks if "left out" in remark] == []
    assert lens.camera_matrix[0, 0] == pytest.approx(270.0, rel=0.01)


@pytest.mark.parametrize("seed", [0, 13])
def test_eight_pictures_of_a_wide_lens_are_not_those_of_two_cameras(seed: int) -> None:
    """One at the edge of the picture, which the others' lens hardly knows, was most of the rms."""
    found = wide_views(8, seed)
    assert suspects(found, estimate_for(found)) == []


@pytest.mark.parametrize("count", [1, 4])
@pytest.mark.parametrize(
    ("turned_over", "word"), [(drawn_mirrored, "mirrored"), (upside_down, "upside down")]
)
def test_pictures_that_were_turned_over_are_named(
    turned_over: Callable[[BoardView], BoardView], word: str, count: int
) -> None:
    mixed = [turned_over(v) if i < count else v for i, v in enumerate(views(13, seed=count))]
    lens = estimate_lens(mixed)
    named = {r.split(":")[0] for r in lens.remarks}
    usual = estimate_lens(mixed[count:]).rms_px
    # where turning over moves nothing, as for a board in the middle, it does no harm either
    truth = SimpleNamespace(camera_matrix=CAMERA, distortion=LENS, model="brown")
    shown = {v.name for v in mixed[:count] if rms_px(residuals_px(v, truth)) > 1.7 * usual}
    assert shown
    assert shown <= named <= {f"picture {i}" for i in range(count)}
    assert all(f"the picture is {word}" in r for r in lens.remarks)
    assert lens.camera_matrix[0, 2] == pytest.approx(334.0, abs=3.0)


def test_the_mirror_image_of_a_view_is_what_a_mirrored_picture_shows() -> None:
    (view,) = views(1)
    again = mirrored(drawn_mirrored(view))
    found = {tuple(np.round(p, 6)) for p in again.corners_px}
    assert found == {tuple(np.round(p, 6)) for p in view.corners_px}
    assert upside_down(upside_down(view)).corners_px == pytest.approx(view.corners_px)


@pytest.mark.parametrize("count", [4, 6])
def test_another_camera_s_pictures_are_named(count: int) -> None:
    foreign = views(count, seed=9, camera=OTHER_CAMERA, name="other")
    lens = estimate_lens([*views(14), *foreign])
    assert {r.split(":")[0] for r in lens.remarks} == {v.name for v in foreign}
    assert all("of another camera" in r for r in lens.remarks)
    assert lens.camera_matrix[0, 0] == pytest.approx(620.0, rel=0.004)


def test_half_of_another_camera_is_an_error_that_names_them() -> None:
    foreign = views(6, seed=9, camera=OTHER_CAMERA, name="other")
    with pytest.raises(CalibrationError, match=r"6 of 14 pictures do not belong.*other 3: of ano"):
        estimate_lens([*views(8), *foreign])


def test_a_mirrored_charuco_board_is_called_mirrored() -> None:
    book = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    image = cv2.aruco.CharucoBoard((5, 7), 0.04, 0.02, book).generateImage((400, 560))
    padded = cv2.copyMakeBorder(image, 30, 30, 30, 30, cv2.BORDER_CONSTANT, value=255)
    found = find_board(np.ascontiguousarray(padded[:, ::-1]), BoardSpec("charuco", 5, 7, 0.04), "a")
    assert isinstance(found, NoBoard)
    assert found.reason.startswith("the picture is mirrored")
    turned = find_board(
        np.ascontiguousarray(padded[::-1, ::-1]), BoardSpec("charuco", 5, 7, 0.04), "b"
    )
    assert isinstance(turned, BoardView)


def test_the_real_stereo_set_s_own_camera_is_not_suspected(real_data: Path) -> None:
    files = sorted((real_data / "calibration").glob("*.jpg"))
    found, _ = find_boards(
        [(p.name, read_picture(p)) for p in files], BoardSpec("chessboard", 9, 6, 0.025)
    )
    assert suspects(found, estimate_for(found)) == []
    mixed = [upside_down(v) if i % 4 == 3 else v for i, v in enumerate(found)]
    named = suspects(mixed, estimate_for(mixed))
    assert named
    assert all(one.index % 4 == 3 and "upside down" in one.reason for one in named)

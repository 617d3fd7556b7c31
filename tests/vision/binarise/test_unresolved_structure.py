"""Walls that a lens has made run together are no free floor; a floor's texture is one."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from benchmarks.vision.regions import FAMILIES, TUNING, drawn
from tests.support.scenes.mazes import maze
from vision import PictureError, extract
from vision.binarise import ONE_LEVEL
from vision.binarise.binarise import binarise
from vision.binarise.grey_classes import classes_of
from vision.binarise.grey_picture import GreyPicture
from vision.binarise.unresolved import unresolved_structure

DARK, LIGHT = 32.0, 207.0


def seen(wall: np.ndarray, noise: float, blur: float = 1.0) -> np.ndarray:
    """Walls and ways of 1 px each as a camera sees them."""
    rng = np.random.default_rng(3)
    grey = cv2.GaussianBlur(np.where(wall, DARK, LIGHT), (0, 0), blur)
    grey = grey + rng.normal(0.0, 1.0, grey.shape) * noise
    return np.clip(np.rint(grey), 0.0, 255.0).astype(np.uint8)


@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("side", ["dark", "light"])
@pytest.mark.parametrize("cells", [21, 61, 151])
def test_walls_of_a_pixel_at_a_blur_of_a_pixel_leave_no_free_floor(cells, side, noise) -> None:
    picture = seen(maze(cells, np.random.default_rng(cells)), noise)
    shown = picture if side == "dark" else 255 - picture
    with pytest.raises(PictureError, match=r"no free space.*too fine.*focus the camera"):
        binarise(shown, polarity=side)


@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("cells", [101, 201])
def test_nor_do_they_beside_a_block_that_is_plainly_seen(cells, noise) -> None:
    wall = maze(cells, np.random.default_rng(4))
    wall[40:52, 40:52] = True
    with pytest.raises(PictureError, match="too fine"):
        binarise(seen(wall, noise))


@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("cells", [101, 201])
@pytest.mark.parametrize("rim", [3, 5, 9])
def test_around_a_marker_on_white_nothing_but_the_white_is_free(rim, cells, noise) -> None:
    wall = maze(cells, np.random.default_rng(4))
    white = np.zeros(wall.shape, np.bool_)
    white[40 - rim : 52 + rim, 40 - rim : 52 + rim] = True
    wall[white] = False
    wall[40:52, 40:52] = True
    try:
        free = binarise(seen(wall, noise)).inside == 0
    except PictureError:
        return
    # the white's own blur reaches a pixel beyond it
    assert not free[cv2.dilate(white.astype(np.uint8), np.ones((3, 3), np.uint8)) == 0].any()


def test_where_a_robot_is_left_out_the_rest_is_obstacle_and_a_remark_says_why() -> None:
    picture = seen(maze(61, np.random.default_rng(5)), 2.0)
    robot = np.zeros(picture.shape, np.bool_)
    robot[20:40, 20:40] = True
    binary = binarise(picture, ignore=robot)
    assert ((binary.inside == 1) == ~robot).all()
    assert any("too fine" in remark for remark in binary.remarks)
    assert any("too fine" in remark for remark in extract(picture, ignore=robot).remarks)
    # a part of the next picture must not be seen by this one's level
    assert binary.how.method not in ONE_LEVEL


@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 10.0])
def test_a_part_of_the_floor_that_is_unresolved_is_an_obstacle(noise) -> None:
    wall = np.zeros((160, 200), np.bool_)
    wall[50:101, 60:111] = maze(51, np.random.default_rng(6))
    binary = binarise(seen(wall, noise))
    assert binary.inside[wall].all()
    assert not binary.inside[:40].any()
    assert not binary.inside[120:].any()


@pytest.mark.parametrize("family", FAMILIES)
def test_floors_with_texture_shadows_and_noise_have_no_such_structure(family) -> None:
    for number in range(4):
        picture = drawn(FAMILIES[family], np.random.default_rng([TUNING, number])).picture
        grey_picture = GreyPicture(picture)
        assert unresolved_structure(grey_picture, classes_of(grey_picture), "dark") is None


@pytest.mark.parametrize("quality", [50, 80])
@pytest.mark.parametrize("noise", [2.0, 5.0])
def test_nor_has_what_compression_leaves_of_noise_and_edges(noise, quality) -> None:
    rng = np.random.default_rng(7)
    grey = np.full((240, 320), 180.0)
    grey[60:140, 80:160] = 40.0
    grey = cv2.GaussianBlur(grey, (0, 0), 0.8) + rng.normal(0.0, noise, grey.shape)
    raw = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
    stored = cv2.imencode(".jpg", raw, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    picture = cv2.imdecode(stored, cv2.IMREAD_GRAYSCALE)
    grey_picture = GreyPicture(picture)
    assert unresolved_structure(grey_picture, classes_of(grey_picture), "dark") is None
    assert binarise(picture).inside.mean() == pytest.approx(80 * 80 / (240 * 320), rel=0.03)


@pytest.mark.parametrize("sigma", [5.0, 20.0, 60.0])
@pytest.mark.parametrize("shape", [(60, 80), (240, 320)])
def test_white_noise_alone_is_no_structure(shape, sigma) -> None:
    rng = np.random.default_rng(8)
    grey_picture = GreyPicture(
        np.clip(np.rint(rng.normal(150.0, sigma, shape)), 0, 255).astype(np.uint8)
    )
    assert unresolved_structure(grey_picture, classes_of(grey_picture), "dark") is None


def test_walls_that_are_wide_enough_to_be_found_are_no_structure() -> None:
    for px in (2, 3, 4, 6):
        wall = np.kron(maze(21, np.random.default_rng(9)), np.ones((px, px))) > 0
        for blur in (0.5, 1.0):
            assert not binarise(seen(wall, 5.0, blur)).inside.all()

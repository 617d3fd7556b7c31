"""Walls and ways of a few pixels are no noise: no smoothing deletes them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from benchmarks.vision.fine import cover
from tests.support.scenes.mazes import maze
from vision import extract
from vision.binarise.binarise import binarise
from vision.binarise.grey_picture import GreyPicture
from vision.binarise.humps import Humps

SIDE = 21
DARK, LIGHT = 32.0, 207.0


def drawn(px: int, blur: float, noise: float = 0.0, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """A maze of walls and ways ``px`` wide: its walls, pixel by pixel, and its picture."""
    rng = np.random.default_rng(seed)
    wall = np.kron(maze(SIDE, rng), np.ones((px, px))) > 0
    grey = np.where(wall, DARK, LIGHT)
    if blur > 0.0:
        grey = cv2.GaussianBlur(grey, (0, 0), blur)
    grey = grey + rng.normal(0.0, 1.0, grey.shape) * noise
    return wall, np.clip(np.rint(grey), 0.0, 255.0).astype(np.uint8)


def cells(pixels: np.ndarray) -> np.ndarray:
    """The share of each cell of the maze that is obstacle."""
    px = len(pixels) // SIDE
    return pixels.reshape(SIDE, px, SIDE, px).mean(axis=(1, 3))


@pytest.mark.parametrize("side", ["dark", "light"])
@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("blur", [0.0, 0.5])
@pytest.mark.parametrize("px", [1, 2, 3, 4, 6])
def test_every_wall_and_every_way_is_what_it_is(px, blur, noise, side) -> None:
    wall, picture = drawn(px, blur, noise)
    shown = picture if side == "dark" else 255 - picture
    found = cells(binarise(shown, polarity=side).inside)
    assert ((found > 0.5) == (cells(wall) > 0.5)).all()


@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("px", [2, 3, 4, 6])
def test_nor_is_a_wall_lost_that_a_lens_blurs_by_a_pixel(px, noise) -> None:
    wall, picture = drawn(px, 1.0, noise)
    found = cells(binarise(picture).inside)
    assert (found[cells(wall) > 0.5] >= 0.5).all()


@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 10.0])
@pytest.mark.parametrize(
    ("px", "blur"), [(px, blur) for px in (1, 2, 3, 4, 6) for blur in (0.0, 0.5, 1.0) if px > blur]
)
def test_the_scene_of_a_fine_maze_has_its_walls(px, blur, noise) -> None:
    """Outlines cut pieces off walls of up to 4 px, where nothing asks whether they do.

    Walls that are no wider than their blur are `test_unresolved_structure`'s.
    """
    for seed in range(1, 4):
        wall, picture = drawn(px, blur, noise, seed)
        covered = cells(cover(extract(picture), picture.shape))
        assert (covered[cells(wall) > 0.5] >= 0.5).all()
        blocked = covered[cells(wall) < 0.5] > 0.5
        # what noise of a fourth of the contrast decides is an obstacle
        assert blocked.mean() <= (0.06 if (px, blur) == (2, 1.0) and noise > 2.0 else 0.01)


def test_what_noise_crosses_unsmoothed_is_said() -> None:
    _, picture = drawn(2, 0.5, 10.0)
    binary = binarise(picture)
    assert any("was not smoothed" in remark for remark in binary.remarks)
    assert not binary.doubtful


@pytest.mark.parametrize("sigma", [5.0, 20.0, 60.0])
def test_noise_alone_is_no_fine_structure(sigma) -> None:
    rng = np.random.default_rng(2)
    grey = np.clip(np.rint(rng.normal(150.0, sigma, (120, 160))), 0, 255).astype(np.uint8)
    grey_picture = GreyPicture(grey)
    assert grey_picture.fine is None
    assert grey_picture.noise > 0.8 * min(sigma, 50.0)


def test_two_grey_values_are_two_humps_and_all_values_alike_are_none() -> None:
    two = np.zeros(256, np.int64)
    two[[40, 200]] = 30, 10
    humps = Humps.of(two)
    assert (humps.dark, humps.light, humps.within) == (40.0, 200.0, 0.0)
    assert (humps.dark_share, humps.apart) == (0.75, 1.0)
    assert abs(Humps.of(np.ones(256, np.int64)).apart - 0.75) < 1e-4
    one = np.zeros(256, np.int64)
    one[7] = 5
    assert Humps.of(one).apart == 0.0

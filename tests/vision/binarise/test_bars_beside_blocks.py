"""A thin bar on an even floor is seen beside a block as it is alone; a floor's pattern is not."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from tests.support.drawn.render import coverage, outline_points, polygon
from vision.binarise.binarise import binarise
from vision.binarise.earlier_level import level_leaves_out
from vision.binarise.regions.floor_pattern import has_pattern

FLOOR = 214.0
SIZE = (220, 160)
BLOCK = [(150.0, 40.0), (205.0, 40.0), (205.0, 120.0), (150.0, 120.0)]
SEEN = 0.85
"""Share of a bar's pixels that are obstacle, or beside one, where it is seen."""


@dataclass(frozen=True)
class Bar:
    """A bar around a point, ``darker`` than the floor by so many grey levels."""

    middle: tuple[float, float]
    length: float
    width: float
    angle: float
    darker: float

    def cover(self, size: tuple[int, int]) -> np.ndarray:
        along = 0.5 * self.length * np.array([math.cos(self.angle), math.sin(self.angle)])
        across = 0.5 * self.width * np.array([-math.sin(self.angle), math.cos(self.angle)])
        signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        corners = [tuple(np.array(self.middle) + s * along + t * across) for s, t in signs]
        return coverage([outline_points(polygon(corners))], size, lines=8)


def picture(grey: np.ndarray, blur: float, noise: float, seed: int) -> np.ndarray:
    seen = cv2.GaussianBlur(grey, (0, 0), blur)
    seen += np.random.default_rng(seed).normal(0.0, noise, grey.shape)
    return np.clip(np.rint(seen), 0, 255).astype(np.uint8)


def found(shown: np.ndarray, bar: np.ndarray, side: str = "dark") -> float:
    """The share of a bar's pixels that are in the mask or next to it."""
    inside = binarise(shown if side == "dark" else 255 - shown, polarity=side).inside
    near = cv2.dilate(inside.copy(), np.ones((3, 3), np.uint8))
    return float((near[bar >= 0.5] != 0).mean())


def test_a_bar_of_two_pixels_with_an_eighth_of_the_light_is_seen_beside_a_black_block() -> None:
    cover = Bar((218.5, 80.0), 78.0, 1.9, math.radians(81.0), 41.0).cover((320, 160))
    grey = FLOOR - 41.0 * cover
    grey[20:140, 20:90] = 45.0
    shown = picture(grey, 0.7, 0.4, 1)
    assert found(shown, cover) > SEEN
    assert not any("pattern" in remark for remark in binarise(shown).remarks)


@pytest.mark.parametrize("side", ["dark", "light"])
def test_a_bar_that_is_seen_alone_is_seen_beside_a_block_of_any_darkness(side: str) -> None:
    seen_alone = 0
    for seed in range(60):
        rng = np.random.default_rng([34, seed])
        middle = (rng.uniform(60.0, 80.0), rng.uniform(60.0, 100.0))
        bar = Bar(
            middle,
            rng.uniform(50.0, 90.0),
            rng.uniform(1.5, 4.0),
            rng.uniform(0.0, math.pi),
            rng.uniform(20.0, 80.0),
        )
        noise, blur, block = rng.uniform(0.3, 3.0), rng.uniform(0.4, 0.8), rng.uniform(0.0, 195.0)
        cover = bar.cover(SIZE)
        alone = FLOOR - bar.darker * cover
        beside = alone + (block - FLOOR) * coverage([outline_points(polygon(BLOCK))], SIZE)
        if found(picture(alone, blur, noise, seed), cover, side) > SEEN:
            seen_alone += 1
            share = found(picture(beside, blur, noise, seed), cover, side)
            assert share > SEEN, (seed, bar, noise, blur, block)
        else:
            assert bar.darker < 15.0 * noise, (seed, bar, noise)
    assert seen_alone >= 55


@pytest.mark.parametrize(
    ("length", "width", "darker"),
    [(6.0, 2.0, 40.0), (12.0, 2.0, 40.0), (30.0, 1.5, 40.0), (30.0, 1.5, 90.0)],
)
def test_a_faint_bar_of_twelve_pixels_is_seen_wherever_it_lies(
    length: float, width: float, darker: float
) -> None:
    for seed in range(12):
        rng = np.random.default_rng([35, seed])
        middle, angle = (rng.uniform(40.0, 400.0), rng.uniform(40.0, 440.0)), rng.uniform(0.0, 3.1)
        cover = Bar(middle, length, width, angle, darker).cover((640, 480))
        grey = FLOOR - darker * cover
        grey[100:300, 450:600] = 45.0
        assert found(picture(grey, 0.7, 2.0, seed), cover) > SEEN, seed


@pytest.mark.parametrize("side", ["dark", "light"])
def test_the_level_of_an_earlier_picture_leaves_a_faint_bar_out_and_no_dark_block(side) -> None:
    bare = np.full(SIZE[::-1], FLOOR)
    block = bare + (40.0 - FLOOR) * coverage([outline_points(polygon(BLOCK))], SIZE)
    bar = block - 40.0 * Bar((70.0, 80.0), 12.0, 2.0, 0.4, 40.0).cover(SIZE)
    pictures = [picture(grey, 0.7, 2.0, 1) for grey in (block, bare, bar)]
    block_seen, bare_seen, bar_seen = pictures if side == "dark" else [255 - p for p in pictures]
    how = binarise(block_seen, polarity=side).how
    assert not level_leaves_out(block_seen, how)
    assert not level_leaves_out(bare_seen, how)
    assert level_leaves_out(bar_seen, how)


@pytest.mark.parametrize("blur", [0.5, 1.2])
@pytest.mark.parametrize("depth", [0.06, 0.1, 0.14])
@pytest.mark.parametrize("pitch", [24, 36, 69])
def test_the_joints_of_a_floor_beside_a_black_block_are_its_pattern(pitch, depth, blur) -> None:
    grey = np.full((360, 480), FLOOR)
    for k in range(3):
        grey[:, 11 + k :: pitch] = FLOOR * (1.0 - depth)
    grey[60:200, 150:300] = 40.0
    shown = picture(grey, blur, 1.0, 3)
    inside = binarise(shown).inside
    assert has_pattern(shown, 1.0, "dark")
    assert cv2.connectedComponents(inside, connectivity=8)[0] - 1 == 1


def test_a_lone_line_and_an_empty_floor_are_no_pattern() -> None:
    grey = np.full((360, 480), FLOOR)
    assert not has_pattern(picture(grey, 0.7, 3.0, 3), 3.0, "dark")
    grey[180:183] = 190.0
    assert not has_pattern(picture(grey, 0.7, 1.0, 3), 1.0, "dark")

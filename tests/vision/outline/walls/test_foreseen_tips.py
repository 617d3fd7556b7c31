"""Corners of slits, bars and wedges: none lies far beyond the border that leads to it.

Rules and units
- The truth is the polygon that the picture is drawn from; pixels, centres at integers, y down.
"""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from planner.scene import PolygonRecord
from tests.support.drawn.render import coverage
from vision import extract

GOLDEN = Path(__file__).parents[3] / "golden"
SIZE = (120, 90)
BLOCK = np.array([(7.5, 7.5), (111.5, 7.5), (111.5, 81.5), (7.5, 81.5)])
NOISES = 0.0, 2.0, 5.0
STRAY_PX = 2.0
"""How far an outline's corner may lie from what was drawn, as the page on outlines promises."""
TIP_PX = 1.0
TIPS_KEPT = 0.8
"""Share of the tips of wedges that an outline has within ``TIP_PX``: others end in chords."""
SEEDS = range(40)


def corners_of(picture: np.ndarray, free: bool) -> np.ndarray:
    """The corners of all outlines, or of all holes."""
    found = []
    for each in extract(picture).objects:
        for record in [r for hole in each.holes for r in hole] if free else each.records:
            if isinstance(record, PolygonRecord):
                found += [edge.start for edge in record.edges]
    return np.array(found).reshape(-1, 2)


def placed(outline: list[tuple[float, float]], rng: np.random.Generator) -> np.ndarray:
    angle = rng.uniform(0.0, math.tau)
    c, s = math.cos(angle), math.sin(angle)
    middle = 0.5 * np.array(SIZE) + rng.uniform(-5.0, 5.0, 2)
    return np.asarray(np.array(outline) @ np.array([[c, s], [-s, c]]) + middle)


def slit(rng: np.random.Generator) -> np.ndarray:
    length, width = 0.5 * rng.uniform(12.0, 60.0), 0.5 * rng.uniform(1.0, 3.0)
    corners = [(-length, -width), (length, -width), (length, width), (-length, width)]
    return placed(corners, rng)


def wedge(rng: np.random.Generator, least_deg: float = 2.0) -> np.ndarray:
    half, length = math.radians(rng.uniform(least_deg, 20.0)), rng.uniform(25.0, 60.0)
    wide = length * math.tan(half)
    return placed([(-0.5 * length, 0.0), (0.5 * length, -wide), (0.5 * length, wide)], rng)


def shown(
    outline: np.ndarray, free: bool, rng: np.random.Generator, noises: tuple[float, ...] = NOISES
) -> np.ndarray:
    """A picture of the outline: an obstacle, or free in a block."""
    covered = coverage([BLOCK, outline] if free else [outline], SIZE)
    grey = cv2.GaussianBlur(210.0 - 160.0 * covered, (0, 0), rng.uniform(0.3, 1.2))
    grey += rng.normal(0.0, 1.0, grey.shape) * rng.choice(noises)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def away(points: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """The distance of each point from a closed outline."""
    a = outline[None]
    along = np.roll(outline, -1, axis=0)[None] - a
    share = ((points[:, None] - a) * along).sum(axis=2) / (along * along).sum(axis=2)
    foot = a + share.clip(0.0, 1.0)[..., None] * along
    return np.asarray(np.hypot(*np.moveaxis(points[:, None] - foot, 2, 0)).min(axis=1))


def test_the_hole_of_a_slit_ends_where_the_slit_ends() -> None:
    """Two nearly parallel sides of nine points met 4 px behind its end."""
    picture = cv2.imread(str(GOLDEN / "slit_in_a_block.png"), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    # a slit of one to two pixels is lighter than half-way between the block and itself
    bright = np.argwhere(picture[20:70, 20:100] > 100)[:, ::-1] + 20.0
    corners = corners_of(picture, free=True)
    assert len(corners) > 3
    gaps = np.hypot(*np.moveaxis(corners[:, None] - bright[None], 2, 0)).min(axis=1)
    assert gaps.max() <= STRAY_PX


@pytest.mark.parametrize("free", [True, False])
@pytest.mark.parametrize("shape", [slit, wedge])
def test_no_corner_lies_far_from_what_was_drawn(shape, free: bool) -> None:
    seen = 0
    for seed in SEEDS:
        rng = np.random.default_rng([seed, 34])
        truth = shape(rng)
        corners = corners_of(shown(truth, free, rng), free)
        seen += len(corners)
        if len(corners):
            assert away(corners, truth).max() <= STRAY_PX, seed
    assert seen > 2 * len(SEEDS)


@pytest.mark.parametrize("free", [True, False])
def test_wedges_of_long_sides_keep_the_tip_that_blur_rounded_back(free: bool) -> None:
    kept = 0
    for seed in SEEDS:
        rng = np.random.default_rng([seed, 35])
        truth = wedge(rng, least_deg=6.0)
        corners = corners_of(shown(truth, free, rng, (0.0,)), free)
        kept += bool((np.hypot(*(corners - truth[0]).T) <= TIP_PX).any())
    assert kept >= TIPS_KEPT * len(SEEDS)

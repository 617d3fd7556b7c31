"""The judge of regions: what a lens blurs is an obstacle, what light blurs is none."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from benchmarks.vision.regions import FAMILIES, drawn, looked_at
from planner.scene import CircleRecord
from tests.support.drawn.render import draw, ramp
from vision.binarise.binarise import binarise
from vision.binarise.grey_picture import GreyPicture
from vision.binarise.light_surface import FREE_LEVEL, without_light
from vision.binarise.regions.edge_evidence import EdgeEvidence
from vision.binarise.regions.edge_evidence_kernels import LEAST_SHARP, steps_of_regions

SIZE = (480, 360)
NINE = [CircleRecord((80.0 + 160 * i, 60.0 + 120 * j), 32.0) for i in range(3) for j in range(3)]


def share_that_is_sharp(sigma: float) -> float:
    """Of a straight edge between 40 and 215, so blurred, in a picture of its own."""
    grey = np.full((64, 128), 215.0)
    grey[:, :64] = 40.0
    seen = cv2.GaussianBlur(grey, (0, 0), sigma) if sigma > 0.0 else grey
    labels = np.zeros(grey.shape, np.int32)
    labels[:, :64] = 1
    steps, _, sharp, _ = steps_of_regions(np.rint(seen).astype(np.uint8), labels, 2, 0.0, 1.0)
    return float(sharp[1] / steps[1].sum())


@pytest.mark.parametrize(
    ("sigma", "share"), [(0.0, 0.6), (0.7, 0.54), (2.0, 0.35), (3.5, 0.06), (7.0, -0.34)]
)
def test_the_limit_of_what_is_sharp_lies_between_a_lens_and_light(sigma, share) -> None:
    assert share_that_is_sharp(sigma) == pytest.approx(share, abs=0.02)
    assert (share > LEAST_SHARP) == (sigma <= 2.0)


@pytest.mark.parametrize("side", ["dark", "light"])
@pytest.mark.parametrize("blur", [0.7, 2.0, 3.0, 3.5])
@pytest.mark.parametrize("noise", [0.0, 4.0])
def test_obstacles_out_of_focus_in_uneven_light_are_counted(side, blur, noise) -> None:
    dark, light = (40.0, 215.0) if side == "dark" else (215.0, 40.0)
    rng = np.random.default_rng(3)
    lit = ramp(SIZE, 0.6, 0.7)
    picture = draw(NINE, SIZE, dark=dark, light=light, blur=blur, lit=lit, noise=noise, rng=rng)
    inside = binarise(picture, polarity=side).inside
    assert cv2.connectedComponents(inside, connectivity=8)[0] - 1 == 9


@pytest.mark.parametrize("blur", [0.7, 2.0, 3.0])
def test_a_faint_obstacle_beside_plain_ones_is_counted_in_uneven_light(blur: float) -> None:
    lit = ramp(SIZE, 0.6, 0.7)
    lit[30:90, 200:280] *= 0.75
    lit[30:90, 200:280] = lit[30:90, 200:280]
    lit = cv2.GaussianBlur(lit, (0, 0), blur)
    plain = [one for one in NINE if one.center != (240.0, 60.0)]
    picture = draw(plain, SIZE, blur=blur, lit=lit)
    inside = binarise(picture).inside
    assert cv2.connectedComponents(inside, connectivity=8)[0] - 1 == 9
    assert inside[60, 240]


@pytest.mark.parametrize("wide", [4.0, 8.0, 20.0])
@pytest.mark.parametrize("noise", [0.0, 4.0, 12.0])
def test_a_penumbra_on_an_empty_floor_is_no_obstacle(wide: float, noise: float) -> None:
    x = np.arange(SIZE[0])[None].repeat(SIZE[1], axis=0)
    for at in (150.0, 330.0):
        lit = 1.0 - 0.5 / (1.0 + np.exp(-(x - at) / wide))
        picture = draw([], SIZE, lit=lit, noise=noise, rng=np.random.default_rng(2))
        assert not binarise(picture).inside.any()


@pytest.mark.parametrize("side", ["dark", "light"])
def test_a_picture_without_its_light_has_one_grey_where_the_floor_is_free(side: str) -> None:
    dark, light = (40.0, 215.0) if side == "dark" else (215.0, 40.0)
    picture = draw(NINE, SIZE, dark=dark, light=light, lit=ramp(SIZE, 0.5, 0.4))
    shown = picture if side == "dark" else 255 - picture
    flat, stronger = without_light(shown, side)
    inside = draw(NINE, SIZE, dark=0.0, light=255.0) < 250
    free = ~cv2.dilate(inside.astype(np.uint8), np.ones((9, 9), np.uint8)).astype(bool)
    assert np.abs(flat[free] / FREE_LEVEL - 1.0).max() < 0.12
    assert np.median(flat[draw(NINE, SIZE, dark=0.0, light=255.0) == 0]) < 0.35 * FREE_LEVEL
    assert stronger > FREE_LEVEL / (light * 1.05)


def test_only_a_picture_out_of_focus_is_halved() -> None:
    for blur, every in ((0.5, 1), (1.2, 1), (3.0, 2), (4.0, 2)):
        picture = draw(NINE, SIZE, blur=blur, lit=ramp(SIZE, 0.3))
        assert EdgeEvidence(GreyPicture(picture), "dark").judge.every == every


def test_a_step_on_one_side_alone_is_no_border() -> None:
    """A disc and the shadow beside it as one region: dark against the floor where the disc is."""
    grey = np.full((120, 200), 120, np.uint8)
    grey[:, :100] = 200
    cv2.circle(grey, (100, 60), 30, 20, -1)
    mask = np.zeros(grey.shape, np.uint8)
    mask[10:110, 100:190] = 1
    judge = EdgeEvidence(GreyPicture(grey), "dark").judge
    assert not judge.regions(mask).stand_out[1]
    cv2.circle(mask := np.zeros(grey.shape, np.uint8), (100, 60), 30, 1, -1)
    assert judge.regions(mask).stand_out[1]


@pytest.mark.parametrize("sigma", [2.0, 5.0, 20.0])
def test_no_region_that_a_level_draws_in_noise_stands_out(sigma: float) -> None:
    rng = np.random.default_rng(5)
    grey = np.clip(np.rint(128.0 + rng.normal(0.0, sigma, (240, 320))), 0, 255).astype(np.uint8)
    evidence = EdgeEvidence(GreyPicture(grey), "dark")
    for above in np.linspace(-3.0, 2.0, 11):
        below = (evidence.grey < 128.0 + above * evidence.noise).astype(np.uint8)
        assert not evidence.judge.regions(below).stand_out.any()


@pytest.mark.parametrize(("family", "least"), [("ramp, unsharp", 0.95), ("shadow", 0.9)])
def test_held_out_pictures_are_drawn_alike_and_their_obstacles_found(family, least) -> None:
    number = list(FAMILIES).index(family)
    found, all_of_them = 0, 0
    for i in range(6):
        one = drawn(FAMILIES[family], np.random.default_rng([9, number, i]))
        again = drawn(FAMILIES[family], np.random.default_rng([9, number, i]))
        assert np.array_equal(one.picture, again.picture)
        hits, false = looked_at(one)
        found, all_of_them = found + sum(hits), all_of_them + len(hits)
        assert false == 0
    assert found >= math.floor(least * all_of_them)

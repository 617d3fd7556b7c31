"""No obstacle is lost for being lighter than others or shaded, and what is left out is said."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from benchmarks.vision import grey_shapes
from benchmarks.vision.regions import FAMILIES, drawn, looked_at
from planner.scene import CircleRecord
from tests.support.drawn.render import coverage, draw, outline_points, polygon
from vision import extract
from vision.binarise.binarise import binarise

SIZE = (320, 240)
PLACES = [(55, 60), (160, 60), (265, 60), (55, 180), (160, 180), (265, 180)]
FLOOR = 215.0


def blocks(greys: tuple[int, ...], noise: float, side: str) -> np.ndarray:
    """A floor with a block of each grey on it, or a picture's negative."""
    picture = np.full(SIZE[::-1], FLOOR)
    for (x, y), grey in zip(PLACES, greys, strict=True):
        corners = [(x - 30, y - 14), (x + 24, y - 26), (x + 30, y + 14), (x - 24, y + 26)]
        picture += (grey - FLOOR) * coverage([outline_points(polygon(corners))], SIZE)
    picture = cv2.GaussianBlur(picture, (0, 0), 0.7)
    picture += np.random.default_rng(1).normal(0.0, noise, picture.shape)
    shown = np.clip(np.rint(picture), 0, 255).astype(np.uint8)
    return shown if side == "dark" else 255 - shown


def count(picture: np.ndarray, **how: object) -> int:
    return cv2.connectedComponents(binarise(picture, **how).inside, connectivity=8)[0] - 1


@pytest.mark.parametrize("noise", [0.0, 5.0])
@pytest.mark.parametrize("side", ["dark", "light"])
@pytest.mark.parametrize(
    "greys",
    [
        (40, 40, 40, 140, 140, 140),
        (40, 40, 40, 40, 40, 150),
        (40, 150, 150, 150, 150, 150),
        (100, 100, 100, 160, 160, 160),
        (20, 60, 100, 140, 160, 180),
    ],
)
def test_obstacles_of_different_greys_are_all_seen(greys, noise, side) -> None:
    assert count(blocks(greys, noise, side), polarity=side) == 6


# the faintest has a step of seven times the noise
@pytest.mark.parametrize(("noise", "worst_px"), [(0.0, 0.15), (5.0, 1.5)])
def test_those_seen_at_a_level_of_their_own_lie_where_they_are(noise, worst_px) -> None:
    scene = extract(blocks((20, 60, 100, 140, 160, 180), noise, "dark"))
    assert any("of their own" in remark or "of its own" in remark for remark in scene.remarks)
    truth = np.array(PLACES) + np.array([[[-30, -14]], [[24, -26]], [[30, 14]], [[-24, 26]]])
    corners = truth.reshape(-1, 2)
    found = np.array([edge.start for one in scene.objects for edge in one.records[0].edges])
    away = np.hypot(*(corners[:, None] - found[None]).transpose(2, 0, 1))
    assert away.min(axis=1).max() < worst_px


@pytest.mark.parametrize(("wide", "at"), [(5, 200), (5, 430), (15, 430)])
@pytest.mark.parametrize("noise", [0.0, 5.0])
@pytest.mark.parametrize("side", ["dark", "light"])
def test_obstacles_in_a_shadow_of_70_percent_are_counted(wide, at, noise, side) -> None:
    six = [CircleRecord((x, y), 40.0) for x in (100.0, 320.0, 540.0) for y in (100.0, 360.0)]
    x = np.arange(640.0)[None].repeat(480, axis=0)
    lit = 1.0 - 0.7 / (1.0 + np.exp(-(x - at) / wide))
    dark, light = (40.0, FLOOR) if side == "dark" else (FLOOR, 40.0)
    rng = np.random.default_rng(6)
    picture = draw(six, (640, 480), dark=dark, light=light, lit=lit, noise=noise, rng=rng)
    assert count(picture, polarity=side) == 6


def test_a_faint_line_that_is_left_out_is_said() -> None:
    """With 12 % of the light it may be a joint of a floor with joints; with 25 % it is none."""
    x = np.arange(640.0)[None].repeat(480, axis=0)
    lit = 1.0 - 0.4 / (1.0 + np.exp(-(x - 430) / 40))
    disc = [CircleRecord((100.0, 100.0), 40.0)]
    lone, joints = lit.copy(), lit.copy()
    lone[300:303, 20:160] *= 0.88
    joints[:, 30::60] *= 0.88
    clear = joints.copy()
    clear[300:303, 35:85] *= 0.75
    assert binarise(draw(disc, (640, 480), lit=lone)).inside[301, 100] == 1
    assert binarise(draw(disc, (640, 480), lit=clear)).inside[301, 60] == 1
    joints[300:303, 35:85] *= 0.88
    picture = draw(disc, (640, 480), lit=joints)
    binary = binarise(picture)
    assert binary.inside[301, 60] == 0
    (said,) = [remark for remark in binary.remarks if "faint" in remark]
    assert "regions were taken for uneven light or the floor's own pattern" in said


@pytest.mark.parametrize(("family", "least"), [("cables", 8), ("cables, ramp", 7)])
def test_a_cable_of_half_the_contrast_is_an_obstacle(family: str, least: int) -> None:
    """2 px thin: 19 of 20 were taken for joints of the floor."""
    found = 0
    for seed in range(10):
        one = drawn(FAMILIES[family], np.random.default_rng([5, seed]))
        hits, false = looked_at(one)
        found += hits[-1]
        assert all(hits[:-1]), f"seed {seed}"
        assert not false, f"seed {seed}"
    assert found >= least


def test_joints_of_a_floor_are_no_cables() -> None:
    for seed in range(10):
        one = drawn(FAMILIES["joints"], np.random.default_rng([6, seed]))
        assert looked_at(one)[1] == 0, f"seed {seed}"


@pytest.mark.parametrize(
    ("family", "look", "seed"),
    [
        ("bar", (0.7, 5.0), 17),
        ("bar", (1.5, 5.0), 26),
        ("pointed", (1.5, 5.0), 15),
        ("pointed", (1.5, 5.0), 44),
    ],
)
def test_a_wall_is_an_obstacle_though_blur_rounds_its_ends(
    family: str, look: tuple[float, float], seed: int
) -> None:
    """Its short sides have less of a step than the long ones: it was no obstacle at all."""
    assert count(grey_shapes.drawn(family, look, seed)[1]) == 1

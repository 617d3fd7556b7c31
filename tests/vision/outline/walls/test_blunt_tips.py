"""Bars and the teeth of combs, three and a half to seven pixels wide: their ends are sides.

Rules and units
- The truth is the polygon that the picture is drawn from; pixels, centres at integers, y down.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from planner.scene import CircleRecord, PolygonRecord, Segment
from tests.support.drawn.render import draw, polygon
from vision import extract

SIZE = (220, 220)
END_PX = 0.5
"""How far the corners of a narrow end may be off without noise: half a pixel, where the stairs that
stood there were off by one."""


def corners_of(outline: np.ndarray, noise: float = 0.0, seed: int = 0) -> np.ndarray:
    """The corners of the only object of a drawing of the outline, all sides straight."""
    rng = np.random.default_rng(seed)
    (only,) = extract(draw([polygon(outline)], SIZE, noise=noise, rng=rng)).objects
    (record,) = only.records
    assert isinstance(record, PolygonRecord)
    assert all(isinstance(edge, Segment) for edge in record.edges)
    return np.array([edge.start for edge in record.edges])


def placed(outline: list[tuple[float, float]], rng: np.random.Generator) -> np.ndarray:
    angle = rng.uniform(0.0, math.tau)
    c, s = math.cos(angle), math.sin(angle)
    middle = 110.0 + rng.uniform(-1.0, 1.0, 2)
    return np.asarray(np.array(outline) @ np.array([[c, s], [-s, c]]) + middle)


def missed(truth: np.ndarray, found: np.ndarray) -> float:
    """How far the worst of the true corners lies from the nearest found one."""
    return float(np.hypot(*np.moveaxis(truth[:, None] - found[None], 2, 0)).min(axis=1).max())


@pytest.mark.parametrize("noise", [0.0, 5.0])
@pytest.mark.parametrize("width", [3.5, 4.0, 4.5, 5.0])
def test_a_narrow_bar_has_four_corners(width: float, noise: float) -> None:
    for seed in range(8):
        rng = np.random.default_rng([seed, int(10 * width)])
        w = 0.5 * width
        truth = placed([(-80, -w), (80, -w), (80, w), (-80, w)], rng)
        found = corners_of(truth, noise, seed)
        assert len(found) == 4, (seed, found)
        assert missed(truth, found) < END_PX + 0.02 * noise, seed


@pytest.mark.parametrize("width", [4.5, 5.5, 6.5])
def test_a_comb_has_the_corners_of_its_teeth(width: float) -> None:
    for seed in range(4):
        rng = np.random.default_rng([seed, int(10 * width)])
        outline = [(-64.0, 20.0)]
        for tooth in range(6):
            x = -64.0 + tooth * 21.0
            outline += [(x, -30.0), (x + width, -30.0), (x + width, 10.0), (x + 21.0, 10.0)]
        truth = placed([*outline, (62.0, 20.0)], rng)
        found = corners_of(truth)
        assert len(found) == len(truth), (seed, len(found))
        assert missed(truth, found) < 2.0 * END_PX, seed


def test_a_sharp_tip_keeps_its_corner() -> None:
    for seed in range(6):
        rng = np.random.default_rng(seed)
        truth = placed([(-70, 0.0), (60, -24.0), (60, 24.0)], rng)
        found = corners_of(truth)
        assert len(found) == 3, (seed, found)
        assert missed(truth, found) < 2.0 * END_PX


def test_a_large_circle_with_noise_is_no_polygon() -> None:
    """One that lost a little more than it may was drawn as 51 chords that followed the noise."""
    for radius, blur, noise, seed in ((100.0, 1.5, 10.0, 30), (60.0, 1.5, 20.0, 32)):
        size = int(2 * radius + 30)
        for more in range(6):
            rng = np.random.default_rng([41, seed + more])
            middle = 0.5 * size + rng.uniform(-1.0, 1.0, 2)
            truth = CircleRecord((float(middle[0]), float(middle[1])), radius + rng.uniform(0, 1))
            picture = draw([truth], (size, size), blur=blur, noise=noise, rng=rng)
            (only,) = extract(picture).objects
            assert isinstance(only.records[0], CircleRecord)

"""What blur and noise do to sharp corners makes no sides; true sides as short stay."""

from __future__ import annotations

import math

import numpy as np
import pytest

from planner.scene import PolygonRecord
from tests.support.drawn.outlines import blank_outline, scratch_for
from tests.support.drawn.render import Points, draw, polygon
from vision import extract
from vision.outline.corners.edit_search_kernels import edit_outline
from vision.outline.fit.edge_shape_kernels import fit_line
from vision.outline.fit.outline_kernels import edge_end
from vision.outline.outline_types import BorderPoints, Costs, OutlineLimits, Prices

SIZE = 220, 220
PLACES = (55.3, 55.1), (165.7, 55.1), (55.3, 165.2), (165.7, 165.2)
COSTS = Costs(False, 0.2, 0.3, 2.0, 0.0)
LIMITS = OutlineLimits(False, 2.0, 2.0, 0.6, 2, 1.6, 1.0, 0.05, 0.02, 1.0, 0.2, 0.0)
SIGNS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def rectangle(rng: np.random.Generator, at: tuple[float, float], least: float) -> Points:
    """The vertices of a turned rectangle, clockwise on the screen."""
    turn = rng.uniform(0.0, math.tau)
    c, s = math.cos(turn), math.sin(turn)
    vertices: Points = SIGNS * rng.uniform(least, 35.0, 2) @ np.array([(c, s), (-s, c)]) + at
    return vertices


@pytest.mark.parametrize(("blur", "noise", "allowed"), [(1.5, 10.0, 0), (2.0, 10.0, 4)])
def test_blur_and_noise_cut_no_corner(blur: float, noise: float, allowed: int) -> None:
    """Rectangles of 96 that have other sides than four: 3 and 19 once."""
    wrong = 0
    for seed in range(24):
        rng = np.random.default_rng([98, seed])
        truth = [polygon(rectangle(rng, at, 10.0)) for at in PLACES]
        for found in extract(draw(truth, SIZE, blur=blur, noise=noise, rng=rng)).objects:
            (record,) = found.records
            wrong += not (isinstance(record, PolygonRecord) and len(record.edges) == 4)
    assert wrong <= allowed


def test_a_short_bevel_stays() -> None:
    """Three pixels cut off both sides of a corner: a side of four."""
    for seed in range(6):
        rng = np.random.default_rng([99, seed])
        corners = rectangle(rng, (110.0, 110.0), 20.0)
        bevelled = []
        for i in range(4):
            for other in (corners[i - 1], corners[(i + 1) % 4]):
                bevelled.append(
                    corners[i] + 3.0 * (other - corners[i]) / math.dist(other, corners[i])
                )
        (only,) = extract(draw([polygon(bevelled)], SIZE, blur=0.7, noise=5.0, rng=rng)).objects
        (record,) = only.records
        assert isinstance(record, PolygonRecord)
        assert len(record.edges) == 8, f"seed {seed}"


def test_breaks_stay_in_order_wherever_the_border_begins() -> None:
    """A side that goes may lie across the border's first point."""
    side = np.arange(0.5, 30.0, 1.0)
    zero, full = np.zeros_like(side), np.full_like(side, 30.0)
    around = [(side, zero), (full, side), (30.0 - side, full), (zero, 30.0 - side)]
    border = np.concatenate([np.stack(each, axis=1) for each in around])
    n = len(border)
    for shift in range(n):
        x, y = np.roll(border, -shift, axis=0).T
        px, py = np.tile(x, 2), np.tile(y, 2)
        # four sides, and the four points around a corner as a fifth
        starts = np.array([2, 30, 60, 90, n - 2])
        edges = len(starts)
        outline = blank_outline(edges)
        breaks = outline.breaks
        breaks[:] = np.sort((starts - shift) % n)
        outline.is_arc[:] = False
        for e in range(edges):
            outline.ranges[e] = breaks[e], edge_end(breaks, edges, n, e)
            fit_line(px, py, breaks[e], edge_end(breaks, edges, n, e), outline.shape[e])
            outline.joints[e] = px[breaks[e]], py[breaks[e]]
        left = edit_outline(
            BorderPoints(px, py, n), outline, edges, LIMITS, 1.0, COSTS, Prices(30.0, 66.0, 54.0),
            scratch_for(n),
        )  # fmt: skip
        assert left == edges - 1
        assert (outline.breaks[:left] >= 0).all()
        assert (outline.breaks[:left] < n).all()
        # they follow one another around the border once
        ahead = (np.roll(outline.breaks[:left], -1) - outline.breaks[:left]) % n
        assert (ahead > 0).all()
        assert ahead.sum() == n

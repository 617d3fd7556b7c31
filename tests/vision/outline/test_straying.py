"""Whether an outline leaves its border: an arc and its chord, and borders that go this way or that.

Rules and units
- The oracle samples outline and border densely and measures each to the other's polyline. Pixels.
"""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.scene import FloatArray
from tests.vision.outline.test_residuals import along, off
from vision.outline.check.loss_kernels import LONGEST_TIP_PX
from vision.outline.check.stray_kernels import outline_strays
from vision.outline.fit.outline_kernels import STRAY_PX
from vision.outline.fitted_borders import ARC_CCW, ARC_CW, LINE
from vision.outline.outline_types import BorderPoints, FinishedEdges

WAYS = ("along", "the other way", "straight", "along, and back a little", "along, with a gap")


def arc_points(radius: float, begin: float, sweep: float) -> FloatArray:
    """Points of an arc around (0, 0), half a pixel apart or less, its end left out."""
    count = max(math.ceil(2.0 * radius * abs(sweep)), 2)
    a = begin + sweep * np.arange(count) / count
    return np.stack([radius * np.cos(a), radius * np.sin(a)], axis=1)


def straight(a: FloatArray, b: FloatArray) -> FloatArray:
    """Points from a to b, half a pixel apart or less, b left out."""
    count = max(math.ceil(2.0 * math.dist(a, b)), 2)
    return np.asarray(a + np.arange(count)[:, None] / count * (b - a))


@settings(max_examples=250, deadline=None)
@given(
    radius=st.floats(0.6, 40.0),
    sweep=st.floats(0.05, math.tau - 0.01),
    gap_px=st.none() | st.floats(0.05, 10.0),
    begin=st.floats(-math.pi, math.pi),
    clockwise=st.booleans(),
    way=st.sampled_from(WAYS),
    noise=st.floats(0.0, 0.4),
    seed=st.integers(0, 1000),
)
def test_an_outline_strays_where_dense_samples_say_so(
    radius, sweep, gap_px, begin, clockwise, way, noise, seed
) -> None:
    if gap_px is not None:  # nearly a whole circle, whose ends are near each other
        sweep = max(math.tau - gap_px / radius, 0.05)
    turn = sweep if clockwise else -sweep  # y points down
    first = radius * np.array([math.cos(begin), math.sin(begin)])
    last = radius * np.array([math.cos(begin + turn), math.sin(begin + turn)])
    arc = arc_points(radius, begin, turn)
    chord = straight(last, first)
    beside = arc
    if way == "the other way":
        beside = arc_points(radius, begin, turn - math.copysign(math.tau, turn))
    elif way == "straight":
        beside = straight(first, last)
    elif way == "along, and back a little":
        third = len(arc) // 3
        beside = np.concatenate([arc[: 2 * third], arc[2 * third : third : -1], arc[third:]])
    elif way == "along, with a gap":
        beside = np.concatenate([arc[: len(arc) // 4 + 1], arc[3 * len(arc) // 4 :]])
    points = np.concatenate([beside, chord])
    points = points + np.random.default_rng(seed).normal(0.0, noise, points.shape).clip(-1.0, 1.0)
    doubled = np.concatenate([points, points, points[:1]])
    border = BorderPoints(doubled[:, 0].copy(), doubled[:, 1].copy(), len(points))
    rows = np.zeros((2, 6))
    rows[0, :5] = *first, 0.0, 0.0, radius
    rows[1, :2] = last
    kinds = np.array([ARC_CW if clockwise else ARC_CCW, LINE], np.int8)
    finished = FinishedEdges(kinds, rows, np.array([0, len(beside)], np.int64))

    strays = outline_strays(border, finished, 2)

    outline = np.concatenate([arc, chord])
    left_out = float(off(along(points), outline).max())
    beyond = float(off(along(outline), points).max())
    if beyond > STRAY_PX + LONGEST_TIP_PX or left_out > 2.0 * STRAY_PX:
        assert strays, (left_out, beyond)
    if way == "along" and max(left_out, beyond) < 0.5 * STRAY_PX:
        assert not strays, (left_out, beyond)

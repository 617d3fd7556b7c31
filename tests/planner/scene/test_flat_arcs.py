"""Arcs of any radius: distances and paths keep what they promise, by an oracle of 60 digits."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest

import planner
from planner.path import Path
from planner.scene import Arc, ArcRecord, Bounds, Scene, SceneObject
from planner.scene.primitive_kernels import distance, with_middles

RADII = [10.0**k for k in range(-2, 16)]
DIGITS = 60


def _height(chord: float, radius: float) -> float:
    """How far the middle of the shorter arc over a chord is from it."""
    half = 0.5 * chord
    return half * half / (radius + math.sqrt((radius - half) * (radius + half)))


def _arc(start: tuple[float, float], end: tuple[float, float], radius: float, ccw: bool) -> Arc:
    """The shorter arc over a chord, ``ccw`` with y up; its centre rounded, as a file has it."""
    with localcontext(prec=DIGITS):
        x, y = _centre(start, end, radius, ccw)
    return Arc(start, end, (float(x), float(y)), radius, ccw)


def _centre(
    start: tuple[float, float], end: tuple[float, float], radius: float, ccw: bool
) -> tuple[Decimal, Decimal]:
    (x0, y0), (x1, y1) = ((Decimal(x), Decimal(y)) for x, y in (start, end))
    dx, dy, side = x1 - x0, y1 - y0, Decimal(1 if ccw else -1)
    square = dx * dx + dy * dy
    off = side * (max(Decimal(radius) ** 2 / square - Decimal("0.25"), Decimal(0))).sqrt()
    return (x0 + x1) / 2 - off * dy, (y0 + y1) / 2 + off * dx


def true_distance(arc: Arc, x: float, y: float) -> float:
    """The distance from a place to the arc of that radius through its ends, by 60 digits."""
    with localcontext(prec=DIGITS):
        cx, cy = _centre(arc.start, arc.end, arc.radius, arc.ccw)
        px, py = Decimal(x) - cx, Decimal(y) - cy
        ends = [(Decimal(a) - cx, Decimal(b) - cy) for a, b in (arc.start, arc.end)]
        (ax, ay), (bx, by) = ends if arc.ccw else ends[::-1]
        if ax * py - ay * px >= 0 and px * by - py * bx >= 0:
            return float(abs((px * px + py * py).sqrt() - Decimal(arc.radius)))
        return float(min(((px - u) ** 2 + (py - v) ** 2).sqrt() for u, v in ends))


def _scene(extent: float, *edges: Arc) -> Scene:
    return Scene("m", Bounds(0.0, 0.0, extent, extent), (SceneObject(0, (ArcRecord(edges),)),))


@pytest.mark.parametrize("radius", RADII)
def test_distances_to_arcs_of_any_radius_are_true_to_a_ten_thousand_millionth_of_the_arena(
    radius: float,
) -> None:
    rng = np.random.default_rng(round(math.log10(radius)) + 2)
    for _ in range(12):
        chord = min(10.0 ** rng.uniform(-1.0, 2.0), 1.9 * radius)
        extent = chord * rng.uniform(1.2, 4.0)
        angle, ccw = rng.uniform(0.0, math.tau), bool(rng.random() < 0.5)
        step = 0.5 * chord * np.array([math.cos(angle), math.sin(angle)])
        middle = np.full(2, 0.5 * extent)
        arc = _arc(tuple((middle - step).tolist()), tuple((middle + step).tolist()), radius, ccw)
        flat = _scene(extent, arc).primitives(include_bounds=False)
        rows = with_middles(np.array(flat.kind), np.array(flat.data))
        for x, y in rng.uniform(0.0, extent, (25, 2)).tolist():
            found = min(distance(np.array(flat.kind), rows, i, x, y) for i in range(len(rows)))
            assert abs(found - true_distance(arc, x, y)) <= 1.5e-10 * extent


@pytest.mark.parametrize("radius", [1e6, 1e8, 1e10, 1e12, 1e15])
@pytest.mark.parametrize("ccw", [False, True])
def test_a_path_past_a_nearly_straight_arc_keeps_the_radius_that_it_reports(
    radius: float, ccw: bool
) -> None:
    """The wall is 8 m long; one path runs along it, another round its end."""
    arc = _arc((1.0, 3.0), (9.0, 4.0), radius, ccw)
    roadmap = planner.build_roadmap(_scene(10.0, arc), 0.3)
    for start, goal in (((2.0, 3.44), (8.0, 4.19)), ((2.0, 2.0), (2.0, 5.0))):
        path = roadmap.plan(start, goal, prefer=0.0)
        assert isinstance(path, Path)
        parts = np.linspace(path.points[:-1], path.points[1:], 20).reshape(-1, 2)
        true = min(true_distance(arc, x, y) for x, y in parts.tolist())
        assert true >= 0.3 * (1.0 - 4e-9)
        assert path.min_clearance <= true + 1.5e-9


def test_a_whole_circle_and_far_arcs_take_few_chords() -> None:
    """A circle of any size that comes into the bounds is followed there, and roughly elsewhere."""
    for radius in (1e7, 1e9, 1e12):
        circle = Arc((5.0, 3.0), (5.0, 3.0), (5.0, 3.0 - radius), radius, ccw=True)
        flat = _scene(10.0, circle).primitives(include_bounds=False)
        assert len(flat.kind) < 300
        ends = flat.data.reshape(-1, 3, 2)[:, :2]
        assert (ends[1:, 0] == ends[:-1, 1]).all()
        assert (ends[0, 0] == ends[-1, 1]).all()
        rows = with_middles(np.array(flat.kind), np.array(flat.data))
        for x in (0.5, 5.0, 9.0):
            found = min(distance(np.array(flat.kind), rows, i, x, 5.0) for i in range(len(rows)))
            with localcontext(prec=DIGITS):
                dx, dy = Decimal(x) - 5, Decimal(2) + Decimal(radius)
                true = float((dx * dx + dy * dy).sqrt() - Decimal(radius))
            assert abs(found - true) <= 1.5e-9 + math.ulp(radius)


def test_arcs_of_usual_radius_stay_arcs() -> None:
    flat = _scene(10.0, _arc((1.0, 3.0), (9.0, 3.0), 1e5, True)).primitives(include_bounds=False)
    assert len(flat.kind) == 1

"""The exact clearance against rational arithmetic: on one line but for an ulp, and anywhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

import planner
from planner.borders import clear_kernels
from planner.scene import (
    ARC,
    CIRCLE,
    POINT,
    SEGMENT,
    Bounds,
    FloatArray,
    SegmentRecord,
    primitive_kernels,
)
from tests.support.oracles.exact_distance import exact_distance
from tests.support.scenes.planner_scenes import scene_of

ROUNDINGS = 16.0 * 2.0**-52
"""What a distance may be off, in parts of the largest coordinate or radius."""


def _measured(kind: int, row: FloatArray, a: FloatArray, b: FloatArray) -> tuple[float, float]:
    kinds = np.array([kind], np.int8)
    data = primitive_kernels.with_middles(kinds, np.atleast_2d(row))
    found, at = primitive_kernels.segment_distance(kinds, data, 0, *a, *b)
    return float(found), float(at)


def _nudged(rng: np.random.Generator, place: FloatArray) -> FloatArray:
    """The place, each coordinate up to an ulp off."""
    ulps = rng.integers(-1, 2, 2)
    return np.array([v + u * math.ulp(v) for v, u in zip(place.tolist(), ulps, strict=True)])


def _on_one_line(rng: np.random.Generator) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A wall's row and a segment on its line but for an ulp: beside, across, within, touching."""
    scale = 10.0 ** float(rng.uniform(-3, 6))
    if rng.random() < 0.5:  # tenths: on a diagonal, upright, level, or any direction
        a, d = rng.integers(-80, 80, 2) / 10.0, rng.integers(-30, 31, 2) / 10.0
        d = d[[0, 0]] if rng.random() < 0.3 else d
    else:
        a, d = rng.uniform(-8.0, 8.0, (2, 2))
    if not d.any():
        d = np.array([3.0, 3.0])
    s, t = rng.choice([rng.uniform(-2.0, 3.0), 0.0, 1.0, -0.05, 1.05, 0.5], 2)
    wall = np.concatenate([a, a + d])
    ends = [_nudged(rng, a + s * d), _nudged(rng, a + t * d)]
    if rng.random() < 0.3:  # the line's extension is touched only
        ends[1] = rng.uniform(-8.0, 8.0, 2)
    return np.concatenate([scale * wall, [0.0, 0.0]]), scale * ends[0], scale * ends[1]


def test_on_one_line_but_for_an_ulp_distances_are_those_of_rational_arithmetic() -> None:
    rng = np.random.default_rng(1)
    wrong = 0
    for _ in range(20_000):
        row, a, b = _on_one_line(rng)
        size = max(np.abs(row).max(), np.abs(a).max(), np.abs(b).max())
        found, at = _measured(SEGMENT, row, a, b)
        off = abs(found - exact_distance(a, b, SEGMENT, row))
        there = a + at * (b - a)
        away = primitive_kernels.point_to_segment(*there, *row[:4])[0]
        wrong += not (off <= ROUNDINGS * size and abs(away - found) <= ROUNDINGS * size)
    assert wrong == 0


def _anything(rng: np.random.Generator) -> tuple[int, FloatArray, FloatArray, FloatArray]:
    """A primitive of any kind, and a segment near it: long, short, tangent, through its ends."""
    scale = 10.0 ** float(rng.uniform(-3, 6))
    kind = int(rng.choice([POINT, SEGMENT, CIRCLE, ARC, ARC]))
    row = np.zeros(6)
    row[:2] = rng.uniform(-8.0, 8.0, 2)
    marks = [row[:2].copy()]
    if kind == SEGMENT:
        row[2:4] = rng.uniform(-8.0, 8.0, 2)
        marks.append(row[2:4].copy())
    if kind in (CIRCLE, ARC):
        row[2] = float(rng.choice([rng.uniform(0.01, 8.0), 1.0, 2.5]))
    if kind == ARC:
        row[3] = float(rng.choice([rng.uniform(-7.0, 7.0), 0.0, 0.5 * math.pi]))
        width = [rng.uniform(0.0, math.tau), 1e-7, math.pi, 0.5 * math.pi, math.tau - 1e-7]
        row[4] = float(rng.choice(width))
        past = float(rng.choice([1e-9, 3e-9, 1e-5]))
        for angle in (row[3], row[3] + row[4], row[3] + 0.5 * row[4], row[3] + row[4] + past):
            marks.append(row[:2] + row[2] * np.array([math.cos(angle), math.sin(angle)]))
    a, b = rng.uniform(-8.0, 8.0, (2, 2))
    turn = rng.random()
    if turn < 0.3:  # an end on a mark, or nearly
        a = _nudged(rng, marks[int(rng.integers(len(marks)))])
    elif turn < 0.5 and kind in (CIRCLE, ARC):  # a tangent, or nearly
        angle = float(rng.uniform(0.0, math.tau))
        out = np.array([math.cos(angle), math.sin(angle)])
        at, along = row[:2] + row[2] * out, np.array([-out[1], out[0]])
        a, b = at - rng.uniform(0.0, 3.0) * along, at + rng.uniform(0.0, 3.0) * along
    if rng.random() < 0.15:
        b = a + rng.uniform(-1.0, 1.0, 2) * float(rng.choice([0.0, 1e-9, 1e-3]))
    row[:3] *= scale
    if kind == SEGMENT:
        row[3] *= scale
    return kind, row, scale * a, scale * b


def test_distances_in_any_position_are_those_of_fifty_digits() -> None:
    rng = np.random.default_rng(2)
    wrong = []
    for _ in range(6_000):
        kind, row, a, b = _anything(rng)
        size = max(np.abs(row[:3]).max(), np.abs(a).max(), np.abs(b).max())
        found, _ = _measured(kind, row, a, b)
        off = abs(found - exact_distance(a, b, kind, row)) / size
        if off > ROUNDINGS:
            wrong.append((off, kind, row, a, b))
    assert not wrong


@pytest.mark.parametrize("turned", [False, True])
def test_a_path_on_the_extension_of_a_wall_is_as_far_as_its_end(turned: bool) -> None:
    scene = scene_of(SegmentRecord((3.7, 3.7), (0.7, 0.7)), bounds=Bounds(0.0, 0.0, 8.0, 8.0))
    roadmap = planner.build_roadmap(scene, 0.1)
    for end in np.linspace(3.75, 7.0, 200):
        line = np.array([(end, end), (7.5, 7.5)])[:: -1 if turned else 1]
        want = min(math.hypot(end - 3.7, end - 3.7), 0.5)
        assert roadmap.path_clearance(line).distance == pytest.approx(want, abs=1e-12)
        keeps = clear_kernels.keeps(roadmap.borders.tree, np.ascontiguousarray(line), want - 1e-9)
        assert keeps

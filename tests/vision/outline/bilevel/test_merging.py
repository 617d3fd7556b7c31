"""Runs of edges without grey become one line or one arc, and no pixel is lost by it.

Rules and units
- The oracle draws an outline again by itself: which pixels' centres lie inside, by counting the
  crossings of a ray. Pixels, y down.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.scene import Arc, FloatArray, PolygonRecord
from tests.vision.outline.bilevel.test_separating_chords import (
    borders_of,
    cracks_of,
    only_record,
    picture,
    random_walls,
    speckled,
)
from tests.vision.outline.test_area_lost import blob, drawn_by_opencv, ellipse, rings, star
from vision import extract
from vision.outline.bilevel.merged_edge_kernels import line_between
from vision.outline.bilevel.merging_kernels import merge_edges
from vision.outline.bilevel.separating_chord_kernels import all_chords
from vision.outline.fitted_borders import ARC_CW, LINE
from vision.outline.outline_types import Cracks, FinishedEdges, Scratch

SHAPES = {
    "ellipse": ellipse, "blob": blob, "star": star, "rings": rings, "walls": random_walls,
    "speckled": speckled, "drawn": drawn_by_opencv,
}  # fmt: skip
HAIR_PX = 1e-6
"""A pixel's centre so near to an edge is on neither side: rounding."""


def space_for(n: int) -> tuple[FinishedEdges, FinishedEdges, FloatArray, Scratch]:
    """Space for as many edges as cracks, twice, a circle, and what steps work in."""
    edges = [
        FinishedEdges(np.zeros(n + 1, np.int8), np.zeros((n + 1, 6)), np.zeros(n + 1, np.int64))
        for _ in range(2)
    ]
    row = 2 * n + 3
    scratch = Scratch(
        np.empty((7, row)), np.empty((7, row), np.int64), np.empty((5, row), np.bool_),
        np.empty((n + 1, 2), np.int64), np.empty((2 * n + 8, 8)),
    )  # fmt: skip
    return edges[0], edges[1], np.empty(3), scratch


def outline_of(edges: FinishedEdges, count: int) -> FloatArray:
    """The outline as a polyline, arcs by points a thousandth of a pixel off."""
    points = []
    for i in range(count):
        a, b = edges.rows[i, :2], edges.rows[(i + 1) % count, :2]
        points.append(a[None])
        if edges.kind[i] != LINE:
            center, r = edges.rows[i, 2:4], edges.rows[i, 4]
            begin, end = (math.atan2(*(p - center)[::-1]) for p in (a, b))
            grows = edges.kind[i] == ARC_CW  # y points down
            turn = (end - begin) % math.tau if grows else -((begin - end) % math.tau)
            steps = max(2, math.ceil(abs(turn) / math.sqrt(8e-3 / max(r, 1.0))))
            angles = begin + turn * np.arange(1, steps) / steps
            points.append(center + r * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return np.concatenate(points)


def inside(outline: FloatArray, x: FloatArray, y: FloatArray) -> np.ndarray:
    """Which places lie inside a closed polyline."""
    found = np.zeros(x.shape, bool)
    for (ax, ay), (bx, by) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if ay != by:
            beside = (ay > y) != (by > y)
            found ^= beside & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    return found


def pixels_lost(cracks: Cracks, edges: FinishedEdges, count: int) -> int:
    """How many pixels beside the cracks an outline takes for what they are not."""
    n = cracks.n
    outline = outline_of(edges, count)
    lost = set()
    for side in (-1.0, 1.0):
        x = cracks.x[:n] + side * cracks.free_x[:n]
        y = cracks.y[:n] + side * cracks.free_y[:n]
        # an outline of an object has its obstacle pixels inside
        wrong = inside(outline, x, y) != (side < 0.0)
        lost |= set(zip(x[wrong].tolist(), y[wrong].tolist(), strict=True))
    return len(lost)


@pytest.mark.parametrize("name", SHAPES)
def test_merged_chords_are_fewer_and_lose_no_pixel(name: str) -> None:
    merged = 0
    for seed in range(6):
        borders = borders_of(SHAPES[name](np.random.default_rng([83, seed])))
        for b in range(len(borders.area)):
            cracks = cracks_of(borders, b)
            if borders.area[b] < 12:
                continue
            edges, trial, circle, scratch = space_for(cracks.n)
            before = all_chords(cracks, edges, np.empty(cracks.n + 2, np.int64))
            after = merge_edges(cracks, edges, before, False, trial, circle, scratch)
            assert 2 <= after <= before
            merged += before - after
            assert pixels_lost(cracks, edges, after) == 0, f"seed {seed}, border {b}"
            at = edges.at[:after]
            turns = np.diff(np.append(at, at[0])) % cracks.n
            assert (turns > 0).all()
            assert turns.sum() == cracks.n  # once around
    assert merged > 0


@settings(max_examples=300, deadline=None)
@given(
    angle=st.floats(0.0, math.tau),
    length=st.integers(2, 80),
    shift=st.floats(0.0, 1.0),
    nibs=st.integers(0, 2),
    seed=st.integers(0, 1000),
)
def test_no_line_passes_between_pixels_with_more_room(
    angle: float, length: int, shift: float, nibs: int, seed: int
) -> None:
    """Against every slope of a fine grid; the gap that is told is there."""
    rng = np.random.default_rng(seed)
    u = np.array([math.cos(angle), math.sin(angle)])
    level = abs(u[0]) > abs(u[1])
    along = np.arange(length) * (math.copysign(1.0, u[0]) if level else math.copysign(1.0, u[1]))
    across = np.floor(along * (u[1] / u[0] if level else u[0] / u[1]) + shift)
    across[rng.integers(0, length, nibs)] += rng.choice([-1.0, 1.0], nibs)
    free = np.array([0.0, -math.copysign(0.5, u[0])] if level else [math.copysign(0.5, u[1]), 0.0])
    # a crack's middle lies between its obstacle pixel and the free one, left of the way
    middle = np.stack([along, across] if level else [across, along], axis=1) + free
    x, y = middle.T.copy()
    cracks = Cracks(x, y, np.full(length, free[0]), np.full(length, free[1]), length)
    gap, x, y, vx, vy = line_between(cracks, 0, length)
    way = middle[-1] - middle[0]
    way /= np.hypot(*way)
    normal = np.array([way[1], -way[0]])
    bright, dark = middle + free - middle[0], middle - free - middle[0]

    tilts = np.linspace(-0.5, 0.5, 2001)[:, None]
    heights = [side @ normal - tilts * (side @ way) for side in (bright, dark)]
    best = float((heights[0].min(axis=1) - heights[1].max(axis=1)).max())
    if best < 0.0:
        assert gap < 1e-3
        return
    assert gap >= best - 2e-3
    heights = [(p + middle[0] - (x, y)) @ np.array([vy, -vx]) for p in (bright, dark)]
    tilt = (vx * normal[0] + vy * normal[1]) / (vx * way[0] + vy * way[1])
    half = 0.5 * gap / math.sqrt(1.0 + tilt * tilt)
    assert heights[0].min() >= half - 1e-9
    assert heights[1].max() <= -half + 1e-9


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    begin=st.tuples(st.integers(30, 70), st.integers(30, 170)),
    end=st.tuples(st.integers(110, 170), st.integers(30, 170)),
    width=st.integers(3, 20),
)
def test_a_wall_drawn_as_a_thick_line_has_long_sides(
    begin: tuple[int, int], end: tuple[int, int], width: int
) -> None:
    """Its sides once were 20 to 58 chords with jogs, for its round ends lost more than it may."""
    mask = np.zeros((200, 200), np.uint8)
    cv2.line(mask, begin, end, 1, width)
    record = only_record(mask > 0)
    assert isinstance(record, PolygonRecord)
    length = math.dist(begin, end)
    lengths = sorted((math.dist(e.start, e.end) for e in record.edges), reverse=True)
    assert sum(lengths[:4]) > 1.5 * length  # two sides, or each of them in two
    assert len(record.edges) <= 24


def test_a_polygon_drawn_by_opencv_has_hardly_more_sides_than_corners() -> None:
    """One of forty had 47."""
    rng = np.random.default_rng(5)
    more = []
    for _ in range(40):
        corners = int(rng.integers(3, 12))
        angles = np.sort(rng.uniform(0.0, math.tau, corners))
        vertices = 100.0 + rng.uniform(20, 90) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        mask = np.zeros((200, 200), np.uint8)
        cv2.fillPoly(mask, [np.rint(vertices).astype(np.int32)], 1)
        if np.count_nonzero(mask) < 100:
            continue
        records = [r for o in extract(picture(mask > 0)).objects for r in o.records]
        more.append(sum(len(getattr(r, "edges", (r,))) for r in records) - corners)
    assert max(more) <= 5
    assert np.mean(more) <= 1.0


def test_an_ellipse_without_grey_is_a_dozen_arcs_at_most() -> None:
    """They were up to 37 edges, where a search stopped at chords."""
    for i in range(12):
        record = only_record(ellipse(np.random.default_rng([7, i])))
        if isinstance(record, PolygonRecord):
            arcs = sum(isinstance(e, Arc) for e in record.edges)
            assert len(record.edges) <= 16
            assert arcs >= 2

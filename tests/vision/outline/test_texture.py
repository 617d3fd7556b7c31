"""Outlines without texture: what they enclose, how much they grow, and when they stay as they are.

Rules and units
- Pixels, centres at integers, y down. The oracles are the mask's own pixels and whether a point is
  in a polygon; how an outline was found plays no part.
"""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from planner.scene import CircleRecord, PolygonRecord, Scene
from vision import PictureError, extract
from vision.binarise.colour import binarise_by_colour
from vision.borders.contours import follow_borders, locate_edges
from vision.outline.fitted_borders import CIRCLE, FittedBorders
from vision.outline.texture import without_texture
from vision.shared.scratch import Room

Mask = NDArray[np.bool_]
CORNER_PX = np.sqrt(0.5)
"""From a pixel's centre to its corner: a border runs between centres of pixels."""
ROUNDED_PX = 1e-3
"""OpenCV's polygons have single precision, and a circle is one of 720 sides."""
FINE = 3
"""Samples a pixel."""
MANY = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def picture_of(mask: Mask) -> NDArray[np.uint8]:
    return np.where(mask, 25, 235).astype(np.uint8)


def ragged(seed: int, size: int = 90) -> Mask:
    """Bars, discs and a frame with a hole, their borders with pixels added at random."""
    rng = np.random.default_rng(seed)
    mask = np.zeros((size, size), np.uint8)
    for _ in range(int(rng.integers(1, 5))):
        centre = tuple(int(v) for v in rng.integers(15, size - 15, 2))
        if rng.random() < 0.5:
            sides = tuple(float(v) for v in rng.integers(8, 60, 2))
            box = cv2.boxPoints((centre, sides, float(rng.uniform(0, 90))))
            cv2.fillPoly(mask, [np.round(box).astype(np.int32)], 1)
        else:
            cv2.circle(mask, centre, int(rng.integers(5, 30)), 1, -1)
    if rng.random() < 0.5:
        cv2.circle(mask, (size // 2, size // 2), int(rng.integers(4, 20)), 0, -1)
    for _ in range(int(rng.integers(1, 3))):
        rim = cv2.dilate(mask, np.ones((3, 3), np.uint8)) - mask
        mask |= rim & (rng.random(mask.shape) < rng.uniform(0.2, 0.8)).astype(np.uint8)
    return mask > 0


class Outlines:
    """All borders of a picture without texture, as polygons; a drawing's are along its cracks."""

    def __init__(self, picture: NDArray[np.uint8], texture_px: float, *, drawn: bool) -> None:
        binary = binarise_by_colour(
            picture,
            polarity="dark",
            method="fixed",
            threshold=128,
            ignore=None,
            room=Room(),
        )
        self.borders = follow_borders(binary.mask)
        edges = locate_edges(binary, self.borders)
        self.points = self.borders.middles if drawn else edges.points.copy()
        self.starts = self.borders.starts if drawn else edges.starts
        count = len(self.starts) - 1
        # as many edges as points: what has fewer takes their place
        rows = np.column_stack([self.points, np.zeros((len(self.points), 4))])
        every = FittedBorders(
            np.zeros(count, np.int8), self.starts, np.zeros(len(rows), np.int8), rows
        )
        self.fitted, _ = without_texture(
            every, self.points, self.starts, self.borders.owner, np.ones(count), texture_px
        )

    def polygon(self, border: int) -> NDArray[np.float32]:
        first, last = self.fitted.edge_starts[border : border + 2]
        rows = self.fitted.data[first:last]
        if self.fitted.border_kind[border] == CIRCLE:
            turn = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
            rim = rows[0, 4] * np.column_stack([np.cos(turn), np.sin(turn)])
            return (rows[0, 2:4] + rim).astype(np.float32)
        return rows[:, :2].astype(np.float32)

    def share_of(self, points: NDArray[np.float64]) -> NDArray[np.int64]:
        """How many objects hold each point."""
        count = np.zeros(len(points), np.int64)
        for b, owner in enumerate(self.borders.owner.tolist()):
            rim = self.polygon(b)
            count += np.where(is_inside(rim, points), 1 if owner == b else -1, 0)
        return count


def is_inside(rim: NDArray[np.float32], points: NDArray[np.float64]) -> Mask:
    """Whether a ray from each point, sorted by y, crosses the rim an odd number of times."""
    odd = np.zeros(len(points), np.bool_)
    x, y = points.T
    begins = np.searchsorted(y, rim[:, 1].astype(np.float64))
    nexts = (np.roll(one, -1, axis=0).tolist() for one in (rim, begins))
    for (ax, ay), begin, (bx, by), end in zip(rim.tolist(), begins.tolist(), *nexts, strict=True):
        # the points on whose height the edge runs
        beside = slice(min(begin, end), max(begin, end))
        if beside.start < beside.stop:
            odd[beside] ^= x[beside] < ax + (bx - ax) * (y[beside] - ay) / (by - ay)
    return odd


@MANY
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.5, 1.0, 1.7, 3.0, 5.0]))
def test_every_pixel_of_an_obstacle_stays_inside_its_outline(seed: int, texture_px: float) -> None:
    mask = ragged(seed)
    pixels = np.argwhere(mask)[:, ::-1].astype(np.float64)
    outlines = Outlines(picture_of(mask), texture_px, drawn=True)
    assert (outlines.share_of(pixels) == 1).all()


@settings(MANY, max_examples=12)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.5, 1.0, 1.7, 3.0, 5.0]))
def test_nothing_farther_than_the_tolerance_is_added_and_no_two_meet(
    seed: int, texture_px: float
) -> None:
    mask = ragged(seed, size=70)
    outlines = Outlines(picture_of(mask), texture_px, drawn=True)
    samples = np.argwhere(np.ones([FINE * side for side in mask.shape]))[:, ::-1] / FINE
    held = outlines.share_of(samples)
    assert held.min() >= 0
    assert held.max() <= 1
    away, _ = cKDTree(np.argwhere(mask)[:, ::-1]).query(samples[held > 0])
    assert away.max() <= texture_px + CORNER_PX


@MANY
@example(1_209_451_408, 0.5, 3.0)  # noise crosses a border with itself
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.5, 1.0, 3.0]), st.floats(0.0, 4.0))
def test_every_edge_point_of_a_picture_with_grey_stays_behind_its_outline(
    seed: int, texture_px: float, noise: float
) -> None:
    blurred = cv2.GaussianBlur(picture_of(ragged(seed)), (0, 0), 1.0)
    grey = blurred + np.random.default_rng(seed).normal(0.0, noise, blurred.shape)
    outlines = Outlines(np.clip(grey, 0, 255).astype(np.uint8), texture_px, drawn=False)
    for b, owner in enumerate(outlines.borders.owner.tolist()):
        rim = outlines.polygon(b)
        sign = 1.0 if owner == b else -1.0
        for x, y in outlines.points[outlines.starts[b] : outlines.starts[b + 1]].tolist():
            depth = sign * cv2.pointPolygonTest(rim, (x, y), True)
            assert -ROUNDED_PX <= depth <= texture_px + ROUNDED_PX


def edges_of(scene: Scene) -> int:
    total = 0
    for obj in scene.objects:
        for record in (*obj.records, *(r for hole in obj.holes for r in hole)):
            total += len(record.edges) if isinstance(record, PolygonRecord) else 1
    return total


def toothed_t() -> NDArray[np.uint8]:
    """A T whose sides have teeth of one pixel, three wide and three apart."""
    mask = np.zeros((400, 400), np.uint8)
    cv2.rectangle(mask, (80, 80), (320, 140), 1, -1)
    cv2.rectangle(mask, (170, 140), (230, 330), 1, -1)
    rim = cv2.dilate(mask, np.ones((3, 3), np.uint8)) - mask
    ys, xs = np.nonzero(rim)
    along = np.where(np.isin(ys, (79, 141, 331)), xs, ys)
    tooth = (along // 3) % 2 == 0
    mask[ys[tooth], xs[tooth]] = 1
    return picture_of(mask > 0)


def test_teeth_a_pixel_high_are_texture_of_a_pixel() -> None:
    exact, simple = extract(toothed_t()), extract(toothed_t(), texture_px=1.0)
    assert edges_of(exact) > 300
    assert edges_of(simple) <= 16
    assert edges_of(extract(toothed_t(), texture_px=2.0)) <= 12
    (said,) = simple.remarks
    assert f"1 border has {edges_of(simple)} edges instead of {edges_of(exact)}" in said
    assert "up to 1 px larger there, and nowhere smaller" in said


def test_a_ragged_disc_is_a_circle_around_all_of_it() -> None:
    y, x = np.mgrid[:300, :300]
    turn = np.arctan2(y - 150, x - 150)
    mask = np.hypot(x - 150, y - 150) < np.where((turn * 50 // 1) % 2 == 0, 81, 80)
    scene = extract(picture_of(mask), texture_px=2.0)
    (record,) = scene.objects[0].records
    assert isinstance(record, CircleRecord)
    pixels = np.argwhere(mask)[:, ::-1]
    assert np.hypot(*(pixels - np.array(record.center)).T).max() < record.radius <= 83.0


def test_smooth_obstacles_are_exact_with_any_tolerance() -> None:
    picture = np.full((300, 400), 235, np.uint8)
    cv2.rectangle(picture, (40, 40), (140, 120), 25, -1)
    cv2.circle(picture, (280, 150), 70, 25, -1)
    picture = cv2.GaussianBlur(picture, (0, 0), 0.8)
    exact = extract(picture)
    for texture_px in (0.5, 2.0, 5.0):
        scene = extract(picture, texture_px=texture_px)
        assert scene.objects == exact.objects
        assert scene.remarks == ()


def test_a_gap_between_two_ragged_obstacles_stays_open() -> None:
    rng = np.random.default_rng(5)
    mask = np.zeros((120, 200), np.bool_)
    mask[20:56, 20:180] = mask[64:100, 20:180] = True
    mask[56, 20:180] = rng.random(160) < 0.5
    mask[63, 20:180] = rng.random(160) < 0.5
    scene = extract(picture_of(mask), texture_px=5.0)
    top, bottom = (obj.records[0] for obj in scene.objects)
    assert isinstance(top, PolygonRecord)
    assert isinstance(bottom, PolygonRecord)
    assert max(e.start[1] for e in top.edges) < min(e.start[1] for e in bottom.edges)


@pytest.mark.parametrize("texture_px", [-1.0, 5.5, float("nan")])
def test_a_tolerance_out_of_its_limits_is_refused(texture_px: float) -> None:
    with pytest.raises(PictureError, match=r"texture_px .*: must be in 0\.\.5"):
        extract(toothed_t(), texture_px=texture_px)


def test_the_papers_recipe_knows_no_texture() -> None:
    with pytest.raises(PictureError, match="mode paper: works without texture_px"):
        extract(toothed_t(), mode="paper", texture_px=1.0)

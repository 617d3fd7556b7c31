"""Objects that meet the picture's edge end there: its bounds are walls."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from planner.scene import Arc, CircleRecord, PolygonRecord, Segment, object_records
from tests.support.drawn.render import outline_points
from vision import extract
from vision.records.clipping import clip_circle, clip_polygon

SIDE = 80
BOUNDS = (-0.5, -0.5, 79.5, 79.5)


def area_of(record: PolygonRecord) -> float:
    x, y = outline_points(record, 1e-4).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize("seed", [30, 108, 176, 206, 268])
def test_no_outline_leaves_the_picture(seed: int) -> None:
    rng = np.random.RandomState(seed)
    blobs = cv2.GaussianBlur(rng.randn(SIDE, SIDE), (0, 0), rng.uniform(1, 4))
    grey = 128 + (blobs - np.quantile(blobs, 0.35)) / blobs.std() * 60
    scene = extract(np.clip(grey, 0, 255).astype(np.uint8), method="otsu")
    for one in scene.objects:
        for record in object_records(one):
            if isinstance(record, PolygonRecord):
                points = outline_points(record)
                assert points.min() >= -0.5 - 0.02
                assert points.max() <= SIDE - 0.5 + 0.02


def test_a_disc_that_the_edge_cuts_is_an_arc_and_its_chord() -> None:
    disc = CircleRecord((5.0, 40.0), 10.0, 0.1)
    cut = clip_circle(disc, BOUNDS)
    assert isinstance(cut, PolygonRecord)
    arcs = [e for e in cut.edges if isinstance(e, Arc)]
    assert all(a.center == disc.center and a.radius == disc.radius for a in arcs)
    half = math.acos(5.5 / 10.0)
    beyond = 100.0 * (half - math.sin(half) * math.cos(half))
    assert abs(area_of(cut) - (math.pi * 100.0 - beyond)) < 0.01
    assert all(
        a.end == b.start for a, b in zip(cut.edges, [*cut.edges[1:], cut.edges[0]], strict=True)
    )


def test_a_corner_beyond_two_sides_is_cut_at_both() -> None:
    places = [(-3.0, -2.0), (20.0, -2.0), (20.0, 20.0), (-3.0, 20.0)]
    edges = tuple(Segment(a, b) for a, b in zip(places, [*places[1:], places[0]], strict=True))
    cut = clip_polygon(PolygonRecord(edges), BOUNDS)
    assert sorted(e.start for e in cut.edges) == [
        (-0.5, -0.5), (-0.5, 20.0), (20.0, -0.5), (20.0, 20.0),
    ]  # fmt: skip
    assert area_of(cut) == pytest.approx(20.5 * 20.5)


def test_an_outline_inside_stays_what_it_is() -> None:
    places = [(-0.505, 5.0), (20.0, 5.0), (20.0, 20.0)]
    edges = tuple(Segment(a, b) for a, b in zip(places, [*places[1:], places[0]], strict=True))
    record = PolygonRecord(edges)
    assert clip_polygon(record, BOUNDS) is record


def test_a_cut_outline_is_closed_to_the_last_bit() -> None:
    rng = np.random.default_rng(1)
    cut = 0
    for _ in range(300):
        turns = np.sort(rng.uniform(0.0, math.tau, int(rng.integers(3, 9))))
        around = np.column_stack([np.cos(turns), np.sin(turns)]) * rng.uniform(2.0, 40.0)
        points = around + rng.uniform(-10.0, 90.0, 2)
        near = rng.random(points.shape) < 0.2
        points[near] = -0.5 + rng.choice([0.0, 1e-16, 1e-10, -1e-10], int(near.sum()))
        places = [(float(x), float(y)) for x, y in points]
        edges = tuple(
            Segment(a, b) for a, b in zip(places, [*places[1:], places[0]], strict=True) if a != b
        )
        record = PolygonRecord(edges)
        edges = clip_polygon(record, BOUNDS).edges
        cut += edges != record.edges
        assert all(a.end == b.start for a, b in zip(edges, [*edges[1:], edges[0]], strict=True))
    assert cut > 100

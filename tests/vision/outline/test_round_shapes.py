"""Round shapes as a calm camera sees them: real arcs, even where they end in a cusp."""

from __future__ import annotations

import math

import numpy as np
import pytest

from planner.scene import Arc, PolygonRecord, Segment, object_records
from tests.support.drawn.render import Points, coverage, draw, outline_points, polygon, rounded
from vision import extract

SIZE = 200, 200


def crescent(rng: np.random.Generator) -> PolygonRecord:
    """What a disc leaves of another one of the same radius beside it."""
    radius = float(rng.uniform(40.0, 80.0))
    apart = float(rng.uniform(0.3, 0.8)) * radius
    angle = float(rng.uniform(0.0, math.tau))
    x, y = (float(v) for v in rng.uniform(95.0, 105.0, 2))
    half = math.acos(0.5 * apart / radius)
    cusps = [
        (x + radius * math.cos(angle + s * half), y + radius * math.sin(angle + s * half))
        for s in (1.0, -1.0)
    ]
    other = (x + apart * math.cos(angle), y + apart * math.sin(angle))
    outer = Arc(cusps[0], cusps[1], (x, y), radius, ccw=False)
    inner = Arc(cusps[1], cusps[0], other, radius, ccw=True)
    return PolygonRecord((outer, inner))


def test_a_crescent_is_two_arcs() -> None:
    """Its cusps are rounded far back; it once fell to chords, ends on whole numbers."""
    whole = 0
    for seed in range(20):
        rng = np.random.default_rng([91, seed])
        truth = crescent(rng)
        (only,) = extract(draw([truth], SIZE, blur=0.7, rng=rng)).objects
        (record,) = only.records
        assert isinstance(record, PolygonRecord)
        if len(record.edges) != 2:
            continue
        whole += 1
        for edge in record.edges:
            assert isinstance(edge, Arc)
            near = min(math.dist(edge.center, t.center) for t in truth.edges if isinstance(t, Arc))
            assert near < 0.5, f"seed {seed}"
    assert whole >= 18


def test_an_ellipse_of_a_calm_camera_is_covered() -> None:
    """What an arc missed within its tolerance was once too much, and chords missed more."""
    overlaps = []
    for seed in range(24):
        rng = np.random.default_rng([93, seed])
        a, b = rng.uniform(40.0, 80.0), rng.uniform(14.0, 30.0)
        turn, at = rng.uniform(0.0, math.tau), rng.uniform(95.0, 105.0, 2)
        t = np.linspace(0.0, math.tau, 400, endpoint=False)
        u, v = a * np.cos(t), b * np.sin(t)
        outline = at + np.stack(
            [u * math.cos(turn) - v * math.sin(turn), u * math.sin(turn) + v * math.cos(turn)],
            axis=1,
        )
        truth = coverage([outline], SIZE) >= 0.5
        scene = extract(draw([polygon(outline)], SIZE, blur=0.7, rng=rng))
        outlines = [
            outline_points(r, 0.01)
            for o in scene.objects
            for r in object_records(o)
            if isinstance(r, PolygonRecord)
        ]
        drawn = coverage(outlines, SIZE) >= 0.5
        overlaps.append((truth & drawn).sum() / (truth | drawn).sum())
    # once 0.9901 at the least, and 8 of 24
    assert min(overlaps) >= 0.991
    assert sum(overlap >= 0.995 for overlap in overlaps) >= 14


def point(xy: Points) -> tuple[float, float]:
    return float(xy[0]), float(xy[1])


def rectangle(rng: np.random.Generator, half: Points) -> Points:
    """The vertices of a turned rectangle, clockwise on the screen."""
    turn, at = rng.uniform(0.0, math.tau), rng.uniform(95.0, 105.0, 2)
    c, s = math.cos(turn), math.sin(turn)
    signs = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    vertices: Points = signs * half @ np.array([(c, s), (-s, c)]) + at
    return vertices


@pytest.mark.parametrize(("blur", "noise"), [(0.7, 0.0), (1.5, 0.0), (0.7, 5.0)])
def test_a_rounded_rectangle_is_four_lines_and_four_arcs(blur: float, noise: float) -> None:
    """Small arcs once were chords, whose joints left out all that lay off them: 1 px at most."""
    for seed in range(16):
        rng = np.random.default_rng([94, seed])
        radius = float(rng.uniform(8.0, 25.0))
        truth = rounded(rectangle(rng, rng.uniform(10.0, 50.0, 2)), radius)
        (only,) = extract(draw([truth], SIZE, blur=blur, noise=noise, rng=rng)).objects
        (record,) = only.records
        assert isinstance(record, PolygonRecord)
        assert len(record.edges) == 8, f"seed {seed}"
        arcs = [e for e in record.edges if isinstance(e, Arc)]
        assert len(arcs) == 4, f"seed {seed}"
        for arc in arcs:
            near = min(math.dist(arc.center, t.center) for t in truth.edges if isinstance(t, Arc))
            assert near < 0.7, f"seed {seed}"
            assert abs(arc.radius - radius) < 0.7, f"seed {seed}"


@pytest.mark.parametrize("noise", [3.0, 10.0])
def test_the_straight_sides_of_a_stadium_are_one_edge_each(noise: float) -> None:
    """Some were two lines, or a flat arc: a break of the search lay beside the arc's end."""
    for seed in range(40):
        rng = np.random.default_rng([97, seed])
        radius = float(rng.uniform(8.0, 21.0))
        turn, at = rng.uniform(0.0, math.tau), rng.uniform(95.0, 105.0, 2)
        along = np.array([math.cos(turn), math.sin(turn)])
        across = np.array([-along[1], along[0]])
        ends = [
            at + x * along + y * radius * across
            for x, y in ((-15.0, -1.0), (15.0, -1.0), (15.0, 1.0), (-15.0, 1.0))
        ]
        truth = PolygonRecord(
            (
                Segment(point(ends[0]), point(ends[1])),
                Arc(point(ends[1]), point(ends[2]), point(at + 15.0 * along), radius, ccw=False),
                Segment(point(ends[2]), point(ends[3])),
                Arc(point(ends[3]), point(ends[0]), point(at - 15.0 * along), radius, ccw=False),
            )
        )
        (only,) = extract(draw([truth], SIZE, blur=0.7, noise=noise, rng=rng)).objects
        (record,) = only.records
        assert isinstance(record, PolygonRecord)
        assert len(record.edges) == 4, f"seed {seed}"
        assert sum(isinstance(edge, Arc) for edge in record.edges) == 2, f"seed {seed}"


@pytest.mark.parametrize("blur", [0.5, 0.7, 1.0])
def test_blur_makes_no_rounded_corner_larger(blur: float) -> None:
    """An arc that has to touch two lines moves four times as far as blur moves its border."""
    errors = []
    for seed in range(8):
        rng = np.random.default_rng([96, seed])
        radius = float(rng.uniform(8.0, 9.0))
        truth = rounded(rectangle(rng, rng.uniform(22.0, 30.0, 2)), radius)
        (only,) = extract(draw([truth], SIZE, blur=blur, rng=rng)).objects
        (record,) = only.records
        assert isinstance(record, PolygonRecord)
        errors += [e.radius - radius for e in record.edges if isinstance(e, Arc)]
    assert len(errors) == 32
    # once 0.12 at a blur of 0.7
    assert abs(np.mean(errors)) < 0.06


@pytest.mark.parametrize(("blur", "noise"), [(0.7, 0.0), (1.5, 0.0), (0.7, 10.0)])
def test_a_bevel_is_not_taken_for_a_rounded_corner(blur: float, noise: float) -> None:
    for seed in range(8):
        rng = np.random.default_rng([95, seed])
        corners = rectangle(rng, rng.uniform(30.0, 60.0, 2))
        cut = float(rng.uniform(6.0, 14.0))
        bevelled = []
        for i in range(4):
            for other in (corners[i - 1], corners[(i + 1) % 4]):
                along = (other - corners[i]) / math.dist(other, corners[i])
                bevelled.append(corners[i] + cut * along)
        picture = draw([polygon(bevelled)], SIZE, blur=blur, noise=noise, rng=rng)
        (only,) = extract(picture).objects
        (record,) = only.records
        assert isinstance(record, PolygonRecord)
        assert len(record.edges) == 8, f"seed {seed}"
        assert all(isinstance(edge, Segment) for edge in record.edges), f"seed {seed}"


@pytest.mark.parametrize("blur", [0.5, 0.7])
def test_the_flat_arcs_of_a_round_gear_are_arcs(blur: float) -> None:
    """Less than a pixel high, between sharp corners: half of them were once two chords."""
    for seed in range(3):
        rng = np.random.default_rng([seed, 83])
        teeth = int(rng.integers(6, 12))
        t = rng.uniform(0.0, math.tau) + np.arange(80 * teeth) * math.tau / (80 * teeth)
        r = np.where(np.arange(80 * teeth) % 80 < 40, 80.0, 60.0)
        outline = 100.0 + rng.uniform(-0.5, 0.5, 2) + np.stack([r * np.cos(t), r * np.sin(t)], 1)
        (only,) = extract(draw([polygon(outline)], SIZE, blur=blur, rng=rng)).objects
        (record,) = only.records
        assert isinstance(record, PolygonRecord)
        radii = sorted(e.radius for e in record.edges if isinstance(e, Arc))
        assert len(record.edges) == 4 * teeth, seed
        assert len(radii) == 2 * teeth, seed
        assert np.abs(np.array(radii[:teeth]) - 60.0).max() < 6.0
        assert np.abs(np.array(radii[teeth:]) - 80.0).max() < 6.0

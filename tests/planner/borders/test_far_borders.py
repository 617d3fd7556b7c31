"""Borders that reach far beyond the bounds: the same free space as where they end beside them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import planner
from planner.borders.generators import disc_around, gather_borders, place_generators
from planner.scene import (
    Arc,
    Bounds,
    CircleRecord,
    PolygonRecord,
    Record,
    Scene,
    SceneObject,
    Segment,
)

BOUNDS = Bounds(0.0, 0.0, 10.0, 10.0)
RADIUS = 0.2
FAR = [3e1, 1e3, 1e6]


def _scene(*records: Record) -> Scene:
    objects = tuple(SceneObject(i, (record,)) for i, record in enumerate(records))
    return Scene("m", BOUNDS, objects)


def _ring(*corners: tuple[float, float]) -> PolygonRecord:
    return PolygonRecord(tuple(map(Segment, corners, corners[1:] + corners[:1])))


def _half_plane(reach: float, slope: float = 0.0) -> PolygonRecord:
    """All below y = 3 + slope (x - 5), out to ``reach``."""
    left, right = -reach, reach
    return _ring(
        (left, -2.0 * reach),
        (left, 3.0 + slope * (left - 5.0)),
        (right, 3.0 + slope * (right - 5.0)),
        (right, -2.0 * reach),
    )


def _band(inner: float, outer: float) -> PolygonRecord:
    """An arch between two radii about (5, -inner + 3): its inner side comes into the bounds."""
    x, y = 5.0, 3.0 - outer
    a, b = (x - outer, y), (x + outer, y)
    c, d = (x + inner, y), (x - inner, y)
    return PolygonRecord(
        (
            Arc(a, b, (x, y), outer, ccw=False),
            Segment(b, c),
            Arc(c, d, (x, y), inner, ccw=True),
            Segment(d, a),
        )
    )


@pytest.mark.parametrize("slope", [0.0, 0.3])
@pytest.mark.parametrize("far", FAR)
def test_a_half_plane_is_planned_beside_however_far_it_reaches(far: float, slope: float) -> None:
    stations = (1.0, 6.0), (9.0, 6.0)
    near = planner.build_roadmap(_scene(_half_plane(14.0, slope)), RADIUS).plan(*stations)
    path = planner.build_roadmap(_scene(_half_plane(far, slope)), RADIUS).plan(*stations)
    assert isinstance(near, planner.Path)
    assert isinstance(path, planner.Path)
    assert path.length == pytest.approx(near.length, rel=1e-6)
    assert path.min_clearance == pytest.approx(near.min_clearance, rel=1e-6)


@pytest.mark.parametrize("far", FAR)
def test_generators_are_as_many_as_the_bounds_have_room_for(far: float) -> None:
    for record in (_half_plane(far), CircleRecord((5.0, 3.0 - far), far), _band(far - 2.0, far)):
        sites = place_generators(gather_borders(_scene(record)), RADIUS).sites
        assert len(sites) < 2.5 * (40.0 + 40.0) / RADIUS


def _shown(record: Record) -> np.ndarray:
    """The generators on one record, along x."""
    scene = _scene(record)
    found = place_generators(gather_borders(scene), RADIUS)
    return found.sites[found.owner == 0]


@pytest.mark.parametrize("far", FAR)
def test_within_the_bounds_no_robot_fits_between_two_generators(far: float) -> None:
    for record in (_half_plane(far), CircleRecord((5.0, 3.0 - far), far), _band(far - 2.0, far)):
        sites = _shown(record)
        top = sites[(abs(sites[:, 0] - 5.0) <= 5.5) & (sites[:, 1] > 1.5)]
        top = top[top[:, 1] > 3.0 - far + math.sqrt((far - 1.0) ** 2 - 30.25)]
        xs = np.sort(top[:, 0])
        assert xs[0] < 0.0 < 10.0 < xs[-1]
        assert np.diff(xs).max() <= RADIUS * (1.0 + 1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_the_part_of_a_piece_in_the_disc_has_all_the_generators_that_are_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y, radius = rng.uniform(-30.0, 30.0, 3)
    start, sweep = rng.uniform(0.0, math.tau, 2)
    a, b = ((x + radius * math.cos(t), y + radius * math.sin(t)) for t in (start, start + sweep))
    records = (
        Segment(a, b),
        Arc(a, b, (x, y), abs(radius), ccw=bool(rng.random() < 0.5)),
        Segment(b, a),
    )
    scene = _scene(PolygonRecord(records), CircleRecord((x, y), abs(radius)))
    borders = gather_borders(scene)
    everywhere = gather_borders(replace(scene, bounds=Bounds(-100.0, -100.0, 100.0, 100.0)))
    all_sites = place_generators(everywhere, RADIUS).sites
    disc = disc_around(borders, RADIUS)
    inside = np.hypot(all_sites[:, 0] - disc[0], all_sites[:, 1] - disc[1]) < disc[2] - 1e-9
    inside &= ~np.isin(abs(all_sites), 100.0).any(axis=1)
    wanted = {tuple(p) for p in np.round(all_sites[inside], 6).tolist()}
    found = {tuple(p) for p in np.round(place_generators(borders, RADIUS).sites, 6).tolist()}
    assert wanted <= found


def test_what_would_take_too_much_memory_is_refused_with_both_figures() -> None:
    with pytest.raises(ValueError, match=r"GB of memory: must be at most 4 GB"):
        planner.build_roadmap(_scene(_half_plane(14.0)), 1e-6)


def test_an_object_that_comes_far_is_taken_up_as_by_building_again() -> None:
    roadmap = planner.build_roadmap(
        _scene(
            CircleRecord((5.0, 5.0), 1.0), *[CircleRecord((1.0 + i, 8.5), 0.2) for i in range(8)]
        ),
        RADIUS,
    )
    scene = replace(
        roadmap.scene, objects=(*roadmap.scene.objects, SceneObject(9, (_half_plane(1e6),)))
    )
    updated, built = roadmap.updated(scene), planner.build_roadmap(scene, RADIUS)
    assert updated.counts["generators"] == built.counts["generators"]
    one, other = (r.plan((1.0, 5.0), (9.0, 5.0)) for r in (updated, built))
    assert isinstance(one, planner.Path)
    assert isinstance(other, planner.Path)
    assert one.length == pytest.approx(other.length, rel=1e-9)

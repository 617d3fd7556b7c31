"""The simulated arena's ground truth, against borders sampled densely."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.config import load_config, parse_config
from navigation.simulator.arena import SimulatedArena, load_arena
from planner.formats.scene_io import read_scene_text
from planner.scene import (
    Arc,
    Bounds,
    CircleRecord,
    FloatArray,
    PointRecord,
    PolygonRecord,
    Scene,
    SceneError,
    SceneObject,
    Segment,
    SegmentRecord,
)

CONFIG = "configs/simulation.yaml"
STEP_M = 2e-4


@pytest.fixture(scope="module")
def laboratory() -> SimulatedArena:
    return load_arena(load_config(CONFIG, {}))


def _ring(*corners: tuple[float, float]) -> PolygonRecord:
    ends = (*corners[1:], corners[0])
    return PolygonRecord(tuple(Segment(a, b) for a, b in zip(corners, ends, strict=True)))


def _arena(*records: PolygonRecord | CircleRecord | PointRecord | SegmentRecord) -> SimulatedArena:
    things = tuple(SceneObject(i, (record,)) for i, record in enumerate(records))
    return SimulatedArena(Scene("m", Bounds(0, 0, 4, 3), things))


def _sampled_ring(record: PolygonRecord | CircleRecord) -> FloatArray:
    """Points every STEP_M along the border, made without the module's help."""
    if isinstance(record, CircleRecord):
        turns = np.arange(0, math.tau, STEP_M / record.radius)
        return np.array(record.center) + record.radius * np.column_stack(
            [np.cos(turns), np.sin(turns)]
        )
    parts = []
    for edge in record.edges:
        if isinstance(edge, Segment):
            share = np.linspace(0, 1, math.ceil(edge.length / STEP_M) + 2)[:, None]
            parts.append(np.array(edge.start) * (1 - share) + np.array(edge.end) * share)
        else:
            a, b = (
                math.atan2(p[1] - edge.center[1], p[0] - edge.center[0])
                for p in (edge.start, edge.end)
            )
            turn = (b - a) % math.tau if edge.ccw else -((a - b) % math.tau)
            turns = np.linspace(a, a + turn, math.ceil(abs(turn) * edge.radius / STEP_M) + 2)
            parts.append(
                np.array(edge.center)
                + edge.radius * np.column_stack([np.cos(turns), np.sin(turns)])
            )
    return np.concatenate(parts)


def _winding(ring: FloatArray, point: FloatArray) -> float:
    angles = np.arctan2(ring[:, 1] - point[1], ring[:, 0] - point[0])
    steps = np.diff(np.append(angles, angles[0]))
    return float(np.sum(np.mod(steps + math.pi, math.tau) - math.pi)) / math.tau


def _clearance_by_sampling(scene: Scene, point: FloatArray) -> float:
    b = scene.bounds
    to_walls = [point[0] - b.x_min, b.x_max - point[0], point[1] - b.y_min, b.y_max - point[1]]
    nearest, solid = min(abs(d) for d in to_walls), min(to_walls) < 0
    for thing in scene.objects:
        for record in thing.records:
            assert isinstance(record, PolygonRecord | CircleRecord)
            ring = _sampled_ring(record)
            nearest = min(nearest, float(np.hypot(*(ring - point).T).min()))
            solid |= round(_winding(ring, point)) != 0
    return -nearest if solid else nearest


def test_clearances_agree_with_borders_sampled_densely(laboratory: SimulatedArena) -> None:
    points = np.random.default_rng(3).uniform((0, 0), (2.4, 1.8), (150, 2))
    expected = [_clearance_by_sampling(laboratory.scene, p) for p in points]
    assert np.abs(laboratory.clearances(points) - expected).max() < STEP_M


@pytest.mark.parametrize("sweep_deg", [20, 90, 180, 200, 240])
@pytest.mark.parametrize("ccw", [True, False])
def test_a_bulging_and_a_hollow_edge_are_told_apart(sweep_deg: float, ccw: bool) -> None:
    """An edge of a square replaced by an arc, outwards or inwards, of any sweep."""
    half = 0.3
    radius = half / math.sin(math.radians(sweep_deg / 2))
    depth = radius * math.cos(math.radians(sweep_deg / 2))
    a, b = (1.5, 1.5 + half), (1.5, 1.5 - half)
    # Seen from a to b (downwards) a counter-clockwise arc bulges to the left of its centre.
    center = (1.5 + (depth if ccw else -depth), 1.5)
    record = PolygonRecord(
        (
            Arc(a, b, center, radius, ccw),
            Segment(b, (2.9, 0.2)),
            Segment((2.9, 0.2), (2.9, 2.8)),
            Segment((2.9, 2.8), a),
        )
    )
    arena = _arena(record)
    points = np.random.default_rng(5).uniform((0.2, 0.2), (3.4, 2.8), (60, 2))
    ring = _sampled_ring(record)
    far = np.array([np.hypot(*(ring - p).T).min() > 1e-3 for p in points])
    crossings = np.array([round(_winding(ring, p)) != 0 for p in points])
    assert (arena.clearances(points) < 0)[far].tolist() == crossings[far].tolist()


def test_points_and_segments_have_no_inside() -> None:
    arena = _arena(PointRecord((1, 1)), SegmentRecord((2, 1), (2, 2)))
    clearances = arena.clearances([[1, 1], [1.3, 1.4], [2, 1.5], [2.2, 1.5], [2, 2.25]])
    assert clearances == pytest.approx([0, 0.5, 0, 0.2, 0.25])


def test_a_hole_is_free_space() -> None:
    outer = _ring((1, 1), (1, 2), (2, 2), (2, 1))
    inner = _ring((1.3, 1.3), (1.7, 1.3), (1.7, 1.7), (1.3, 1.7))
    thing = SceneObject(0, (outer,), ((inner,),))
    arena = SimulatedArena(Scene("m", Bounds(0, 0, 4, 3), (thing,)))
    assert arena.clearances([[1.5, 1.5], [1.1, 1.5]]) == pytest.approx([0.2, -0.1])


def test_outside_the_bounds_is_negative() -> None:
    assert _arena().clearances([[-0.5, 1], [4.25, 1], [1, 1]]) == pytest.approx([-0.5, -0.25, 1])


@given(
    st.floats(-3, 3),
    st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
    st.integers(0, 2**32 - 1),
)
def test_turning_and_moving_the_obstacle_turns_and_moves_its_distances(
    turn: float, shift: tuple[float, float], seed: int
) -> None:
    c, s = math.cos(turn), math.sin(turn)

    def moved(p: tuple[float, float]) -> tuple[float, float]:
        return (c * p[0] - s * p[1] + shift[0], s * p[0] + c * p[1] + shift[1])

    def arena(move: bool) -> SimulatedArena:
        m = moved if move else (lambda p: p)
        edges = (
            Arc(m((0.0, 1.0)), m((0.0, -1.0)), m((0.0, 0.0)), 1.0, ccw=False),
            Segment(m((0.0, -1.0)), m((-1.0, 0.3))),
            Segment(m((-1.0, 0.3)), m((0.0, 1.0))),
        )
        thing = SceneObject(0, (PolygonRecord(edges),))
        return SimulatedArena(Scene("m", Bounds(-99, -99, 99, 99), (thing,)))

    points = np.random.default_rng(seed).uniform(-2, 2, (20, 2))
    there = np.array([moved((x, y)) for x, y in points])
    assert arena(True).clearances(there) == pytest.approx(arena(False).clearances(points), abs=1e-9)


def test_a_track_s_least_clearance_lies_between_its_points_too() -> None:
    arena = _arena(CircleRecord((2.0, 1.0), 0.3))
    clearance, where = arena.track_clearance([[1.0, 1.5], [3.0, 1.5]])
    assert clearance == pytest.approx(0.2, abs=1e-6)
    assert where == pytest.approx((2.0, 1.5), abs=1e-3)


def test_a_track_through_an_obstacle_is_negative_even_where_its_points_are_free() -> None:
    arena = _arena(CircleRecord((2.0, 1.0), 0.3))
    clearance, _ = arena.track_clearance([[1.0, 1.0], [3.0, 1.0]])
    assert clearance == pytest.approx(-0.3, abs=1e-6)


@pytest.mark.parametrize("seed", range(8))
def test_the_track_s_clearance_is_the_least_of_a_dense_walk(
    seed: int, laboratory: SimulatedArena
) -> None:
    arena = laboratory
    track = np.random.default_rng(seed).uniform((0.1, 0.1), (2.3, 1.7), (4, 2))
    share = np.linspace(0, 1, 2001)[:, None]
    walk = np.concatenate([a * (1 - share) + b * share for a, b in pairwise(track)])
    dense = float(arena.clearances(walk).min())
    clearance, where = arena.track_clearance(track)
    assert dense - 1e-3 < clearance <= dense + 1e-9
    assert float(arena.clearances([where])[0]) == pytest.approx(clearance, abs=1e-12)


def test_a_track_of_one_point_is_that_point() -> None:
    assert _arena().track_clearance([[1.0, 1.0]]) == (1.0, (1.0, 1.0))


def test_no_track_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one point"):
        _arena().track_clearance(np.empty((0, 2)))


def test_a_scene_in_pixels_is_refused() -> None:
    with pytest.raises(SceneError, match="is in px: must be in m"):
        SimulatedArena(read_scene_text("C (10,10) 3\n"))


def test_a_robot_that_starts_in_an_obstacle_is_refused() -> None:
    text = """
arena: {bounds_m: [0, 0, 2, 2]}
camera: {source: simulated}
robot: {marker_id: 1, marker_size_m: 0.1, radius_m: 0.1}
simulation:
  arena_text: |
    #@ clearway.scene/1
    #@ units m
    C (0.5,0.5) 0.2
  start: {x_m: 0.6, y_m: 0.75}
"""
    with pytest.raises(SceneError, match=r"clearance of 0\.069 m: must be >= 0\.1"):
        load_arena(parse_config(text))


def test_the_laboratory_holds_what_the_first_run_must_show(laboratory: SimulatedArena) -> None:
    """At least six obstacles: convex, non-convex, one with arc edges, one circle."""
    records = [thing.records[0] for thing in laboratory.scene.objects]
    polygons = [r for r in records if isinstance(r, PolygonRecord)]
    straight = [p for p in polygons if all(isinstance(e, Segment) for e in p.edges)]
    convex = [_is_convex(p) for p in straight]
    assert len(records) >= 6
    assert any(isinstance(r, CircleRecord) for r in records)
    assert len(straight) < len(polygons)
    assert any(convex)
    assert not all(convex)


def _is_convex(polygon: PolygonRecord) -> bool:
    corners = np.array([edge.start for edge in polygon.edges])
    sides = np.roll(corners, -1, axis=0) - corners
    following = np.roll(sides, -1, axis=0)
    turns = sides[:, 0] * following[:, 1] - sides[:, 1] * following[:, 0]
    return bool((turns < 0).all())

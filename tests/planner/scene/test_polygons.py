"""Scenes from arrays and from what has ``__geo_interface__``, and back."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planner
from planner.scene import Bounds, CircleRecord, PolygonRecord, Scene, SceneError, SceneObject
from planner.scene.polygons import first_crossing

SQUARE = np.array([(1.0, 1.0), (3.0, 1.0), (3.0, 2.0), (1.0, 2.0)])
HOLE = np.array([(1.5, 1.2), (2.5, 1.2), (2.5, 1.8), (1.5, 1.8)])


def corners(scene: Scene, number: int = 0) -> set[tuple[float, float]]:
    (record,) = scene.objects[number].records
    assert isinstance(record, PolygonRecord)
    return {edge.start for edge in record.edges}


def area(ring: Any) -> float:
    """Positive where it turns from x to y."""
    x, y = np.array(ring)[:, :2].T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


@pytest.mark.parametrize("units", ["m", "px"])
@pytest.mark.parametrize("ring", [SQUARE, SQUARE[::-1], SQUARE.tolist(), [*SQUARE, SQUARE[0]]])
def test_a_polygon_is_an_obstacle_whichever_way_it_turns(ring: Any, units: Any) -> None:
    scene = Scene.from_polygons([ring], bounds=(0, 0, 5, 4), units=units)
    assert corners(scene) == set(map(tuple, SQUARE.tolist()))
    (record,) = scene.objects[0].records
    assert isinstance(record, PolygonRecord)
    turn = area([edge.start for edge in record.edges])
    assert (turn > 0.0) == scene.y_down, "clockwise as seen on the screen"
    roadmap = planner.build_roadmap(scene, 0.2)
    assert np.allclose(roadmap.clearance([(2.0, 1.5), (4.0, 1.5)]), [-0.5, 1.0])


def test_circles_follow_polygons_and_bounds_may_be_derived() -> None:
    scene = Scene.from_polygons([SQUARE], [(4.0, 4.0, 0.5)])
    assert scene.objects[1].records == (CircleRecord((4.0, 4.0), 0.5),)
    assert not scene.bounds_given
    assert scene.bounds.contains((0.0, 0.0))
    assert Scene.from_polygons(bounds=Bounds(0, 0, 1, 1)).objects == ()


@pytest.mark.parametrize(
    ("polygons", "said"),
    [
        ([SQUARE, SQUARE[:2]], "polygon 1: 2 different vertices: must have at least 3"),
        ([np.repeat(SQUARE[:2], 2, axis=0)], "polygon 0: 2 different vertices"),
        ([np.zeros((4, 4))], "polygon 0: shape (4, 4): must be (n, 2)"),
        ([[(0.0, 0.0), (1.0, math.nan), (0.0, 1.0)]], "polygon 0: all coordinates must be finite"),
        ([[(0, 0), (1, 1), (2, 2)]], "polygon 0: encloses nothing"),
        ([SQUARE[[0, 2, 1, 3]]], "polygon 0: its sides"),
        (["abc"], "polygon 0: must be numbers"),
    ],
)
def test_what_is_no_polygon_is_refused_by_its_number(polygons: Any, said: str) -> None:
    with pytest.raises(SceneError) as error:
        Scene.from_polygons(polygons, bounds=(0, 0, 5, 4))
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"circles": [(1, 2)]}, "circle 0: shape (2,): must be x, y, radius"),
        ({"circles": [(1, 2, -1)], "bounds": (0, 0, 5, 4)}, "must be >= 0"),
        ({"bounds": (0, 0, 1)}, "must be x_min, y_min, x_max, y_max"),
        ({"bounds": (0, 0, 1, 1), "units": "mm"}, "units 'mm': must be one of px, m, cells"),
        ({}, "no obstacle and no bounds"),
    ],
)
def test_other_arguments_are_refused_in_one_sentence(words: Any, said: str) -> None:
    with pytest.raises(SceneError) as error:
        Scene.from_polygons(**words)
    assert said in str(error.value)


def test_arrays_in_the_place_of_objects_are_refused_at_once() -> None:
    with pytest.raises(SceneError, match=r"object 1 is a ndarray: .*Scene\.from_polygons"):
        Scene("m", Bounds(0, 0, 5, 4), (SceneObject(0, ()), SQUARE))  # type: ignore[arg-type]


@given(st.lists(st.tuples(*[st.integers(-6, 6)] * 2), min_size=3, max_size=9))
def test_sides_cross_where_two_segments_do(points: list[tuple[int, int]]) -> None:
    """By parameters along both, in place of the sides of points."""
    ring = np.array(points, dtype=float)
    n = len(ring)

    def crosses(i: int, j: int) -> bool:
        a, u = ring[i], ring[(i + 1) % n] - ring[i]
        c, v = ring[j], ring[(j + 1) % n] - ring[j]
        det = u[0] * v[1] - u[1] * v[0]
        if det == 0.0:
            return False
        w = c - a
        s, t = (w[0] * v[1] - w[1] * v[0]) / det, (w[0] * u[1] - w[1] * u[0]) / det
        return bool(1e-9 < s < 1.0 - 1e-9 and 1e-9 < t < 1.0 - 1e-9)

    pairs = {(i, j) for i in range(n) for j in range(i + 1, n) if crosses(i, j)}
    found = first_crossing(ring)
    assert (found is None) == (not pairs)
    assert found is None or found in pairs


def test_a_scene_is_a_feature_collection_and_comes_back() -> None:
    ring = [*SQUARE.tolist(), SQUARE[0].tolist()]
    hole = [*HOLE.tolist(), HOLE[0].tolist()]
    given_ = {"type": "Polygon", "coordinates": [ring, hole]}
    scene = Scene.from_geo(given_, bounds=(0, 0, 5, 4))
    (one,) = scene.objects
    assert len(one.holes) == 1
    clearance = planner.build_roadmap(scene, 0.1).clearance([(2.0, 1.5), (1.2, 1.5)])
    assert np.allclose(clearance, [0.3, -0.2])
    told = scene.__geo_interface__
    outline, inside = told["features"][0]["geometry"]["coordinates"]
    assert area(outline[:-1]) > 0.0 > area(inside[:-1])
    assert outline[0] == outline[-1]
    again = Scene.from_geo(scene, bounds=(0, 0, 5, 4))
    assert again.__geo_interface__ == told


@pytest.mark.parametrize("tolerance", [0.001, 0.02, 10.0])
def test_a_circle_is_a_polygon_within_its_tolerance(tolerance: float) -> None:
    scene = Scene.from_polygons(circles=[(2.0, 2.0, 1.0)], bounds=(0, 0, 5, 4))
    geometry = scene.to_geo(tolerance)["features"][0]["geometry"]
    (ring,) = geometry["coordinates"]
    points = np.array(ring)
    assert np.allclose(np.hypot(*(points - 2.0).T), 1.0)
    middles = 0.5 * (points[1:] + points[:-1])
    if tolerance < 1.0:
        assert np.hypot(*(middles - 2.0).T).min() >= 1.0 - tolerance - 1e-12


def test_all_kinds_of_geometry_are_taken() -> None:
    ring = [*SQUARE.tolist(), SQUARE[0].tolist()]
    line = {"type": "LineString", "coordinates": [(0.5, 0.5), (0.5, 3.0)]}
    bent = {"type": "LineString", "coordinates": [(4.0, 0.5), (4.0, 2.0, 7.0), (4.5, 2.0, 7.0)]}
    parts = [
        SimpleNamespace(__geo_interface__=line),
        {"type": "Feature", "geometry": None, "properties": {}},
        {"type": "Feature", "geometry": {"type": "MultiPolygon", "coordinates": [[ring]]}},
        {"type": "Feature", "geometry": {"type": "GeometryCollection", "geometries": [line]}},
        {"type": "LinearRing", "coordinates": ring},
        {"type": "MultiPoint", "coordinates": [(0.2, 0.2), (0.3, 0.3)]},
    ]
    whole = {"type": "FeatureCollection", "features": parts}
    scene = Scene.from_geo(SimpleNamespace(__geo_interface__=whole), bounds=(0, 0, 5, 4))
    kinds = [type(one.records[0]).__name__.removesuffix("Record") for one in scene.objects]
    assert kinds == ["Segment", "Polygon", "Segment", "Polygon", "Point", "Point"]
    with pytest.raises(SceneError, match="must be"):
        Scene.from_geo({"type": "LineString", "coordinates": [(4.0, 0.5), (4.0, 2.0, 7.0)]})
    straight = {**bent, "coordinates": [(4.0, 0.5), (4.0, 2.0), (4.5, 2.0)]}
    assert len(Scene.from_geo(straight).objects) == 1


@pytest.mark.parametrize(
    ("geometry", "said"),
    [
        (SQUARE, "geometry: a ndarray: must have __geo_interface__"),
        ({"type": "Circle"}, "geometry: type 'Circle': must be a GeoJSON geometry"),
        ({"type": "Polygon"}, "geometry: Polygon without coordinates"),
        ({"type": "Polygon", "coordinates": [[(0, 0), (1, 1)]]}, "geometry, ring 0: 2 different"),
        ({"type": "Point", "coordinates": [1]}, "geometry: shape (1,): a point must be x, y"),
        (
            {"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": 3}]},
            "feature 0: a int: must have",
        ),
    ],
)
def test_what_is_no_geometry_is_refused_where_it_stands(geometry: Any, said: str) -> None:
    with pytest.raises(SceneError) as error:
        Scene.from_geo(geometry, bounds=(0, 0, 5, 4))
    assert said in str(error.value)

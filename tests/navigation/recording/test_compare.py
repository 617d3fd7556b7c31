"""How far two scenes or two paths are from each other."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from navigation.draw.outlines import object_lines
from navigation.recording.compare import path_distance_m, scene_distance_m
from planner.scene import Bounds, CircleRecord, PointRecord, PolygonRecord, Scene, SceneObject
from planner.scene import Segment as Line


def square(x: float, y: float, side: float) -> PolygonRecord:
    corners = [(x, y), (x, y + side), (x + side, y + side), (x + side, y)]
    return PolygonRecord(tuple(Line(corners[i], corners[(i + 1) % 4]) for i in range(4)))


def scene(*records: Any) -> Scene:
    objects = tuple(SceneObject(i, (record,)) for i, record in enumerate(records))
    return Scene("m", Bounds(0.0, 0.0, 3.0, 3.0), objects)


def test_the_distance_of_scenes_is_how_far_a_border_moved() -> None:
    one, other = scene(square(1.0, 1.0, 0.5)), scene(square(1.02, 1.0, 0.5))
    assert scene_distance_m(one, other) == pytest.approx(0.02)
    assert scene_distance_m(one, one) == 0.0
    assert scene_distance_m(one, scene()) == math.inf
    assert scene_distance_m(scene(), scene()) == 0.0


def test_the_distance_works_both_ways() -> None:
    one = scene(square(1.0, 1.0, 0.5))
    both = scene(square(1.0, 1.0, 0.5), PointRecord((2.5, 1.5)))
    assert scene_distance_m(one, both) == scene_distance_m(both, one) == pytest.approx(1.0)


def test_the_distance_of_a_circle_and_a_larger_one_is_the_difference_of_radii() -> None:
    one, other = scene(CircleRecord((1.0, 1.0), 0.3)), scene(CircleRecord((1.0, 1.0), 0.33))
    assert scene_distance_m(one, other) == pytest.approx(0.03, abs=2e-3)


def test_paths_of_other_vertices_and_the_same_course_are_equal() -> None:
    one = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
    other = np.array([(0.0, 0.0), (0.3, 0.0), (1.0, 0.0), (1.0, 0.9), (1.0, 1.0)])
    assert path_distance_m(one, other) == pytest.approx(0.0, abs=1e-12)
    assert path_distance_m(one, other + np.array([0.0, 0.05])) == pytest.approx(0.05)


def test_borders_as_lines_keep_to_their_arcs() -> None:
    (thing,) = scene(CircleRecord((1.0, 1.0), 0.3)).objects
    (ring,) = object_lines(thing, y_down=False)
    np.testing.assert_allclose(np.hypot(*(ring - 1.0).T), 0.3, atol=1e-12)
    middles = (ring[:-1] + ring[1:]) / 2.0
    assert np.hypot(*(middles - 1.0).T).min() > 0.3 - 2e-3
    np.testing.assert_allclose(ring[0], ring[-1], atol=1e-12)

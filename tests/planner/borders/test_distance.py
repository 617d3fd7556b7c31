"""Distances to primitives and the box tree, against numpy and dense sampling."""

from __future__ import annotations

import numpy as np
import pytest

from planner.borders.generators import gather_borders
from planner.scene import primitive_kernels
from tests.support.scenes.planner_scenes import hand_made, random_scene, slow_distance, slow_inside


@pytest.mark.parametrize("seed", range(12))
def test_nearest_border_is_as_far_as_numpy_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = random_scene(rng)
    borders = gather_borders(scene)
    points = rng.uniform(-20.0, 180.0, (300, 2))
    distance, which = borders.distances(points)
    assert distance == pytest.approx(slow_distance(scene, points), abs=1e-9)
    for i in range(0, 300, 10):
        alone = primitive_kernels.distance(borders.kind, borders.data, which[i], *points[i])
        assert alone == distance[i]


@pytest.mark.parametrize("seed", range(8))
def test_segment_distance_is_the_least_of_its_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    borders = gather_borders(random_scene(rng))
    a, b = rng.uniform(0.0, 120.0, (2, 2))
    t = np.linspace(0.0, 1.0, 2001)
    step = float(np.hypot(*(b - a))) / 2000
    for i in range(borders.primitive_count):
        found, at = primitive_kernels.segment_distance(borders.kind, borders.data, i, *a, *b)
        dense = min(
            primitive_kernels.distance(borders.kind, borders.data, i, *(a + s * (b - a))) for s in t
        )
        assert dense - step <= found <= dense + 1e-9
        there = primitive_kernels.distance(borders.kind, borders.data, i, *(a + at * (b - a)))
        assert there == pytest.approx(found, abs=1e-6)


@pytest.mark.parametrize("name", list(hand_made()))
def test_inside_is_even_odd(name: str) -> None:
    scene = hand_made()[name]
    borders = gather_borders(scene)
    points = np.random.default_rng(3).uniform(0.0, 119.0, (60, 2)).round()
    apart = slow_distance(scene, points) > 0.3
    inside = slow_inside(scene, points)
    for (x, y), want in zip(points[apart], inside[apart], strict=True):
        reach = float(borders.distances(np.array([[x, y]]))[0][0])
        assert borders.owners_around(x, y, reach).any() == want

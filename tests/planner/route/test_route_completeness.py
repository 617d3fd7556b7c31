"""A path is found exactly when one exists: judged by connected grid cells of enough distance."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy import ndimage

import planner
from planner.path import Path
from planner.scene import FloatArray, Scene
from tests.support.scenes.planner_scenes import hand_made, random_scene, slow_distance, slow_inside

FOUR = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]])
EIGHT = np.ones((3, 3))


def _grid(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Places one pixel apart and their signed distance, by a method of the tests' own."""
    b = scene.bounds
    xs, ys = np.meshgrid(np.arange(np.ceil(b.x_min), b.x_max), np.arange(np.ceil(b.y_min), b.y_max))
    places = np.c_[xs.ravel(), ys.ravel()]
    distance = slow_distance(scene, places)
    distance[slow_inside(scene, places)] *= -1.0
    return places, distance.reshape(xs.shape)


def _judge(scene: Scene, radius: float, rng: np.random.Generator, pairs: int) -> None:
    """Between cells joined at radius + 1 a path must be found; at radius - 1 apart, none."""
    places, distance = _grid(scene)
    roadmap = planner.build_roadmap(scene, radius)
    sure = ndimage.label(distance >= radius + 1.0, structure=FOUR)[0].ravel()
    maybe = ndimage.label(distance >= radius - 1.0, structure=EIGHT)[0].ravel()
    standing = np.flatnonzero(distance.ravel() >= radius + 1e-6)
    if len(standing) < 2:
        return
    for i, j in rng.choice(standing, (pairs, 2)):
        answer = roadmap.plan(places[i], places[j])
        if isinstance(answer, Path):
            assert maybe[i] == maybe[j], f"a path where none is: {places[i]} {places[j]}"
            assert answer.min_clearance >= radius - 1e-6
            assert slow_distance(scene, _dense(answer.points)).min() >= radius - 1e-6
        else:
            assert sure[i] != sure[j] or sure[i] == 0, f"missed: {places[i]} {places[j]}"


def _dense(points: FloatArray) -> FloatArray:
    t = np.linspace(0.0, 1.0, 7)[:, None]
    parts = [a + t * (b - a) for a, b in itertools.pairwise(points)]
    return np.concatenate([*parts, points[-1:]])


@pytest.mark.parametrize("radius", [1.5, 4.0, 9.0])
@pytest.mark.parametrize("name", list(hand_made()))
def test_path_is_found_exactly_when_one_exists_in_hand_made(name: str, radius: float) -> None:
    _judge(hand_made()[name], radius, np.random.default_rng(1), 8)


@pytest.mark.parametrize("seed", range(40))
def test_path_is_found_exactly_when_one_exists_in_random(seed: int) -> None:
    rng = np.random.default_rng(seed)
    _judge(random_scene(rng), float(rng.uniform(1.5, 10.0)), rng, 8)

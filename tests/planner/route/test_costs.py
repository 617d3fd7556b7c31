"""A path says what it was chosen by, and no alternative costs less than the best."""

from __future__ import annotations

import numpy as np
import pytest

import planner
from planner.path import NoPath, Path
from planner.roadmap.roadmap import Roadmap
from planner.search.chain_search import DETOUR
from tests.support.scenes.planner_scenes import random_scene, slow_distance

RADIUS = 1.92


def journeys(seed: int) -> tuple[Roadmap, tuple[float, float], tuple[float, float]]:
    """A random scene's roadmap and two places in it with room for the robot."""
    scene = random_scene(np.random.default_rng(1000 + seed))
    roadmap = planner.build_roadmap(scene, RADIUS)
    rng = np.random.default_rng(seed)
    b = scene.bounds
    places: list[tuple[float, float]] = []
    while len(places) < 2:
        x, y = rng.uniform((b.x_min, b.y_min), (b.x_max, b.y_max)).tolist()
        if roadmap.clearance([(x, y)])[0] > 1.1 * RADIUS:
            places.append((x, y))
    return roadmap, places[0], places[1]


@pytest.mark.parametrize("seed", [3, 14, 23, 40, 74])
@pytest.mark.parametrize("prefer", ["balanced", "length", 0.1])
def test_no_alternative_costs_less_than_the_best(seed, prefer):
    roadmap, start, goal = journeys(seed)
    best = roadmap.plan(start, goal, alternatives=4, prefer=prefer)
    if isinstance(best, NoPath):
        return
    costs = [path.cost for path in (best, *best.alternatives)]
    assert all(cost is not None and cost >= costs[0] * (1 - 1e-9) for cost in costs)


@pytest.mark.parametrize("seed", [3, 14, 23])
def test_the_cost_is_the_length_and_what_narrow_places_add(seed):
    roadmap, start, goal = journeys(seed)
    path = roadmap.plan(start, goal, margin=0.2)
    if isinstance(path, NoPath):
        return
    need, weight = RADIUS + 0.2, 0.5 * DETOUR
    a, b = path.points[:-1], path.points[1:]
    steps = np.hypot(*(b - a).T)
    rho = slow_distance(random_scene(np.random.default_rng(1000 + seed)), 0.5 * (a + b))
    wanted = float((steps * (1.0 + weight * need / np.maximum(rho, need))).sum())
    assert path.cost == pytest.approx(wanted, rel=1e-6)


def test_the_shortest_path_costs_its_length():
    roadmap, start, goal = journeys(23)
    path = roadmap.plan(start, goal, prefer="length")
    assert isinstance(path, Path)
    assert path.cost == pytest.approx(path.length)

"""Ways cut short and judged: as a plain reading of the rules says, step by step."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import planner
from planner.path import Path
from planner.roadmap.roadmap import Roadmap
from planner.route import taut_kernels
from planner.scene import FloatArray, Scene
from tests.support.scenes.planner_scenes import random_scene, slow_distance

ROUNDING = 1e-7


def _keeps(roadmap: Roadmap, a: FloatArray, b: FloatArray, keep: float) -> bool:
    return roadmap.path_clearance([a, b]).distance >= keep


def _cut(roadmap: Roadmap, scene: Scene, way: FloatArray, need: float, wish: float) -> FloatArray:
    """From each point the farthest of the last one, half as far, a quarter as far ... is taken.

    Forwards, and then the same from the other end.
    """
    for _ in range(2):
        own = slow_distance(scene, way)
        kept, here = [0], 0
        while here < len(way) - 1:
            step = len(way) - 1 - here
            while step > 1:
                keep = max(need, min(wish, own[here], own[here + step]))
                if _keeps(roadmap, way[here], way[here + step], keep - ROUNDING):
                    break
                step //= 2
            here += step
            kept.append(here)
        way = way[kept][::-1]
    return way


def _price(scene: Scene, way: FloatArray, need: float, weight: float) -> float:
    """Each step costs its length, and more by ``weight`` where its middle is narrow."""
    total = 0.0
    for a, b in pairwise(way):
        away = float(slow_distance(scene, 0.5 * (a + b)[None])[0])
        total += math.dist(a, b) * (1.0 + weight * need / max(away, need))
    return total


def _ways(seed: int) -> tuple[Scene, Roadmap, list[FloatArray]]:
    """A scene and widest ways in it: they leave much to cut."""
    rng = np.random.default_rng(seed)
    scene = random_scene(rng)
    roadmap = planner.build_roadmap(scene, float(rng.uniform(2.0, 5.0)))
    places = rng.uniform(0.0, 119.0, (60, 2))
    places = places[roadmap.clearance(places) >= roadmap.radius]
    answers = [
        roadmap.plan(tuple(a), tuple(b), prefer="clearance")
        for a, b in zip(places[:8:2], places[1:8:2], strict=False)
    ]
    return scene, roadmap, [np.array(p.points) for p in answers if isinstance(p, Path)]


@pytest.mark.parametrize("seed", range(16))
def test_a_way_is_cut_as_the_rules_say(seed: int) -> None:
    scene, roadmap, ways = _ways(seed)
    need = roadmap.radius
    for way in ways:
        for wish in (need, 1.5 * need, 3.0 * need):
            cut = taut_kernels.cut_short(roadmap.borders.tree, way, need, wish, ROUNDING)
            assert cut == pytest.approx(_cut(roadmap, scene, way, need, wish), abs=0.0)
            assert roadmap.path_clearance(cut).distance >= need - ROUNDING


@pytest.mark.parametrize("seed", range(16))
def test_a_way_costs_what_the_rules_say(seed: int) -> None:
    scene, roadmap, ways = _ways(seed)
    tree, need = roadmap.borders.tree, roadmap.radius
    for way in ways:
        for weight in (0.0, 1.0, 4.0):
            price = _price(scene, way, need, weight)
            judged = taut_kernels.judge(tree, way, need, weight, np.inf)
            assert judged == pytest.approx(price, rel=1e-9)
            above, below = price * (1 + 1e-6) + 1e-9, price * (1 - 1e-6)
            assert taut_kernels.judge(tree, way, need, weight, above) == judged
            assert taut_kernels.judge(tree, way, need, weight, below) == np.inf


@pytest.mark.parametrize("seed", range(16))
def test_the_best_cut_is_the_cheapest_of_all_cuts(seed: int) -> None:
    scene, roadmap, ways = _ways(seed)
    need, wish, weight = roadmap.radius, 1.5 * roadmap.radius, 2.0
    ways = [way for way in ways if len(way) > 1]
    if not ways:
        pytest.skip("no way in this scene")
    first = np.cumsum([0, *(len(way) for way in ways)], dtype=np.int32)
    best = taut_kernels.best_cut(
        roadmap.borders.tree, np.concatenate(ways), first, need, wish, weight, ROUNDING
    )
    cuts = [_cut(roadmap, scene, way, need, wish) for way in ways]
    prices = [_price(scene, cut, need, weight) for cut in cuts]
    # the cheapest is cut from its other end on, too
    back = _cut(roadmap, scene, ways[int(np.argmin(prices))][::-1], need, wish)[::-1]
    cuts, prices = [*cuts, back], [*prices, _price(scene, back, need, weight)]
    assert _price(scene, best, need, weight) == pytest.approx(min(prices), rel=1e-9)
    assert best == pytest.approx(cuts[int(np.argmin(prices))], abs=0.0)


@pytest.mark.parametrize("seed", range(6))
def test_cutting_a_way_twice_never_makes_it_longer(seed: int) -> None:
    _, roadmap, ways = _ways(seed)
    need = roadmap.radius
    for way in ways:
        lengths = [np.hypot(*np.diff(way, axis=0).T).sum()]
        for _ in range(3):
            way = taut_kernels.cut_short(roadmap.borders.tree, way, need, need, ROUNDING)
            lengths.append(np.hypot(*np.diff(way, axis=0).T).sum())
        assert all(b <= a * (1 + 1e-12) for a, b in pairwise(lengths))

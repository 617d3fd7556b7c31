"""The shortest way, against a slow visibility graph of the borders moved outwards."""

from __future__ import annotations

import math

import numpy as np
import pytest

import planner
from planner.borders.generators import gather_borders
from planner.path import NoPath, Path
from planner.route.route import GAVE_UP
from planner.scene import ArcRecord, Bounds, CircleRecord, FloatArray, PointRecord, Scene
from planner.search import tangent_search
from planner.search.tangent_search import shortest_way
from tests.support.oracles.visibility_oracle import VisibilityGraph
from tests.support.scenes.planner_scenes import (
    box,
    hand_made,
    random_scene,
    scene_of,
    slow_distance,
)

WITHIN = 1e-3
"""Chords around arcs are longer by less: asked for is 2 %."""


def _length(way: FloatArray) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


def _pairs(scene: Scene, radius: float, rng: np.random.Generator, count: int) -> FloatArray:
    """(count, 2, 2) stations where the disc can stand, by a distance of the tests' own."""
    b = scene.bounds
    places = rng.uniform([b.x_min, b.y_min], [b.x_max, b.y_max], (400, 2))
    return places[slow_distance(scene, places) >= radius][: 2 * count].reshape(-1, 2, 2)


def _judge(scene: Scene, radius: float, pairs: FloatArray) -> None:
    roadmap, oracle = planner.build_roadmap(scene, radius), VisibilityGraph(scene, radius)
    for a, b in pairs:
        best = oracle.length(tuple(a), tuple(b))
        path = roadmap.plan(a, b, prefer="length")
        if isinstance(path, NoPath):
            assert best == math.inf or "inside" in path.reason
            continue
        assert best * (1.0 - 1e-9) <= path.length <= best * (1.0 + WITHIN)
        assert path.min_clearance >= radius - 1e-9 * 160.0
        assert path.remarks == ()


@pytest.mark.parametrize("seed", range(24))
def test_length_is_that_of_the_visibility_graph_in_random_scenes(seed: int) -> None:
    rng = np.random.default_rng(seed + 9000)
    scene, radius = random_scene(rng), float(rng.uniform(1.5, 8.0))
    pairs = _pairs(scene, radius, rng, 2)
    _judge(scene, radius, pairs.reshape(-1, 2, 2))


@pytest.mark.parametrize(
    "name",
    ["U", "bay", "stadium hole", "zigzag", "regular 40-gon", "concentric circles", "round hole"],
)
def test_length_is_that_of_the_visibility_graph_in_hand_made_scenes(name: str) -> None:
    scene = hand_made()[name]
    _judge(scene, 4.0, _pairs(scene, 4.0, np.random.default_rng(3), 3))


def test_way_around_a_circle_is_two_tangents_and_an_arc() -> None:
    scene = scene_of(CircleRecord((80.0, 60.0), 20.0))
    way = shortest_way(gather_borders(scene), (40.0, 60.0), (120.0, 60.0), 5.0).way
    tangent, turned = math.sqrt(40.0**2 - 25.0**2), math.acos(25.0 / 40.0)
    assert _length(way) == pytest.approx(2 * tangent + 25.0 * (math.pi - 2 * turned), rel=3e-4)


def test_way_around_an_open_arc_turns_about_its_ends_too() -> None:
    scene = hand_made()["bay"]
    arcs = ArcRecord(scene.objects[0].records[0].edges[:1])
    scene = scene_of(arcs)
    _judge(scene, 3.0, _pairs(scene, 3.0, np.random.default_rng(5), 4))


def test_passage_exactly_as_wide_as_the_disc_is_taken() -> None:
    scene = scene_of(box(60, -20, 70, 50), box(60, 58, 70, 140))
    path = planner.build_roadmap(scene, 4.0).plan((30, 54), (100, 54), prefer="length")
    assert isinstance(path, Path)
    assert path.length == pytest.approx(70.0)


def test_a_search_that_gives_up_says_so_and_answers_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(tangent_search, "BUDGET", 10)
    scene = hand_made()["lattice of boxes"]
    path = planner.build_roadmap(scene, 4.0).plan((5, 5), (150, 110), prefer="length")
    assert isinstance(path, Path)
    assert path.remarks == (GAVE_UP,)
    assert path.min_clearance >= 4.0 - 1e-6


def test_nothing_is_shorter_than_the_shortest() -> None:
    borders = gather_borders(hand_made()["one box"])
    ends = ((20.0, 60.0), (140.0, 60.0))
    way = shortest_way(borders, *ends, 5.0).way
    again = shortest_way(borders, *ends, 5.0, 0.999 * _length(way))
    assert again.way is None
    assert again.certain


@pytest.mark.parametrize("seed", range(3))
def test_a_thousand_points_take_less_than_the_budget(seed: int) -> None:
    rng = np.random.default_rng(seed)
    bounds = Bounds(0.0, 0.0, 1000.0, 1000.0)
    places = rng.uniform(0.0, 1000.0, (1000, 2))
    scene = scene_of(*(PointRecord((float(x), float(y))) for x, y in places), bounds=bounds)
    (a, b), *_ = _pairs(scene, 6.0, rng, 1)
    found = shortest_way(gather_borders(scene), tuple(a), tuple(b), 6.0)
    assert found.certain

"""Distinct ways: an obstacle between two ways makes them distinct, and nothing else does."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import planner
from planner.path import Path
from planner.scene import FloatArray, Scene
from planner.search import homotopy
from tests.support.scenes.planner_scenes import all_edges, box, hand_made, random_scene, scene_of


def word(places: FloatArray, way: FloatArray) -> homotopy.Word:
    """The word of a way among places that are in the order of x, numbered in that order."""
    return homotopy.word(np.c_[places, np.arange(len(places))], way)


def _crossings(way: FloatArray, place: tuple[float, float]) -> float:
    """The angle a way sweeps as seen from a place."""
    v = way - np.array(place)
    return float(np.unwrap(np.arctan2(v[:, 1], v[:, 0]))[[0, -1]] @ [-1.0, 1.0])


def _one_place_each(scene: Scene) -> list[tuple[float, float]]:
    """The end of some edge of every object, by the records."""
    return [item if isinstance(item, tuple) else tuple(item[0].end) for item in all_edges(scene)]


def _letters(scene: Scene, way: FloatArray) -> list[tuple[int, int]]:
    """Crossings of slanting rays in order, undone ones struck out, by brute force.

    Rays lead from each object downwards and to the left, where the planner's lead upwards.
    """
    slant = np.array([-0.3713, -1.0])
    found = []
    for index, place in enumerate(_one_place_each(scene)):
        for piece, (a, b) in enumerate(itertools.pairwise(way)):
            matrix = np.array([b - a, -slant]).T
            if abs(np.linalg.det(matrix)) < 1e-12:
                continue
            t, far = np.linalg.solve(matrix, np.array(place) - a)
            if 0.0 <= t < 1.0 and far > 0.0:
                found.append((piece + t, index, int(np.sign(np.linalg.det(matrix)))))
    kept: list[tuple[int, int]] = []
    for _, index, sign in sorted(found):
        if kept and kept[-1] == (index, -sign):
            kept.pop()
        else:
            kept.append((index, sign))
    return kept


def test_ways_on_two_sides_of_an_obstacle_differ_and_a_shifted_one_does_not() -> None:
    place = np.array([[5.0, 5.0]])
    above = np.array([[0.0, 5.0], [5.0, 8.0], [10.0, 5.0]])
    below = np.array([[0.0, 5.0], [5.0, 2.0], [10.0, 5.0]])
    wavy = np.array([[0.0, 5.0], [6.0, 9.0], [3.0, 9.5], [7.0, 6.0], [10.0, 5.0]])
    assert word(place, above) == word(place, wavy) != word(place, below)


def test_a_loop_round_an_obstacle_counts() -> None:
    place = np.array([[5.0, 5.0]])
    round_it = np.array([[0, 0], [0, 9], [9, 9], [9, 0], [-1, -1], [-1, 10], [12, 10]], float)
    once = np.array([[0, 0], [0, 9], [12, 10]], float)
    assert word(place, round_it) != word(place, once)


def test_order_of_loops_counts_where_turns_alone_do_not_tell() -> None:
    """A way around one post and then the other, and the other way round: equal sums of turns."""
    places = np.array([[-2.0, 0.0], [2.0, 0.0]])
    left = [(0, 0), (0, 3), (-4, 3), (-4, -3), (0, -3), (0, 0)]
    right = [(0, 0), (0, -3), (4, -3), (4, 3), (0, 3), (0, 0)]
    one = np.array([*left, *right[1:], *left[::-1][1:], *right[::-1][1:]], float)
    none = np.array([(0.0, 0.0), (0.1, 0.0), (0.0, 0.0)])
    for place in places:
        assert _crossings(one, tuple(place)) == pytest.approx(0.0, abs=1e-9)
    assert word(places, one) != word(places, none) == ()


def test_obstacles_above_each_other_are_told_apart() -> None:
    places = np.array([[5.0, 2.0], [5.0, 6.0]])
    ways = [np.array([[0.0, 4.0], [5.0, y], [10.0, 4.0]]) for y in (0.0, 4.0, 8.0)]
    assert len({word(places, way) for way in ways}) == 3


@pytest.mark.parametrize("prefer", ["length", "balanced", "clearance"])
@pytest.mark.parametrize("seed", range(6))
def test_alternatives_are_distinct_by_rays_of_the_tests_own(seed: int, prefer: str) -> None:
    scene = random_scene(np.random.default_rng(seed + 700))
    answer = planner.build_roadmap(scene, 2.0).plan(
        (3, 3), (156, 116), prefer=prefer, alternatives=4
    )
    if not isinstance(answer, Path):
        return
    words = [tuple(_letters(scene, p.points)) for p in (answer, *answer.alternatives)]
    assert len(set(words)) == len(words)


def test_four_boxes_have_more_than_four_ways_round() -> None:
    scene = scene_of(*(box(x, y, x + 20, y + 20) for x in (40, 90) for y in (30, 70)))
    answer = planner.build_roadmap(scene, 3.0).plan((10, 60), (150, 60), alternatives=5)
    assert len(answer.alternatives) == 5


def test_an_empty_arena_has_one_way_only() -> None:
    answer = planner.build_roadmap(hand_made()["empty"], 3.0).plan(
        (10, 60), (150, 60), alternatives=3
    )
    assert answer.alternatives == ()

"""Station orders: exact against every permutation, good against the exact ones."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from planner.search.tour import EXACT_STATIONS, TourError, best_tour


def cost_of(matrix: np.ndarray, stops: list[int]) -> float:
    return sum(float(matrix[a, b]) for a, b in itertools.pairwise(stops))


def every_order(matrix: np.ndarray) -> float:
    end = len(matrix) - 1
    inner = range(1, end)
    return min(cost_of(matrix, [0, *order, end]) for order in itertools.permutations(inner))


def plane(rng: np.random.Generator, count: int) -> np.ndarray:
    points = rng.random((count, 2))
    return np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))


squares = st.integers(2, 7).flatmap(
    lambda n: arrays(np.float64, (n, n), elements=st.integers(0, 20).map(float))
)


@settings(max_examples=100)
@given(squares)
def test_no_order_is_cheaper_than_the_exact_one(matrix):
    tour = best_tour(matrix)
    end = len(matrix) - 1
    assert sorted(tour.order) == list(range(1, end))
    assert tour.cost == pytest.approx(cost_of(matrix, [0, *tour.order, end]))
    assert tour.cost == pytest.approx(every_order(matrix))
    assert tour.exact


def test_ways_that_do_not_exist_are_avoided():
    matrix = np.full((4, 4), math.inf)
    matrix[0, 2] = matrix[2, 1] = matrix[1, 3] = 1.0
    assert best_tour(matrix).order == (2, 1)
    matrix[2, 1] = math.inf
    assert best_tour(matrix).cost == math.inf


def test_as_many_stations_as_are_promised_are_exact():
    matrix = plane(np.random.default_rng(1), EXACT_STATIONS + 2)
    assert best_tour(matrix).exact
    assert not best_tour(plane(np.random.default_rng(1), EXACT_STATIONS + 3)).exact


def test_one_station_or_none_needs_no_order():
    assert best_tour([[0, 3], [3, 0]]).order == ()
    assert best_tour([[0, 3], [3, 0]]).cost == 3.0


def test_the_heuristic_finds_the_shortest_way_round_a_ring():
    angle = np.linspace(0.0, math.tau, 41)[:-1]
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    shuffled = np.concatenate([[0], 1 + np.random.default_rng(2).permutation(39)])
    shuffled = np.concatenate([shuffled[shuffled != 39], [39]])
    points = points[shuffled]
    matrix = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    tour = best_tour(matrix)
    assert not tour.exact
    assert tour.cost == pytest.approx(39 * 2 * math.sin(math.pi / 40))


def test_the_heuristic_is_within_five_percent_of_the_exact_order(monkeypatch):
    rng = np.random.default_rng(3)
    for _ in range(10):
        matrix = plane(rng, 14)
        exact = best_tour(matrix)
        monkeypatch.setattr("planner.search.tour.EXACT_STATIONS", 0)
        found = best_tour(matrix)
        monkeypatch.undo()
        assert sorted(found.order) == sorted(exact.order)
        assert exact.cost - 1e-9 <= found.cost <= 1.05 * exact.cost


def test_one_way_streets_are_costed_one_way(monkeypatch):
    rng = np.random.default_rng(4)
    for _ in range(10):
        matrix = rng.random((10, 10)) + 0.2
        exact = best_tour(matrix)
        monkeypatch.setattr("planner.search.tour.EXACT_STATIONS", 0)
        found = best_tour(matrix)
        monkeypatch.undo()
        assert found.cost == pytest.approx(cost_of(matrix, [0, *found.order, 9]))
        assert exact.cost - 1e-9 <= found.cost <= 1.3 * exact.cost


def test_equal_questions_get_equal_answers():
    matrix = plane(np.random.default_rng(5), 40)
    assert best_tour(matrix) == best_tour(matrix.copy())


@pytest.mark.parametrize(
    "bad", [[[0.0, math.nan], [1, 0]], [[0, -1], [1, 0]], [[0, 1]], [], [[0]], [1, 2]]
)
def test_bad_distances_are_refused(bad):
    with pytest.raises(TourError, match="distances"):
        best_tour(bad)

"""Several robots on a graph: plans before an independent judge, reasons of refusals."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planner
from planner import FleetPlan, NoFleetPlan, plan_on_graph
from tests.support.oracles.fleet_judge import (
    delayed,
    has_joint_plan,
    judge_on_graph,
    least_gap,
)


def both(*edges: tuple[int, int]) -> list[tuple[int, int]]:
    return [*edges, *((b, a) for a, b in edges)]


LINE = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0)]
LINE_EDGES = both((0, 1), (1, 2), (2, 3))
T = [*LINE, (1.0, 1.0)]
T_EDGES = [*LINE_EDGES, (1, 4), (4, 1)]
RING = [(np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3]
RING_EDGES = [(i, (i + 1) % 6) for i in range(6)]


def solved(nodes: Any, edges: Any, radius: float, starts: Any, goals: Any) -> FleetPlan:
    plan = plan_on_graph(nodes, edges, radius, starts, goals)
    assert isinstance(plan, FleetPlan), plan
    judge_on_graph(nodes, edges, starts, goals, plan.tracks, radius)
    assert plan.makespan_s == max(plan.arrivals_s, default=0.0)
    assert plan.flowtime_s == pytest.approx(sum(plan.arrivals_s))
    return plan


def refused(*request: Any, **options: Any) -> NoFleetPlan:
    plan = plan_on_graph(*request, **options)
    assert isinstance(plan, NoFleetPlan)
    assert not plan
    return plan


def test_no_robots_need_no_tracks() -> None:
    plan = plan_on_graph(LINE, LINE_EDGES, 0.3, [], [])
    assert plan == FleetPlan((), (), 0.0, 0.0)
    assert plan


def test_one_robot_takes_the_shortest_way() -> None:
    plan = solved(LINE, LINE_EDGES, 0.3, [0], [3])
    assert plan.flowtime_s == pytest.approx(3.0)
    assert plan.dependencies == ()


def test_who_is_at_its_goal_stays_there() -> None:
    plan = solved(LINE, LINE_EDGES, 0.3, [2], [2])
    assert plan.tracks[0].tolist() == [[0.0, 2.0, 0.0]]
    assert plan.makespan_s == 0.0


def test_robots_in_a_row_follow_each_other() -> None:
    plan = solved(LINE, LINE_EDGES, 0.3, [0, 1], [2, 3])
    assert plan.flowtime_s == pytest.approx(4.0)


def test_one_steps_aside_into_a_niche() -> None:
    plan = solved(T, T_EDGES, 0.3, [0, 2], [2, 0])
    assert plan.flowtime_s < 9.0


def test_a_robot_at_its_goal_steps_aside_and_comes_back() -> None:
    plan = solved(T, T_EDGES, 0.3, [0, 1], [3, 1])
    assert plan.tracks[1].shape[0] > 1
    assert plan.tracks[1][-1, 1:].tolist() == [1.0, 0.0]


def test_swapping_along_one_edge_is_refused_with_both_names() -> None:
    plan = refused(LINE[:2], both((0, 1)), 0.3, [0, 1], [1, 0])
    assert plan.blocking == (0, 1)
    assert plan.proved


def test_a_robot_that_stands_on_the_only_way_is_named() -> None:
    plan = refused(LINE, LINE_EDGES, 0.3, [0, 1], [3, 1])
    assert plan.blocking == (0, 1)
    assert plan.proved
    assert "proved" in plan.reason


def test_a_full_ring_turns_all_at_once() -> None:
    plan = solved(RING, RING_EDGES, 0.4, list(range(6)), [(i + 2) % 6 for i in range(6)])
    assert plan.makespan_s == pytest.approx(2.0, rel=1e-6)


def test_a_full_ring_cannot_exchange_two() -> None:
    plan = refused(RING, both(*RING_EDGES), 0.4, list(range(6)), [1, 0, 2, 3, 4, 5])
    assert plan.proved


def test_queues_in_four_arms_are_exchanged() -> None:
    arms = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    nodes = [(0.0, 0.0), *((float(a * k), float(b * k)) for a, b in arms for k in range(1, 5))]
    edges = both(
        *((0 if k == 1 else 4 * a + k - 1, 4 * a + k) for a in range(4) for k in (1, 2, 3, 4))
    )
    queued = [4 * a + k for a in range(4) for k in (4, 3)]
    solved(nodes, edges, 0.49, queued, [queued[(k + 4) % 8] for k in range(8)])


def test_the_same_goal_is_refused() -> None:
    plan = refused(LINE, LINE_EDGES, 0.3, [0, 3, 1], [2, 2, 0])
    assert plan.blocking == (0, 1)
    assert "same place" in plan.reason


def test_robots_that_touch_at_the_start_are_refused_with_distance_and_need() -> None:
    plan = refused(LINE, LINE_EDGES, 0.6, [0, 1], [3, 1])
    assert plan.blocking == (0, 1)
    assert "1 apart" in plan.reason
    assert "1.2" in plan.reason


def test_robots_that_just_touch_at_the_start_may_drive() -> None:
    solved(LINE, LINE_EDGES, 0.5, [0, 1], [2, 3])


def test_a_goal_that_cannot_be_reached_alone_names_its_robot() -> None:
    plan = refused(LINE, [(1, 0), (1, 2)], 0.3, [1, 3], [2, 0])
    assert plan.blocking == (1,)


def test_edges_of_no_length_take_no_time() -> None:
    nodes = [(0.0, 0.0), (0.0, 0.0), (1.0, 0.0)]
    with np.errstate(all="raise"):
        plan = solved(nodes, [(0, 1), (1, 2)], 0.3, [0], [2])
    assert plan.flowtime_s == pytest.approx(1.0)


def test_a_time_limit_is_kept_and_said_not_to_prove_anything() -> None:
    nodes = [(float(x), float(y)) for x in range(5) for y in range(5)]
    edges = [(a, b) for a in range(25) for b in range(25)
             if abs(nodes[a][0] - nodes[b][0]) + abs(nodes[a][1] - nodes[b][1]) == 1.0]  # fmt: skip
    # a board of 24 robots with one free place and two exchanged: no plan, and too much to look at
    goals = list(range(24))
    goals[0], goals[1] = 1, 0
    plan = refused(nodes, edges, 0.45, list(range(24)), goals, time_limit_s=0.5)
    assert not plan.proved
    assert "not proved" in plan.reason


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"nodes": [(0.0, float("nan"))]}, "nodes"),
        ({"nodes": [(0.0, 1.0, 2.0)]}, "nodes"),
        ({"edges": [(0, 9)]}, "edges"),
        ({"edges": [(0, 0.5)]}, "edges"),
        ({"radius": -1.0}, "radius"),
        ({"radius": float("inf")}, "radius"),
        ({"starts": [7]}, "starts"),
        ({"starts": [0.5]}, "starts"),
        ({"goals": [1, 2]}, "goals"),
        ({"time_limit_s": 0.0}, "time_limit_s"),
        ({"improve": -1}, "improve"),
        ({"seed": -1}, "seed"),
    ],
)
def test_input_that_makes_no_sense_is_named(changed: dict[str, Any], said: str) -> None:
    request = {"nodes": LINE, "edges": LINE_EDGES, "radius": 0.3, "starts": [0], "goals": [1]}
    with pytest.raises(ValueError, match=said):
        plan_on_graph(**{**request, **changed})


def test_arrays_and_lists_give_the_same_plan_and_are_left_as_they_are() -> None:
    nodes, edges = np.array(T), np.array(T_EDGES, dtype=np.int32)
    starts, goals = np.array([0, 2]), np.array([2, 0])
    kept = [a.copy() for a in (nodes, edges, starts, goals)]
    for array in (nodes, edges, starts, goals):
        array.setflags(write=False)
    plans = [
        plan_on_graph(nodes, edges, 0.3, starts, goals),
        plan_on_graph(T, T_EDGES, 0.3, [0, 2], (2, 0)),
    ]
    assert json.dumps([t.tolist() for t in plans[0].tracks]) == json.dumps(
        [t.tolist() for t in plans[1].tracks]
    )
    for array, before in zip((nodes, edges, starts, goals), kept, strict=True):
        assert (array == before).all()


def test_several_threads_get_the_same_plans() -> None:
    requests = [([0, 2], [2, 0]), ([0, 1], [3, 1]), ([3, 0], [0, 3])] * 4
    with ThreadPoolExecutor(4) as pool:
        plans = list(pool.map(lambda r: plan_on_graph(T, T_EDGES, 0.3, *r), requests))
    for request, plan in zip(requests, plans, strict=True):
        alone = plan_on_graph(T, T_EDGES, 0.3, *request)
        assert [t.tolist() for t in plan.tracks] == [t.tolist() for t in alone.tracks]


@st.composite
def small_tasks(draw: st.DrawFn) -> tuple[Any, ...]:
    count = draw(st.integers(2, 6))
    cells = draw(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), min_size=count,
                          max_size=count, unique=True))  # fmt: skip
    nodes = [(float(x), float(y)) for x, y in cells]
    pairs = [(a, b) for a in range(count) for b in range(count) if a != b]
    edges = draw(st.lists(st.sampled_from(pairs), max_size=14, unique=True))
    if draw(st.booleans()):
        edges = sorted({*edges, *((b, a) for a, b in edges)})
    robots = draw(st.integers(1, min(3, count)))
    starts = draw(st.permutations(range(count)))[:robots]
    goals = draw(st.permutations(range(count)))[:robots]
    radius = draw(st.sampled_from([0.2, 0.35, 0.45, 0.49]))
    return nodes, edges, radius, starts, goals


@settings(max_examples=150, deadline=None)
@given(small_tasks())
def test_a_plan_is_found_where_brute_force_finds_one(task: tuple[Any, ...]) -> None:
    nodes, edges, radius, starts, goals = task
    plan = plan_on_graph(*task)
    if isinstance(plan, FleetPlan):
        judge_on_graph(nodes, edges, starts, goals, plan.tracks, radius)
        return
    assert plan.proved
    assert plan.blocking
    assert not has_joint_plan(nodes, edges, radius, starts, goals)


def lattice(rng: np.random.Generator) -> tuple[Any, ...]:
    nodes = np.array([(x, y) for x in range(6) for y in range(5)], dtype=float)
    nodes += rng.uniform(-0.1, 0.1, nodes.shape)
    away = np.hypot(*(nodes[:, None] - nodes[None]).transpose(2, 0, 1))
    edges = np.argwhere((away > 0.0) & (away < 1.3))
    robots = int(rng.integers(2, 13))
    return nodes, edges, 0.3, rng.permutation(30)[:robots], rng.permutation(30)[:robots]


@pytest.mark.parametrize("seed", range(12))
def test_whatever_the_delays_the_dependencies_keep_robots_apart(seed: int) -> None:
    rng = np.random.default_rng(seed)
    task = lattice(rng)
    plan = solved(*task)
    assert plan.remarks == ()
    for _ in range(5):
        driven = delayed(plan.tracks, plan.dependencies, rng, 5.0)
        assert least_gap(driven, [task[2]] * len(driven)) >= -1e-7
        assert [t[-1, 1:].tolist() for t in driven] == [t[-1, 1:].tolist() for t in plan.tracks]


def test_more_shortening_is_never_longer() -> None:
    task = lattice(np.random.default_rng(5))
    flowtimes = [plan_on_graph(*task, improve=rounds).flowtime_s for rounds in (0, 10, 30, 100)]
    assert flowtimes == sorted(flowtimes, reverse=True)


def test_equal_input_gives_equal_plans() -> None:
    task = lattice(np.random.default_rng(6))
    one, other = planner.plan_on_graph(*task), planner.plan_on_graph(*task)
    assert [t.tolist() for t in one.tracks] == [t.tolist() for t in other.tracks]
    assert one.dependencies == other.dependencies

"""Where there is no plan, `plan_on_graph` ends: at its limit, or before it with a proof.

The clock is the tests' own: each time it is asked a hundredth of a second has passed. A search that
forgot to ask it would never end here, and what is done between two questions is counted.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planner
from planner.fleet.search import solver, team
from planner.scene import Bounds, Scene

TICK_S = 0.01
Task = tuple[list[tuple[float, float]], list[tuple[int, int]], float, list[int], list[int]]


def both_ways(pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    return [*pairs, *((b, a) for a, b in pairs)]


def puzzle(width: int, height: int) -> Task:
    """All fields but one are full and two robots are to change places: an odd permutation."""
    nodes = [(float(x), float(y)) for y in range(height) for x in range(width)]
    across = [(i, i + 1) for i in range(len(nodes)) if (i + 1) % width]
    down = [(i, i + width) for i in range(len(nodes) - width)]
    starts = list(range(len(nodes) - 1))
    goals = [1, 0, *starts[2:]]
    return nodes, both_ways([*across, *down]), 0.49, starts, goals


def full_ring(count: int) -> Task:
    """No field of a ring is free, and two neighbours are to change places."""
    size = 0.5 / math.sin(math.pi / count)
    turns = [math.tau * i / count for i in range(count)]
    nodes = [(size * math.cos(turn), size * math.sin(turn)) for turn in turns]
    edges = both_ways([(i, (i + 1) % count) for i in range(count)])
    return nodes, edges, 0.45, list(range(count)), [1, 0, *range(2, count)]


def lane(length: int, robots: int) -> Task:
    """In a lane without a niche the last robot is to be the first at the other end."""
    nodes = [(float(i), 0.0) for i in range(length)]
    last = length - robots
    goals = [last + (i + 1) % robots for i in range(robots)]
    return (
        nodes,
        both_ways([(i, i + 1) for i in range(length - 1)]),
        0.4,
        list(range(robots)),
        goals,
    )


HOPELESS = {
    "puzzle of 3 by 3": puzzle(3, 3),
    "puzzle of 7 by 7": puzzle(7, 7),
    "ring of 12": full_ring(12),
    "ring of 60": full_ring(60),
    "lane of 80 with 25": lane(80, 25),
}


class Asked:
    """A clock that goes on when it is asked; how much was searched between two questions."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.count = self.searches = self.most = 0
        find_way: Callable[..., Any] = solver.find_way

        def counted(*arguments: Any) -> Any:
            self.searches += 1
            return find_way(*arguments)

        monkeypatch.setattr(solver, "find_way", counted)

    def __call__(self) -> float:
        self.count += 1
        self.most = max(self.most, self.searches)
        self.searches = 0
        return TICK_S * self.count


@pytest.mark.parametrize("name", HOPELESS)
def test_it_ends_at_its_limit_and_says_that_nothing_is_proved(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = HOPELESS[name]
    clock = Asked(monkeypatch)
    plan = planner.plan_on_graph(*task, time_limit_s=3.0, clock=clock)
    assert isinstance(plan, planner.NoFleetPlan)
    if plan.proved:
        assert "proved" in plan.reason
    else:
        assert "within 3 s" in plan.reason
        assert plan.blocking
    # once it is late each of the nested searches asks once more
    assert clock.count <= 3.0 / TICK_S + 30
    assert clock.most <= len(task[3]) + 16, "searches of one robot between two questions"


@pytest.mark.parametrize("task", [puzzle(3, 2), lane(10, 4), lane(5, 2), full_ring(5)])
def test_small_hopeless_tasks_end_with_a_proof_long_before_the_limit(task: Task) -> None:
    plan = planner.plan_on_graph(*task, time_limit_s=1e6)
    assert isinstance(plan, planner.NoFleetPlan)
    assert plan.proved


@settings(max_examples=60, deadline=None)
@given(
    st.integers(2, 9),
    st.integers(0, 2**32 - 1),
    st.integers(1, 40),
)
def test_any_graph_s_search_ends_when_its_clock_says_so(count: int, seed: int, asks: int) -> None:
    rng = np.random.default_rng(seed)
    nodes = rng.uniform(0.0, 4.0, (count, 2))
    pairs = rng.integers(0, count, (int(rng.integers(0, 3 * count)), 2))
    edges = [(int(a), int(b)) for a, b in pairs if a != b]
    robots = int(rng.integers(1, count + 1))
    starts, goals = (rng.permutation(count)[:robots].tolist() for _ in range(2))
    with pytest.MonkeyPatch.context() as patched:
        clock = Asked(patched)
        plan = planner.plan_on_graph(
            nodes, edges, 0.2, starts, goals, TICK_S * asks, improve=1000, clock=clock
        )
    assert clock.count <= asks + 30
    assert bool(plan) or isinstance(plan, planner.NoFleetPlan)


@pytest.mark.parametrize("asks", [1, 7, 40])
def test_the_time_limit_includes_setting_up(asks: int, monkeypatch: pytest.MonkeyPatch) -> None:
    set_up = 0
    times_to: Callable[..., Any] = team.times_to

    def counted(*arguments: Any) -> Any:
        nonlocal set_up
        set_up += 1
        return times_to(*arguments)

    monkeypatch.setattr(team, "times_to", counted)
    clock = Asked(monkeypatch)
    nodes, edges, radius, starts, goals = lane(120, 60)
    plan = planner.plan_on_graph(
        nodes, edges, radius, starts, goals, TICK_S * (asks - 0.5), clock=clock
    )
    assert isinstance(plan, planner.NoFleetPlan)
    assert not plan.proved
    assert f"within {TICK_S * (asks - 0.5):g} s" in plan.reason
    assert set_up == asks - 1
    assert plan.blocking == tuple(range(asks - 1, 60))
    assert clock.count == asks + 1
    assert clock.searches == 0


@pytest.mark.parametrize("asks", [1, 3, 14, 80])
def test_the_time_limit_of_a_fleet_among_obstacles_includes_setting_up(
    asks: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = Asked(monkeypatch)
    roadmap = planner.build_roadmap(Scene("m", Bounds(0.0, 0.0, 10.0, 4.0), ()), 0.1)
    starts = [(1.0 + 0.5 * i, 1.0) for i in range(12)]
    goals = [(1.0 + 0.5 * i, 3.0) for i in range(12)][::-1]
    plan = planner.plan_fleet(
        roadmap, starts, goals, time_limit_s=TICK_S * (asks - 0.5), clock=clock
    )
    assert isinstance(plan, planner.NoFleetPlan)
    assert plan.blocking == tuple(range(asks - 1 if asks <= 12 else 0, 12))
    assert not plan.proved
    assert clock.count == asks + 1
    assert clock.searches == 0


@pytest.mark.parametrize("name", HOPELESS)
def test_what_is_done_between_two_looks_at_the_clock_is_short(name: str) -> None:
    """By the processor's time, in which nobody else's work counts."""
    planner.plan_on_graph(*puzzle(3, 2), time_limit_s=1.0)  # compiles
    longest_s, last_s = 0.0, math.inf

    def clock() -> float:
        nonlocal longest_s, last_s
        now_s = time.process_time()
        longest_s = max(longest_s, now_s - last_s)
        last_s = now_s
        return now_s

    began_s = time.process_time()
    plan = planner.plan_on_graph(*HOPELESS[name], time_limit_s=1.0, clock=clock)
    took_s = time.process_time() - began_s
    assert isinstance(plan, planner.NoFleetPlan)
    assert longest_s < 0.5
    assert took_s < 1.0 + 0.5

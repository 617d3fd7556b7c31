"""Releases: whatever the delays, nobody touches anybody, and somebody can always move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planner import FleetPlan, plan_on_graph
from planner.fleet.execution import Wait, releases, waiting_circle
from tests.support.oracles.fleet_judge import least_gap


def crossing_task(seed: int) -> tuple[Any, ...]:
    rng = np.random.default_rng(seed)
    nodes = np.array([(x, y) for x in range(5) for y in range(4)], dtype=float)
    nodes += rng.uniform(-0.1, 0.1, nodes.shape)
    away = np.hypot(*(nodes[:, None] - nodes[None]).transpose(2, 0, 1))
    edges = np.argwhere((away > 0.0) & (away < 1.3))
    robots = int(rng.integers(2, 9))
    return nodes, edges, 0.3, rng.permutation(20)[:robots], rng.permutation(20)[:robots]


def driven(plan: FleetPlan, draw: Any) -> list[np.ndarray]:
    """The tracks as driven by releases alone: each piece takes as long as is drawn.

    At each moment a robot that may move begins its next piece, or one that drives ends its own,
    whichever is drawn: any interleaving can come out.
    """
    passed = [0] * len(plan.tracks)
    driving = [False] * len(plan.tracks)
    rows: list[list[tuple[float, float, float]]] = [[(0.0, *t[0, 1:])] for t in plan.tracks]
    now_s, last = 0.0, [-1] * len(plan.tracks)
    while True:
        allowed = releases(plan, passed)
        for i, release in enumerate(allowed):
            assert release.row >= last[i], "what was given is never taken back"
            last[i] = release.row
        can = [i for i, r in enumerate(allowed) if driving[i] or r.row > passed[i]]
        if not can:
            break
        i = can[draw(len(can))]
        now_s += 0.5 + draw(4)
        place = plan.tracks[i][passed[i] + driving[i], 1:]
        rows[i].append((now_s, *place))
        passed[i] += driving[i]
        driving[i] = not driving[i]
    assert passed == [len(track) - 1 for track in plan.tracks], "a deadlock: nobody can move"
    return [np.array(r) for r in rows]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 30), st.randoms(use_true_random=False))
def test_any_interleaving_of_delays_keeps_all_apart_and_brings_all_home(
    seed: int, chance: Any
) -> None:
    task = crossing_task(seed)
    plan = plan_on_graph(*task, improve=3)
    assert isinstance(plan, FleetPlan), plan
    # on a given graph a few plans turn in rings all at once, and say so
    assume(not plan.remarks)
    tracks = driven(plan, chance.randrange)
    assert least_gap(tracks, [task[2]] * len(tracks)) >= -1e-7


PASS = FleetPlan(
    (
        np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]]),
        np.array([[0.0, 1.0, 2.0], [2.0, 1.0, 1.0], [3.0, 1.0, 0.0]]),
    ),
    ((0, 2, 1, 1),), 3.0, 5.0,
)  # fmt: skip


@pytest.mark.parametrize(
    ("passed", "rows", "waits"),
    [
        ((0, 0), (2, 1), (Wait(1, 0, 2),)),
        ((1, 1), (2, 1), (Wait(1, 0, 2),)),
        ((2, 0), (2, 2), ()),
        ((2, 2), (2, 2), ()),
    ],
)
def test_a_robot_is_given_its_rows_up_to_the_next_unmet_dependency(
    passed: Sequence[int], rows: Sequence[int], waits: Sequence[Wait]
) -> None:
    found = releases(PASS, passed)
    assert tuple(r.row for r in found) == rows
    assert found[1].waits == waits
    assert waiting_circle(PASS, passed) == ()


def test_robots_that_turn_in_a_full_ring_are_named_as_a_circle() -> None:
    nodes = [(np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3]
    plan = plan_on_graph(
        nodes, [(i, (i + 1) % 6) for i in range(6)], 0.4, range(6), [1, 2, 3, 4, 5, 0]
    )
    assert isinstance(plan, FleetPlan)
    assert plan.remarks
    assert waiting_circle(plan, [0] * 6) == tuple(range(6))


@pytest.mark.parametrize("passed", [(0,), (0, 3), (-1, 0)])
def test_progress_that_no_track_has_is_named(passed: Sequence[int]) -> None:
    with pytest.raises(ValueError, match=r"rows for 2 robots|passed"):
        releases(PASS, passed)

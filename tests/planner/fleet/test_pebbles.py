"""Pebbles on a graph: every move is allowed, and what brute force can do is done."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planner.fleet.search.pebbles import rearrange, without_detours

Near = list[list[int]]


def can_be_rearranged(near: Near, start: Sequence[int], goal: Sequence[int]) -> bool:
    """By looking at every arrangement."""
    seen, left = {tuple(start)}, [tuple(start)]
    while left:
        at = left.pop()
        if at == tuple(goal):
            return True
        for i, u in enumerate(at):
            for v in near[u]:
                then = (*at[:i], v, *at[i + 1 :])
                if v not in at and then not in seen:
                    seen.add(then)
                    left.append(then)
    return False


def driven(near: Near, start: Sequence[int], moves: Any) -> list[int]:
    """Where the pebbles end, each move checked."""
    at = list(start)
    for i, u, v in moves:
        assert at[i] == u
        assert v in near[u]
        assert v not in at
        at[i] = v
    return at


def rearranged(near: Near, start: Sequence[int], goal: Sequence[int]) -> Any:
    return rearrange(near, start, goal, np.random.default_rng(0), lambda: False)


def star(arms: int, length: int) -> Near:
    """Arms of a length around node 0; node 1 + arm * length is an arm's first."""
    near: Near = [[] for _ in range(1 + arms * length)]
    for arm in range(arms):
        before = 0
        for node in range(1 + arm * length, 1 + (arm + 1) * length):
            near[before].append(node)
            near[node].append(before)
            before = node
    return near


@st.composite
def trees_with_pebbles(draw: st.DrawFn) -> tuple[Near, list[int], list[int]]:
    count = draw(st.integers(3, 7))
    near: list[set[int]] = [set() for _ in range(count)]
    pairs = [(draw(st.integers(0, k - 1)), k) for k in range(1, count)]
    for a, b in pairs + draw(st.lists(st.tuples(*[st.integers(0, count - 1)] * 2), max_size=2)):
        if a != b:
            near[a].add(b)
            near[b].add(a)
    pebbles = draw(st.integers(1, count - 1))
    start = draw(st.permutations(range(count)))[:pebbles]
    goal = draw(st.permutations(range(count)))[:pebbles]
    return [sorted(n) for n in near], start, goal


@settings(max_examples=300, deadline=None)
@given(trees_with_pebbles())
def test_every_move_is_allowed_and_ends_where_it_should(task: Any) -> None:
    near, start, goal = task
    moves = rearranged(near, start, goal)
    if moves is None:
        return
    assert driven(near, start, moves) == list(goal)


@settings(max_examples=200, deadline=None)
@given(trees_with_pebbles())
def test_with_one_pebble_more_than_half_empty_brute_force_finds_no_more(task: Any) -> None:
    near, start, goal = task
    assume(len(near) >= 2 * len(start) + 1)
    assert (rearranged(near, start, goal) is not None) == can_be_rearranged(near, start, goal)


def test_eight_pebbles_cross_in_every_order() -> None:
    rng = np.random.default_rng(4)
    for length in (3, 4, 6):
        near = star(4, length)
        start = [1 + arm * length + k for arm in range(4) for k in (length - 1, length - 2)]
        for _ in range(10):
            goal = rng.permutation(start).tolist()
            moves = rearranged(near, start, goal)
            assert moves is not None
            assert driven(near, start, moves) == goal


def test_two_cannot_pass_on_a_line() -> None:
    near = [[1], [0, 2], [1, 3], [2]]
    assert rearranged(near, [0, 3], [3, 0]) is None


def test_pebbles_at_their_goals_stay() -> None:
    assert rearranged(star(3, 2), [1, 3], [1, 3]) == []


def test_what_leads_nowhere_is_left_out() -> None:
    moves = [(0, 0, 1), (1, 5, 6), (0, 1, 0), (1, 6, 7)]
    assert without_detours(moves) == [(1, 5, 6), (1, 6, 7)]


def test_a_detour_that_makes_room_stays() -> None:
    moves = [(0, 0, 1), (1, 5, 0), (1, 0, 6), (0, 1, 0)]
    assert without_detours(moves) == moves

"""Proof that two robots can never both reach their goals, whatever the others do.

Only the two are there, in the steps of ``joint_search``. The search leads back from both goals and
forwards from both starts: a robot confined to a few places is soon found from one side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from planner.fleet.motions.interval_search_kernels import HORIZON
from planner.fleet.search.joint_search import JointSearch
from planner.fleet.search.team import TeamRobot

PAIRS_MOST = 20_000
"""Pairs of places examined from one side: some seconds, where steps are new."""
PAIRS_FEW = 500
"""The same where most proofs end, in milliseconds."""

Pair = tuple[int, int]


def can_never_pass(
    one: TeamRobot,
    other: TeamRobot,
    search: JointSearch,
    expired: Callable[[], bool],
    most: int = PAIRS_MOST,
) -> bool:
    """True if the two provably have no plan; ``search`` is of these two.

    Beyond ``most`` pairs of places a side proves nothing.
    """
    start, goal = (one.start, other.start), (one.goal, other.goal)
    before = _into(one), _into(other)
    return _is_enclosed(
        goal, start, lambda pair: _back(pair, before, search), expired, most
    ) or _is_enclosed(start, goal, lambda pair: _on(pair, search), expired, most)


def _is_enclosed(
    begin: Pair,
    end: Pair,
    neighbours: Callable[[Pair], Iterator[Pair]],
    expired: Callable[[], bool],
    most: int,
) -> bool:
    seen = {begin}
    open_pairs = [begin]
    while open_pairs:
        if expired():
            return False
        for pair in neighbours(open_pairs.pop()):
            if pair == end or len(seen) > most:
                return False
            if pair not in seen:
                seen.add(pair)
                open_pairs.append(pair)
    return end not in seen


def _into(robot: TeamRobot) -> dict[int, list[int]]:
    """Nodes that reach each node in one step, itself included."""
    graph = robot.graph
    into = {n: [n] for n in range(len(graph.places))}
    for n in range(len(graph.places)):
        for m in graph.to[graph.starts[n] : graph.starts[n + 1]].tolist():
            if m != n and robot.to_goal[m] < HORIZON:
                into[m].append(n)
    return into


def _back(
    pair: Pair, before: tuple[dict[int, list[int]], dict[int, list[int]]], search: JointSearch
) -> Iterator[Pair]:
    for u in before[0][pair[0]]:
        for v in before[1][pair[1]]:
            if search.is_allowed((u, v), pair):
                yield u, v


def _on(pair: Pair, search: JointSearch) -> Iterator[Pair]:
    for u, _ in search.ends(0, pair[0]):
        for v, _ in search.ends(1, pair[1]):
            if search.is_allowed(pair, (u, v)):
                yield u, v

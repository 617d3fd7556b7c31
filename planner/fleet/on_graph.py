"""Several robots on a given graph: unit speed, waiting at nodes, one radius for all."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from planner.fleet.fleet_plan import FleetPlan, NoFleetPlan
from planner.fleet.search.fleet_search import SHORTENING_ROUNDS, Effort, search, touching
from planner.fleet.search.team import edges_of, make_graph, make_robot
from planner.scene import FloatArray
from planner.shared.arguments import as_list, as_numbers, as_positive, as_whole, brief
from planner.shared.search_clock import Clock, search_clock_s


def plan_on_graph(
    nodes: ArrayLike,
    edges: ArrayLike,
    radius: float,
    starts: Sequence[int],
    goals: Sequence[int],
    time_limit_s: float = 30.0,
    *,
    improve: int = SHORTENING_ROUNDS,
    seed: int = 0,
    clock: Clock = search_clock_s,
) -> FleetPlan | NoFleetPlan:
    """Plan tracks for discs of one radius on a graph, no two of which ever touch.

    ``nodes`` (n, 2) are places, ``edges`` (m, 2) directed pairs of node numbers, ``starts`` and
    ``goals`` node numbers; robots drive along straight edges at speed 1 and may wait at nodes.
    ``improve`` is the number of rounds that shorten the sum of arrivals, 0 for the first plan.
    Equal input and ``seed`` give equal plans, unless ``time_limit_s``, which includes setting up,
    ends the search; ``clock`` gives its seconds. ``ValueError`` on senseless input. Method:
    :mod:`planner.fleet.search.solver`.
    """
    effort = check_effort(time_limit_s, improve, seed, clock)
    places = _numbers("nodes", nodes)
    rows = _edges(edges, len(places))
    size = as_positive("radius", radius, zero=True)
    begin, end = _nodes("starts", starts, len(places)), _nodes("goals", goals, len(places))
    if len(begin) != len(end):
        raise ValueError(f"{len(begin)} starts and {len(end)} goals: must be as many")
    radii = [size] * len(begin)
    for what, chosen in (("starts", begin), ("goals", end)):
        for refused in (_shared(what, chosen), touching(what, places[chosen], radii)):
            if refused is not None:
                return refused
    graph = make_graph(places, rows)
    pairs, robots = edges_of(graph), []
    for i, (a, b) in enumerate(zip(begin, end, strict=True)):
        if effort.expired():
            return effort.out_of_time(range(i, len(begin)))
        robots.append(make_robot(graph, pairs, size, a, b))
    junctions = np.flatnonzero(np.diff(graph.starts) > 2).tolist()
    return search(robots, junctions, effort)


def check_effort(
    time_limit_s: float, improve: int, seed: int, clock: Clock = search_clock_s
) -> Effort:
    """Return the effort, with its time limit starting now; ``ValueError`` on senseless input."""
    limit = as_positive("time_limit_s", time_limit_s)
    rounds, number = as_whole("improve", improve), as_whole("seed", seed)
    return Effort(limit, clock() + limit, rounds, number, clock)


def _shared(what: str, chosen: Sequence[int]) -> NoFleetPlan | None:
    first: dict[int, int] = {}
    for j, node in enumerate(chosen):
        i = first.setdefault(node, j)
        if i < j:
            return NoFleetPlan(f"robots {i} and {j}: their {what} are the same place", (i, j))
    return None


def _numbers(name: str, rows: ArrayLike) -> FloatArray:
    array = as_numbers(name, rows, "rows of two numbers")
    if array.size == 0:
        return np.empty((0, 2))
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"{name}: must be rows of two numbers, not of shape {array.shape}")
    if not np.isfinite(array).all():
        at = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise ValueError(f"{name}[{at}] = {tuple(array[at].tolist())}: must be finite")
    return np.ascontiguousarray(array)


def _edges(edges: ArrayLike, count: int) -> NDArray[np.int64]:
    pairs = _numbers("edges", edges)
    bad = np.flatnonzero(((pairs < 0) | (pairs >= count) | (pairs != np.floor(pairs))).any(axis=1))
    if len(bad):
        at = int(bad[0])
        raise ValueError(
            f"edges[{at}] = {tuple(pairs[at].tolist())}: must be nodes 0 to {count - 1}"
        )
    return pairs.astype(np.int64)


def _nodes(name: str, chosen: Sequence[Any], count: int) -> list[int]:
    numbers = []
    for i, node in enumerate(as_list(name, chosen, "node numbers")):
        try:
            number = operator.index(node)
        except TypeError:
            raise ValueError(f"{name}[{i}] = {brief(node)}: must be a node number") from None
        if not 0 <= number < count:
            raise ValueError(f"{name}[{i}] = {number}: must be a node, 0 to {count - 1}")
        numbers.append(number)
    return numbers

"""The k cheapest routes over the chains without a loop, on flat arrays.

Rules and units
- Method: Yen (1971): every route found is left once at each of its nodes, for the cheapest way
  on that no route found before it takes. Nodes on the way there are shut, so no route meets
  a node twice. Up to where it left another one itself, that one was left before (Lawler 1972).
- Two such routes are never shifts of one another: the chains are what is left of the free space
  when it is shrunk, and in a graph two ways without a step back and forth are shifts of one
  another only where they are the same.
- Entries, gates and steps are those of :mod:`planner.search.route_kernels`.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: allow-untyped-defs

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import NONE, grown
from planner.search.route_kernels import (
    CLEARED,
    between,
    gates_of,
    lay,
    left_to,
    put_behind,
    search,
)
from planner.search.search_kernels import GateCosts, Graph

BEYOND = 1.0 + 1e-9
"""Costs are known but for rounding: so many times the limit is surely beyond it."""
COST, ENTRY, EXIT, BEGIN, END, TAKEN, LEFT = 0, 1, 2, 3, 4, 5, 6
"""Columns of a route: what it costs, its gates, its steps' place among all steps, 1 once told,
and after how many steps it left another, -1 at its gate."""


class Query(NamedTuple):
    """What is asked, the same for every search.

    ``ahead`` (n,) as :func:`planner.search.route_kernels.left_to` returns it; what the gates of
    both stations cost, and the steps that lead over a station's ``own`` chain (2 c,).
    """

    graph: Graph
    ahead: NDArray[np.float64]
    floor: float
    start: GateCosts
    goal: GateCosts
    own: NDArray[np.bool_]


class Table(NamedTuple):
    """The routes that were found: ``filled`` rows of ``routes`` (r, 7), and all their ``steps``."""

    routes: NDArray[np.float64]
    steps: NDArray[np.int32]
    filled: np.int64


@njit(**OWNING)
def _noted(table, cost, entry, out, root, rest, left):
    """The table with a route with the steps ``root`` and then ``rest``, unless it is known.

    It ``left`` another after so many steps.
    """
    routes, steps, count = table
    n = len(root) + len(rest)
    for k in range(count):
        begin, end = int(routes[k, BEGIN]), int(routes[k, END])
        same = routes[k, ENTRY] == entry and routes[k, EXIT] == out and end - begin == n
        for i in range(n if same else 0):
            step = root[i] if i < len(root) else rest[i - len(root)]
            same = same and steps[begin + i] == step
        if same:
            return Table(routes, steps, count)
    begin = int(routes[count - 1, END]) if count > 0 else 0
    if count == len(routes):
        routes = grown(routes, 2 * count)
    if begin + n > len(steps):
        steps = grown(steps, 2 * (begin + n))
    steps[begin : begin + len(root)] = root
    steps[begin + len(root) : begin + n] = rest
    routes[count, COST], routes[count, ENTRY], routes[count, EXIT] = cost, entry, out
    routes[count, BEGIN], routes[count, END], routes[count, TAKEN] = begin, begin + n, 0.0
    routes[count, LEFT] = left
    return Table(routes, steps, count + 1)


@njit(**BORROWING)
def _shut_repeats(access, cost, rounding):
    """Shut the gates of all entries but one at each place: beyond it their routes are the same.

    Where a station attaches at a node, it does so over every chain that ends there.
    """
    for i in range(len(access)):
        if cost[2 * i] == np.inf and cost[2 * i + 1] == np.inf:
            continue
        for j in range(i + 1, len(access)):
            dx, dy = access[j, 2, 0] - access[i, 2, 0], access[j, 2, 1] - access[i, 2, 1]
            if dx * dx + dy * dy <= rounding * rounding:
                cost[2 * j], cost[2 * j + 1] = np.inf, np.inf


@njit(**BORROWING)
def _bar_own(where, cost, barred):
    """Bar the steps over a station's own chain, where it stands on one only.

    A route over the whole of it passes the station on the way: a loop.
    """
    own = -1
    for i in range(len(where)):
        if cost[2 * i] < np.inf or cost[2 * i + 1] < np.inf:
            if own >= 0:
                return
            own = where[i, 0]
    if own >= 0:
        barred[2 * own], barred[2 * own + 1] = True, True


@njit(**BORROWING)
def _passes(way, chain):
    """Whether the steps lead over the whole of a chain."""
    passes = False
    for k in range(len(way)):
        passes = passes or way[k] // 2 == chain
    return passes


@njit(**BORROWING)
def _cheapest(routes, count):
    """The cheapest of the routes that are not told yet, or -1."""
    pick, least = -1, np.inf
    for k in range(count):
        if routes[k, TAKEN] == 0.0 and routes[k, COST] < least:
            pick, least = k, routes[k, COST]
    return pick


@njit(**BORROWING)
def _bar_told(table, told, entry, way, at, barred, to_cost):
    """Bar what routes that were told do after the first ``at`` steps of a ``way``, if they share
    them: the next step, or the gate that they leave by."""
    routes, steps, _ = table
    for t in range(len(told)):
        k = told[t]
        lo, hi = int(routes[k, BEGIN]), int(routes[k, END])
        shares = routes[k, ENTRY] == entry and hi - lo >= at
        for i in range(at if shares else 0):
            shares = shares and steps[lo + i] == way[i]
        if shares and hi - lo > at:
            barred[steps[lo + at]] = True
        elif shares:
            to_cost[int(routes[k, EXIT])] = np.inf


@njit(**OWNING)
def _first_routes(query, start, goal):
    """The cheapest route, and those within one chain, in a new table; and the work."""
    table = Table(np.empty((32, 7)), np.empty(64, np.int32), np.int64(0))
    none = np.empty(0, np.int32)
    shut = np.zeros(len(query.graph.around) - 1, np.bool_)
    best, entry, out, way, work = search(
        query.graph, query.ahead, query.floor, query.start, query.goal, shut, query.own,
        np.inf,
    )  # fmt: skip
    if best < np.inf:
        table = _noted(table, best, entry, out, none, way, NONE)
    for i in range(len(start.where)):
        for j in range(len(goal.where)):
            if start.where[i, 0] == goal.where[j, 0]:
                wide, apart = between(query.graph, start, i, goal, j)
                if wide >= query.floor:
                    cost = start.price[i, 1] + goal.price[j, 1] + apart
                    table = _noted(table, cost, -1 - i, -1 - j, none, none, NONE)
    return table, work


@njit(**OWNING)
def _leave(query, table, told, pick, way, most, work, budget):
    """Leave route ``pick``, its steps ``way``, at its gate and at each of its nodes.

    Not before it left another itself, and for routes that cost less than ``most``. The table with
    the routes that were found, and the work, which ends at ``budget``.
    """
    graph, ends, own = query.graph, query.graph.chains.ends, query.own
    entry, first = int(table.routes[pick, ENTRY]), int(table.routes[pick, LEFT])
    shut = np.zeros(len(graph.around) - 1, np.bool_)
    u, gone = np.int32(-1), 0.0
    # at its gate (-1), and then at each of its nodes
    for at in range(min(first, 0), len(way) + 1):
        if at == 0:
            u, gone = query.start.node[entry], query.start.cost[entry]
        elif at > 0:
            gone += graph.total[way[at - 1] // 2]
            u = ends[way[at - 1] // 2, 1 - way[at - 1] % 2]
        if at >= 0:
            shut[u] = True
        if at < first:
            continue
        barred = own.copy()
        origin = GateCosts(query.start.node, query.start.cost.copy())
        goal = GateCosts(query.goal.node, query.goal.cost.copy())
        if at < 0:
            for t in range(len(told)):
                if table.routes[told[t], ENTRY] >= 0:
                    origin.cost[int(table.routes[told[t], ENTRY])] = np.inf
        else:
            _bar_told(table, told, entry, way, at, barred, goal.cost)
            origin = GateCosts(np.full(1, u, np.int32), np.full(1, gone))
        found, way_in, way_out, rest, looked_at = search(
            graph, query.ahead, query.floor, origin, goal, shut, barred, most
        )
        work += looked_at + len(own) // CLEARED + len(told) * (at + 2) + table.filled
        if found < np.inf:
            table = _noted(
                table, found, way_in if at < 0 else entry, way_out, way[: max(at, 0)], rest, at
            )
        if work > budget:
            break
    return table, work


@njit(**OWNING)
def cheapest_routes(graph, floor, start, goal, wanted, rounding, budget, dearest):
    """The ``wanted`` cheapest routes, the cheapest first: fewer where there are no more.

    ``start`` and ``goal`` are the stations' gates; those nearer to one another than ``rounding``
    are one. The search ends, too, where it has done the work of looking at ``budget`` steps over
    chains, or where a route is more than ``dearest`` times as dear as the first. Returns all
    lines' points and pairs, where each line begins (n + 1,), and the work.
    """
    line = np.empty((64, 2))
    pair = np.empty((64, 2), np.int32)
    begin = np.zeros(wanted + 1, np.int32)
    if len(start.where) == 0 or len(goal.where) == 0:
        return line[:0], pair[:0], begin[:1].copy(), 0
    from_cost = gates_of(start, graph.chains.ends, floor)
    to_cost = gates_of(goal, graph.chains.ends, floor)
    _shut_repeats(start.access, from_cost.cost, rounding)
    _shut_repeats(goal.access, to_cost.cost, rounding)
    own = np.zeros(2 * len(graph.chains.ends), np.bool_)
    _bar_own(start.where, from_cost.cost, own)
    _bar_own(goal.where, to_cost.cost, own)
    ahead = left_to(graph, floor, start, goal)
    query = Query(graph, ahead, floor, from_cost, to_cost, own)
    table, work = _first_routes(query, start, goal)
    taken = np.zeros(wanted * 4 + 8, np.int32)
    told, laid = 0, 0
    limit = np.inf
    while laid < wanted and told < len(taken) and work <= budget:
        work += table.filled
        pick = _cheapest(table.routes, table.filled)
        if pick < 0 or table.routes[pick, COST] > limit:
            break
        if told == 0:
            limit = dearest * table.routes[pick, COST]
        taken[told], table.routes[pick, TAKEN] = pick, 1.0
        told += 1
        entry, out = int(table.routes[pick, ENTRY]), int(table.routes[pick, EXIT])
        way = table.steps[int(table.routes[pick, BEGIN]) : int(table.routes[pick, END])].copy()
        round_trip = entry >= 0 and (
            _passes(way, start.where[entry // 2, 0]) or _passes(way, goal.where[out // 2, 0])
        )
        if not round_trip:
            xy, beside = lay(graph.chains, start, entry, way, goal, out)
            line, pair = put_behind(line, pair, begin[laid], xy, beside)
            laid += 1
            begin[laid] = begin[laid - 1] + len(xy)
        if entry >= 0 and laid < wanted:
            most = limit * BEYOND
            table, work = _leave(query, table, taken[:told], pick, way, most, work, budget)
    return line[: begin[laid]], pair[: begin[laid]], begin[: laid + 1].copy(), work

"""The k cheapest routes over the chains without a loop, on flat arrays.

Rules and units
- Yen (1971): leave each route once at each node, for the cheapest continuation that no earlier
  route takes. Nodes before it are shut, so no route meets a node twice. A route that left another
  is left only from there on (Lawler 1972).
- A continuation costs at least the first step plus the least rest, and is sought only once nothing
  else can be cheaper, nor beyond the ``wanted`` cheapest answers.
- Two such routes are never shifts of one another: the chains are the free space shrunk.
- Entries, gates and steps are those of :mod:`planner.search.route_search_kernels`.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import NONE, grown, put_rows
from planner.search.chain_graph_kernels import ChainGraph, GateCosts, costs_from, pop, pushed
from planner.search.route_search_kernels import (
    CLEARED,
    between,
    gates_of,
    lay,
    search,
)

BEYOND = 1.0 + 1e-9
"""Multiple of the limit that is surely beyond it, in spite of rounding."""
COST, ENTRY, EXIT, BEGIN, END, LEFT, KIND = 0, 1, 2, 3, 4, 5, 6
"""Columns of a route: cost, gates, its steps' place among all steps, after how many steps it left
another, -1 at its gate, and kind."""
ANSWER, LOOP, SOUGHT = 0.0, 1.0, 2.0
"""A route; one that passes a station of its own, left like others and no answer; and where one was
left, with the least cost onwards."""


class Query(NamedTuple):
    """Fixed input of every search.

    ``ahead`` (n,) is the least cost from every node to the goal, then the costs of both stations'
    gates, steps over a station's ``own`` chain (2 c,), and the chains of the stations'
    entries.
    """

    graph: ChainGraph
    ahead: NDArray[np.float64]
    floor: float
    start: GateCosts
    goal: GateCosts
    own: NDArray[np.bool_]
    start_chains: NDArray[np.int32]
    goal_chains: NDArray[np.int32]


class Table(NamedTuple):
    """Routes found: ``filled`` rows of ``routes`` (r, 7), ``used`` of ``steps``.

    ``keys`` and ``items`` are a heap of the ``waiting`` rows by cost; ``least`` holds the
    ``wanted`` least costs of answers, ascending.
    """

    routes: NDArray[np.float64]
    steps: NDArray[np.int32]
    filled: np.int64
    used: np.int64
    keys: NDArray[np.float64]
    items: NDArray[np.int32]
    waiting: np.int64
    least: NDArray[np.float64]


@njit(**OWNING)
def _noted(query, table, cost, entry, out, root, rest, left):
    """Add the route with steps ``root`` and ``rest``, which is new, to the table.

    ``left`` is the number of steps after which it leaves another.
    """
    steps, begin = table.steps, table.used
    end = begin + len(root) + len(rest)
    if end > len(steps):
        steps = grown(steps, 2 * end)
    put_rows(steps, begin, root)
    put_rows(steps, begin + len(root), rest)
    kind = ANSWER
    if entry >= 0:
        way = steps[begin:end]
        loops = _passes(way, query.start_chains[entry // 2])
        if loops or _passes(way, query.goal_chains[out // 2]):
            kind = LOOP
    if kind == ANSWER:
        _insert(table.least, cost)
    return _put(table, steps, end, cost, entry, out, begin, end, left, kind)


@njit(**OWNING)
def _put(table, steps, used, cost, entry, out, begin, end, left, kind):
    routes, count = table.routes, table.filled
    if count == len(routes):
        routes = grown(routes, 2 * count)
    routes[count, COST], routes[count, ENTRY], routes[count, EXIT] = cost, entry, out
    routes[count, BEGIN], routes[count, END] = begin, end
    routes[count, LEFT], routes[count, KIND] = left, kind
    keys, items = pushed(table.keys, table.items, table.waiting, cost, count)
    return Table(routes, steps, count + 1, used, keys, items, table.waiting + 1, table.least)


@njit(**BORROWING)
def _insert(least, cost):
    k = len(least) - 1
    if k < 0 or cost >= least[k]:
        return
    while k > 0 and least[k - 1] > cost:
        least[k] = least[k - 1]
        k -= 1
    least[k] = cost


@njit(**BORROWING)
def _shut_repeats(access, cost, rounding):
    """Shut all gates but one entry's at each place: the routes beyond are equal.

    A station attached at a node enters every chain that ends there.
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
    """Bar the steps over a station's own chain if it is on one only."""
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
    passes = False
    for k in range(len(way)):
        passes = passes or way[k] // 2 == chain
    return passes


@njit(**BORROWING)
def _bar_told(table, told, entry, way, at, barred, to_cost):
    """Bar continuations of routes that share entry and first ``at`` steps with ``way``."""
    routes, steps = table.routes, table.steps
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


@njit(**OWNING, inline="always")
def _first_routes(query, start, goal, wanted):
    """New table with the cheapest route and those within one chain; also the work."""
    least = np.full(wanted, np.inf)
    none = np.int64(0)
    table = Table(
        np.empty((32, 7)), np.empty(64, np.int32), none, none,
        np.empty(32), np.empty(32, np.int32), none, least,
    )  # fmt: skip
    no_steps = np.empty(0, np.int32)
    shut = np.zeros(len(query.graph.around) - 1, np.bool_)
    best, entry, out, way, work = search(
        query.graph, query.ahead, query.floor, query.start, query.goal, shut, query.own,
        np.inf,
    )  # fmt: skip
    if best < np.inf:
        table = _noted(query, table, best, entry, out, no_steps, way, NONE)
    for i in range(len(start.where)):
        for j in range(len(goal.where)):
            if start.where[i, 0] == goal.where[j, 0]:
                wide, apart = between(query.graph, start, i, goal, j)
                if wide >= query.floor:
                    cost = start.price[i, 1] + goal.price[j, 1] + apart
                    table = _noted(query, table, cost, -1 - i, -1 - j, no_steps, no_steps, NONE)
    return table, work


@njit(**BORROWING)
def _bar_gates(table, told, from_cost):
    for t in range(len(told)):
        entry = int(table.routes[told[t], ENTRY])
        if entry >= 0:
            from_cost[entry] = np.inf


@njit(**BORROWING)
def _least_onwards(query, u, shut, barred, to_cost):
    """Least cost onwards from a node: out by a gate, or over a step."""
    graph, ends = query.graph, query.graph.chains.ends
    least = np.inf
    for i in range(len(query.goal.node)):
        if query.goal.node[i] == u:
            least = min(least, to_cost[i])
    for k in range(graph.around[u], graph.around[u + 1]):
        c, end = graph.leaving[k] // 2, graph.leaving[k] % 2
        v = ends[c, 1 - end]
        if graph.chains.clearance[c] < query.floor or shut[v] or barred[graph.leaving[k]]:
            continue
        least = min(least, graph.total[c] + query.ahead[v])
    return least


@njit(**OWNING)
def _leave(query, table, told, pick, most, work, budget):
    """Note the places to leave route ``pick``: its gate and each of its nodes.

    Skips those before it left another itself, or with continuations of cost ``most`` or more.
    Returns the table, and the work, which ends at ``budget``.
    """
    graph, ends = query.graph, query.graph.chains.ends
    routes = table.routes
    entry, first = int(routes[pick, ENTRY]), int(routes[pick, LEFT])
    begin = int(routes[pick, BEGIN])
    way = table.steps[begin : int(routes[pick, END])]
    shut = np.zeros(len(graph.around) - 1, np.bool_)
    barred, to_cost = query.own.copy(), query.goal.cost.copy()
    work += (len(shut) + len(barred)) // CLEARED
    if first < 0:
        cost = query.start.cost.copy()
        _bar_gates(table, told, cost)
        least = np.inf
        for i in range(len(cost)):
            least = min(least, cost[i] + query.ahead[query.start.node[i]])
        if least < most:
            table = _put(
                table, table.steps, table.used, least, entry, NONE, begin, begin, NONE, SOUGHT
            )
    u, gone = query.start.node[entry], query.start.cost[entry]
    for at in range(len(way) + 1):
        if at > 0:
            gone += graph.total[way[at - 1] // 2]
            u = ends[way[at - 1] // 2, 1 - way[at - 1] % 2]
        shut[u] = True
        if at < first:
            continue
        for i in range(len(to_cost)):
            to_cost[i] = query.goal.cost[i]
        _bar_told(table, told, entry, way, at, barred, to_cost)
        least = gone + _least_onwards(query, u, shut, barred, to_cost)
        for k in range(graph.around[u], graph.around[u + 1]):
            barred[graph.leaving[k]] = query.own[graph.leaving[k]]
        work += 1 + graph.around[u + 1] - graph.around[u] + len(told) * (at + 2)
        if least < most:
            table = _put(
                table, table.steps, table.used, least, entry, NONE, begin, begin + at, at, SOUGHT
            )
        if work > budget:
            break
    return table, work


@njit(**OWNING, inline="always")
def _seek(query, table, told, row, most):
    """Add the cheapest continuation from where a route was left; also return the work.

    It must cost less than ``most``.
    """
    graph, ends = query.graph, query.graph.chains.ends
    routes = table.routes
    entry, at = int(routes[row, ENTRY]), int(routes[row, LEFT])
    root = table.steps[int(routes[row, BEGIN]) : int(routes[row, END])].copy()
    shut = np.zeros(len(graph.around) - 1, np.bool_)
    barred, to_cost = query.own.copy(), query.goal.cost.copy()
    node, cost = query.start.node, query.start.cost.copy()
    if at < 0:
        _bar_gates(table, told, cost)
    else:
        u, gone = node[entry], cost[entry]
        shut[u] = True
        for k in range(at):
            gone += graph.total[root[k] // 2]
            u = ends[root[k] // 2, 1 - root[k] % 2]
            shut[u] = True
        _bar_told(table, told, entry, root, at, barred, to_cost)
        node, cost = np.full(1, u, np.int32), np.full(1, gone)
    found, way_in, way_out, rest, work = search(
        graph, query.ahead, query.floor, GateCosts(node, cost),
        GateCosts(query.goal.node, to_cost), shut, barred, most,
    )  # fmt: skip
    if found < np.inf:
        way_in = way_in if at < 0 else entry
        table = _noted(query, table, found, way_in, way_out, root, rest, at)
    return table, work + len(barred) // CLEARED + len(told) * (at + 2)


@njit(**OWNING)
def cheapest_routes(graph, floor, start, goal, wanted, rounding, budget, dearest):
    """Kernel of :func:`planner.search.chain_search.cheapest_routes`.

    Gates of ``start`` or ``goal`` within ``rounding`` count as one. Returns all lines' points and
    pairs, the start of each (n + 1,), and the work.
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
    ends = graph.chains.ends
    ahead = costs_from(graph, floor, gates_of(goal, ends, floor), gates_of(start, ends, floor))
    query = Query(
        graph, ahead, floor, from_cost, to_cost, own,
        start.where[:, 0].copy(), goal.where[:, 0].copy(),
    )  # fmt: skip
    table, work = _first_routes(query, start, goal, wanted)
    taken = np.zeros(wanted * 4 + 8, np.int32)
    told, laid = 0, 0
    limit = np.inf
    while laid < wanted and told < len(taken) and work <= budget and table.waiting > 0:
        cost, pick = pop(table.keys, table.items, table.waiting)
        if cost > limit:
            break
        routes, steps, filled, used, keys, items, waiting, least = table
        table = Table(routes, steps, filled, used, keys, items, waiting - 1, least)
        work += 1
        if table.routes[pick, KIND] == SOUGHT:
            most = BEYOND * min(limit, table.least[-1])
            table, more = _seek(query, table, taken[:told], pick, most)
            work += more
            continue
        if told == 0:
            limit = dearest * cost
        taken[told] = pick
        told += 1
        entry, out = int(table.routes[pick, ENTRY]), int(table.routes[pick, EXIT])
        way = table.steps[int(table.routes[pick, BEGIN]) : int(table.routes[pick, END])].copy()
        if table.routes[pick, KIND] == ANSWER:
            xy, beside = lay(graph.chains, start, entry, way, goal, out)
            last, end = begin[laid], begin[laid] + len(xy)
            if end > len(line):
                line, pair = grown(line, 2 * end), grown(pair, 2 * end)
            put_rows(line, last, xy)
            put_rows(pair, last, beside)
            laid += 1
            begin[laid] = end
        if entry >= 0 and laid < wanted:
            most = BEYOND * min(limit, table.least[-1])
            table, work = _leave(query, table, taken[:told], pick, most, work, budget)
    return line[: begin[laid]], pair[: begin[laid]], begin[: laid + 1].copy(), work

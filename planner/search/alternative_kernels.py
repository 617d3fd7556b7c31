"""The k cheapest routes over the chains without a loop, on flat arrays.

Rules and units
- Method: Yen (1971): every route found is left once at each of its nodes, for the cheapest way
  on that no route found before it takes. Nodes on the way there are shut, so no route meets
  a node twice.
- Two such routes are never shifts of one another: the chains are what is left of the free space
  when it is shrunk, and in a graph two ways without a step back and forth are shifts of one
  another only where they are the same.
- Entries, gates and steps are those of :mod:`planner.search.route_kernels`.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import BORROWING
from planner.search.route_kernels import (
    CLEARED,
    between,
    gates_of,
    lay,
    left_to,
    put_behind,
    search,
)

COST, ENTRY, EXIT, BEGIN, END, TAKEN = 0, 1, 2, 3, 4, 5
"""Columns of a route: what it costs, its gates, its steps' place among all steps, 1 once told."""


@njit(cache=True, nogil=True)
def _noted(routes, steps, count, cost, entry, out, root, rest):
    """Note a route with the steps ``root`` and then ``rest``, unless it is known; the tables."""
    n = len(root) + len(rest)
    for k in range(count):
        begin, end = int(routes[k, BEGIN]), int(routes[k, END])
        same = routes[k, ENTRY] == entry and routes[k, EXIT] == out and end - begin == n
        for i in range(n if same else 0):
            step = root[i] if i < len(root) else rest[i - len(root)]
            same = same and steps[begin + i] == step
        if same:
            return routes, steps, count
    begin = int(routes[count - 1, END]) if count > 0 else 0
    if count == len(routes):
        more = np.empty((2 * count, 6))
        more[:count] = routes
        routes = more
    if begin + n > len(steps):
        longer = np.empty(2 * (begin + n), np.int32)
        longer[:begin] = steps[:begin]
        steps = longer
    steps[begin : begin + len(root)] = root
    steps[begin + len(root) : begin + n] = rest
    routes[count, COST], routes[count, ENTRY], routes[count, EXIT] = cost, entry, out
    routes[count, BEGIN], routes[count, END], routes[count, TAKEN] = begin, begin + n, 0.0
    return routes, steps, count + 1


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


@njit(cache=True, nogil=True)
def cheapest_routes(
    around, leaving, ends, total, cost, clearance, points, first, pieces, proved, rho, gap,
    floor, s_where, s_access, s_price, g_where, g_access, g_price, wanted, rounding, budget,
):  # fmt: skip
    """The ``wanted`` cheapest routes, the cheapest first: fewer where there are no more.

    Entries nearer to one another than ``rounding`` are one. The search ends, too, where it has
    done the work of looking at ``budget`` steps over chains. Returns what
    :func:`planner.search.route_kernels.routes` does, and the work.
    """
    line = np.empty((64, 2))
    pair = np.empty((64, 2), np.int32)
    begin = np.zeros(wanted + 1, np.int32)
    none = np.empty(0, np.int32)
    same = np.ones(len(total))
    s_node, s_cost = gates_of(s_where, s_price, ends, floor, same)
    g_node, g_cost = gates_of(g_where, g_price, ends, floor, same)
    _shut_repeats(s_access, s_cost, rounding)
    _shut_repeats(g_access, g_cost, rounding)
    shut = np.zeros(len(around) - 1, np.bool_)
    own = np.zeros(2 * len(ends), np.bool_)
    _bar_own(s_where, s_cost, own)
    _bar_own(g_where, g_cost, own)
    routes = np.empty((32, 6))
    steps = np.empty(64, np.int32)
    count = 0
    if len(s_where) == 0 or len(g_where) == 0:
        return line[:0], pair[:0], begin[:1].copy(), 0
    ahead = left_to(
        around, leaving, ends, total, clearance, floor, s_where, s_price, g_where, g_price
    )
    best, entry, out, way, work = search(
        around, leaving, ends, total, clearance, same, ahead, floor, s_node, s_cost,
        g_node, g_cost, shut, own,
    )  # fmt: skip
    if best < np.inf:
        routes, steps, count = _noted(routes, steps, count, best, entry, out, none, way)
    for i in range(len(s_where)):
        for j in range(len(g_where)):
            if s_where[i, 0] == g_where[j, 0]:
                wide, apart = between(
                    first, rho, gap, cost, proved, s_where, s_price, i, g_where, g_price, j
                )
                if wide >= floor:
                    routes, steps, count = _noted(
                        routes, steps, count, s_price[i, 1] + g_price[j, 1] + apart,
                        -1 - i, -1 - j, none, none,
                    )  # fmt: skip
    taken = np.empty(wanted * 4 + 8, np.int32)
    told, laid = 0, 0
    while laid < wanted and told < len(taken) and work <= budget:
        work += count
        pick, least = -1, np.inf
        for k in range(count):
            if routes[k, TAKEN] == 0.0 and routes[k, COST] < least:
                pick, least = k, routes[k, COST]
        if pick < 0:
            break
        taken[told], routes[pick, TAKEN] = pick, 1.0
        told += 1
        entry, out = int(routes[pick, ENTRY]), int(routes[pick, EXIT])
        way = steps[int(routes[pick, BEGIN]) : int(routes[pick, END])].copy()
        round_trip = entry >= 0 and (
            _passes(way, s_where[entry // 2, 0]) or _passes(way, g_where[out // 2, 0])
        )
        if not round_trip:
            xy, beside = lay(
                points, first, pieces, proved, s_where, s_access, s_price, entry, way,
                g_where, g_access, g_price, out,
            )  # fmt: skip
            line, pair = put_behind(line, pair, begin[laid], xy, beside)
            laid += 1
            begin[laid] = begin[laid - 1] + len(xy)
        if entry < 0:
            continue
        # leave it at its gate (-1), and then at each of its nodes
        shut[:] = False
        gone = 0.0
        for at in range(-1, len(way) + 1):
            barred = own.copy()
            from_node, from_cost, to_cost = s_node, s_cost.copy(), g_cost.copy()
            if at < 0:
                for t in range(told):
                    if routes[taken[t], ENTRY] >= 0:
                        from_cost[int(routes[taken[t], ENTRY])] = np.inf
            else:
                if at == 0:
                    u, gone = s_node[entry], s_cost[entry]
                else:
                    gone += total[way[at - 1] // 2]
                    u = ends[way[at - 1] // 2, 1 - way[at - 1] % 2]
                for t in range(told):
                    k = taken[t]
                    lo, hi = int(routes[k, BEGIN]), int(routes[k, END])
                    shares = routes[k, ENTRY] == entry and hi - lo >= at
                    for i in range(at if shares else 0):
                        shares = shares and steps[lo + i] == way[i]
                    if shares and hi - lo > at:
                        barred[steps[lo + at]] = True
                    elif shares:
                        to_cost[int(routes[k, EXIT])] = np.inf
                from_node, from_cost = np.full(1, u, np.int32), np.full(1, gone)
                shut[u] = True
            found, way_in, way_out, rest, steps_looked_at = search(
                around, leaving, ends, total, clearance, same, ahead, floor, from_node, from_cost,
                g_node, to_cost, shut, barred,
            )  # fmt: skip
            work += steps_looked_at + len(own) // CLEARED + told * (at + 2) + count
            if found < np.inf:
                routes, steps, count = _noted(
                    routes, steps, count, found, way_in if at < 0 else entry, way_out,
                    way[: max(at, 0)], rest,
                )  # fmt: skip
            if work > budget:
                break
    return line[: begin[laid]], pair[: begin[laid]], begin[: laid + 1].copy(), work

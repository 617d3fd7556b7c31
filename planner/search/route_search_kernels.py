"""Routes over the roadmap's chains, searched and laid out as lines, on flat arrays.

Rules and units
- Chains and links are those of :mod:`planner.search.chain_graph_kernels`.
- Gate 2 i + end leads over a station's entry i (:class:`planner.search.chain_graph_kernels.Gates`)
  to that end of its chain.
- A laid route is points (n, 2) and pairs (n, 2): the pieces left and right of the link to the next
  point, -1 if the link is straight.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import NONE
from planner.search.chain_graph_kernels import GateCosts, pop, push, pushed

CLEARED = 8
"""Nodes that are made ready for a search in the time of one step of it."""


@njit(**OWNING)
def gates_of(gates, ends, floor):
    """Cost of every gate, infinity if its clearance is below ``floor``."""
    where, price = gates.where, gates.price
    m = len(where)
    node = np.empty(2 * m, np.int32)
    cost = np.empty(2 * m)
    for i in range(m):
        c = where[i, 0]
        for end in range(2):
            node[2 * i + end] = ends[c, end]
            wide = min(price[i, 2], price[i, 4 + 2 * end]) >= floor
            cost[2 * i + end] = price[i, 1] + price[i, 3 + 2 * end] if wide else np.inf
    return GateCosts(node, cost)


@njit(**BORROWING)
def between(graph, start, i, goal, j):
    """Clearance and cost of the way within one chain from the start's entry i to the goal's j.

    Only the part between them counts; clearance is monotone along a proved link.
    """
    first, rho, gap = graph.chains.first, graph.chains.rho, graph.chains.gap
    cost, proved, price, other_price = graph.cost, graph.chains.proved, start.price, goal.price
    c, a, b = start.where[i, 0], start.where[i, 1], goal.where[j, 1]
    lo, hi = min(a, b), max(a, b)
    wide = min(price[i, 2], other_price[j, 2])
    if first[c + 1] - first[c] == 1:
        return min(wide, rho[lo]), 0.0
    apart = other_price[j, 0] * cost[b] - price[i, 0] * cost[a]
    total = 0.0
    for k in range(lo, hi):
        total += cost[k]
        if k > lo:
            wide = min(wide, gap[k])
    if lo < hi:
        wide = min(wide, rho[lo + 1] if proved[lo] else gap[lo])
        wide = min(wide, rho[hi] if proved[hi] else gap[hi])
    elif not proved[lo]:
        wide = min(wide, gap[lo])
    return wide, abs(apart + (total if b > a else -total))


@njit(**OWNING)
def search(graph, ahead, floor, start, goal, shut, barred, most):
    """The cheapest way from the ``start``'s gates to the ``goal``'s, avoiding ``shut`` nodes (n,).

    A* over chains of clearance ``floor`` or more; ``ahead`` (n,) is each node's least cost to the
    goal (:func:`costs_from`). Steps ``barred`` (2 chains,) and ways of cost ``most`` or more are
    excluded. Returns the cost, infinity without a way, both gates, the chains in order as chain * 2
    + starting end, and the work: steps examined, plus clearing the nodes.
    """
    around, leaving, total = graph.around, graph.leaving, graph.total
    ends, clearance = graph.chains.ends, graph.chains.clearance
    s_node, s_cost = start
    g_node, g_cost = goal
    n = len(around) - 1
    far = np.full(n, np.inf)
    came = np.full(n, -1, np.int32)
    gate = np.full(n, -1, np.int32)
    keys = np.empty(64)
    items = np.empty(64, np.int32)
    size, work = np.int64(0), n // CLEARED
    best, out, exit_node = most, -1, -1
    for i in range(len(s_node)):
        u = s_node[i]
        if s_cost[i] < far[u]:
            far[u], gate[u] = s_cost[i], i
            keys, items = pushed(keys, items, size, far[u] + ahead[u], u)
            size += 1
    while size > 0:
        key, u = pop(keys, items, size)
        size -= 1
        d = far[u]
        if key > d + ahead[u]:
            continue
        if key >= best:
            break
        work += 1 + around[u + 1] - around[u]
        for i in range(len(g_node)):
            if g_node[i] == u and d + g_cost[i] < best:
                best, out, exit_node = d + g_cost[i], i, u
        for k in range(around[u], around[u + 1]):
            c, end = leaving[k] // 2, leaving[k] % 2
            v = ends[c, 1 - end]
            if clearance[c] < floor or shut[v] or barred[leaving[k]]:
                continue
            there = d + total[c]
            if there < far[v]:
                far[v], came[v], gate[v] = there, leaving[k], -1
                if there + ahead[v] < best:
                    keys, items = pushed(keys, items, size, there + ahead[v], v)
                    size += 1
    steps = np.empty(n, np.int32)
    count = 0
    u = exit_node
    while u >= 0 and gate[u] < 0:
        steps[count] = came[u]
        count += 1
        u = ends[came[u] // 2, came[u] % 2]
    entry = gate[u] if u >= 0 else -1
    if exit_node < 0:
        best = np.inf
    return best, entry, out, steps[:count][::-1].copy(), work


@njit(**BORROWING)
def _add(line, pair, m, x, y, left, right):
    """Write a point and the pair of its link; a repeated point takes the later link."""
    if m > 0 and line[m - 1, 0] == x and line[m - 1, 1] == y:
        m -= 1
    line[m, 0], line[m, 1] = x, y
    pair[m, 0], pair[m, 1] = left, right
    return m + 1


@njit(**BORROWING)
def _beside(pieces, proved, link, forwards):
    """Pieces left and right of a link walked this way, -1 if it is straight."""
    if not proved[link]:
        return NONE, NONE
    left, right = np.int64(pieces[link, 0]), np.int64(pieces[link, 1])
    return (left, right) if forwards else (right, left)


@njit(**BORROWING)
def _add_points(chains, a, b, forwards, through, line, pair, m):
    """Write the points from a to b inclusive, none if b is behind a.

    ``through``: the link after b is walked, too.
    """
    points, pieces, proved = chains.points, chains.pieces, chains.proved
    step = 1 if forwards else -1
    for k in range((b - a) * step + 1):
        i = a + step * k
        left, right = NONE, NONE
        if i != b or through:
            left, right = _beside(pieces, proved, i if forwards else i - 1, forwards)
        m = _add(line, pair, m, points[i, 0], points[i, 1], left, right)
    return m


@njit(**BORROWING)
def _walk(chains, chain, entered, left_at, forwards, line, pair, m):
    """Write a chain's points between two of its links; -1 means its end there."""
    lo, hi = np.int64(chains.first[chain]), np.int64(chains.first[chain + 1]) - 1
    if forwards:
        a = lo if entered < 0 else entered + 1
        b = hi if left_at < 0 else left_at
    else:
        a = hi if entered < 0 else entered
        b = lo if left_at < 0 else left_at + 1
    if entered >= 0 and lo == hi:
        return m
    return _add_points(chains, a, b, forwards, left_at >= 0, line, pair, m)


@njit(**OWNING)
def lay(chains, start, s_gate, steps, goal, g_gate):
    """The route in through gate ``s_gate``, over ``steps`` and out through ``g_gate``.

    Gates below 0 mean entries -1 - gate, both on one chain, and the way within it.
    """
    first, pieces, proved = chains.first, chains.pieces, chains.proved
    s_where, s_access, s_price = start
    g_where, g_access, g_price = goal
    inside = s_gate < 0
    a = -1 - s_gate if inside else s_gate // 2
    b = -1 - g_gate if inside else g_gate // 2
    c, e = np.int64(s_where[a, 0]), np.int64(g_where[b, 0])
    capacity = 8 + first[c + 1] - first[c] + first[e + 1] - first[e]
    for k in range(len(steps)):
        capacity += first[steps[k] // 2 + 1] - first[steps[k] // 2]
    line = np.empty((capacity, 2))
    pair = np.empty((capacity, 2), np.int32)
    la, lb = np.int64(s_where[a, 1]), np.int64(g_where[b, 1])
    forwards = s_gate % 2 == 1
    if inside:
        forwards = la < lb or (la == lb and s_price[a, 0] <= g_price[b, 0])
    m = np.int64(0)
    for k in range(2):
        m = _add(line, pair, m, s_access[a, k, 0], s_access[a, k, 1], NONE, NONE)
    left, right = _beside(pieces, proved, la, forwards)
    m = _add(line, pair, m, s_access[a, 2, 0], s_access[a, 2, 1], left, right)
    if inside:
        if la != lb:
            m = _walk(chains, c, la, lb, forwards, line, pair, m)
    else:
        m = _walk(chains, c, la, NONE, forwards, line, pair, m)
        for k in range(len(steps)):
            s, onwards = np.int64(steps[k] // 2), steps[k] % 2 == 0
            m = _walk(chains, s, NONE, NONE, onwards, line, pair, m)
        forwards = g_gate % 2 == 0
        if first[e + 1] - first[e] > 1:
            m = _walk(chains, e, NONE, lb, forwards, line, pair, m)
    for k in range(2, -1, -1):
        m = _add(line, pair, m, g_access[b, k, 0], g_access[b, k, 1], NONE, NONE)
    return line[:m].copy(), pair[:m].copy()


@njit(**OWNING)
def widest_way(graph, start, goal):
    """Largest least clearance of any way from the start's entries to the goal's, or -inf."""
    around, leaving = graph.around, graph.leaving
    ends, clearance = graph.chains.ends, graph.chains.clearance
    s_where, s_price, g_where, g_price = start.where, start.price, goal.where, goal.price
    n = len(around) - 1
    wide = np.full(n, -np.inf)
    capacity = len(leaving) + 2 * len(s_where) + 1
    keys = np.empty(capacity)
    items = np.empty(capacity, np.int32)
    size = np.int64(0)
    best = -np.inf
    for i in range(len(s_where)):
        for end in range(2):
            u, w = ends[s_where[i, 0], end], min(s_price[i, 2], s_price[i, 4 + 2 * end])
            if w > wide[u]:
                wide[u] = w
                push(keys, items, size, -w, u)
                size += 1
        for j in range(len(g_where)):
            if s_where[i, 0] == g_where[j, 0]:
                w, _ = between(graph, start, i, goal, j)
                best = max(best, w)
    while size > 0:
        key, u = pop(keys, items, size)
        size -= 1
        if -key < wide[u]:
            continue
        if -key <= best:
            break
        for j in range(len(g_where)):
            for end in range(2):
                if ends[g_where[j, 0], end] == u:
                    best = max(best, min(-key, g_price[j, 2], g_price[j, 4 + 2 * end]))
        for k in range(around[u], around[u + 1]):
            c, end = leaving[k] // 2, leaving[k] % 2
            v = ends[c, 1 - end]
            w = min(-key, clearance[c])
            if w > wide[v]:
                wide[v] = w
                push(keys, items, size, -w, v)
                size += 1
    return best

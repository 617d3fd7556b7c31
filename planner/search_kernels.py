"""Attaching a place to the roadmap, and searching the roadmap, on flat arrays.

Rules and units
- Chains are numbered as :func:`planner.agvd_kernels.trace_chains` leaves them; chain c's points
  are ``points[first[c] : first[c + 1]]``, and link i runs from point i to point i + 1.
- A gate is a way onto the roadmap's nodes: ``node``, what it costs to get there, and the
  clearance on the way.
- Costs are lengths, or lengths weighted where the clearance is small; never negative.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import numpy as np
from numba import njit

from planner.distance_kernels import foot, nearest, point_to_segment

SHRINKS = 60
"""Steps of the shrinking ball; it took at most 12 on random scenes."""


@njit(cache=True, nogil=True)
def retract(kind, data, order, large, boxes, x, y, reach):
    """Move (x, y) away from the nearest border until a second border is as near.

    The shrinking ball of Ma, Bae and Choi (2012): a ball through the nearest foot, centred
    on the ray from it through (x, y), shrinks until no border is inside. Returns the centre,
    its radius and the two primitives. ``reach`` is the first ball's radius, larger than any
    clearance in the scene.
    """
    d, a = nearest(kind, data, order, large, boxes, x, y, np.inf)
    fx, fy = foot(kind, data, a, x, y)
    if d <= 0.0:
        return x, y, d, a, a
    nx, ny = (x - fx) / d, (y - fy) / d
    r, b = max(reach, d), a
    for _ in range(SHRINKS):
        cx, cy = fx + r * nx, fy + r * ny
        _, i = nearest(kind, data, order, large, boxes, cx, cy, r * (1.0 - 1e-12))
        if i < 0:
            break
        qx, qy = foot(kind, data, i, cx, cy)
        wx, wy = qx - fx, qy - fy
        along = nx * wx + ny * wy
        if along <= 0.0:
            break
        smaller = 0.5 * (wx * wx + wy * wy) / along
        if smaller < d:
            r, b = d, i
            break
        if smaller >= r:
            break
        r, b = smaller, i
    return fx + r * nx, fy + r * ny, r, a, b


@njit(cache=True, nogil=True)
def nearest_links(points, first, usable, x, y, count):
    """The links nearest to (x, y), at most one a chain: chain, point index, part, distance."""
    chain = np.full(count, -1, np.int32)
    link = np.zeros(count, np.int32)
    part = np.zeros(count)
    away = np.full(count, np.inf)
    for c in range(len(first) - 1):
        if not usable[c]:
            continue
        best, bi, bt = np.inf, -1, 0.0
        for i in range(first[c], max(first[c] + 1, first[c + 1] - 1)):
            j = min(i + 1, first[c + 1] - 1)
            d, t = point_to_segment(x, y, points[i, 0], points[i, 1], points[j, 0], points[j, 1])
            if d < best:
                best, bi, bt = d, i, t
        if best >= away[count - 1]:
            continue
        k = count - 1
        while k > 0 and away[k - 1] > best:
            chain[k], link[k], part[k], away[k] = (
                chain[k - 1],
                link[k - 1],
                part[k - 1],
                away[k - 1],
            )
            k -= 1
        chain[k], link[k], part[k], away[k] = c, bi, bt, best
    return chain, link, part, away


@njit(cache=True, nogil=True)
def chain_costs(rho, gap, step, first, length, radius, weight):
    """The cost of every link and chain: length times 1 + weight * radius / clearance."""
    cost = np.zeros(len(step))
    total = np.zeros(len(length))
    for c in range(len(length)):
        for i in range(first[c], first[c + 1] - 1):
            near = max(gap[i], 1e-12)
            cost[i] = step[i] * (1.0 + weight * radius / near)
            total[c] += cost[i]
    return cost, total


@njit(cache=True, nogil=True)
def adjacency(ends, nodes):
    """Chains around every node: offsets (nodes + 1,) and chain * 2 + end leaving it."""
    first = np.zeros(nodes + 1, np.int32)
    for c in range(len(ends)):
        first[ends[c, 0] + 1] += 1
        first[ends[c, 1] + 1] += 1
    for n in range(nodes):
        first[n + 1] += first[n]
    fill = first[:-1].copy()
    leaving = np.empty(2 * len(ends), np.int32)
    for c in range(len(ends)):
        for end in range(2):
            n = ends[c, end]
            leaving[fill[n]] = 2 * c + end
            fill[n] += 1
    return first, leaving


@njit(cache=True, nogil=True)
def push(keys, items, size, key, item):
    """Put an item into the heap; ``size`` is the number of entries before."""
    i = size
    while i > 0 and keys[(i - 1) // 2] > key:
        keys[i], items[i] = keys[(i - 1) // 2], items[(i - 1) // 2]
        i = (i - 1) // 2
    keys[i], items[i] = key, item


@njit(cache=True, nogil=True)
def pop(keys, items, size):
    """Take the least; ``size`` is the number of entries before. Returns key, item."""
    key, item = keys[0], items[0]
    last_key, last_item = keys[size - 1], items[size - 1]
    i, n = 0, size - 1
    while True:
        child = 2 * i + 1
        if child >= n:
            break
        if child + 1 < n and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= last_key:
            break
        keys[i], items[i] = keys[child], items[child]
        i = child
    keys[i], items[i] = last_key, last_item
    return key, item


@njit(cache=True, nogil=True)
def cheapest(around, leaving, ends, cost, clearance, floor, s_node, s_cost, g_node, g_cost):
    """The cheapest way from the start's gates to the goal's over chains not below ``floor``.

    Dijkstra. Returns the total (inf where there is none), the start's and the goal's gate,
    and the chains in order as chain * 2 + end walked from.
    """
    n = len(around) - 1
    far = np.full(n, np.inf)
    came = np.full(n, -1, np.int32)
    gate = np.full(n, -1, np.int32)
    room = len(leaving) + len(s_node) + 1
    keys = np.empty(room)
    items = np.empty(room, np.int32)
    size = 0
    for i in range(len(s_node)):
        if s_cost[i] < far[s_node[i]]:
            far[s_node[i]], gate[s_node[i]] = s_cost[i], i
            push(keys, items, size, s_cost[i], s_node[i])
            size += 1
    best, out, exit_node = np.inf, -1, -1
    while size > 0:
        d, u = pop(keys, items, size)
        size -= 1
        if d > far[u]:
            continue
        if d >= best:
            break
        for i in range(len(g_node)):
            if g_node[i] == u and d + g_cost[i] < best:
                best, out, exit_node = d + g_cost[i], i, u
        for k in range(around[u], around[u + 1]):
            c, end = leaving[k] // 2, leaving[k] % 2
            if clearance[c] < floor:
                continue
            v = ends[c, 1 - end]
            if d + cost[c] < far[v]:
                far[v], came[v], gate[v] = d + cost[c], leaving[k], -1
                push(keys, items, size, far[v], v)
                size += 1
    steps = np.empty(n, np.int32)
    count = 0
    u = exit_node
    while u >= 0 and gate[u] < 0:
        steps[count] = came[u]
        count += 1
        u = ends[came[u] // 2, came[u] % 2]
    entry = gate[u] if u >= 0 else -1
    return best, entry, out, steps[:count][::-1].copy()


@njit(cache=True, nogil=True)
def costs_from(around, leaving, ends, cost, clearance, floor, s_node, s_cost):
    """What the cheapest way from the gates to every node costs (n,), inf where there is none."""
    n = len(around) - 1
    far = np.full(n, np.inf)
    room = len(leaving) + len(s_node) + 1
    keys = np.empty(room)
    items = np.empty(room, np.int32)
    size = 0
    for i in range(len(s_node)):
        if s_cost[i] < far[s_node[i]]:
            far[s_node[i]] = s_cost[i]
            push(keys, items, size, s_cost[i], s_node[i])
            size += 1
    while size > 0:
        d, u = pop(keys, items, size)
        size -= 1
        if d > far[u]:
            continue
        for k in range(around[u], around[u + 1]):
            c, end = leaving[k] // 2, leaving[k] % 2
            if clearance[c] < floor:
                continue
            v = ends[c, 1 - end]
            if d + cost[c] < far[v]:
                far[v] = d + cost[c]
                push(keys, items, size, far[v], v)
                size += 1
    return far


@njit(cache=True, nogil=True)
def widest(around, leaving, ends, clearance, s_node, s_gap, g_node, g_gap):
    """The largest least clearance of any way from the start's gates to the goal's, or -inf."""
    n = len(around) - 1
    wide = np.full(n, -np.inf)
    room = len(leaving) + len(s_node) + 1
    keys = np.empty(room)
    items = np.empty(room, np.int32)
    size = 0
    for i in range(len(s_node)):
        if s_gap[i] > wide[s_node[i]]:
            wide[s_node[i]] = s_gap[i]
            push(keys, items, size, -s_gap[i], s_node[i])
            size += 1
    best = -np.inf
    while size > 0:
        d, u = pop(keys, items, size)
        size -= 1
        if -d < wide[u]:
            continue
        if -d <= best:
            break
        for i in range(len(g_node)):
            if g_node[i] == u:
                best = max(best, min(-d, g_gap[i]))
        for k in range(around[u], around[u + 1]):
            c, end = leaving[k] // 2, leaving[k] % 2
            v = ends[c, 1 - end]
            w = min(-d, clearance[c])
            if w > wide[v]:
                wide[v] = w
                push(keys, items, size, -w, v)
                size += 1
    return best

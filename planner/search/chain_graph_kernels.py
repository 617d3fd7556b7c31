"""The roadmap's chains as a graph with costs, and shortest distances, on flat arrays.

Rules and units
- Chain c's points are ``points[first[c] : first[c + 1]]``
  (:func:`planner.diagram.chains.trace_kernels.trace_chains`); link i leads from point i to point i
  + 1.
- A gate is a way onto the roadmap's nodes: ``node``, its cost, and its clearance.
- Costs are lengths, weighted where the clearance is small; never negative.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from planner.diagram.diagram_arrays import ChainArrays
from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import grown

NEAREST = 1e-12
"""A link costs no more than one of this clearance does."""


class ChainGraph(NamedTuple):
    """The chains as a graph.

    ``cost`` (p,) of the link from each point, ``total`` (c,) of every chain; node n has the chains
    ``leaving[around[n] : around[n + 1]]``, as chain * 2 + end.
    """

    chains: ChainArrays
    cost: NDArray[np.float64]
    total: NDArray[np.float64]
    around: NDArray[np.int32]
    leaving: NDArray[np.int32]


class Gates(NamedTuple):
    """A station's m ways onto the chains, the nearest first.

    ``where`` (m, 2) are chain and link; ``access`` (m, 3, 2) leads from the station over the
    retracted place to the chain; ``price`` (m, 7) is the passed part of the link, the access's
    length and exact clearance, and cost and clearance to the chain's first and last end.
    """

    where: NDArray[np.int32]
    access: NDArray[np.float64]
    price: NDArray[np.float64]


class GateCosts(NamedTuple):
    """``node`` and ``cost`` (2 m,) of a station's gates to both ends of their chains.

    A way too narrow costs infinity.
    """

    node: NDArray[np.int32]
    cost: NDArray[np.float64]


@njit(**OWNING)
def price_chains(chains, nodes, radius, weight):
    """Compute the :class:`ChainGraph` fields of chains between ``nodes`` nodes.

    A link costs its length times 1 + weight * radius / clearance.
    """
    gap, step, first, ends = chains.gap, chains.step, chains.first, chains.ends
    cost = np.zeros(len(step))
    total = np.zeros(len(chains.length))
    for c in range(len(total)):
        for i in range(first[c], first[c + 1] - 1):
            near = max(gap[i], NEAREST)
            cost[i] = step[i] * (1.0 + weight * radius / near)
            total[c] += cost[i]
    around = np.zeros(nodes + 1, np.int32)
    for c in range(len(ends)):
        around[ends[c, 0] + 1] += 1
        around[ends[c, 1] + 1] += 1
    for n in range(nodes):
        around[n + 1] += around[n]
    fill = around[:-1].copy()
    leaving = np.empty(2 * len(ends), np.int32)
    for c in range(len(ends)):
        for end in range(2):
            n = ends[c, end]
            leaving[fill[n]] = 2 * c + end
            fill[n] += 1
    return cost, total, around, leaving


@njit(**BORROWING)
def push(keys, items, size, key, item):
    """Put an item into the heap of ``size`` entries."""
    i = size
    while i > 0 and keys[(i - 1) // 2] > key:
        keys[i], items[i] = keys[(i - 1) // 2], items[(i - 1) // 2]
        i = (i - 1) // 2
    keys[i], items[i] = key, item


@njit(**BORROWING)
def pop(keys, items, size):
    """Take the least of ``size`` entries."""
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


@njit(**OWNING)
def pushed(keys, items, size, key, item):
    """Put an item into the heap, grown if full."""
    if size == len(keys):
        keys, items = grown(keys, 2 * size + 8), grown(items, 2 * size + 8)
    push(keys, items, size, key, item)
    return keys, items


@njit(**OWNING, inline="always")
def costs_from(graph, floor, start, goal):
    """Cheapest cost from the start's gates to every node (n,), inf if unreachable.

    Dijkstra over :class:`GateCosts`, as far as the goal's first gate, if any; farther nodes get the
    farthest cost reached, a lower bound.
    """
    around, leaving, cost = graph.around, graph.leaving, graph.total
    ends, clearance = graph.chains.ends, graph.chains.clearance
    s_node, s_cost = start
    g_node, g_cost = goal
    n = len(around) - 1
    far = np.full(n, np.inf)
    keys = np.empty(n + 8)
    items = np.empty(n + 8, np.int32)
    size = np.int64(0)
    best = np.inf
    for i in range(len(s_node)):
        if s_cost[i] < far[s_node[i]]:
            far[s_node[i]] = s_cost[i]
            keys, items = pushed(keys, items, size, s_cost[i], s_node[i])
            size += 1
    while size > 0:
        d, u = pop(keys, items, size)
        size -= 1
        if d > far[u]:
            continue
        for i in range(len(g_node)):
            if g_node[i] == u:
                best = min(best, d + g_cost[i])
        if d >= best:
            for v in range(n):
                far[v] = min(far[v], d)
            break
        for k in range(around[u], around[u + 1]):
            c, end = leaving[k] // 2, leaving[k] % 2
            if clearance[c] < floor:
                continue
            v = ends[c, 1 - end]
            if d + cost[c] < far[v]:
                far[v] = d + cost[c]
                keys, items = pushed(keys, items, size, far[v], v)
                size += 1
    return far

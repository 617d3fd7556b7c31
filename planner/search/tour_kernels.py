"""Orders of stations, compiled: exact by dynamic programming, good by local search.

Rules are those of :func:`planner.search.tour.best_tour`.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import put_rows


@njit(**OWNING)
def held_karp(distance):
    """The cheapest order (Held and Karp 1962) and its cost: O(n^2 2^n) for n inner stations.

    ``distance`` (m, m); the first and last station stay.
    """
    m = distance.shape[0]
    n = m - 2
    end = m - 1
    order = np.empty(n, dtype=np.int64)
    if n == 0:
        return order, distance[0, end]
    full = 1 << n
    cost = np.full((full, n), np.inf)
    came = np.full((full, n), -1, dtype=np.int8)
    for j in range(n):
        cost[1 << j, j] = distance[0, j + 1]
    for visited in range(1, full):
        for j in range(n):
            here = cost[visited, j]
            if here == np.inf or not visited & (1 << j):
                continue
            for k in range(n):
                bit = 1 << k
                if visited & bit:
                    continue
                there = here + distance[j + 1, k + 1]
                if there < cost[visited | bit, k]:
                    cost[visited | bit, k] = there
                    came[visited | bit, k] = j
    best, last = np.inf, -1
    for j in range(n):
        total = cost[full - 1, j] + distance[j + 1, end]
        if total < best:
            best, last = total, j
    if last < 0:
        for j in range(n):
            order[j] = j + 1
        return order, np.inf
    visited, j = full - 1, last
    for at in range(n - 1, -1, -1):
        order[at] = j + 1
        before = int(came[visited, j])
        visited ^= 1 << j
        j = before
    return order, best


@njit(**BORROWING)
def tour_cost(distance, tour):
    """Length of ``tour``, ends included."""
    total = 0.0
    for k in range(tour.shape[0] - 1):
        total += distance[tour[k], tour[k + 1]]
    return total


@njit(**OWNING)
def cheapest_insertion(distance, inner, end):
    """A first tour from 0 to ``end``: repeatedly insert the station that costs least."""
    n = inner.shape[0]
    tour = np.empty(n + 2, dtype=np.int64)
    tour[0], tour[1] = 0, end
    size = 2
    left = np.ones(n, dtype=np.bool_)
    for _ in range(n):
        best, what, where = np.inf, -1, -1
        for i in range(n):
            if not left[i]:
                continue
            s = inner[i]
            for k in range(size - 1):
                extra = (
                    distance[tour[k], s] + distance[s, tour[k + 1]] - distance[tour[k], tour[k + 1]]
                )
                if extra < best:
                    best, what, where = extra, i, k + 1
        if what < 0:
            for i in range(n):
                if left[i]:
                    what, where = i, size - 1
                    break
        for k in range(size, where, -1):
            tour[k] = tour[k - 1]
        tour[where] = inner[what]
        left[what] = False
        size += 1
    return tour


@njit(**OWNING)
def improve(distance, tour, tolerance):
    """2-opt and Or-opt moves, in place, until none gains more than ``tolerance``.

    2-opt reverses a stretch, so it compares both directions' costs; Or-opt moves up to three
    stations elsewhere, either way round (Or 1976). The ends stay.
    """
    size = tour.shape[0]
    better = True
    while better:
        better = False
        for i in range(1, size - 2):
            inside = 0.0
            turned = 0.0
            for j in range(i + 1, size - 1):
                inside += distance[tour[j - 1], tour[j]]
                turned += distance[tour[j], tour[j - 1]]
                old = distance[tour[i - 1], tour[i]] + inside + distance[tour[j], tour[j + 1]]
                new = distance[tour[i - 1], tour[j]] + turned + distance[tour[i], tour[j + 1]]
                if new < old - tolerance:
                    put_rows(tour, i, tour[i : j + 1][::-1].copy())
                    inside, turned = turned, inside
                    better = True
        if _or_opt(distance, tour, tolerance):
            better = True
    return tour


@njit(**OWNING)
def _or_opt(distance, tour, tolerance):
    size = tour.shape[0]
    found = False
    for length in range(1, 4):
        for i in range(1, size - length):
            before = tour_cost(distance, tour)
            block = tour[i : i + length].copy()
            rest = np.concatenate((tour[:i], tour[i + length :]))
            best, where, turned = before - tolerance, -1, False
            gap = before
            for k in range(length + 1):
                gap -= distance[tour[i - 1 + k], tour[i + k]]
            gap += distance[tour[i - 1], tour[i + length]]
            inside = tour_cost(distance, block)
            back = tour_cost(distance, block[::-1])
            for k in range(rest.shape[0] - 1):
                a, b = rest[k], rest[k + 1]
                base = gap - distance[a, b]
                there = base + distance[a, block[0]] + inside + distance[block[-1], b]
                if there < best:
                    best, where, turned = there, k, False
                there = base + distance[a, block[-1]] + back + distance[block[0], b]
                if there < best:
                    best, where, turned = there, k, True
            if where >= 0:
                put = block[::-1].copy() if turned else block
                new = np.concatenate((rest[: where + 1], put, rest[where + 1 :]))
                for k in range(size):
                    tour[k] = new[k]
                found = True
    return found

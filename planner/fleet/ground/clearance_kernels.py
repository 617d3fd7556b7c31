"""Distances of many edges from the borders, and near pairs of places."""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import polyline_clearance
from planner.scene.compile_options import OWNING


@njit(**OWNING)
def edge_clearances(tree, places, edges):
    """Least distance of each edge (m, 2) between two of the places (n, 2) to any border."""
    found = np.empty(edges.shape[0])
    line = np.empty((2, 2))
    for e in range(edges.shape[0]):
        for k in range(2):
            line[k, 0], line[k, 1] = places[edges[e, k], 0], places[edges[e, k], 1]
        found[e] = polyline_clearance(tree, line)[0]
    return found


@njit(**OWNING)
def near_pairs(places, reach):
    """All pairs of places (k, 2) within ``reach``, the lower number first.

    By a sweep over x, after sorting the places.
    """
    order = np.argsort(places[:, 0])
    count = 0
    pairs = np.empty((16 * places.shape[0] + 16, 2), np.int64)
    for a in range(order.size):
        i = order[a]
        for b in range(a + 1, order.size):
            j = order[b]
            if places[j, 0] - places[i, 0] > reach:
                break
            if np.hypot(places[j, 0] - places[i, 0], places[j, 1] - places[i, 1]) <= reach:
                if count == pairs.shape[0]:
                    pairs = np.concatenate((pairs, np.empty_like(pairs)))
                pairs[count, 0], pairs[count, 1] = min(i, j), max(i, j)
                count += 1
    return pairs[:count].copy()

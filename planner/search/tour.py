"""The order in which to visit stations: exact for up to 15, a good one above.

Exact: dynamic programming over subsets (Held and Karp 1962). Above: cheapest insertion, then 2-opt
and Or-opt moves until none helps, repeated from shaken tours with a fixed seed, so that equal input
gives equal answers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from planner.scene import FloatArray
from planner.search import tour_kernels

EXACT_STATIONS = 15
"""Inner stations up to which the order is exact."""
SHAKES = 24
"""New starts of the local search, each from the best tour with a double bridge (Martin, Otto
and Felten 1991)."""
_SEED = 20
_GAIN = 1e-12
"""Moves that gain less than this part of the tour are rounding."""


class TourError(ValueError):
    """Unusable distances; the message says why."""


@dataclass(frozen=True, slots=True)
class Tour:
    """``order`` of the inner stations, as indices into the matrix, and total ``cost``.

    ``exact`` is True if no order is cheaper.
    """

    order: tuple[int, ...]
    cost: float
    exact: bool


def best_tour(distances: ArrayLike) -> Tour:
    """Return the order that makes the path from station 0 to station m - 1 shortest.

    ``distances`` (m, m) from each station to each other are >= 0, infinity if there is no path, and
    need not be symmetric. ``cost`` is infinite if no order is possible. Raises :class:`TourError`
    on anything else. O(n^2 2^n) to 15 inner stations, then O(n^3) or so.
    """
    matrix = _checked(distances)
    if len(matrix) - 2 <= EXACT_STATIONS:
        order, cost = tour_kernels.held_karp(matrix)
        return Tour(tuple(order.tolist()), float(cost), exact=True)
    return _search(matrix)


def _checked(distances: ArrayLike) -> FloatArray:
    matrix = np.ascontiguousarray(distances, dtype=np.float64)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or len(matrix) < 2:
        raise TourError(f"distances of shape {matrix.shape}: must be square, at least 2")
    if np.isnan(matrix).any() or (matrix < 0.0).any():
        raise TourError("distances must be >= 0, infinity where there is no way")
    return matrix


def _search(matrix: FloatArray) -> Tour:
    inner, end = np.arange(1, len(matrix) - 1), len(matrix) - 1
    finite = np.where(np.isfinite(matrix), matrix, 0.0)
    blocked = float(finite.sum()) + 1.0
    usable = np.where(np.isfinite(matrix), matrix, blocked)
    best = tour_kernels.cheapest_insertion(usable, inner, end)
    tolerance = _GAIN * float(finite.max(initial=0.0))
    best = tour_kernels.improve(usable, best, tolerance)
    cost = tour_kernels.tour_cost(usable, best)
    rng = np.random.default_rng(_SEED)
    for _ in range(SHAKES):
        cut = np.sort(rng.choice(np.arange(1, len(best) - 1), 3, replace=False))
        a, b, c = (int(v) for v in cut)
        shaken = np.concatenate([best[:a], best[b:c], best[a:b], best[c:]])
        tour_kernels.improve(usable, shaken, tolerance)
        shaken_cost = tour_kernels.tour_cost(usable, shaken)
        if shaken_cost < cost - tolerance:
            best, cost = shaken, shaken_cost
    total = float(tour_kernels.tour_cost(matrix, best))
    return Tour(tuple(best[1:-1].tolist()), total, exact=False)

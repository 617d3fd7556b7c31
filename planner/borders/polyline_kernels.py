"""Polylines on flat arrays: fewer vertices, and limits that spread along them.

Units are the polyline's.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import point_to_segment


@njit(**BORROWING)
def _fits(points, here, there, tolerance):
    """True if all vertices between two lie within ``tolerance`` of their chord."""
    ax, ay, bx, by = points[here, 0], points[here, 1], points[there, 0], points[there, 1]
    for i in range(here + 1, there):
        if point_to_segment(points[i, 0], points[i, 1], ax, ay, bx, by)[0] > tolerance:
            return False
    return True


@njit(**BORROWING)
def _reach(points, here, limit, tolerance):
    """Last vertex that a chord from ``here`` may reach; at least the next vertex."""
    good, step = here + 1, 1
    while good < limit:
        there = min(good + step, limit)
        if not _fits(points, here, there, tolerance):
            break
        good, step = there, 2 * step
    while step > 1:
        step //= 2
        there = good + step
        if there <= limit and _fits(points, here, there, tolerance):
            good = there
    return good


@njit(**OWNING)
def fewer_vertices(points, along, tolerance, spacing):
    """Indices of vertices, see :func:`planner.borders.polyline.fewer_vertices`."""
    last = len(points) - 1
    kept = np.empty(last + 1, np.int32)
    kept[0] = 0
    m = 1
    while kept[m - 1] < last:
        here = kept[m - 1]
        limit = np.searchsorted(along, along[here] + spacing, side="right") - 1
        limit = min(max(limit, here + 1), last)
        kept[m] = _reach(points, here, limit, tolerance)
        m += 1
    return kept[:m].copy()


@njit(**OWNING)
def reach_out(limits, first, last):
    """Lower each cell's limit to that of every cell i that reaches it: first[i] to last[i]."""
    lowered = limits.copy()
    top = limits.max()
    for i in range(len(limits)):
        if limits[i] < top:
            for j in range(max(first[i], 0), min(last[i], len(limits))):
                lowered[j] = min(lowered[j], limits[i])
    return lowered

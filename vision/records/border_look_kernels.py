"""What the records of a picture's borders need to know beforehand, in one pass.

Units are pixels; areas are in pixels, and cracks are counted.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import OWNING


@njit(**OWNING)
def look_at_borders(kind, data, edge_starts, limits):
    """``(ends, stray)`` of the fitted edges, see ``vision.records.records.FittedBorders``.

    ``ends`` (k,) int64: the edge that begins where each one ends, in its own border. ``stray``
    (b,) bool: whether a border has a corner, or an arc's whole circle, beyond ``limits``: x, y of
    the least and of the greatest.
    """
    low_x, low_y, high_x, high_y = limits
    borders = edge_starts.shape[0] - 1
    ends = np.empty(kind.shape[0], np.int64)
    stray = np.zeros(borders, np.bool_)
    for b in range(borders):
        first = edge_starts[b]
        last = edge_starts[b + 1]
        for e in range(first, last):
            ends[e] = e + 1 if e + 1 < last else first
            x, y, cx, cy, r = data[e, 0], data[e, 1], data[e, 2], data[e, 3], data[e, 4]
            out = x < low_x or y < low_y or x > high_x or y > high_y
            if kind[e] != 0:
                out |= cx - r < low_x or cx + r > high_x or cy - r < low_y or cy + r > high_y
            stray[b] |= out
    return ends, stray


@njit(**OWNING)
def may_be_thin(areas, starts):
    """Which borders have two cracks for every pixel that they enclose, or more: (b,) bool."""
    thin = np.empty(areas.shape[0], np.bool_)
    for b in range(areas.shape[0]):
        thin[b] = areas[b] > 0 and 2 * areas[b] <= starts[b + 1] - starts[b]
    return thin

"""Lengths of edges in the unseen cells of a map."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from planner.scene import FloatArray, UnknownCells


def length_in_cells(cells: UnknownCells, line: FloatArray) -> float:
    """Length of a line in the marked cells, exact: it is cut at every grid line."""
    cos, sin = np.cos(cells.yaw_rad), np.sin(cells.yaw_rad)
    off = line - (cells.x, cells.y)
    grid = np.stack([off @ (cos, sin), off @ (-sin, cos)], axis=1) / cells.resolution
    height, width = cells.mask.shape
    total = 0.0
    for a, b in pairwise(grid):
        cuts = [np.array([0.0, 1.0])]
        for axis in range(2):
            low, high = sorted((a[axis], b[axis]))
            low, high = max(low, 0.0), min(high, float((width, height)[axis]))
            if high > low:
                lines = np.arange(np.ceil(low), np.floor(high) + 1)
                cuts.append((lines - a[axis]) / (b[axis] - a[axis]))
        t = np.sort(np.concatenate(cuts).clip(0.0, 1.0))
        middle = np.floor(a + 0.5 * (t[1:] + t[:-1])[:, None] * (b - a)).astype(np.int64)
        row, column = height - 1 - middle[:, 1], middle[:, 0]
        on = (row >= 0) & (row < height) & (column >= 0) & (column < width)
        marked = np.zeros(len(middle), dtype=np.bool_)
        marked[on] = cells.mask[row[on], column[on]]
        total += float(np.diff(t)[marked].sum() * np.hypot(*(b - a)) * cells.resolution)
    return total

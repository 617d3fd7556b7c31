"""Facts for records, found for all borders in one pass.

Rules and units
- Edges are those of ``vision.outline.fitted_borders.FittedBorders``, in the scene's coordinates or
  in pixels; areas are in pixels, and cracks are counted.
- For some dozen edges whole arrays take ten times as long.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import OWNING
from vision.outline.fitted_borders import LINE
from vision.shared.typed_numbers import ZERO


@njit(**OWNING)
def look_at_borders(kind, data, edge_starts, limits, areas, crack_starts):
    """Return ``(ends, bent, stray, thin)`` of edges (k,) and borders (b,).

    ``ends`` (k,) int64: the edge of the same border that begins where each one ends. ``bent`` (m,)
    int64: edges that are not lines. ``stray`` (b,) bool: a corner, or an arc's whole circle, lies
    beyond ``limits`` (least x, y, greatest x, y). ``thin`` (b,) bool: an object's border with at
    least two cracks for every pixel that it encloses.
    """
    left, top, right, bottom = limits
    borders = edge_starts.shape[0] - 1
    ends = np.empty(kind.shape[0], np.int64)
    bent = np.empty(kind.shape[0], np.int64)
    count = ZERO
    stray = np.zeros(borders, np.bool_)
    thin = np.empty(borders, np.bool_)
    for b in range(borders):
        first = edge_starts[b]
        last = edge_starts[b + 1]
        for e in range(first, last):
            ends[e] = e + 1 if e + 1 < last else first
            x, y, cx, cy, r = data[e, 0], data[e, 1], data[e, 2], data[e, 3], data[e, 4]
            out = x < left or y < top or x > right or y > bottom
            if kind[e] != LINE:
                bent[count] = e
                count += 1
                out |= cx - r < left or cy - r < top or cx + r > right or cy + r > bottom
            stray[b] |= out
        thin[b] = areas[b] > 0 and 2 * areas[b] <= crack_starts[b + 1] - crack_starts[b]
    return ends, bent[:count], stray, thin

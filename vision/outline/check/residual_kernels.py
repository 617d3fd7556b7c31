"""Distance of a border from the outline written for it.

Rules and units
- ``border`` and ``finished``, edges ``0 .. count - 1`` around it: see
  ``vision.outline.outline_types``.
- A fit ignores points near its ends; here all count, less the effect of blur on corners.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.fit.outline_kernels import distance_to_edge
from vision.outline.fitted_borders import ARC_CCW, LINE

NEAR_ENDS = 4
"""Points at either end of an edge that may be nearer to its neighbour: chosen."""
CORNER_SHIFT = math.sqrt(2.0 / math.pi)
"""Movement of the border at a corner by blur, as a multiple of its sigma and the sine of half the
turn: derived, the mean of |x| under a Gaussian."""


@njit(**LEAF)
def measure_residual(border, finished, count, blur, reach):
    """Write to every edge the rms distance of all points from the outline.

    ``blur``: sigma in pixels; ``reach``: its range from a corner.
    """
    n = border.n
    at = finished.at
    kind = finished.kind
    rows = finished.rows
    total = 0.0
    many = 0
    for i in range(count):
        after = successor(i, count)
        before = predecessor(i, count)
        behind = successor(after, count)
        lo = at[i]
        hi = at[after]
        hi = hi + n if hi < lo or count == 1 else hi
        first = min(lo + NEAR_ENDS, hi)
        last = max(hi - NEAR_ENDS, first)
        total += _squares(border.x[first:last], border.y[first:last], kind, rows, i, after)
        many += last - first
        begin = CORNER_SHIFT * blur * _bend(kind, rows, before, i, after)
        end = CORNER_SHIFT * blur * _bend(kind, rows, i, after, behind)
        for k in range(lo, hi):
            if first <= k < last:
                continue
            x = border.x[k]
            y = border.y[k]
            d, _, _ = distance_to_edge(kind, rows, i, after, x, y)
            other, _, _ = distance_to_edge(kind, rows, before, i, x, y)
            d = min(d, other)
            other, _, _ = distance_to_edge(kind, rows, after, behind, x, y)
            d = min(d, other)
            if (x - rows[i, 0]) ** 2 + (y - rows[i, 1]) ** 2 < reach * reach:
                d -= min(begin, d)
            if (x - rows[after, 0]) ** 2 + (y - rows[after, 1]) ** 2 < reach * reach:
                d -= min(end, d)
            total += d * d
            many += 1
    rms = math.sqrt(total / max(many, 1))
    for i in range(count):
        rows[i, 5] = rms


@njit(**SUMS)
def _squares(xs, ys, kind, rows, i, after):
    total = 0.0
    if kind[i] == LINE:
        dx = rows[after, 0] - rows[i, 0]
        dy = rows[after, 1] - rows[i, 1]
        share = 1.0 / max(math.sqrt(dx * dx + dy * dy), 1e-9)
        a = dy * share
        b = -dx * share
        c = -(rows[i, 0] * a + rows[i, 1] * b)
        for k in range(xs.shape[0]):
            d = xs[k] * a + ys[k] * b + c
            total += d * d
        return total
    for k in range(xs.shape[0]):
        dx = xs[k] - rows[i, 2]
        dy = ys[k] - rows[i, 3]
        d = math.sqrt(dx * dx + dy * dy) - rows[i, 4]
        total += d * d
    return total


@njit(**LEAF)
def _way(kind, rows, i, after, end):
    if kind[i] == LINE:
        return rows[after, 0] - rows[i, 0], rows[after, 1] - rows[i, 1]
    dx = rows[end, 0] - rows[i, 2]
    dy = rows[end, 1] - rows[i, 3]
    # y down: the angle grows along an arc clockwise on the screen
    if kind[i] == ARC_CCW:
        return dy, -dx
    return -dy, dx


@njit(**LEAF)
def _bend(kind, rows, before, i, after):
    ax, ay = _way(kind, rows, before, i, i)
    bx, by = _way(kind, rows, i, after, i)
    lengths = math.sqrt((ax * ax + ay * ay) * (bx * bx + by * by))
    cosine = (ax * bx + ay * by) / max(lengths, 1e-30)
    return math.sqrt(max(0.5 * (1.0 - cosine), 0.0))

"""Joins between the primitives of borders, and the corners that need a point of their own.

Rules
- A piece is a primitive of the scene or a corner point: the end of an open chain, or a corner that
  the free space goes round. Other corners need none: the bisector of their sides reaches them, with
  generators half a spacing away on either side. All corners of a border that crosses itself have a
  point.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import (
    ARC,
    CIRCLE,
    FIRST,
    LAST,
    NONE,
    POINT,
    has_ends,
)
from planner.scene.shape_kernels import (
    area_beyond_chord,
    cross,
    end_of,
    length_of,
    tangent_at,
    x_range,
)

SMOOTH = 1e-3
"""Sine of the turn below which a joint is smooth and needs no corner point."""


@njit(**OWNING)
def without_repeats(kind, data, border, backwards, tolerance):
    """Turn degenerate primitives into points, and leave out points at a neighbour's end.

    Edges shorter than ``tolerance`` have no direction. Returns ``kind`` (k,), ``data`` (k, 6) and
    ``keep`` (k,) bool.
    """
    n = len(kind)
    out_kind, out = kind.copy(), data.copy()
    keep = np.ones(n, np.bool_)
    for i in range(n):
        if kind[i] != POINT and length_of(kind, data, i) <= tolerance:
            if kind[i] == ARC and data[i, 2] > tolerance:
                out[i, 0], out[i, 1] = end_of(kind, data, backwards, i, FIRST)
            out[i, 2:] = 0.0
            out_kind[i] = POINT
    for turn in range(2):
        last = NONE
        for j in range(n):
            i = j if turn == 0 else n - 1 - j
            if out_kind[i] == CIRCLE or not keep[i]:
                continue
            if out_kind[i] == POINT and last >= 0 and border[last] == border[i]:
                x, y = end_of(out_kind, out, backwards, last, turn == 0)
                keep[i] = abs(x - out[i, 0]) > tolerance or abs(y - out[i, 1]) > tolerance
            if keep[i]:
                last = np.int64(i)
    return out_kind, out, keep


@njit(**OWNING, inline="always")
def link_borders(kind, data, border, is_hole, backwards, tolerance):
    """Join the primitives of every border.

    Returns ``following`` and ``preceding`` (k,) int32, -1 at the ends of open chains; ``solid``
    (k,) int8 as in :class:`planner.borders.border_arrays.Pieces`; and ``crossed`` (k,) bool: part
    of a border that crosses itself, whose solid changes sides.
    """
    n = len(kind)
    following = np.full(n, -1, np.int32)
    preceding = np.full(n, -1, np.int32)
    solid = np.zeros(n, np.int8)
    crossed = np.zeros(n, np.bool_)
    first = np.int64(0)
    while first < n:
        last = first
        if kind[first] == CIRCLE:
            solid[first] = -1 if is_hole[first] else 1
            first += 1
            continue
        if kind[first] == POINT:
            first += 1
            continue
        while last + 1 < n and border[last + 1] == border[first] and kind[last + 1] != CIRCLE:
            ex, ey = end_of(kind, data, backwards, last, LAST)
            sx, sy = end_of(kind, data, backwards, last + 1, FIRST)
            if abs(ex - sx) > tolerance or abs(ey - sy) > tolerance:
                break
            following[last], preceding[last + 1] = last + 1, last
            last += 1
        ex, ey = end_of(kind, data, backwards, last, LAST)
        sx, sy = end_of(kind, data, backwards, first, FIRST)
        if (
            abs(ex - sx) <= tolerance
            and abs(ey - sy) <= tolerance
            and (last > first or kind[first] == ARC)
        ):
            following[last], preceding[first] = first, last
            area = _signed_area(kind, data, backwards, first, last)
            side = 1 if (area > 0.0) != is_hole[first] else -1
            crossed[first : last + 1] = _crosses_itself(kind, data, first, last)
            # two lobes of equal size have area 0 but are solid; a line there and back is a wall
            solid[first : last + 1] = 0 if area == 0.0 and not crossed[first] else side
        first = last + 1
    return following, preceding, solid, crossed


@njit(**OWNING)
def _crosses_itself(kind, data, first, last):
    n = last + 1 - first
    if n < 4:
        return False
    if n <= 12:
        for i in range(n):
            for j in range(i + 2, n if i > 0 else n - 1):
                if cross(kind, data, first + i, first + j):
                    return True
        return False
    low, high = np.empty(n), np.empty(n)
    for i in range(n):
        low[i], high[i] = x_range(kind, data, first + i)
    order = np.argsort(low)
    for a in range(n):
        i = order[a]
        for b in range(a + 1, n):
            j = order[b]
            if low[j] > high[i]:
                break
            apart = abs(i - j)
            if 1 < apart < n - 1 and cross(kind, data, first + i, first + j):
                return True
    return False


@njit(**BORROWING)
def _signed_area(kind, data, backwards, first, last):
    """Area inside a closed chain, positive if it turns from x to y."""
    area = 0.0
    ox, oy = end_of(kind, data, backwards, first, FIRST)
    for i in range(first, last + 1):
        ax, ay = end_of(kind, data, backwards, i, FIRST)
        bx, by = end_of(kind, data, backwards, i, LAST)
        area += 0.5 * ((ax - ox) * (by - oy) - (ay - oy) * (bx - ox))
        area += area_beyond_chord(kind, data, backwards, i)
    return area


@njit(**OWNING)
def corner_points(kind, data, backwards, following, preceding, solid, every):
    """Corners that need a point of their own.

    Returns ``at`` (c, 2), and ``before`` and ``after`` (c,), the primitives that meet there (-1
    where a chain ends). ``every`` (k,) marks primitives whose joints all have one.
    """
    n = len(kind)
    at = np.empty((2 * n, 2), np.float64)
    before = np.empty(2 * n, np.int32)
    after = np.empty(2 * n, np.int32)
    c = 0
    for i in range(n):
        if not has_ends(kind[i]):
            continue
        if preceding[i] < 0:
            at[c, 0], at[c, 1] = end_of(kind, data, backwards, i, FIRST)
            before[c], after[c] = -1, i
            c += 1
        x, y = end_of(kind, data, backwards, i, LAST)
        j = np.int64(following[i])
        if j >= 0 and not every[i] and solid[i] != 0:
            ux, uy = tangent_at(kind, data, backwards, i, x, y)
            sx, sy = end_of(kind, data, backwards, j, FIRST)
            vx, vy = tangent_at(kind, data, backwards, j, sx, sy)
            if (ux * vy - uy * vx) * solid[i] < -SMOOTH:
                continue
        at[c, 0], at[c, 1] = x, y
        before[c], after[c] = i, j
        c += 1
    return at[:c], before[:c], after[:c]

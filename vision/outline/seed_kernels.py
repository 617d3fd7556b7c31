"""Seeds: possible breaks of a border into edges.

Seeds are the indices of points of a ``border`` (``vision.outline.outline_types``), ascending.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from vision.shared.typed_numbers import ZERO

SNAP = 4
"""Points by which a seed moves to the middle of its corner: chosen."""


@njit(**LEAF)
def seed_breaks(border, tolerance, is_seed, away, stack):
    """Mark generous breaks: split at the farthest point until chords lie within tolerance.

    The first point is one, farthest out. ``away`` (n,) and ``stack`` (n + 1, 2) are scratch space.
    """
    px = border.x
    py = border.y
    n = border.n
    for k in range(n):
        is_seed[k] = False
    start = ZERO
    other, _ = _farthest(px, py, start, n, away)
    is_seed[start] = True
    is_seed[other] = True
    stack[0, 0] = start
    stack[0, 1] = other
    stack[1, 0] = other
    stack[1, 1] = start + n
    top = 2
    while top > 0:
        top -= 1
        lo = stack[top, 0]
        hi = stack[top, 1]
        if hi - lo < 2:
            continue
        where, far = _farthest(px, py, lo, hi, away)
        if far <= tolerance:
            continue
        is_seed[where - n if where >= n else where] = True
        stack[top, 0] = lo
        stack[top, 1] = where
        stack[top + 1, 0] = where
        stack[top + 1, 1] = hi
        top += 2


@njit(**SUMS)
def _farthest(px, py, lo, hi, away):
    """The point between lo and hi farthest from their chord: ``(where, distance)``."""
    x0 = px[lo]
    y0 = py[lo]
    dx = px[hi] - x0
    dy = py[hi] - y0
    length = math.sqrt(dx * dx + dy * dy)
    xs = px[lo + 1 : hi]
    ys = py[lo + 1 : hi]
    far = 0.0
    if length < 1e-9:
        length = 1.0
        for k in range(hi - lo - 1):
            x = xs[k] - x0
            y = ys[k] - y0
            d = math.sqrt(x * x + y * y)
            away[k] = d
            far = max(far, d)
    else:
        for k in range(hi - lo - 1):
            d = abs((xs[k] - x0) * dy - (ys[k] - y0) * dx)
            away[k] = d
            far = max(far, d)
    where = 0
    while away[where] < far:
        where += 1
    return lo + 1 + where, far / length


@njit(**LEAF)
def _around(k, n):
    if k < 0:
        return k + n
    return k - n if k >= n else k


@njit(**LEAF)
def _bulge(border, k, reach):
    px = border.x
    py = border.y
    n = border.n
    p = _around(k - reach, n)
    q = _around(k + reach, n)
    dx = px[q] - px[p]
    dy = py[q] - py[p]
    length = math.sqrt(dx * dx + dy * dy)
    if length < 1e-9:
        return 0.0
    return abs((px[k] - px[p]) * dy - (py[k] - py[p]) * dx) / length


@njit(**LEAF)
def snap_seeds(border, seeds, reach):
    """Move every seed to the strongest bulge nearby, less than half-way to the next seed.

    They stay ascending.
    """
    n = border.n
    m = seeds.shape[0]
    reach = min(reach, n // 4)
    if reach < 2:
        return
    first = seeds[0]
    before = seeds[m - 1] - n
    for s in range(m):
        here = seeds[s]
        after = seeds[s + 1] if s + 1 < m else first + n
        best = -1.0
        where = here
        for k in range(
            max(here - SNAP, (here + before) // 2 + 1), min(here + SNAP, (here + after) // 2) + 1
        ):
            bulge = _bulge(border, _around(k, n), reach)
            if bulge > best:
                best = bulge
                where = k
        before = here
        seeds[s] = where
    if seeds[0] < 0:
        here = seeds[0] + n
        for s in range(m - 1):
            seeds[s] = seeds[s + 1]
        seeds[m - 1] = here
    elif seeds[m - 1] >= n:
        here = seeds[m - 1] - n
        for s in range(m - 1, 0, -1):
            seeds[s] = seeds[s - 1]
        seeds[0] = here


@njit(**LEAF)
def turn_at(border, k, reach):
    """Turn of the border at point k, in radians."""
    px = border.x
    py = border.y
    n = border.n
    reach = min(reach, n // 4)
    p = _around(k - reach, n)
    q = _around(k + reach, n)
    ax = px[k] - px[p]
    ay = py[k] - py[p]
    bx = px[q] - px[k]
    by = py[q] - py[k]
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))

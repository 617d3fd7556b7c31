"""Order of the sites for insertion, along a Hilbert curve and coarse to fine; and their scale.

Crowded cells of the curve are sorted again within themselves (Ohya, Iri and Murota 1984); every
64th site comes first, then every 16th, every 4th, all.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING

COARSENING = 4
"""Ratio of a round's sites to the sites before it."""
TINY_COORDINATE = 2.0**-215
"""Scaled coordinates below which they are rounded to multiples of 2^-268."""
CROWD = 12
"""Sites of a cell of the curve above which it is sorted within itself."""


@njit(**LEAF)
def _hilbert(x, y, levels):
    """Place of cell (x, y) along the Hilbert curve over 2^levels by 2^levels cells."""
    place = 0
    flip = 0
    swap = 0
    for level in range(levels - 1, -1, -1):
        u = ((x >> level) & 1) ^ flip
        v = ((y >> level) & 1) ^ flip
        cross = (u ^ v) & swap
        u ^= cross
        v ^= cross
        place = (place << 2) | ((3 * u) ^ v)
        turn = v ^ 1
        flip ^= turn & u
        swap ^= turn
    return place


@njit(**LEAF)
def _sort_run(sites, order, lo, hi, keyed, spare, counts):
    """Sort order[lo:hi] along a Hilbert curve over its own bounding square.

    keyed[lo:hi] holds key << 32 | site afterwards. Returns False if all coincide.
    """
    n = hi - lo
    x_min = y_min = np.inf
    x_max = y_max = -np.inf
    for i in range(lo, hi):
        x, y = sites[order[i], 0], sites[order[i], 1]
        x_min, x_max = min(x_min, x), max(x_max, x)
        y_min, y_max = min(y_min, y), max(y_max, y)
    side = max(x_max - x_min, y_max - y_min)
    if side == 0.0:
        return False
    levels = 2
    while (1 << (2 * levels)) < 4 * n and levels < 15:
        levels += 1
    cells = 1 << levels
    # halved, so that neither the side nor its inverse overflows
    per_x = 0.5 * cells / (0.5 * side)
    if per_x == np.inf:
        per_x = 1e308
    top = cells - 1
    for i in range(lo, hi):
        s = order[i]
        u = min(np.int64((sites[s, 0] - x_min) * 0.5 * per_x), top)
        v = min(np.int64((sites[s, 1] - y_min) * 0.5 * per_x), top)
        keyed[i] = (np.int64(_hilbert(u, v, levels)) << 32) | np.int64(s)
    bits = 2 * levels
    passes = (bits + 10) // 11
    width = (bits + passes - 1) // passes
    mask = (1 << width) - 1
    for p in range(passes):
        shift = 32 + p * width
        counts[: mask + 2] = 0
        for i in range(lo, hi):
            counts[((keyed[i] >> shift) & mask) + 1] += 1
        for d in range(mask):
            counts[d + 1] += counts[d]
        for i in range(lo, hi):
            d = (keyed[i] >> shift) & mask
            spare[lo + counts[d]] = keyed[i]
            counts[d] += 1
        for i in range(lo, hi):
            keyed[i] = spare[i]
    for i in range(lo, hi):
        order[i] = keyed[i] & 0xFFFFFFFF
    return True


@njit(**OWNING, error_model="numpy")
def spatial_order(sites):
    """(n,) int64: sites along a Hilbert curve, crowded cells sorted within themselves."""
    n = sites.shape[0]
    order = np.arange(n)
    keyed = np.empty(n, np.int64)
    spare = np.empty(n, np.int64)
    counts = np.empty(2050, np.int64)
    todo = np.empty(2 * n + 2, np.int64)
    todo[0], todo[1] = 0, n
    depth = 2
    while depth > 0:
        depth -= 2
        lo, hi = todo[depth], todo[depth + 1]
        if not _sort_run(sites, order, lo, hi, keyed, spare, counts):
            continue
        start = lo
        for i in range(lo + 1, hi + 1):
            if i == hi or (keyed[i] >> 32) != (keyed[start] >> 32):
                if i - start > CROWD and i - start < hi - lo:
                    todo[depth], todo[depth + 1] = start, i
                    depth += 2
                start = i
    return order


@njit(**OWNING, error_model="numpy")
def coarse_to_fine(n, first, second, third):
    """Sites in order of insertion, without the first three."""
    todo = np.empty(max(n - 3, 0), np.int32)
    stride = 1
    while stride * COARSENING < n:
        stride *= COARSENING
    coarser = 0
    m = 0
    while stride > 0:
        for p in range(0, n, stride):
            if (coarser > 0 and p % coarser == 0) or p in (first, second, third):
                continue
            todo[m] = p
            m += 1
        coarser = stride
        stride //= COARSENING
    return todo


@njit(**LEAF)
def load_sites(sites, order, xy):
    """Scale the sites into xy[: 2n], in this order; return the exponent that scales back."""
    n = order.shape[0]
    top = 0.0
    for i in range(n):
        top = max(top, max(abs(sites[i, 0]), abs(sites[i, 1])))
    _, exponent = math.frexp(top)
    # in two halves: 2^-exponent itself may be out of range
    half = exponent // 2
    down_1, down_2 = math.ldexp(1.0, -half), math.ldexp(1.0, half - exponent)
    for i in range(n):
        x = sites[order[i], 0] * down_1 * down_2
        y = sites[order[i], 1] * down_1 * down_2
        if abs(x) < TINY_COORDINATE:
            x = (x + TINY_COORDINATE) - TINY_COORDINATE
        if abs(y) < TINY_COORDINATE:
            y = (y + TINY_COORDINATE) - TINY_COORDINATE
        xy[2 * i] = x
        xy[2 * i + 1] = y
    xy[2 * n] = np.nan
    xy[2 * n + 1] = np.nan
    return exponent

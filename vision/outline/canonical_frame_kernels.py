"""A canonical frame, in which mirrored or turned borders are fitted alike.

Rules and units
- A search along a border may answer differently for the mirror image. So a left-handed border is
  transposed: x and y are exchanged and its order is reversed, which keeps it clockwise. Finished
  edges are transposed back.
- A fit begins where the border is farthest from its centroid, turned to the east, so that ties are
  decided alike however a border is turned.
- ``border``, ``cracks``, ``place`` and ``finished``: see ``vision.outline.outline_types``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from vision.outline.fit.edge_shape_kernels import HUGE
from vision.outline.outline_types import CanonicalPlace
from vision.shared.typed_numbers import ZERO

COMPARED_APART = 7
"""Share of a border between compared points: chosen, no usual symmetry has it."""
NEITHER = 1e-10
"""Relative skewness of a mirror-symmetric border: indifferent, thousands of sums round by 1e-12 in
all."""

PIXEL_PARTS = 2.0**20
"""Parts of a pixel to which points are rounded: chosen, a power of two, exact. Equal shapes stay
equal everywhere in the picture, and ties are decided alike."""


@njit(**SUMS)
def bring_into_place(points, away, border):
    """Write a border's points (n, 2) so that it is right-handed and begins far in the east.

    Its first point is the origin. ``away`` (n + 1,) is scratch space.
    """
    px = border.x
    py = border.y
    n = border.n
    mx = 0.0
    my = 0.0
    for k in range(n):
        mx += points[k, 0]
        my += points[k, 1]
    mx /= n
    my /= n
    farthest = 0.0
    for k in range(n):
        x = points[k, 0] - mx
        y = points[k, 1] - my
        d = x * x + y * y
        away[k] = d
        farthest = max(farthest, d)
    first = 0
    while away[first] < farthest:
        first += 1
    transposed = is_left_handed(away, n, farthest)
    x = points[first, 0]
    y = points[first, 1]
    east = x - mx
    south = y - my
    # matrix from the picture's x and y to the frame's
    xx, xy, yx, yy = 1.0, 0.0, 0.0, 1.0
    if transposed:
        xx, xy, yx, yy = 0.0, 1.0, 1.0, 0.0
        east, south = south, east
    turns = 0
    while not abs(south) <= east and turns < 3:
        turns += 1
        east, south = -south, east
        xx, xy, yx, yy = -yx, -yy, xx, xy
    share = 1.0 / PIXEL_PARTS
    for part in range(2):
        behind = part == 1
        if transposed:
            low = first + 1 if behind else 0
            count = n - 1 - first if behind else first + 1
            to = first + 1 if behind else 0
        else:
            low = 0 if behind else first
            count = first if behind else n - first
            to = n - first if behind else 0
        for k in range(count):
            i = low + count - 1 - k if transposed else low + k
            u = points[i, 0] - x
            v = points[i, 1] - y
            px[to + k] = math.floor((xx * u + xy * v) * PIXEL_PARTS + 0.5) * share
            py[to + k] = math.floor((yx * u + yy * v) * PIXEL_PARTS + 0.5) * share
    _repeat(px, py, n)
    return CanonicalPlace(transposed, turns, xx * x + xy * y, yx * x + yy * y)


@njit(**SUMS)
def is_left_handed(away, n, farthest):
    """True if the squared distances from the centroid rise more steeply than they fall.

    A third moment along the border: only mirroring changes its sign.
    """
    step = n // COMPARED_APART + 1
    skew = 0.0
    for part in range(3):
        # no index wraps round, ``after`` does, or ``here`` does too
        lo = (0, n - 2 * step, n - step)[part]
        hi = (n - 2 * step, n - step, n)[part]
        here = away[lo + step - n if part == 2 else lo + step :]
        after = away[lo + 2 * step - n if part > 0 else lo + 2 * step :]
        before = away[lo:hi]
        for k in range(hi - lo):
            skew += here[k] * here[k] * (after[k] - before[k])
    return skew > NEITHER * n * farthest * farthest * farthest


@njit(**LEAF)
def bring_cracks_along(border, cracks, place):
    """Bring the border's cracks into the same frame, beginning with the crack at the origin.

    Its obstacle pixel becomes the origin of both. Returns the new place.
    """
    qx = cracks.x
    qy = cracks.y
    hx = cracks.free_x
    hy = cracks.free_y
    n = cracks.n
    x = place.x
    y = place.y
    if place.transposed:
        _transpose(qx, qy, n)
        _transpose(hx, hy, n)
    _turn(qx, qy, n, place.turns)
    _turn(hx, hy, n, place.turns)
    best = HUGE
    first = ZERO
    for k in range(n):
        d = (qx[k] - x) ** 2 + (qy[k] - y) ** 2
        if d < best:
            best = d
            first = k
    _begin_at(qx, qy, n, first)
    _begin_at(hx, hy, n, first)
    dx = qx[0] - hx[0]
    dy = qy[0] - hy[0]
    _shift(qx, qy, n, dx, dy)
    right = _rounded(dx - x)
    down = _rounded(dy - y)
    _shift(border.x, border.y, border.n, right, down)
    return CanonicalPlace(place.transposed, place.turns, dx, dy)


@njit(**LEAF)
def _rounded(x):
    return math.floor(x * PIXEL_PARTS + 0.5) / PIXEL_PARTS


@njit(**LEAF)
def _shift(px, py, n, dx, dy):
    for k in range(2 * n + 1):
        px[k] -= dx
        py[k] -= dy


@njit(**LEAF)
def _begin_at(px, py, n, first):
    for k in range(n):
        px[k] = px[first + k]
        py[k] = py[first + k]
    _repeat(px, py, n)


@njit(**LEAF)
def _turn(px, py, n, turns):
    for _ in range(turns):
        for k in range(2 * n + 1):
            px[k], py[k] = -py[k], px[k]


@njit(**LEAF)
def _transpose(px, py, n):
    for k in range((n + 1) // 2):
        other = n - 1 - k
        px[k], py[k], px[other], py[other] = py[other], px[other], py[k], px[k]
    _repeat(px, py, n)


@njit(**LEAF)
def _repeat(px, py, n):
    for k in range(n):
        px[n + k] = px[k]
        py[n + k] = py[k]
    px[2 * n] = px[0]
    py[2 * n] = py[0]


@njit(**LEAF)
def put_edges_back(finished, count, place):
    """Turn and transpose finished edges back to the picture's frame.

    A transposed arc keeps its direction: it is both mirrored and reversed.
    """
    kind = finished.kind
    rows = finished.rows
    for _ in range(place.turns):
        for i in range(count):
            rows[i, 0], rows[i, 1] = rows[i, 1], -rows[i, 0]
            rows[i, 2], rows[i, 3] = rows[i, 3], -rows[i, 2]
    if not place.transposed:
        return
    for i in range(count // 2):
        other = count - 1 - i
        kind[i], kind[other] = kind[other], kind[i]
        for c in range(6):
            rows[i, c], rows[other, c] = rows[other, c], rows[i, c]
    x = rows[count - 1, 0]
    y = rows[count - 1, 1]
    for i in range(count - 1, 0, -1):
        rows[i, 0], rows[i, 1] = rows[i - 1, 1], rows[i - 1, 0]
    rows[0, 0], rows[0, 1] = y, x
    for i in range(count):
        rows[i, 2], rows[i, 3] = rows[i, 3], rows[i, 2]

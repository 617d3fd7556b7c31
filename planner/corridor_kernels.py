"""The shortest way along a route: a funnel through the free corridor around it.

Rules and units
- A portal is a line across the corridor, from ``keep`` off the left border to ``keep`` off the
  right one through a place of the route; where there is no room it is that place alone.
- Left and right are those of ``cross(along, left - right) > 0``.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.bisector_kernels import slide_between
from planner.distance_kernels import ARC, CIRCLE, foot

DENSER = 12
"""How often a link is halved at most for its feet to turn slowly enough."""


@njit(cache=True, nogil=True)
def _portal(kind, data, pair, x, y, keep, out):
    """Write left x, y and right x, y of the portal at a place of the route."""
    out[0], out[1], out[2], out[3] = x, y, x, y
    if pair[0] < 0:
        return
    for side in range(2):
        fx, fy = foot(kind, data, pair[side], x, y)
        d = math.sqrt((x - fx) ** 2 + (y - fy) ** 2)
        if d > keep:
            out[2 * side] = fx + (x - fx) * keep / d
            out[2 * side + 1] = fy + (y - fy) * keep / d


@njit(cache=True, nogil=True)
def _turn(kind, data, piece, ax, ay, bx, by, keep):
    """Cosine of the angle between the directions from a piece's feet to two places.

    A chord around a circle of radius R, ``keep`` off it, bulges by 1 + R / keep times more
    than one around a point: its angle counts as so much larger.
    """
    px, py = foot(kind, data, piece, ax, ay)
    qx, qy = foot(kind, data, piece, bx, by)
    ux, uy, vx, vy = ax - px, ay - py, bx - qx, by - qy
    n = math.sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy))
    if n == 0.0:
        return 1.0
    bulge = 1.0 - (ux * vx + uy * vy) / n
    if kind[piece] == CIRCLE or kind[piece] == ARC:
        bulge *= 1.0 + data[piece, 2] / keep
    return 1.0 - bulge


@njit(cache=True, nogil=True)
def portals(kind, data, points, pairs, keep, least_cosine, tolerance):
    """The portals (n, 4) of a route, so dense that feet turn by little from one to the next."""
    n = len(points)
    room = 8 * n + 64
    out = np.empty((room, 4))
    stack = np.empty((DENSER + 2, 2))
    level = np.empty(DENSER + 2, np.int32)
    m = 0
    for i in range(n - 1):
        pair = pairs[i]
        ax, ay = points[i, 0], points[i, 1]
        stack[0, 0], stack[0, 1], level[0] = points[i + 1, 0], points[i + 1, 1], 0
        top = 1
        first = True
        while top > 0:
            if m + 2 >= room:
                room *= 2
                grown = np.empty((room, 4))
                grown[:m] = out[:m]
                out = grown
            if first:
                _portal(kind, data, pair, ax, ay, keep, out[m])
                m += 1
                first = False
            bx, by, deep = stack[top - 1, 0], stack[top - 1, 1], level[top - 1]
            if pair[0] >= 0 and deep < DENSER:
                c = min(
                    _turn(kind, data, pair[0], ax, ay, bx, by, keep),
                    _turn(kind, data, pair[1], ax, ay, bx, by, keep),
                )
                if c < least_cosine:
                    mx, my, found = slide_between(
                        kind, data, pair[0], pair[1], 0.5 * (ax + bx), 0.5 * (ay + by), tolerance
                    )
                    if found:
                        stack[top, 0], stack[top, 1], level[top] = mx, my, deep + 1
                        level[top - 1] = deep + 1
                        top += 1
                        continue
            top -= 1
            _portal(kind, data, pair, bx, by, keep, out[m])
            m += 1
            ax, ay = bx, by
    return out[:m]


@njit(cache=True, nogil=True)
def _side(ax, ay, bx, by, cx, cy):
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


@njit(cache=True, nogil=True)
def between(gates, sx, sy, gx, gy):
    """The first and last portal that the way from s to g has to pass: first, last + 1.

    Portals that s has passed already, or lies on, are left out, and so are those beyond g:
    the first ones of a route often lie behind its start, which retraction moved sideways.
    """
    first, last = 0, len(gates)
    while first < last:
        q = gates[first]
        if _side(q[2], q[3], q[0], q[1], sx, sy) > 0.0:
            break
        if q[0] == q[2] and q[1] == q[3] and (q[0] != sx or q[1] != sy):
            break
        first += 1
    while last > first:
        q = gates[last - 1]
        if _side(q[2], q[3], q[0], q[1], gx, gy) < 0.0:
            break
        if q[0] == q[2] and q[1] == q[3] and (q[0] != gx or q[1] != gy):
            break
        last -= 1
    return first, last


@njit(cache=True, nogil=True)
def funnel(gates, sx, sy, gx, gy):
    """The shortest polyline from s to g through all portals in order.

    The funnel algorithm of Lee and Preparata (1984) in its short form, which starts anew at
    each corner it fixes.
    """
    n = len(gates)
    gate = np.empty((n + 1, 4))
    gate[:n] = gates
    gate[n, 0], gate[n, 1], gate[n, 2], gate[n, 3] = gx, gy, gx, gy
    out = np.empty((2 * n + 8, 2))
    out[0, 0], out[0, 1] = sx, sy
    m = 1
    px, py = sx, sy
    lx, ly, rx, ry = sx, sy, sx, sy
    left_at, right_at = -1, -1
    i = 0
    while i <= n:
        qx, qy, wx, wy = gate[i, 0], gate[i, 1], gate[i, 2], gate[i, 3]
        # narrow on the right: a new right point must not lie to the right of the old
        if _side(px, py, rx, ry, wx, wy) >= 0.0 or (rx == px and ry == py):
            if (rx == px and ry == py) or _side(px, py, lx, ly, wx, wy) <= 0.0:
                rx, ry, right_at = wx, wy, i
            else:
                px, py = lx, ly
                if m < len(out) and (out[m - 1, 0] != px or out[m - 1, 1] != py):
                    out[m, 0], out[m, 1] = px, py
                    m += 1
                i = left_at + 1
                rx, ry, lx, ly = px, py, px, py
                right_at = left_at
                continue
        if _side(px, py, lx, ly, qx, qy) <= 0.0 or (lx == px and ly == py):
            if (lx == px and ly == py) or _side(px, py, rx, ry, qx, qy) >= 0.0:
                lx, ly, left_at = qx, qy, i
            else:
                px, py = rx, ry
                if m < len(out) and (out[m - 1, 0] != px or out[m - 1, 1] != py):
                    out[m, 0], out[m, 1] = px, py
                    m += 1
                i = right_at + 1
                lx, ly, rx, ry = px, py, px, py
                left_at = right_at
                continue
        i += 1
    out[m, 0], out[m, 1] = gx, gy
    return out[: m + 1]

"""The curves that cut a corner of a polyline, on flat arrays.

Rules and units
- A curve runs from ``reach`` before the corner to ``reach`` after it, along the polyline, and is
  tangent to it at both ends.
- Chords leave a curve by at most ``tolerance``, unless that takes more than ``MOST_CHORDS`` of
  them.
- A curve is empty (0, 2) if the tangents do not meet ahead of the first end and behind the last,
  or if it would be longer than the piece it replaces.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import BORROWING, OWNING

MOST_CHORDS = 256
"""Chords of a curve."""
PARALLEL = 1e-9
"""Sine of the turn below which tangents count as parallel."""
BEND_SPARE = 0.05
"""An arc is this part wider than the tightest allowed."""


@njit(**BORROWING)
def _place(points, lengths, i, at):
    step = lengths[i + 1] - lengths[i]
    t = (at - lengths[i]) / step if step > 0.0 else 0.0
    x, y = points[i, 0], points[i, 1]
    return x + t * (points[i + 1, 0] - x), y + t * (points[i + 1, 1] - y)


@njit(**BORROWING)
def _control(points, lengths, corner, reach, out):
    """Write both ends of the cut and the tangents' meeting point (3, 2); False if there is none."""
    begin, end = corner - reach, corner + reach
    last = len(points) - 1
    i = min(max(np.searchsorted(lengths, begin, side="right"), 1), last) - 1
    j = min(max(np.searchsorted(lengths, end, side="left"), 1), last) - 1
    ax, ay = _place(points, lengths, i, begin)
    bx, by = _place(points, lengths, j, end)
    ux, uy = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
    vx, vy = points[j + 1, 0] - points[j, 0], points[j + 1, 1] - points[j, 1]
    cross = ux * vy - uy * vx
    scale = math.hypot(ux, uy) * math.hypot(vx, vy)
    if scale == 0.0 or abs(cross) <= PARALLEL * scale:
        return False
    ahead = ((bx - ax) * vy - (by - ay) * vx) / cross
    back = (ux * (by - ay) - uy * (bx - ax)) / cross
    if ahead <= 0.0 or back <= 0.0:
        return False
    out[0, 0], out[0, 1], out[1, 0], out[1, 1] = ax, ay, bx, by
    out[2, 0], out[2, 1] = ax + ahead * ux, ay + ahead * uy
    return True


@njit(**OWNING)
def _if_shorter(curve, most):
    length = 0.0
    for i in range(len(curve) - 1):
        length += math.hypot(curve[i + 1, 0] - curve[i, 0], curve[i + 1, 1] - curve[i, 1])
    return curve if length <= most else curve[:0]


@njit(**OWNING)
def parabola(points, lengths, corner, reach, tolerance):
    """Parabola across a corner of a polyline (n, 2) with its ``lengths`` (n,)."""
    met = np.empty((3, 2))
    if not _control(points, lengths, corner, reach, met):
        return met[:0]
    ax, ay, bx, by, cx, cy = met[0, 0], met[0, 1], met[1, 0], met[1, 1], met[2, 0], met[2, 1]
    # the chords of a parabola in n equal steps leave it by |a - 2 c + b| / (4 n^2)
    bulge = math.hypot(ax - 2.0 * cx + bx, ay - 2.0 * cy + by)
    count = int(min(max(2.0, math.ceil(math.sqrt(bulge / (4.0 * tolerance)))), float(MOST_CHORDS)))
    curve = np.empty((count + 1, 2))
    for k in range(count + 1):
        t = k / count
        p, q, r = (1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t
        curve[k, 0], curve[k, 1] = p * ax + q * cx + r * bx, p * ay + q * cy + r * by
    return _if_shorter(curve, 2.0 * reach)


@njit(**OWNING)
def bend(points, lengths, corner, reach, tolerance, least_radius):
    """Arc of at least ``least_radius`` joining both tangents, and the rest of the tangents.

    Also empty if the tangents have no room for the arc.
    """
    met = np.empty((3, 2))
    if not _control(points, lengths, corner, reach, met):
        return met[:0]
    ux, uy = met[2, 0] - met[0, 0], met[2, 1] - met[0, 1]
    vx, vy = met[1, 0] - met[2, 0], met[1, 1] - met[2, 1]
    before, after = math.hypot(ux, uy), math.hypot(vx, vy)
    if before == 0.0 or after == 0.0:
        return met[:0]
    shorter = min(before, after)
    ux, uy, vx, vy = ux / before, uy / before, vx / after, vy / after
    turn = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy)
    radius = shorter / math.tan(0.5 * abs(turn))
    # driven in chords, an arc bends slightly more
    if radius < least_radius * (1.0 + BEND_SPARE):
        return met[:0]
    steps = math.ceil(abs(turn) / math.sqrt(8.0 * tolerance / radius))
    count = int(min(max(2.0, steps), float(MOST_CHORDS)))
    bx, by = met[2, 0] - shorter * ux, met[2, 1] - shorter * uy
    side = 1.0 if turn >= 0.0 else -1.0
    curve = np.empty((count + 3, 2))
    curve[0, 0], curve[0, 1] = met[0, 0], met[0, 1]
    m = 1
    for k in range(count + 2):
        x, y = met[1, 0], met[1, 1]
        if k <= count:
            angle = abs(turn) * k / count
            along, off = radius * math.sin(angle), radius * (1.0 - math.cos(angle)) * side
            x, y = bx + along * ux - off * uy, by + along * uy + off * ux
        if math.hypot(x - curve[m - 1, 0], y - curve[m - 1, 1]) > 1e-9 * radius:
            curve[m, 0], curve[m, 1] = x, y
            m += 1
    return _if_shorter(curve[:m].copy(), 2.0 * reach)

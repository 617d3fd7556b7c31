"""The shortest way along a route: a funnel through the free corridor around it.

Rules and units
- The corridor's shortest way that keeps ``keep`` off its borders is taut: straight, and around
  corners.
- A portal is a line across the corridor through a place of the route, ``keep`` off both borders;
  without room for it, the place alone.
- Left and right are those of ``cross(along, left - right) > 0``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.clear_kernels import keeps
from planner.diagram.bisector_kernels import slide_between
from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import foot, grown, is_round

DENSER = 12
"""Most halvings of a link for its feet to turn slowly enough."""
TURNS_RAD = (0.2, 0.05)
"""Most that a border's foot may turn between portals: tried in this order."""


@njit(**BORROWING)
def _look(kind, data, left, right, x, y, out):
    """Write a place, the vectors to it from the feet on both sides, and their lengths."""
    out[0], out[1] = x, y
    fx, fy = foot(kind, data, left, x, y)
    dx, dy = x - fx, y - fy
    out[2], out[3], out[4] = dx, dy, math.sqrt(dx * dx + dy * dy)
    fx, fy = foot(kind, data, right, x, y)
    dx, dy = x - fx, y - fy
    out[5], out[6], out[7] = dx, dy, math.sqrt(dx * dx + dy * dy)


@njit(**BORROWING)
def _portal(seen, keep, out):
    """Write left x, y and right x, y of the portal at a place described by ``_look``."""
    s = 1.0 - keep / seen[4] if seen[4] > keep else 0.0
    t = 1.0 - keep / seen[7] if seen[7] > keep else 0.0
    out[0], out[1] = seen[0] - s * seen[2], seen[1] - s * seen[3]
    out[2], out[3] = seen[0] - t * seen[5], seen[1] - t * seen[6]


@njit(**BORROWING)
def _turns_little(a, b, round_left, round_right, least_cosine):
    """True if the directions from both pieces' feet turn little between two places.

    A chord around a circle of radius R, ``keep`` off it, bulges by 1 + R / keep times more than one
    around a point: its angle counts as that much larger (``round_left``, ``round_right``).
    """
    n, e = a[4] * b[4], a[7] * b[7]
    bulge = round_left * (n - a[2] * b[2] - a[3] * b[3])
    other = round_right * (e - a[5] * b[5] - a[6] * b[6])
    return bulge <= (1.0 - least_cosine) * n and other <= (1.0 - least_cosine) * e


@njit(**BORROWING)
def _roundness(kind, data, piece, keep):
    if is_round(kind[piece]):
        return 1.0 + data[piece, 2] / keep
    return 1.0


@njit(**OWNING, inline="always")
def portals(kind, data, points, pairs, keep, least_cosine, tolerance):
    """Portals (n, 4) of a route, so dense that feet turn little between them.

    A link with unknown pieces beside it (-1) has its ends as portals without width.
    """
    out = np.empty((4 * len(points) + 64, 4))
    here = np.empty(8)
    stack = np.empty((DENSER + 2, 8))
    level = np.empty(DENSER + 2, np.int32)
    m = 0
    round_left, round_right = 1.0, 1.0
    for i in range(len(points) - 1):
        left, right = np.int64(pairs[i, 0]), np.int64(pairs[i, 1])
        as_before = i > 0 and left == pairs[i - 1, 0] and right == pairs[i - 1, 1]
        if m + 4 >= len(out):
            out = grown(out, 2 * len(out))
        if left < 0:
            for k in range(1 if as_before else 0, 2):
                out[m, 0], out[m, 1] = points[i + k, 0], points[i + k, 1]
                out[m, 2], out[m, 3] = points[i + k, 0], points[i + k, 1]
                m += 1
            continue
        if not as_before:
            round_left = _roundness(kind, data, left, keep)
            round_right = _roundness(kind, data, right, keep)
            _look(kind, data, left, right, points[i, 0], points[i, 1], here)
            _portal(here, keep, out[m])
            m += 1
        _look(kind, data, left, right, points[i + 1, 0], points[i + 1, 1], stack[0])
        level[0] = 0
        top = 1
        while top > 0:
            there, deep = stack[top - 1], level[top - 1]
            if deep < DENSER and not _turns_little(
                here, there, round_left, round_right, least_cosine
            ):
                mx, my, found = slide_between(
                    kind, data, left, right,
                    0.5 * (here[0] + there[0]), 0.5 * (here[1] + there[1]), tolerance,
                )  # fmt: skip
                if found:
                    _look(kind, data, left, right, mx, my, stack[top])
                    level[top - 1], level[top] = deep + 1, deep + 1
                    top += 1
                    continue
            top -= 1
            for c in range(8):
                here[c] = there[c]
            if m + 1 >= len(out):
                out = grown(out, 2 * len(out))
            _portal(here, keep, out[m])
            m += 1
    return out[:m]


@njit(**BORROWING)
def _side(ax, ay, bx, by, cx, cy):
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


@njit(**BORROWING)
def between(gates, sx, sy, gx, gy):
    """Range of portals that the way from s to g must pass: first, last + 1.

    Portals that s has passed or lies on, and those beyond g, are left out: retraction moved the
    route's start sideways.
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


@njit(**OWNING, inline="always")
def funnel(gates, sx, sy, gx, gy):
    """Shortest polyline from s to g through all portals in order.

    The short form of Lee and Preparata's funnel algorithm (1984), restarted at each fixed corner.
    """
    n = len(gates)
    gate = np.empty((n + 1, 4))
    for i in range(n):
        for c in range(4):
            gate[i, c] = gates[i, c]
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
        turned = -1
        # narrow on the right: a new right point must not lie to the right of the old
        if _side(px, py, rx, ry, wx, wy) >= 0.0 or (rx == px and ry == py):
            if (rx == px and ry == py) or _side(px, py, lx, ly, wx, wy) <= 0.0:
                rx, ry, right_at = wx, wy, i
            else:
                px, py, turned = lx, ly, left_at
        if turned < 0 and (_side(px, py, lx, ly, qx, qy) <= 0.0 or (lx == px and ly == py)):
            if (lx == px and ly == py) or _side(px, py, rx, ry, qx, qy) >= 0.0:
                lx, ly, left_at = qx, qy, i
            else:
                px, py, turned = rx, ry, right_at
        if turned < 0:
            i += 1
            continue
        if m < len(out) and (out[m - 1, 0] != px or out[m - 1, 1] != py):
            out[m, 0], out[m, 1] = px, py
            m += 1
        i = turned + 1
        lx, ly, rx, ry = px, py, px, py
        left_at, right_at = turned, turned
    out[m, 0], out[m, 1] = gx, gy
    return out[: m + 1]


@njit(**OWNING, inline="always")
def pull_taut(tree, points, pairs, keep, need, tolerance):
    """Taut polyline along a route; empty unless proved, against all borders, to keep ``need``.

    ``pairs`` (n, 2) are the pieces left and right of each link, -1 where unknown: there the route
    itself is kept, except its ends, where a station lies in the first or last disc. The way keeps
    ``keep`` >= ``need``, plus the bulge of chords between portals, where there is room.
    """
    lo, hi = 0, len(points) - 1
    while lo <= hi and pairs[lo, 0] < 0:
        lo += 1
    while hi > lo and pairs[hi, 0] < 0:
        hi -= 1
    sx, sy = points[0, 0], points[0, 1]
    gx, gy = points[-1, 0], points[-1, 1]
    if lo <= hi:
        for turn in TURNS_RAD:
            gates = portals(
                tree.kind, tree.data, points[lo : hi + 2], pairs[lo : hi + 2],
                keep / math.cos(0.5 * turn), math.cos(turn), tolerance,
            )  # fmt: skip
            first, last = between(gates, sx, sy, gx, gy)
            way = funnel(gates[first:last], sx, sy, gx, gy)
            if keeps(tree, way, need):
                return way.copy()
    return np.empty((0, 2))

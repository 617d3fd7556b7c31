"""The test that finished edges separate the pixels of a border without grey.

Rules and units
- A crack lies between the centres of an obstacle pixel and a free one, half a pixel from each. If
  edges cross this line, its way, an odd number of times, they reproduce both pixels exactly.
- ``cracks``, and ``finished``, edges ``0 .. count - 1`` whose first cracks ascend around the
  border: see ``vision.outline.outline_types``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import successor
from vision.outline.fit.edge_shape_kernels import HUGE
from vision.outline.fit.outline_kernels import STRAY_PX, distance_to_edge, in_sweep
from vision.outline.fit.separating_fit_kernels import COARSE_PX, HALF
from vision.outline.fitted_borders import LINE

AHEAD, SAME_PX = 12, 1e-6
"""Cracks among which an edge point's is sought, and its distance: indifferent, far more than lie
between two points, and rounding."""
NEAR_JOINT_PX = 2.0
"""Distance from a joint within which other edges may pass a point: chosen, two pixels."""
NEIGHBOURS = 2
"""Edges on either side that may pass a point: chosen."""
GRAVE_PX = 0.5 * (0.5 + 1.0)
"""Distance from its edges at which a lost point is repaired whatever the budget: derived, half-way
from half a pixel to one."""
ROUND_HALF = HALF - COARSE_PX
"""Distance from a crack's middle within which an arc may pass: derived, half a pixel less the error
of its polyline."""
JOINT_REACH = 8
"""Cracks on either side of its own beside which a joint is sought: indifferent."""
OK, LOST, GRAVE = 0, 1, 2
"""Verdicts on a crack: defined. Negative where its obstacle's pixel is lost, or else the free
one."""


@njit(**LEAF)
def runs_between_two_greys(grey, xs, ys, directions):
    """True if all obstacle pixels at cracks have one value, and all free ones beside them one."""
    height, width = grey.shape
    dark = grey[0, 0]
    light = grey[0, 0]
    seen = False
    for k in range(xs.shape[0]):
        x = np.int64(xs[k])
        y = np.int64(ys[k])
        d = np.int64(directions[k])
        if k == 0:
            dark = grey[y, x]
        if grey[y, x] != dark:
            return False
        x += (d & 1) * (2 - d)
        y += (1 - (d & 1)) * (d - 1)
        if not (0 <= x < width and 0 <= y < height):
            continue
        if not seen:
            light = grey[y, x]
            seen = True
        if grey[y, x] != light:
            return False
    return True


@njit(**LEAF)
def fill_cracks(xs, ys, directions, cracks):
    """Fill ``cracks`` from a border's obstacle pixels and the free ones' directions."""
    n = cracks.n
    for k in range(n):
        d = np.int64(directions[k])
        ox = HALF * ((d & 1) * (2 - d))
        oy = HALF * ((1 - (d & 1)) * (d - 1))
        cracks.free_x[k] = ox
        cracks.free_y[k] = oy
        cracks.free_x[n + k] = ox
        cracks.free_y[n + k] = oy
        cracks.x[k] = xs[k] + ox
        cracks.y[k] = ys[k] + oy
        cracks.x[n + k] = cracks.x[k]
        cracks.y[n + k] = cracks.y[k]
    cracks.x[2 * n] = cracks.x[0]
    cracks.y[2 * n] = cracks.y[0]
    cracks.free_x[2 * n] = cracks.free_x[0]
    cracks.free_y[2 * n] = cracks.free_y[0]


@njit(**LEAF)
def find_cracks(border, cracks, crack_of):
    """Fill ``crack_of`` (points,), ascending: the crack that each point was measured across."""
    c = -1
    for k in range(border.n):
        x = border.x[k]
        y = border.y[k]
        nearest = HUGE
        where = c + 1
        last = min(c + AHEAD, cracks.n - border.n + k)
        for j in range(c + 1, last + 1):
            d = abs(cracks.x[j] - x) + abs(cracks.y[j] - y)
            if d < nearest:
                nearest = d
                where = j
            if d < SAME_PX:
                break
        c = where
        crack_of[k] = c


@njit(**LEAF)
def _crossings(kind, rows, i, after, x, y, upright):
    x0 = rows[i, 0]
    y0 = rows[i, 1]
    x1 = rows[after, 0]
    y1 = rows[after, 1]
    if kind[i] == LINE:
        if upright:
            if (y0 <= y) == (y1 <= y):
                return 0
            there = x0 + (y - y0) * (x1 - x0) / (y1 - y0)
            return 1 if abs(there - x) < HALF else 0
        if (x0 <= x) == (x1 <= x):
            return 0
        there = y0 + (x - x0) * (y1 - y0) / (x1 - x0)
        return 1 if abs(there - y) < HALF else 0
    return _round_crossings(kind, rows, i, after, x, y, upright)


@njit(**LEAF)
def _round_crossings(kind, rows, i, after, x, y, upright):
    """Number of crossings for an arc.

    An arc whose ends lie on different sides of the line through both pixels crosses it once,
    otherwise never or twice.
    """
    cx = rows[i, 2]
    cy = rows[i, 3]
    r = rows[i, 4]
    off = y - cy if upright else x - cx
    square = r * r - off * off
    if square <= 0.0:
        return 0
    root = math.sqrt(square)
    ax = cx + root if upright else x
    ay = y if upright else cy + root
    bx = cx - root if upright else x
    by = y if upright else cy - root
    a = in_sweep(kind, rows, i, after, ax, ay)
    b = in_sweep(kind, rows, i, after, bx, by)
    x0 = rows[i, 0]
    y0 = rows[i, 1]
    x1 = rows[after, 0]
    y1 = rows[after, 1]
    sides = (y0 <= y) != (y1 <= y) if upright else (x0 <= x) != (x1 <= x)
    if (a != b) != sides:
        far_a = min((ax - x0) ** 2 + (ay - y0) ** 2, (ax - x1) ** 2 + (ay - y1) ** 2)
        far_b = min((bx - x0) ** 2 + (by - y0) ** 2, (bx - x1) ** 2 + (by - y1) ** 2)
        if far_a < far_b:
            a = not a
        else:
            b = not b
    found = 0
    if a and abs(ax - x) < ROUND_HALF and abs(ay - y) < ROUND_HALF:
        found += 1
    if b and abs(bx - x) < ROUND_HALF and abs(by - y) < ROUND_HALF:
        found += 1
    return found


@njit(**LEAF)
def _judge(kind, rows, count, i, x, y, free_x, free_y):
    upright = free_x != 0.0
    after = successor(i, count)
    own = _crossings(kind, rows, i, after, x, y, upright)
    near = NEAR_JOINT_PX * NEAR_JOINT_PX
    beside = (x - rows[i, 0]) ** 2 + (y - rows[i, 1]) ** 2 < near
    beside = beside or (x - rows[after, 0]) ** 2 + (y - rows[after, 1]) ** 2 < near
    if own == 1 and not beside:
        return OK
    reach = min(NEIGHBOURS, (count - 1) // 2)
    first = -reach
    last = reach if count > 2 * NEIGHBOURS else count - 1 - reach
    for step in range(first, last + 1):
        if step != 0:
            j = (i + step + count) % count
            own += _crossings(kind, rows, j, successor(j, count), x, y, upright)
    if own % 2 == 1:
        return OK
    nearest = HUGE
    beyond = False
    for step in range(first, last + 1):
        j = (i + step + count) % count
        away, foot_x, foot_y = distance_to_edge(kind, rows, j, successor(j, count), x, y)
        if away < nearest:
            nearest = away
            beyond = (foot_x - x) * free_x + (foot_y - y) * free_y > 0.0
    found = LOST if nearest <= GRAVE_PX else GRAVE
    return found if beyond else -found


@njit(**LEAF)
def find_lost(cracks, finished, count, state):
    """Fill ``state`` (n,) of every crack; return the cracks lost, and how many of them gravely."""
    lost = 0
    grave = 0
    for i in range(count):
        some, worse = find_lost_beside(cracks, finished, count, i, state)
        lost += some
        grave += worse
    return lost, grave


@njit(**LEAF)
def find_lost_beside(cracks, finished, count, i, state):
    """The same for the cracks in the stretch of edge i."""
    n = cracks.n
    lost = 0
    grave = 0
    after = successor(i, count)
    lo = finished.at[i]
    hi = finished.at[after]
    hi = hi + n if hi <= lo else hi
    x0 = finished.rows[i, 0]
    y0 = finished.rows[i, 1]
    dx = finished.rows[after, 0] - x0
    dy = finished.rows[after, 1] - y0
    # a line alone decides on a crack well within it
    square = dx * dx + dy * dy if finished.kind[i] == LINE else 0.0
    margin = NEAR_JOINT_PX * math.sqrt(square)
    across_upright = HALF * abs(dy)
    across_level = HALF * abs(dx)
    for k in range(lo, hi):
        here = k - n if k >= n else k
        x = cracks.x[k] - x0
        y = cracks.y[k] - y0
        along = x * dx + y * dy
        limit = across_upright if cracks.free_x[k] != 0.0 else across_level
        if (margin < along) & (along < square - margin) & (abs(x * dy - y * dx) < limit):
            state[here] = OK
            continue
        found = _judge(
            finished.kind,
            finished.rows,
            count,
            i,
            cracks.x[k],
            cracks.y[k],
            cracks.free_x[k],
            cracks.free_y[k],
        )
        state[here] = found
        lost += found != OK
        grave += abs(found) == GRAVE
    if not _is_beside(cracks, lo, x0, y0):
        lost += state[lo] == OK
        grave += abs(state[lo]) != GRAVE
        state[lo] = GRAVE
    return lost, grave


@njit(**LEAF)
def _is_beside(cracks, k, x, y):
    """True if a joint at (x, y) lies beside the border at crack k.

    A pointed corner beyond its last pixel may hold others without a crack.
    """
    n = cracks.n
    for step in range(JOINT_REACH + 1):
        for j in (k + step, k - step):
            here = (j + n) % n
            dx = cracks.x[here] - x
            dy = cracks.y[here] - y
            if dx * dx + dy * dy <= STRAY_PX * STRAY_PX:
                return True
    return False

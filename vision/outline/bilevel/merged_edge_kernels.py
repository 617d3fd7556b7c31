"""A line or an arc that may replace a run of edges without grey.

Rules and units
- ``cracks``, and ``trial``, edges ``0 .. count - 1`` with their first cracks, of which edge ``at``
  replaces cracks lo .. hi - 1: see ``vision.outline.outline_types``.
- Chords begin between a crack's pixels, so two or three may approximate a line that begins
  elsewhere. The line found here runs as far as possible from the pixels on both sides.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.bilevel.joint_relaxation_kernels import circle_through
from vision.outline.corners.crossing_kernels import SHALLOW
from vision.outline.fit.edge_shape_kernels import HUGE, circle_cost, circle_of_three, fit_circle
from vision.outline.fit.outline_kernels import FLATTEST_PX
from vision.outline.fit.separating_fit_kernels import HALF, SEPARATION_MARGIN, separate_circle
from vision.outline.fitted_borders import ARC_CCW, ARC_CW, LINE
from vision.outline.limit_kernels import MOST_MISS_PX
from vision.shared.typed_numbers import YES

GAP_STEPS = 12
"""Most steps to the line farthest from its pixels: indifferent, a bound on the work."""
GAP_SETTLED_PX = 1e-3
"""Possible gain of the widest gap: indifferent."""
LEAST_ARC = 5
"""Least cracks of an arc: derived, three lie on any circle."""
ARC_ASTRAY_PX = 3.0
"""Largest distance of an arc from the circle through its ends and middle: indifferent, to spare
work."""
ARC_PARTS = 8
"""Parts of a run at whose ends that is tested: indifferent."""


@njit(**LEAF)
def put_line(cracks, trial, count, at, lo, hi):
    """Make edge ``at`` the line farthest from the pixels of cracks lo .. hi - 1, if possible."""
    gap, x, y, vx, vy = line_between(cracks, lo, hi)
    if gap < 0.0:
        return False
    before = predecessor(at, count)
    after = successor(at, count)
    x0, y0, met = _meet(cracks, trial, before, at, lo, x, y, vx, vy)
    if not met:
        return False
    x1, y1, met = _meet(cracks, trial, after, successor(after, count), hi, x, y, vx, vy)
    if not met or (x1 - x0) * vx + (y1 - y0) * vy <= 0.0:
        return False
    rows = trial.rows
    end = successor(after, count)
    if count > 2:
        if not _goes_on(trial.kind[before], rows[before], rows[at], x0, y0):
            return False
        if not _goes_on(trial.kind[after], rows[end], rows[after], x1, y1):
            return False
    rows[at, 0], rows[at, 1] = x0, y0
    rows[after, 0], rows[after, 1] = x1, y1
    return True


@njit(**LEAF)
def _goes_on(kind, stays, moves, x, y):
    """True if an edge between a joint that stays and one that moves keeps its direction.

    ``stays``, ``moves``: their rows; (x, y): the latter's new position. Arcs shorter than two
    ``MOST_MISS_PX`` are refused.
    """
    dx = moves[0] - stays[0]
    dy = moves[1] - stays[1]
    if kind != LINE and dx * dx + dy * dy < 4.0 * MOST_MISS_PX * MOST_MISS_PX:
        return False
    return (x - stays[0]) * dx + (y - stays[1]) * dy > 0.0


@njit(**SUMS)
def _gap_at(cracks, lo, hi, x0, y0, ux, uy, tilt):
    """Least height of a free pixel, greatest of an obstacle, and where both are.

    Heights are above a line through (x0, y0) of slope ``tilt`` against (ux, uy), towards the free
    pixels.
    """
    free = HUGE
    dark = -HUGE
    free_at = 0.0
    dark_at = 0.0
    for k in range(lo, hi):
        x = cracks.x[k] - x0
        y = cracks.y[k] - y0
        along = x * ux + y * uy
        height = x * uy - y * ux
        more = cracks.free_x[k] * ux + cracks.free_y[k] * uy
        up = cracks.free_x[k] * uy - cracks.free_y[k] * ux
        above = height + up - tilt * (along + more)
        below = height - up - tilt * (along - more)
        if above < free:
            free = above
            free_at = along + more
        if below > dark:
            dark = below
            dark_at = along - more
    return free, dark, free_at, dark_at


@njit(**LEAF)
def line_between(cracks, lo, hi):
    """Line farthest from the pixels on both sides of cracks lo .. hi - 1.

    Returns the width of the gap, negative if no line separates the sides, a point and the unit
    vector. The gap is concave in the slope: the next slope is where its tangents at two slopes
    meet.
    """
    x0 = cracks.x[lo]
    y0 = cracks.y[lo]
    ux = cracks.x[hi - 1] - x0
    uy = cracks.y[hi - 1] - y0
    length = math.sqrt(ux * ux + uy * uy)
    if length <= 0.0:
        return -HUGE, x0, y0, 1.0, 0.0
    ux /= length
    uy /= length
    # no steeper line passes between the pixels of the first and the last crack
    steepest = 2.0 * HALF / max(length - 2.0 * HALF, HALF)
    low, low_gap, low_slope = -steepest, HUGE, 0.0
    high, high_gap, high_slope = steepest, HUGE, 0.0
    tilt = 0.0
    best = -HUGE
    best_tilt = 0.0
    best_height = 0.0
    for _ in range(GAP_STEPS):
        free, dark, free_at, dark_at = _gap_at(cracks, lo, hi, x0, y0, ux, uy, tilt)
        gap = free - dark
        if gap > best:
            best = gap
            best_tilt = tilt
            best_height = 0.5 * (free + dark)
        slope = dark_at - free_at
        if slope == 0.0 or (abs(tilt) >= steepest and slope * tilt > 0.0):
            break
        if slope > 0.0:
            low, low_gap, low_slope = tilt, gap, slope
        else:
            high, high_gap, high_slope = tilt, gap, slope
        if low_gap >= HUGE:
            tilt = -steepest
            continue
        if high_gap >= HUGE:
            tilt = steepest
            continue
        tilt = (high_gap - low_gap + low_slope * low - high_slope * high) / (low_slope - high_slope)
        most = low_gap + low_slope * (tilt - low)
        if most < 0.0 or most - best < GAP_SETTLED_PX:
            break
    share = 1.0 / math.sqrt(1.0 + best_tilt * best_tilt)
    vx = (ux + best_tilt * uy) * share
    vy = (uy - best_tilt * ux) * share
    return best, x0 + best_height * uy, y0 - best_height * ux, vx, vy


@njit(**LEAF)
def _meet(cracks, edges, i, after, k, x, y, vx, vy):
    """Point where a line meets edge i, which ends or begins at crack k: x, y, and True if it does.

    An arc is met on its circle; a line at the crossing, or else between the crack's pixels.
    """
    kx = cracks.x[k]
    ky = cracks.y[k]
    ax = edges.rows[i, 0]
    ay = edges.rows[i, 1]
    if edges.kind[i] != LINE:
        qx, qy, met = _on_circle(edges.rows[i, 2:5], x, y, vx, vy, kx, ky)
        off = (edges.rows[i, 2] - x) * vy - (edges.rows[i, 3] - y) * vx
        return qx, qy, met and abs(off) < edges.rows[i, 4]
    bx = edges.rows[after, 0] - ax
    by = edges.rows[after, 1] - ay
    cross = vx * by - vy * bx
    if abs(cross) > SHALLOW * math.sqrt(bx * bx + by * by):
        t = ((ax - x) * by - (ay - y) * bx) / cross
        qx = x + t * vx
        qy = y + t * vy
        if (qx - kx) ** 2 + (qy - ky) ** 2 < MOST_MISS_PX * MOST_MISS_PX:
            return qx, qy, True
    across = cracks.free_x[k] * vy - cracks.free_y[k] * vx
    if across == 0.0:
        return kx, ky, False
    t = ((x - kx) * vy - (y - ky) * vx) / across
    return kx + t * cracks.free_x[k], ky + t * cracks.free_y[k], abs(t) < 1.0


@njit(**LEAF)
def _on_circle(circle, x, y, vx, vy, near_x, near_y):
    """Point where a line meets or nearly meets a circle: x, y, and True if near a given place."""
    cx = circle[0] - x
    cy = circle[1] - y
    along = cx * vx + cy * vy
    off = cx * vy - cy * vx
    root = math.sqrt(max(circle[2] * circle[2] - off * off, 0.0))
    here = (near_x - x) * vx + (near_y - y) * vy
    t = along + root if here > along else along - root
    qx = x + t * vx
    qy = y + t * vy
    near = (qx - near_x) ** 2 + (qy - near_y) ** 2 < MOST_MISS_PX * MOST_MISS_PX
    return qx, qy, near


@njit(**LEAF)
def put_arc(cracks, trial, count, at, lo, hi, circle, scratch):
    """Make edge ``at`` the arc that fits cracks lo .. hi - 1 best, if there is one.

    Between two lines it ends where its circle meets them, else at its joints.
    """
    if not fit_circle(cracks.x, cracks.y, lo, hi, circle):
        return False
    if circle_cost(cracks.x, cracks.y, lo, hi, circle, YES, HALF, 1.0, MOST_MISS_PX, HUGE) >= HUGE:
        return False
    separate_circle(cracks.x, cracks.y, lo, hi, circle, scratch.numbers[0:2])
    rows = trial.rows
    before = predecessor(at, count)
    after = successor(at, count)
    x0, y0 = rows[at, 0], rows[at, 1]
    x1, y1 = rows[after, 0], rows[after, 1]
    if trial.kind[before] == LINE and trial.kind[after] == LINE:
        ax, ay, met = _end_on(circle, rows[before, 0], rows[before, 1], x0, y0)
        end = successor(after, count)
        bx, by, meets = _end_on(circle, rows[end, 0], rows[end, 1], x1, y1)
        if met and meets:
            x0, y0, x1, y1 = ax, ay, bx, by
            rows[at, 0], rows[at, 1], rows[after, 0], rows[after, 1] = x0, y0, x1, y1
    middle = (lo + hi) // 2
    rise = _rise_of(circle, x0, y0, x1, y1, cracks.x[middle], cracks.y[middle])
    if abs(rise) < FLATTEST_PX:
        return False
    trial.kind[at] = ARC_CW if rise > 0.0 else ARC_CCW
    rows[at, 2], rows[at, 3], rows[at, 4] = circle_through(x0, y0, x1, y1, rise)
    return _keeps_off(cracks, lo, hi, rows[at, 2], rows[at, 3], rows[at, 4])


@njit(**SUMS)
def _keeps_off(cracks, lo, hi, cx, cy, r):
    beyond = 0
    for k in range(lo, hi):
        x = cracks.x[k] - cx
        y = cracks.y[k] - cy
        far = math.sqrt(x * x + y * y)
        limit = (HALF - SEPARATION_MARGIN) * max(abs(x), abs(y))
        beyond += abs(far - r) * far > limit
    return beyond == 0


@njit(**LEAF)
def _end_on(circle, ax, ay, x, y):
    """End of the line from (ax, ay) to (x, y) on a circle: x, y, and True if near (x, y)."""
    vx = x - ax
    vy = y - ay
    length = math.sqrt(vx * vx + vy * vy)
    if length < MOST_MISS_PX:
        return x, y, False
    return _on_circle(circle, x, y, vx / length, vy / length, x, y)


@njit(**LEAF)
def _rise_of(circle, x0, y0, x1, y1, x, y):
    """Rise of a circle's arc beside (x, y) to the left of the chord between two places."""
    dx = x1 - x0
    dy = y1 - y0
    chord = math.sqrt(dx * dx + dy * dy)
    if chord <= 0.0:
        return 0.0
    mx = x0 + 0.5 * dx
    my = y0 + 0.5 * dy
    center = ((circle[0] - mx) * dy - (circle[1] - my) * dx) / chord
    height = ((x - mx) * dy - (y - my) * dx) / chord
    left = center + circle[2]
    right = center - circle[2]
    return left if abs(left - height) < abs(right - height) else right


@njit(**LEAF)
def may_be_arc(cracks, lo, hi):
    """True if a sample of cracks lo .. hi - 1 lies near the circle through three of them."""
    if hi - lo < LEAST_ARC:
        return False
    last = hi - 1
    k = (lo + hi) // 2
    x0 = cracks.x[lo]
    y0 = cracks.y[lo]
    cx, cy, r = circle_of_three(
        cracks.x[k] - x0, cracks.y[k] - y0, cracks.x[last] - x0, cracks.y[last] - y0
    )
    if r >= HUGE:
        return False
    for part in range(1, ARC_PARTS):
        j = lo + (last - lo) * part // ARC_PARTS
        away = math.sqrt((cracks.x[j] - x0 - cx) ** 2 + (cracks.y[j] - y0 - cy) ** 2)
        if abs(away - r) > ARC_ASTRAY_PX:
            return False
    return True

"""Loss of one finished edge: its distance from the border, and the area between.

Rules and units
- Types: ``vision.outline.outline_types``; pixels, square pixels.
- Without grey a pixel is lost or not, and deviations are along the pixels' axis.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.fit.outline_kernels import STRAY_PX, arc_ends, distance_to_edge
from vision.outline.fit.separating_fit_kernels import COARSE_PX, HALF
from vision.outline.fitted_borders import LINE
from vision.outline.limit_kernels import MOST_MISS_PX

LOST_AXIS_PX = HALF + COARSE_PX
"""Distance along a pixel's axis, from the middle between two centres, at which an edge loses a
pixel: derived, half a pixel and a drawing's error."""
NARROW_TIP_PX = 0.75
"""Half the width of a tip without a pixel's centre: chosen, above half a pixel's diagonal."""
LONGEST_TIP_PX = 12.0
"""Largest reach of a tip, the blur's sigma over the sine of half its angle: chosen, 10 degrees at a
sigma of 1 px."""
BESIDE_OTHER_PX = HALF
"""Distance of a point from its edge at which it may lie at a neighbour: half a pixel."""
TIP_PX = 2.5
"""Distance from a corner within which pixels are too coarse to show its sides: chosen."""


@njit(**LEAF)
def _narrow_reach(rows, before, at, after):
    """Distance from a joint within which the border is too narrow for a pixel's centre."""
    ax = rows[before, 0] - rows[at, 0]
    ay = rows[before, 1] - rows[at, 1]
    bx = rows[after, 0] - rows[at, 0]
    by = rows[after, 1] - rows[at, 1]
    lengths = math.sqrt((ax * ax + ay * ay) * (bx * bx + by * by))
    cosine = (ax * bx + ay * by) / max(lengths, 1e-9)
    # cotangent of half the angle
    slender = math.sqrt((1.0 + cosine) / max(1.0 - cosine, 1e-3))
    return min(NARROW_TIP_PX * slender, LONGEST_TIP_PX)


@njit(**LEAF)
def _nothing_lost(border, lo, hi, finished, e, after, near_begin, near_end):
    kinds, rows = finished.kind, finished.rows
    xs, ys = border.x[lo : hi + 1], border.y[lo : hi + 1]
    x0, y0 = rows[e, 0], rows[e, 1]
    x1, y1 = rows[after, 0], rows[after, 1]
    doubts = 0
    if kinds[e] == LINE:
        dx = x1 - x0
        dy = y1 - y0
        square = dx * dx + dy * dy
        if square <= 0.0:
            return False
        for k in range(hi + 1 - lo):
            x = xs[k] - x0
            y = ys[k] - y0
            t = min(max((x * dx + y * dy) / square, 0.0), 1.0)
            ax = abs(x - t * dx)
            ay = abs(y - t * dy)
            best = ax * ax + ay * ay
            beside = x * x + y * y < near_begin
            beside |= (xs[k] - x1) * (xs[k] - x1) + (ys[k] - y1) * (ys[k] - y1) < near_end
            lost = (best > LOST_AXIS_PX * max(ax, ay)) | (best >= HALF * HALF)
            beside &= best < MOST_MISS_PX * MOST_MISS_PX
            doubts += lost & (not beside)
        return doubts == 0
    cx, cy, r = rows[e, 2], rows[e, 3], rows[e, 4]
    ax, ay, bx, by = arc_ends(kinds, rows, e, after)
    narrow = ax * by - ay * bx >= 0.0
    for k in range(hi + 1 - lo):
        dx = xs[k] - cx
        dy = ys[k] - cy
        far = math.sqrt(dx * dx + dy * dy)
        after_a = ax * dy - ay * dx >= 0.0
        before_b = dx * by - dy * bx >= 0.0
        within = (after_a & before_b) | ((after_a | before_b) & (not narrow))
        off = abs(far - r)
        best = off * off
        axis = max(abs(dx), abs(dy)) * off / max(far, 1e-9)
        ux = xs[k] - x0
        uy = ys[k] - y0
        vx = xs[k] - x1
        vy = ys[k] - y1
        to_begin = ux * ux + uy * uy
        to_end = vx * vx + vy * vy
        first = to_begin < to_end
        best = best if within else min(to_begin, to_end)
        end_axis = max(abs(ux if first else vx), abs(uy if first else vy))
        axis = axis if within else end_axis
        beside = (to_begin < near_begin) | (to_end < near_end)
        lost = (best > LOST_AXIS_PX * axis) | (best >= HALF * HALF)
        beside &= best < MOST_MISS_PX * MOST_MISS_PX
        doubts += lost & (not beside)
    return doubts == 0


@njit(**SUMS)
def loss_beside(border, lo, hi, finished, e, after, free, near_begin, near_end):
    """Largest distance of a stretch from its finished edge, and the area lost beyond ``free``.

    With grey. Points near the ends (squared distances) do not count up to ``STRAY_PX``.
    """
    kinds, rows = finished.kind, finished.rows
    xs, ys = border.x[lo : hi + 1], border.y[lo : hi + 1]
    x0, y0 = rows[e, 0], rows[e, 1]
    x1, y1 = rows[after, 0], rows[after, 1]
    farthest = 0.0
    lost = 0.0
    if kinds[e] == LINE:
        dx = x1 - x0
        dy = y1 - y0
        square = dx * dx + dy * dy
        share = 1.0 / square if square > 0.0 else 0.0
        for k in range(hi + 1 - lo):
            x = xs[k] - x0
            y = ys[k] - y0
            vx = xs[k] - x1
            vy = ys[k] - y1
            t = min(max((x * dx + y * dy) * share, 0.0), 1.0)
            ax = x - t * dx
            ay = y - t * dy
            away = math.sqrt(ax * ax + ay * ay)
            beside = (x * x + y * y < near_begin) | (vx * vx + vy * vy < near_end)
            away = 0.0 if beside & (away < STRAY_PX) else away
            farthest = max(farthest, away)
            lost += max(away - free, 0.0)
        return farthest, lost
    cx, cy, r = rows[e, 2], rows[e, 3], rows[e, 4]
    ax, ay, bx, by = arc_ends(kinds, rows, e, after)
    narrow = ax * by - ay * bx >= 0.0
    for k in range(hi + 1 - lo):
        dx = xs[k] - cx
        dy = ys[k] - cy
        after_a = ax * dy - ay * dx >= 0.0
        before_b = dx * by - dy * bx >= 0.0
        within = (after_a & before_b) | ((after_a | before_b) & (not narrow))
        ux = xs[k] - x0
        uy = ys[k] - y0
        vx = xs[k] - x1
        vy = ys[k] - y1
        to_begin = ux * ux + uy * uy
        to_end = vx * vx + vy * vy
        away = abs(math.sqrt(dx * dx + dy * dy) - r)
        away = away if within else math.sqrt(min(to_begin, to_end))
        beside = (to_begin < near_begin) | (to_end < near_end)
        away = 0.0 if beside & (away < STRAY_PX) else away
        farthest = max(farthest, away)
        lost += max(away - free, 0.0)
    return farthest, lost


@njit(**LEAF)
def edge_loss(border, lo, hi, finished, e, edges, limits):
    """Loss of a finished edge along its stretch: ``(worst deviation, area lost)``, 0 for little.

    A point may lie at a neighbouring edge. Points in a tip, or within ``guard`` of a joint, do not
    count. Without grey a deviation over ``LOST_AXIS_PX`` along the axis loses a pixel; otherwise
    the excess over ``free`` is lost.
    """
    px = border.x
    py = border.y
    kinds, rows = finished.kind, finished.rows
    crisp = limits.crisp
    free = limits.free
    guard = limits.guard
    next_ = successor(e, edges)
    before = predecessor(e, edges)
    behind = successor(next_, edges)
    near_begin = _narrow_reach(rows, before, e, next_) ** 2
    near_end = _narrow_reach(rows, e, next_, behind) ** 2
    if crisp:
        if _nothing_lost(border, lo, hi, finished, e, next_, near_begin, near_end):
            return 0.0, 0.0
    else:
        # in narrow places the light of both sides meets
        near_begin = max(near_begin, guard * guard, TIP_PX * TIP_PX)
        near_end = max(near_end, guard * guard, TIP_PX * TIP_PX)
        far, area = loss_beside(border, lo, hi, finished, e, next_, free, near_begin, near_end)
        if far < BESIDE_OTHER_PX:
            return far, area
    worst = 0.0
    lost = 0.0
    for k in range(lo, hi + 1):
        x = px[k]
        y = py[k]
        beside = (x - rows[e, 0]) ** 2 + (y - rows[e, 1]) ** 2 < near_begin
        beside = beside or (x - rows[next_, 0]) ** 2 + (y - rows[next_, 1]) ** 2 < near_end
        best, fx, fy = distance_to_edge(kinds, rows, e, next_, x, y)
        if beside and best < (MOST_MISS_PX if crisp else STRAY_PX):
            continue
        if best >= BESIDE_OTHER_PX:
            d, ex, ey = distance_to_edge(kinds, rows, before, e, x, y)
            if d < best:
                best = d
                fx = ex
                fy = ey
            d, ex, ey = distance_to_edge(kinds, rows, next_, behind, x, y)
            if d < best:
                best = d
                fx = ex
                fy = ey
        worst = max(worst, best)
        if crisp:
            axis = max(abs(x - fx), abs(y - fy))
            if best * best > LOST_AXIS_PX * axis:
                lost += 1.0
        elif best > free:
            lost += best - free
    return worst, lost

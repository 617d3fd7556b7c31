"""Finished edges, and whether they cover their border: what does not, falls to chords.

Rules and units
- ``px``, ``py`` as in ``vision.outline.fit.shape_kernels``: one border's n points, twice over.
- A finished edge is a row x, y of its first point, cx, cy, r of an arc, and the rms deviation;
  it ends where the next one begins.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from vision.outline.corners.joint_kernels import edge_end, onto
from vision.outline.drawn.joint_relaxation_kernels import polish_edges
from vision.outline.fit.outline_kernels import STRAY_PX, arc_length, distance_to_edge, finish_edge
from vision.outline.fit.separating_fit_kernels import HALF
from vision.outline.fit.shape_kernels import HUGE
from vision.outline.fitted_borders import ARC_CCW, LINE

CHECKS = 6
"""Times that the finished edges are compared with the border."""
LOST_AXIS_PX = 0.505
"""Along a pixel's axis, how far from the middle between two pixels' centres an edge may run
before a pixel counts as lost."""
NARROW_PX, LONGEST_TIP_PX = 0.75, 12.0
"""Half the width of a tip without a pixel's centre, and how far it may reach back."""
BESIDE_OTHER_PX = 0.5
"""A point farther from its edge may lie at a neighbouring one."""
TIP_STRAY_PX = 1.0
"""The border of a tip stays as near to its edges; what is farther off is no tip."""
TIP_PX = 2.5
"""Within this distance of a corner pixels are too coarse to tell where its sides run."""
RAGGED_SHARE, CRISP_RAGGED_SHARE = 0.15, 0.03
"""Area lost per point from which a stretch counts as ragged, where its border loses too much."""


@njit(**LEAF)
def _tip(rows, before, at, after):
    """Within which distance of a joint the border is too narrow to hold a pixel's centre."""
    ax = rows[before, 0] - rows[at, 0]
    ay = rows[before, 1] - rows[at, 1]
    bx = rows[after, 0] - rows[at, 0]
    by = rows[after, 1] - rows[at, 1]
    lengths = math.sqrt((ax * ax + ay * ay) * (bx * bx + by * by))
    cosine = (ax * bx + ay * by) / max(lengths, 1e-9)
    # half the angle's cotangent
    slender = math.sqrt((1.0 + cosine) / max(1.0 - cosine, 1e-3))
    return min(NARROW_PX * slender, LONGEST_TIP_PX)


@njit(**LEAF)
def _nothing_lost(px, py, lo, hi, e, after, kinds, rows, near_begin, near_end):
    """Whether no pixel of a picture without grey is lost beside a finished edge."""
    xs = px[lo : hi + 1]
    ys = py[lo : hi + 1]
    x0 = rows[e, 0]
    y0 = rows[e, 1]
    x1 = rows[after, 0]
    y1 = rows[after, 1]
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
            beside &= best < TIP_STRAY_PX * TIP_STRAY_PX
            doubts += lost & (not beside)
        return doubts == 0
    cx = rows[e, 2]
    cy = rows[e, 3]
    r = rows[e, 4]
    ax, ay, bx, by = _arc_ends(kinds, rows, e, after)
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
        beside &= best < TIP_STRAY_PX * TIP_STRAY_PX
        doubts += lost & (not beside)
    return doubts == 0


@njit(**LEAF)
def _arc_ends(kinds, rows, e, after):
    """From an arc's centre to its ends, in the sense in which the angle grows."""
    ax = rows[e, 0] - rows[e, 2]
    ay = rows[e, 1] - rows[e, 3]
    bx = rows[after, 0] - rows[e, 2]
    by = rows[after, 1] - rows[e, 3]
    if kinds[e] == ARC_CCW:
        return bx, by, ax, ay
    return ax, ay, bx, by


@njit(**SUMS)
def loss_beside(px, py, lo, hi, e, after, kinds, rows, free, near_begin, near_end):
    """A stretch's farthest point from its finished edge, and the area lost beyond ``free``.

    In a picture with grey; what lies near the ends, as squared distances, does not count as far as
    ``STRAY_PX``.
    """
    xs = px[lo : hi + 1]
    ys = py[lo : hi + 1]
    x0 = rows[e, 0]
    y0 = rows[e, 1]
    x1 = rows[after, 0]
    y1 = rows[after, 1]
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
    cx = rows[e, 2]
    cy = rows[e, 3]
    r = rows[e, 4]
    ax, ay, bx, by = _arc_ends(kinds, rows, e, after)
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
def _loss(px, py, lo, hi, e, edges, kinds, rows, crisp, free, guard):
    """What a finished edge misses of its stretch: ``(worst deviation, area lost)``, 0 for little.

    A point may lie at a neighbouring edge, which the joint may have lengthened; what blur
    rounds within ``guard`` of a joint, or lies in a tip, does not count. In a picture without
    grey a deviation below ``LOST_AXIS_PX`` along the axis loses nothing, beyond it a pixel;
    otherwise what exceeds ``free`` is lost.
    """
    next_ = e + 1 if e + 1 < edges else 0
    before = e - 1 if e > 0 else edges - 1
    behind = next_ + 1 if next_ + 1 < edges else 0
    near_begin = _tip(rows, before, e, next_) ** 2
    near_end = _tip(rows, e, next_, behind) ** 2
    if crisp:
        if _nothing_lost(px, py, lo, hi, e, next_, kinds, rows, near_begin, near_end):
            return 0.0, 0.0
    else:
        # where it is narrow the light of both sides meets
        near_begin = max(near_begin, guard * guard, TIP_PX * TIP_PX)
        near_end = max(near_end, guard * guard, TIP_PX * TIP_PX)
        far, area = loss_beside(
            px, py, lo, hi, e, next_, kinds, rows, free, near_begin, near_end
        )  # fmt: skip
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
        if beside and best < (TIP_STRAY_PX if crisp else STRAY_PX):
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


@njit(**LEAF)
def pass_between_pixels(
    px, py, n, breaks, is_arc, edges, shape, joints, free, allowed, guard,
    ragged, losses, stale, kinds, rows, circle, push,
):  # fmt: skip
    """Finish the edges of a picture without grey between its pixels: the area that they lose.

    HUGE where one strays too far. ``push`` (2 * edges, 6) is room to work in.
    """
    total = HUGE
    for again in range(2):
        total = area_lost(
            px, py, n, breaks, is_arc, edges, shape, joints, True, free, allowed, guard,
            ragged, losses, stale, kinds, rows, circle,
        )  # fmt: skip
        if total == 0.0 or again == 1:
            break
        polish_edges(px, py, n, breaks, is_arc, kinds, edges, joints, rows, shape, push)
    return total


@njit(**SUMS)
def area_beside_circle(px, py, lo, hi, circle, free):
    """The area that a circle would lose of points lo .. hi - 1, as ``area_lost`` of edges."""
    xs = px[lo:hi]
    ys = py[lo:hi]
    cx = circle[0]
    cy = circle[1]
    r = circle[2]
    lost = 0.0
    for k in range(hi - lo):
        x = xs[k] - cx
        y = ys[k] - cy
        lost += max(abs(math.sqrt(x * x + y * y) - r) - free, 0.0)
    return lost


@njit(**LEAF)
def area_lost(
    px, py, n, breaks, is_arc, edges, shape, joints, crisp, free, allowed, guard,
    ragged, losses, stale, kinds, rows, circle,
):  # fmt: skip
    """Finish the edges: the area that they lose, HUGE where one strays too far."""
    for e in range(edges):
        ragged[e] = False
        stale[e] = True
    _finish_stale(px, py, n, breaks, is_arc, edges, shape, joints, stale, kinds, rows, circle)
    bad, total = _find_losses(
        px, py, n, breaks, edges, crisp, free, allowed, guard, ragged, losses, stale, kinds, rows
    )
    return HUGE if bad else total


@njit(**LEAF)
def _find_losses(
    px, py, n, breaks, edges, crisp, free, allowed, guard, ragged, losses, stale, kinds, rows
):
    """Every edge's lost area, anew where it is stale: ``(whether one strays, total)``."""
    strayed = False
    total = 0.0
    for e in range(edges):
        if ragged[e]:
            losses[e] = 0.0
            continue
        after = e + 1 if e + 1 < edges else 0
        before = e - 1 if e > 0 else edges - 1
        if stale[before] or stale[e] or stale[after]:
            lo = breaks[e]
            hi = edge_end(breaks, edges, n, e)
            farthest, losses[e] = _loss(px, py, lo, hi, e, edges, kinds, rows, crisp, free, guard)
            bad = farthest > allowed
            if kinds[e] != LINE:
                longest = 2.0 * (hi - lo) + 4.0
                bad = bad or arc_length(kinds, rows, e, after) > longest
            if bad:
                ragged[e] = True
                strayed = True
        total += losses[e]
    return strayed, total


@njit(**LEAF)
def check_edges(
    px, py, n, breaks, is_arc, edges, shape, joints, crisp, free, allowed, guard, budget,
    ragged, losses, stale, kinds, rows, circle,
):  # fmt: skip
    """Finish the edges, and mark as ragged what would not cover the border well enough.

    A ragged edge ends at border points; that moves its neighbours' ends, so the check is
    repeated until nothing changes. ``stale`` (edges,) is room to work in.
    """
    for e in range(edges):
        ragged[e] = False
        stale[e] = True
        losses[e] = 0.0
    for _ in range(CHECKS):
        _finish_stale(px, py, n, breaks, is_arc, edges, shape, joints, stale, kinds, rows, circle)
        changed, total = _find_losses(
            px, py, n, breaks, edges, crisp, free, allowed, guard, ragged, losses, stale, kinds,
            rows,
        )  # fmt: skip
        while total > budget:
            worst = 0
            densest = 0.0
            for e in range(edges):
                length = edge_end(breaks, edges, n, e) - breaks[e]
                density = losses[e] / max(length, 4)
                if density > densest:
                    densest = density
                    worst = e
            if densest < (CRISP_RAGGED_SHARE if crisp else RAGGED_SHARE):
                break
            changed = True
            total -= losses[worst]
            losses[worst] = 0.0
            ragged[worst] = True
        if not changed:
            return
        for e in range(edges):
            stale[e] = False
        for e in range(edges):
            if ragged[e]:
                _end_at_points(px, py, breaks, is_arc, edges, shape, joints, ragged, stale, e)
    _finish_stale(px, py, n, breaks, is_arc, edges, shape, joints, stale, kinds, rows, circle)


@njit(**LEAF)
def _end_at_points(px, py, breaks, is_arc, edges, shape, joints, ragged, stale, e):
    """Move both joints of a ragged edge to the border, on their neighbours where these fit."""
    stale[e] = True
    for side in range(2):
        end = e if side == 0 else (e + 1 if e + 1 < edges else 0)
        x = px[breaks[end]]
        y = py[breaks[end]]
        other = (e - 1 if e > 0 else edges - 1) if side == 0 else end
        stale[other] = True
        if not ragged[other]:
            # the neighbour stays where its fit is
            fx, fy = onto(shape, other, is_arc[other], x, y)
            if (fx - x) ** 2 + (fy - y) ** 2 < 1.0:
                x = fx
                y = fy
        joints[end, 0] = x
        joints[end, 1] = y


@njit(**LEAF)
def _finish_stale(px, py, n, breaks, is_arc, edges, shape, joints, stale, kinds, rows, circle):
    for e in range(edges):
        if stale[e]:
            hi = edge_end(breaks, edges, n, e)
            kinds[e] = finish_edge(
                px, py, breaks[e], hi, is_arc[e], shape, e, joints,
                e + 1 if e + 1 < edges else 0, rows, circle,
            )  # fmt: skip


@njit(cache=True, nogil=True)
def chords(px, py, lo, hi, tolerance, is_seed, found):
    """Break a stretch into chords within tolerance: ``found`` = their first points' indices."""
    count = hi - lo
    for k in range(count + 1):
        is_seed[k] = False
    found[0] = lo
    m = 1
    stack = np.empty((count + 2, 2), np.int64)
    stack[0, 0] = lo
    stack[0, 1] = hi
    top = 1
    while top > 0:
        top -= 1
        a = stack[top, 0]
        b = stack[top, 1]
        dx = px[b] - px[a]
        dy = py[b] - py[a]
        length = math.sqrt(dx * dx + dy * dy)
        far = -HUGE
        where = a
        for k in range(a + 1, b):
            x = px[k] - px[a]
            y = py[k] - py[a]
            d = math.sqrt(x * x + y * y) if length < 1e-9 else abs(x * dy - y * dx) / length
            if d > far:
                far = d
                where = k
        if far > tolerance:
            is_seed[where - lo] = True
            stack[top, 0] = where
            stack[top, 1] = b
            stack[top + 1, 0] = a
            stack[top + 1, 1] = where
            top += 2
    for k in range(1, count):
        if is_seed[k]:
            found[m] = lo + k
            m += 1
    return m

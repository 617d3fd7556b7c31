"""Edges fitted between their breaks, and the joints where neighbouring edges meet.

Rules and units
- ``px``, ``py`` as in ``vision.outline.fit.shape_kernels``: one border's n points, twice over.
- ``breaks`` holds each edge's first point; the edge ends at the next one's. ``shape`` row:
  x, y, ux, uy of a line or cx, cy, r of a circle, and the rms deviation last.
- What lies within ``guard`` pixels of a corner, where blur rounds the border, takes no part in
  a fit; short stretches keep their middle.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.fit.separating_fit_kernels import separate_circle, separate_line
from vision.outline.fit.shape_kernels import (
    HUGE,
    circle_rms,
    fit_circle,
    fit_line,
    line_rms,
    refine_circle,
)

ROUNDS = 4
"""Times that edges are fitted, each with the corners of the time before."""
REFINEMENTS, EVERY = np.int64(8), np.int64(1)
"""Rounds of Gauss-Newton; a fit takes every point."""
STRAIGHT_PX = 0.05
"""An arc that rises less over its chord is a line: no edge point is known better."""
SHALLOW = 0.03
"""Sine of the angle below which two lines are taken for one."""
SMOOTH_SLIDE = 24
"""Points by which a break beside an arc may move to where the fits of both sides are best."""
TURN = 6
"""Points on either side of a break that tell where its border comes from and goes to."""
SLIDE = 8
"""Points by which a break may move towards its corner at a time."""


@njit(**LEAF)
def edge_end(breaks, edges, n, e):
    """The last point of edge e, behind its first one: it may run past the border's end."""
    hi = breaks[e + 1 if e + 1 < edges else 0]
    return hi + n if hi <= breaks[e] else hi


@njit(cache=True, nogil=True)
def fit_and_join(
    px, py, n, breaks, is_arc, edges, crisp, guard, blur, tangent, joints, shape, ranges, fresh,
    active,
):  # fmt: skip
    """Fit every edge, join neighbours, and so again with the joints found, until it settles.

    ``joints`` (edges, 2) and ``shape`` are filled, ``breaks`` and ``is_arc`` corrected;
    ``ranges`` (edges, 2), ``fresh`` (edges, 2) and ``active`` are room to work in.
    """
    for e in range(edges):
        joints[e, 0] = px[breaks[e]]
        joints[e, 1] = py[breaks[e]]
        ranges[e, 0] = -1
        ranges[e, 1] = -1
        fresh[e, 1] = True
    for _ in range(ROUNDS):
        if not _fit_edges(
            px, py, n, breaks, is_arc, edges, crisp, guard, joints, shape, ranges, fresh, active
        ):
            break
        _join(px, py, n, breaks, is_arc, edges, shape, blur, tangent, joints, fresh)


@njit(**LEAF)
def onto(shape, e, is_arc, x, y):
    """The point of the fitted line or circle of edge e nearest to (x, y)."""
    if is_arc:
        dx = x - shape[e, 0]
        dy = y - shape[e, 1]
        d = math.sqrt(dx * dx + dy * dy)
        if d == 0.0:
            return x, y
        return shape[e, 0] + dx * shape[e, 2] / d, shape[e, 1] + dy * shape[e, 2] / d
    t = (x - shape[e, 0]) * shape[e, 2] + (y - shape[e, 1]) * shape[e, 3]
    return shape[e, 0] + t * shape[e, 2], shape[e, 1] + t * shape[e, 3]


@njit(**LEAF)
def _away(shape, e, is_arc, known, x, y, joints, j):
    """How far (x, y) lies from joint j, squared: along the edge where that has been fitted.

    A point's deviation must not decide whether it takes part: those that lie far off would.
    """
    if known:
        x, y = onto(shape, e, is_arc, x, y)
    return (x - joints[j, 0]) ** 2 + (y - joints[j, 1]) ** 2


@njit(**LEAF)
def _clear_of_joints(px, py, lo, hi, joints, shape, e, is_arc, known, after, guard):
    """The part of a stretch that keeps ``guard`` pixels from both joints, or its middle."""
    length = hi - lo
    least = max(3, (2 * length) // 5)
    a = lo
    b = hi
    near = guard * guard
    d = _away(shape, e, is_arc, known, px[a], py[a], joints, e)
    f = _away(shape, e, is_arc, known, px[b], py[b], joints, after)
    while b - a > least and (d < near or f < near):
        if d < near:
            a += 1
            d = _away(shape, e, is_arc, known, px[a], py[a], joints, e)
        if f < near:
            b -= 1
            f = _away(shape, e, is_arc, known, px[b], py[b], joints, after)
    return a, b + 1


@njit(**LEAF)
def _fit_edges(
    px, py, n, breaks, is_arc, edges, crisp, guard, joints, shape, ranges, fresh, active
):
    """Fit the edges whose points are not those of the time before: whether there were any.

    ``fresh[e, 0]`` says so of each edge; where only a break moved, ``fresh[e, 1]``, the
    joints are looked at again.
    """
    work = False
    for e in range(edges):
        lo = breaks[e]
        hi = edge_end(breaks, edges, n, e)
        a, b = _clear_of_joints(
            px, py, lo, hi, joints, shape, e, is_arc[e], ranges[e, 0] >= 0,
            e + 1 if e + 1 < edges else 0, guard,
        )  # fmt: skip
        fresh[e, 0] = a != ranges[e, 0] or b != ranges[e, 1]
        work = work or fresh[e, 0] or fresh[e, 1]
        if not fresh[e, 0]:
            continue
        ranges[e, 0] = a
        ranges[e, 1] = b
        row = shape[e]
        if is_arc[e] and not (b - a >= 5 and fit_circle(px, py, a, b, EVERY, row)):
            is_arc[e] = False
        if is_arc[e]:
            chord_x = px[b - 1] - px[a]
            chord_y = py[b - 1] - py[a]
            rise = (chord_x * chord_x + chord_y * chord_y) / (8.0 * row[2])
            is_arc[e] = rise >= STRAIGHT_PX
        if is_arc[e]:
            refine_circle(px, py, a, b, REFINEMENTS, row)
            if crisp:
                separate_circle(px, py, a, b, row, active)
            row[4] = circle_rms(px, py, a, b, row)
        else:
            fit_line(px, py, a, b, EVERY, row)
            if crisp:
                separate_line(px, py, a, b, row, active)
            row[4] = line_rms(px, py, a, b, row)
    return work


@njit(**LEAF)
def _crossing(a, a_arc, b, b_arc, x, y, from_x, from_y, to_x, to_y, out):
    """The crossing of two neighbouring edges nearest to (x, y); False where there is none.

    out = x, y and half the sine of the angle between the edges, as a share of the rounding; the
    border comes from (from_x, from_y) and goes to (to_x, to_y).
    """
    if not a_arc and not b_arc:
        cross = a[2] * b[3] - a[3] * b[2]
        if abs(cross) < SHALLOW:
            return False
        t = ((b[0] - a[0]) * b[3] - (b[1] - a[1]) * b[2]) / cross
        out[0] = a[0] + t * a[2]
        out[1] = a[1] + t * a[3]
        # sine of half the corner's inner angle: a narrow tip is rounded far back
        out[2] = math.sqrt(max(0.5 * (1.0 + a[2] * b[2] + a[3] * b[3]), 0.0))
        return True
    if a_arc and b_arc:
        dx = b[0] - a[0]
        dy = b[1] - a[1]
        d = math.sqrt(dx * dx + dy * dy)
        if d < 1e-9:
            return False
        along = (d * d + a[2] * a[2] - b[2] * b[2]) / (2.0 * d)
        base_x = a[0] + along * dx / d
        base_y = a[1] + along * dy / d
        off2 = a[2] * a[2] - along * along
        off_x = -dy / d
        off_y = dx / d
    else:
        line = b if a_arc else a
        arc = a if a_arc else b
        t = (arc[0] - line[0]) * line[2] + (arc[1] - line[1]) * line[3]
        base_x = line[0] + t * line[2]
        base_y = line[1] + t * line[3]
        off2 = arc[2] * arc[2] - (arc[0] - base_x) ** 2 - (arc[1] - base_y) ** 2
        off_x = line[2]
        off_y = line[3]
    if off2 < 0.0:
        return False
    off = math.sqrt(off2)
    if (x - base_x) * off_x + (y - base_y) * off_y < 0.0:
        off = -off
    out[0] = base_x + off * off_x
    out[1] = base_y + off * off_y
    ax, ay = tangent_at(a, a_arc, out[0], out[1], x - from_x, y - from_y)
    bx, by = tangent_at(b, b_arc, out[0], out[1], to_x - x, to_y - y)
    out[2] = math.sqrt(max(0.5 * (1.0 + ax * bx + ay * by), 0.0))
    return True


@njit(**LEAF)
def tangent_at(row, is_arc, x, y, along_x, along_y):
    """The unit vector along a fitted edge at (x, y), towards (along_x, along_y)."""
    tx = row[2]
    ty = row[3]
    if is_arc:
        tx = (row[1] - y) / row[2]
        ty = (x - row[0]) / row[2]
    if tx * along_x + ty * along_y < 0.0:
        return -tx, -ty
    return tx, ty


@njit(**LEAF)
def _touch(a, a_arc, b, b_arc, out):
    """Where an arc and its neighbour come nearest; out = x, y and the gap (crossing: negative).

    Two arcs touch from outside or from inside, whichever leaves the smaller gap. A crossing's
    position is ill-defined where edges are nearly tangent; the point of contact is not.
    """
    if a_arc and b_arc:
        dx = b[0] - a[0]
        dy = b[1] - a[1]
        d = math.sqrt(dx * dx + dy * dy)
        if d < 1e-9:
            return False
        # on the line of centres, the points of both circles
        outside = d - a[2] - b[2]
        inside = d - abs(a[2] - b[2])
        ta = a[2]
        tb = d - b[2]
        gap = outside
        if abs(inside) < abs(outside):
            if a[2] >= b[2]:
                tb = d + b[2]
            else:
                ta = -a[2]
            gap = -inside
        t = 0.5 * (ta + tb) / d
        out[0] = a[0] + t * dx
        out[1] = a[1] + t * dy
        out[2] = gap
        return True
    line = b if a_arc else a
    arc = a if a_arc else b
    t = (arc[0] - line[0]) * line[2] + (arc[1] - line[1]) * line[3]
    foot_x = line[0] + t * line[2]
    foot_y = line[1] + t * line[3]
    dx = foot_x - arc[0]
    dy = foot_y - arc[1]
    d = math.sqrt(dx * dx + dy * dy)
    if d < 1e-9:
        return False
    share = 0.5 * (1.0 + arc[2] / d)
    out[0] = arc[0] + share * dx
    out[1] = arc[1] + share * dy
    out[2] = d - arc[2]
    return True


@njit(**LEAF)
def nearest_point(px, py, n, middle, before, after, x, y):
    """The border point nearest to (x, y) from ``before`` points ahead of ``middle`` to after."""
    best = HUGE
    where = middle
    first = middle + n if middle < before else middle
    for k in range(first - before, first + after + 1):
        d = (px[k] - x) ** 2 + (py[k] - y) ** 2
        if d < best:
            best = d
            where = k
    return where - n if where >= n else where, math.sqrt(best)


@njit(**LEAF)
def _deviation(row, is_arc, x, y):
    dx = x - row[0]
    dy = y - row[1]
    if is_arc:
        return abs(math.sqrt(dx * dx + dy * dy) - row[2])
    return abs(dx * row[3] - dy * row[2])


@njit(**LEAF)
def _best_split(px, py, n, a, a_arc, b, b_arc, middle, before, after):
    """Where a border changes from edge a to edge b: the split with the least squares."""
    total = 0.0
    best = 0.0
    first = middle + n if middle < before else middle
    where = first - before
    for k in range(first - before, first + after):
        da = _deviation(a, a_arc, px[k], py[k])
        db = _deviation(b, b_arc, px[k], py[k])
        total += da * da - db * db
        if total < best:
            best = total
            where = k + 1
    return where - n if where >= n else where


@njit(cache=True, nogil=True)
def _join(px, py, n, breaks, is_arc, edges, shape, blur, tangent, joints, fresh):
    """Where neighbouring edges meet; breaks move to the border points nearest to that.

    A crossing is believed where the border comes as near to it as blur and the corner's
    angle let it; edges that do not cross, or hardly, meet half-way between them. On return
    ``fresh[e, 1]`` says whether break e moved.
    """
    found = np.empty(3, np.float64)
    moved = np.empty(edges, np.int64)
    for e in range(edges):
        moved[e] = breaks[e]
        before = e - 1 if e > 0 else edges - 1
        after = e + 1 if e + 1 < edges else 0
        if not (
            fresh[before, 0] or fresh[e, 0] or fresh[before, 1] or fresh[e, 1] or fresh[after, 1]
        ):
            continue
        a = shape[before]
        b = shape[e]
        a_arc = is_arc[before]
        b_arc = is_arc[e]
        here = breaks[e]
        room_before = max((here - breaks[before]) % n - 1, 0) // 2
        room_after = max((breaks[after] - here) % n - 1, 0) // 2
        if a_arc or b_arc:
            here = _best_split(
                px, py, n, a, a_arc, b, b_arc, here,
                min(SMOOTH_SLIDE, room_before), min(SMOOTH_SLIDE, room_after),
            )  # fmt: skip
            # no farther than half-way to the next break, or two might change places
            slid = (here - breaks[e] + n // 2) % n - n // 2
            room_before += slid
            room_after -= slid
        x = px[here]
        y = py[here]
        moved[e] = here
        if (a_arc or b_arc) and _touch(a, a_arc, b, b_arc, found) and abs(found[2]) <= tangent:
            where, distance = nearest_point(
                px, py, n, here, min(SMOOTH_SLIDE, room_before), min(SMOOTH_SLIDE, room_after),
                found[0], found[1],
            )  # fmt: skip
            if distance <= 1.0:
                joints[e, 0] = found[0]
                joints[e, 1] = found[1]
                moved[e] = where
                continue
        p = here - min(TURN, n // 4)
        q = here + min(TURN, n // 4)
        p = p + n if p < 0 else p
        if _crossing(a, a_arc, b, b_arc, x, y, px[p], py[p], px[q], py[q], found):
            where, distance = nearest_point(
                px, py, n, here, min(SLIDE, room_before), min(SLIDE, room_after),
                found[0], found[1],
            )  # fmt: skip
            if distance <= 0.5 + (0.3 + blur) / max(found[2], 0.1):
                joints[e, 0] = found[0]
                joints[e, 1] = found[1]
                moved[e] = where
                continue
        ax, ay = onto(shape, before, a_arc, x, y)
        bx, by = onto(shape, e, b_arc, x, y)
        joints[e, 0] = 0.5 * (ax + bx)
        joints[e, 1] = 0.5 * (ay + by)
        if (joints[e, 0] - x) ** 2 + (joints[e, 1] - y) ** 2 > 1.0:
            joints[e, 0] = x
            joints[e, 1] = y
    for e in range(edges):
        fresh[e, 1] = moved[e] != breaks[e]
        breaks[e] = moved[e]

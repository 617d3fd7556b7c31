"""Edges fitted between their breaks, and the joints where neighbouring edges meet.

Rules and units
- Types: ``vision.outline.outline_types``.
- Points within ``guard`` pixels of a corner, where blur rounds the border, take no part in a fit;
  short stretches keep their middle.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.corners.crossing_kernels import crossing, onto, touch
from vision.outline.fit.edge_shape_kernels import (
    HUGE,
    circle_rms,
    fit_circle,
    fit_line,
    line_rms,
    refine_circle,
)
from vision.outline.fit.outline_kernels import KNOWN_PX, STRAY_PX, edge_end
from vision.outline.fit.separating_fit_kernels import separate_circle, separate_line

CORNER_ROUNDS = 4
"""Most fits of edges, each with the last corners: chosen, a bound on the work."""
SMOOTH_SLIDE = 24
"""Points by which a break beside an arc may move to the best split: chosen."""
SLIDE = 8
"""Points by which a break may move towards its corner at a time: chosen."""
FORESEEN = 0.25
"""Largest distance of a corner beyond the border, as a share of its shorter side: chosen, short,
nearly parallel lines meet anywhere. It gives up 50 of 679 tips of drawn wedges, 25 to 60 px long,
that lie beyond by 2 px."""


@njit(**LEAF, forceinline=False)
def fit_and_join(border, outline, edges, limits, scratch):
    """Fit every edge and join neighbours until the joints settle.

    Corrects the outline's ``breaks`` and ``is_arc``; fills all but ``is_fillet``.
    """
    near = scratch.numbers[0:2]
    found = scratch.numbers[2]
    for e in range(edges):
        outline.joints[e, 0] = border.x[outline.breaks[e]]
        outline.joints[e, 1] = border.y[outline.breaks[e]]
        outline.ranges[e, 0] = -1
        outline.ranges[e, 1] = -1
        outline.fresh[e, 1] = True
    for _ in range(CORNER_ROUNDS):
        if not _fit_edges(border, outline, edges, limits, near):
            break
        _join(border, outline, edges, limits, found)


@njit(**LEAF)
def _away(shape, e, is_arc, known, x, y, joints, j):
    """Squared distance of (x, y) from joint j, measured along the edge if it has been fitted.

    A point's deviation must not decide if it takes part.
    """
    if known:
        x, y = onto(shape, e, is_arc, x, y)
    return (x - joints[j, 0]) ** 2 + (y - joints[j, 1]) ** 2


@njit(**LEAF)
def _clear_of_joints(border, outline, edges, e, guard):
    px = border.x
    py = border.y
    joints = outline.joints
    shape = outline.shape
    is_arc = outline.is_arc[e]
    known = outline.ranges[e, 0] >= 0
    after = successor(e, edges)
    lo = outline.breaks[e]
    hi = edge_end(outline.breaks, edges, border.n, e)
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


@njit(**LEAF, forceinline=True)
def _fit_edges(border, outline, edges, limits, near):
    """Fit the edges whose points have changed; True if there were any.

    ``fresh[e, 0]`` marks each.
    """
    px = border.x
    py = border.y
    is_arc = outline.is_arc
    ranges = outline.ranges
    fresh = outline.fresh
    work = False
    for e in range(edges):
        a, b = _clear_of_joints(border, outline, edges, e, limits.guard)
        fresh[e, 0] = a != ranges[e, 0] or b != ranges[e, 1]
        work = work or fresh[e, 0] or fresh[e, 1]
        if not fresh[e, 0]:
            continue
        ranges[e, 0] = a
        ranges[e, 1] = b
        row = outline.shape[e]
        if is_arc[e] and not (b - a >= 5 and fit_circle(px, py, a, b, row)):
            is_arc[e] = False
        if is_arc[e]:
            chord_x = px[b - 1] - px[a]
            chord_y = py[b - 1] - py[a]
            rise = (chord_x * chord_x + chord_y * chord_y) / (8.0 * row[2])
            is_arc[e] = rise >= KNOWN_PX
        if is_arc[e]:
            refine_circle(px, py, a, b, row)
            if limits.crisp:
                separate_circle(px, py, a, b, row, near)
            row[4] = circle_rms(px, py, a, b, row)
        else:
            fit_line(px, py, a, b, row)
            if limits.crisp:
                separate_line(px, py, a, b, row, near)
            row[4] = line_rms(px, py, a, b, row)
    return work


@njit(**LEAF)
def nearest_point(border, middle, before, after, x, y):
    """Border point nearest to (x, y), from ``before`` points ahead of ``middle`` to ``after``
    behind."""
    px = border.x
    py = border.y
    n = border.n
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
def _best_split(border, a, a_arc, b, b_arc, middle, before, after):
    px = border.x
    py = border.y
    n = border.n
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


@njit(**LEAF, forceinline=True)
def _join(border, outline, edges, limits, found):
    """Join neighbouring edges; breaks move to the border points nearest to the joints.

    ``fresh[e, 1]`` marks moved ones.
    """
    fresh = outline.fresh
    breaks = outline.breaks
    moved = outline.moved
    for e in range(edges):
        moved[e] = breaks[e]
        before = predecessor(e, edges)
        after = successor(e, edges)
        if fresh[before, 0] or fresh[e, 0] or fresh[before, 1] or fresh[e, 1] or fresh[after, 1]:
            moved[e] = _join_at(border, outline, edges, limits, e, found)
    for e in range(edges):
        fresh[e, 1] = moved[e] != breaks[e]
        breaks[e] = moved[e]


@njit(**LEAF)
def _join_at(border, outline, edges, limits, e, found):
    """Join edge e to the one before it, in ``joints``; return the break nearest to the joint.

    A crossing counts if the border comes as near to it as blur and the corner's angle allow, and
    beyond ``STRAY_PX`` only if its sides are long enough. Other edges meet half-way between them.
    ``found`` (3,) is scratch space.
    """
    n = border.n
    breaks = outline.breaks
    joints = outline.joints
    shape = outline.shape
    before = predecessor(e, edges)
    after = successor(e, edges)
    a = shape[before]
    b = shape[e]
    a_arc = outline.is_arc[before]
    b_arc = outline.is_arc[e]
    here = breaks[e]
    slack_before = max((here - breaks[before]) % n - 1, 0) // 2
    slack_after = max((breaks[after] - here) % n - 1, 0) // 2
    if a_arc or b_arc:
        here = _best_split(
            border, a, a_arc, b, b_arc, here,
            min(SMOOTH_SLIDE, slack_before), min(SMOOTH_SLIDE, slack_after),
        )  # fmt: skip
        # at most half-way to the next break, or two might change places
        slid = (here - breaks[e] + n // 2) % n - n // 2
        slack_before += slid
        slack_after -= slid
    x = border.x[here]
    y = border.y[here]
    if (a_arc or b_arc) and touch(a, a_arc, b, b_arc, found) and abs(found[2]) <= limits.tangent:
        where, distance = nearest_point(
            border, here, min(SMOOTH_SLIDE, slack_before), min(SMOOTH_SLIDE, slack_after),
            found[0], found[1],
        )  # fmt: skip
        if distance <= 1.0:
            joints[e, 0] = found[0]
            joints[e, 1] = found[1]
            return where
    if crossing(border, here, a, a_arc, b, b_arc, found):
        where, distance = nearest_point(
            border, here, min(SLIDE, slack_before), min(SLIDE, slack_after), found[0], found[1]
        )
        explained = 0.5 + (0.3 + limits.corner_blur) / max(found[2], 0.1)
        px, py, p, q = border.x, border.y, breaks[before], breaks[after]
        to_p = (px[p] - px[where]) ** 2 + (py[p] - py[where]) ** 2
        to_q = (px[q] - px[where]) ** 2 + (py[q] - py[where]) ** 2
        foreseen = FORESEEN * math.sqrt(min(to_p, to_q))
        if distance <= min(explained, max(foreseen, STRAY_PX)):
            joints[e, 0] = found[0]
            joints[e, 1] = found[1]
            return where
    ax, ay = onto(shape, before, a_arc, x, y)
    bx, by = onto(shape, e, b_arc, x, y)
    joints[e, 0] = 0.5 * (ax + bx)
    joints[e, 1] = 0.5 * (ay + by)
    if (joints[e, 0] - x) ** 2 + (joints[e, 1] - y) ** 2 > 1.0:
        joints[e, 0] = x
        joints[e, 1] = y
    return here

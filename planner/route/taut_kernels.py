"""From routes to polylines: taut, cut short, judged, on flat arrays.

Rules and units
- Every polyline and every cut is proved to keep its clearance exactly from all borders.
- If both ends of a line are nearer to a border than wished, the line may be as near as they are,
  but never nearer than needed.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import nearest, segment_clearance
from planner.borders.clear_kernels import blocker, keeps
from planner.diagram.bisector_kernels import follow
from planner.route.corridor_kernels import pull_taut
from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import NONE, grown, put_rows

UNEQUAL = 1e-2
"""Shortfall of corners by rounding, in parts of what is equal."""
FOLD = 0.25
"""A way that can go straight on never turns back within this part of what it needs."""


@njit(**OWNING)
def certain(tree, points, pairs, need, flatness, tolerance, rounding):
    """The route unchanged, so close to its bisectors that it keeps ``need``; else empty.

    A way through a bend just wide enough has corners outside its bisector. Where both borders bend
    alike it falls short by its chords' bulge: by ``rounding`` at most.
    """
    keep = need - 0.5 * rounding
    way, _ = follow(tree, points, pairs, keep, flatness, tolerance, need - UNEQUAL * tolerance)
    if keeps(tree, way, need - rounding):
        return way.copy()
    return np.empty((0, 2))


@njit(**OWNING)
def unfolded(tree, way, reach, tolerance):
    """The way (n, 2) without turns back by more than a right angle before or after ``reach``.

    A way may overshoot slightly where it enters or changes a chain. A turn stays if the line past
    it would be narrower.
    """
    out = np.empty((len(way), 2))
    m = 0
    for i in range(len(way)):
        x, y = way[i, 0], way[i, 1]
        while m >= 2:
            px, py, qx, qy = out[m - 2, 0], out[m - 2, 1], out[m - 1, 0], out[m - 1, 1]
            ux, uy, vx, vy = qx - px, qy - py, x - qx, y - qy
            short = min(ux * ux + uy * uy, vx * vx + vy * vy)
            if ux * vx + uy * vy >= 0.0 or short > reach * reach:
                break
            old, _, _ = segment_clearance(tree, px, py, qx, qy, np.inf)
            old, _, _ = segment_clearance(tree, qx, qy, x, y, old)
            _, _, which = segment_clearance(tree, px, py, x, y, old - tolerance)
            if which >= 0:
                break
            m -= 1
        out[m, 0], out[m, 1] = x, y
        m += 1
    return out[:m].copy()


@njit(**OWNING)
def finish(tree, line, pair, begin, wish, need, flatness, tolerance, rounding):
    """Kernel of :func:`planner.route.taut.finish`.

    Routes are ``line[begin[i] : begin[i + 1]]`` with their ``pair``. Taut ways keep ``wish`` where
    there is room; an infinite ``wish`` pulls none taut.
    """
    out = np.empty((256, 2))
    first = np.zeros(len(begin), np.int32)
    count = 0
    for i in range(len(begin) - 1):
        points, pairs = line[begin[i] : begin[i + 1]], pair[begin[i] : begin[i + 1]]
        way = np.empty((0, 2))
        if wish < np.inf:
            way = pull_taut(tree, points, pairs, wish, need, tolerance)
        if len(way) == 0:
            way = certain(tree, points, pairs, need, flatness, tolerance, rounding)
        if len(way) == 0:
            continue
        way = unfolded(tree, way, FOLD * need, tolerance)
        lo, hi = first[count], first[count] + len(way)
        if hi > len(out):
            out = grown(out, 2 * hi)
        put_rows(out, lo, way)
        count += 1
        first[count] = hi
    return out[: first[count]].copy(), first[: count + 1].copy()


@njit(**OWNING)
def cut_short(tree, way, need, wish, rounding):
    """The way (n, 2) with straight cuts, from its start and then from its end.

    From each point the line to the last one is tried, then to one half as far, and so on, for n
    points O(n log n) lines. A line keeps ``wish``, or its ends' clearance if smaller, but at least
    ``need``; all less ``rounding``.
    """
    xy = way.copy()
    rho = np.empty(len(way))
    for i in range(len(way)):
        rho[i], _ = nearest(tree, xy[i, 0], xy[i, 1], wish)
    n = len(way)
    guess = NONE
    for _ in range(2):
        here, m = 0, 1
        while here < n - 1:
            step = n - 1 - here
            while step > 1:
                there = here + step
                met = blocker(
                    tree, xy[here, 0], xy[here, 1], xy[there, 0], xy[there, 1],
                    max(need, min(rho[here], rho[there])) - rounding, guess,
                )  # fmt: skip
                if met < 0:
                    break
                guess = met
                step //= 2
            here += step
            xy[m, 0], xy[m, 1], rho[m] = xy[here, 0], xy[here, 1], rho[here]
            m += 1
        n = m
        for i in range(n // 2):  # reversed; two reversals restore the order
            j = n - 1 - i
            for c in range(2):
                xy[i, c], xy[j, c] = xy[j, c], xy[i, c]
            rho[i], rho[j] = rho[j], rho[i]
    return xy[:n].copy()


@njit(**BORROWING)
def judge(tree, way, need, weight, most):
    """Length of the way, each step times 1 + ``weight * need / clearance``, clearance >= need.

    Infinity, found early, if that is ``most`` or more.
    """
    total = 0.0
    for i in range(len(way) - 1):
        total += math.hypot(way[i + 1, 0] - way[i, 0], way[i + 1, 1] - way[i, 1])
    for i in range(len(way) - 1):
        if total >= most:
            return np.inf
        if weight <= 0.0:
            break
        ax, ay, bx, by = way[i, 0], way[i, 1], way[i + 1, 0], way[i + 1, 1]
        x, y = 0.5 * (ax + bx), 0.5 * (ay + by)
        rho, _ = nearest(tree, x, y, np.inf)
        total += math.hypot(bx - ax, by - ay) * weight * need / max(rho, need)
    return total if total < most else np.inf


@njit(**OWNING)
def best_cut(tree, ways, first, need, wish, weight, rounding):
    """The cheapest of the ways ``ways[first[i] : first[i + 1]]`` after cutting them short.

    A cut may change to another side of an obstacle, and never lengthens. The cheapest is also cut
    from its end, so that the cost does not depend on the direction.
    """
    best, least, which = ways[:0].copy(), np.inf, 0
    for i in range(len(first) - 1):
        way = cut_short(tree, ways[first[i] : first[i + 1]], need, wish, rounding)
        cost = judge(tree, way, need, weight, least)
        if cost < least:
            best, least, which = way, cost, i
    back = ways[first[which] : first[which + 1]][::-1].copy()
    way = cut_short(tree, back, need, wish, rounding)
    if judge(tree, way, need, weight, least) < least:
        best = way[::-1].copy()
    return best

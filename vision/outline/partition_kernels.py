"""Where a border breaks into edges: seeds, and the cheapest partition that breaks at some.

Rules and units
- ``px``, ``py`` as in ``vision.outline.fit.shape_kernels``: one border's n points, twice over.
- A partition's cost is the cost of its lines and arcs plus their ``prices`` (see
  ``vision.outline.fit.edge_prices``): a minimum description length, which the best partition
  minimises.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from vision.outline.fit.moment_kernels import FIRST, ROOM, circle_of, grow, line_of
from vision.outline.fit.separating_fit_kernels import separate_circle
from vision.outline.fit.shape_kernels import HUGE, circle_cost, line_cost

LINE, ARC = 0, 1
"""Where the prices of a line and of an arc stand."""
FAILED = 4.0
"""A stretch between two seeds that is no line costs as many."""
NEAR_MISS = 1.6
"""Share of the worst deviation up to which an arc is worth turning between the pixels."""
SPAN = 160
"""At most so many seeds in one stretch."""
CORNER = 1.2
"""Turn in radians from which a seed is surely a corner: a cap of 10 px radius turns by 0.6, and a
staircase turns sharply by itself."""
SNAP = 4
"""Points by which a seed moves to the middle of its corner."""
FAILURES = 3
"""A stretch that has failed so often with one end is not extended further."""
ANY, BENT, NOTHING = np.int64(0), np.int64(1), np.int64(2)
"""What a stretch may be: a line or an arc, an arc, neither."""
ROUNDING = 1e-9
"""A partition begun elsewhere may cost as much, but for the order of its sums."""
ROUND_SEEDS = 12
"""At most so many seeds on a border that is nearly a circle and no polygon: it turns evenly, and a
break beside an arc moves to its place when the edges are fitted."""
NO_LINE, NO_CIRCLE = 2.0, 3.0
"""In worst deviations: how far a seed may lie from the chord, or from the circle through both
ends and the middle, of a stretch that might be a line or an arc."""


@njit(cache=True, nogil=True)
def seed_breaks(px, py, n, tolerance, is_seed, away):
    """Mark generous breaks: split at the farthest point until chords lie within tolerance.

    The first point is one, which lies farthest out (see
    ``vision.outline.canonical_frame_kernels``); ``away`` (n,) is room to work in.
    """
    is_seed[:n] = False
    start = 0
    other, _ = _farthest(px, py, 0, n, away)
    is_seed[start] = True
    is_seed[other] = True
    stack = np.empty((128, 2), np.int64)
    stack[0, 0] = start
    stack[0, 1] = other
    stack[1, 0] = other
    stack[1, 1] = start + n
    top = 2
    while top > 0:
        top -= 1
        lo = stack[top, 0]
        hi = stack[top, 1]
        if hi - lo < 2:
            continue
        where, far = _farthest(px, py, lo, hi, away)
        if far <= tolerance:
            continue
        is_seed[where - n if where >= n else where] = True
        if top + 2 > stack.shape[0]:
            bigger = np.empty((2 * stack.shape[0], 2), np.int64)
            bigger[:top] = stack[:top]
            stack = bigger
        stack[top, 0] = lo
        stack[top, 1] = where
        stack[top + 1, 0] = where
        stack[top + 1, 1] = hi
        top += 2


@njit(**SUMS)
def _farthest(px, py, lo, hi, away):
    """The point between lo and hi farthest from their chord: ``(where, distance)``."""
    x0 = px[lo]
    y0 = py[lo]
    dx = px[hi] - x0
    dy = py[hi] - y0
    length = math.sqrt(dx * dx + dy * dy)
    xs = px[lo + 1 : hi]
    ys = py[lo + 1 : hi]
    far = 0.0
    if length < 1e-9:
        length = 1.0
        for k in range(hi - lo - 1):
            x = xs[k] - x0
            y = ys[k] - y0
            d = math.sqrt(x * x + y * y)
            away[k] = d
            far = max(far, d)
    else:
        for k in range(hi - lo - 1):
            d = abs((xs[k] - x0) * dy - (ys[k] - y0) * dx)
            away[k] = d
            far = max(far, d)
    where = 0
    while away[where] < far:
        where += 1
    return lo + 1 + where, far / length


@njit(**LEAF)
def _around(k, n):
    if k < 0:
        return k + n
    return k - n if k >= n else k


@njit(**LEAF)
def _bulge(px, py, n, k, reach):
    """How far point k lies from the chord of its neighbours ``reach`` points away."""
    p = _around(k - reach, n)
    q = _around(k + reach, n)
    dx = px[q] - px[p]
    dy = py[q] - py[p]
    length = math.sqrt(dx * dx + dy * dy)
    if length < 1e-9:
        return 0.0
    return abs((px[k] - px[p]) * dy - (py[k] - py[p]) * dx) / length


@njit(**LEAF)
def _snap_seeds(px, py, n, seeds, m, reach):
    """Move every seed to where the border bulges most nearby, short of half-way to the next.

    They stay ascending; one that passes the border's first point changes its place.
    """
    reach = min(reach, n // 4)
    if reach < 2:
        return
    first = seeds[0]
    before = seeds[m - 1] - n
    for s in range(m):
        here = seeds[s]
        after = seeds[s + 1] if s + 1 < m else first + n
        best = -1.0
        where = here
        for k in range(
            max(here - SNAP, (here + before) // 2 + 1), min(here + SNAP, (here + after) // 2) + 1
        ):
            bulge = _bulge(px, py, n, _around(k, n), reach)
            if bulge > best:
                best = bulge
                where = k
        before = here
        seeds[s] = where
    if seeds[0] < 0:
        here = seeds[0] + n
        for s in range(m - 1):
            seeds[s] = seeds[s + 1]
        seeds[m - 1] = here
    elif seeds[m - 1] >= n:
        here = seeds[m - 1] - n
        for s in range(m - 1, 0, -1):
            seeds[s] = seeds[s - 1]
        seeds[0] = here


@njit(**LEAF)
def _turn_at(px, py, n, k, reach):
    """How sharply the border turns at point k, in radians."""
    reach = min(reach, n // 4)
    p = _around(k - reach, n)
    q = _around(k + reach, n)
    ax = px[k] - px[p]
    ay = py[k] - py[p]
    bx = px[q] - px[k]
    by = py[q] - py[k]
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))


@njit(**LEAF)
def _trim(length, guard):
    """How many points to leave out at each end of a stretch."""
    if length >= 3 * guard + 4:
        return guard
    if length >= 6:
        return min(guard, (length - 3) // 3)
    return 0


@njit(**LEAF)
def _what_seeds_allow(px, py, a, b, position, i, j, shift, worst):
    """What points a .. b may be, by the seeds i + 1 .. j - 1 alone: ANY, BENT or NOTHING."""
    x0 = px[a]
    y0 = py[a]
    dx = px[b] - x0
    dy = py[b] - y0
    chord = math.sqrt(dx * dx + dy * dy)
    far = 0.0
    for s in range(i + 1, j):
        k = position[s] - shift
        if a < k < b:
            far = max(far, abs((px[k] - x0) * dy - (py[k] - y0) * dx))
    if far <= NO_LINE * worst * chord:
        return ANY
    # the circle through both ends and the middle
    c = (a + b) // 2
    cx = px[c] - x0
    cy = py[c] - y0
    det = 2.0 * (cx * dy - cy * dx)
    if abs(det) < 1e-9:
        return BENT
    cc = cx * cx + cy * cy
    dd = dx * dx + dy * dy
    mx = (dy * cc - cy * dd) / det
    my = (cx * dd - dx * cc) / det
    r = math.sqrt(mx * mx + my * my)
    if chord < r:
        # too little is known of a circle from points so near to each other
        return BENT
    for s in range(i, j):
        # the seeds, and half-way between them
        k = (position[s] + position[s + 1]) // 2 - shift
        if a < k < b:
            d = math.sqrt((px[k] - x0 - mx) ** 2 + (py[k] - y0 - my) ** 2) - r
            if abs(d) > NO_CIRCLE * worst:
                return NOTHING
        k = position[s] - shift
        if a < k < b:
            d = math.sqrt((px[k] - x0 - mx) ** 2 + (py[k] - y0 - my) ** 2) - r
            if abs(d) > NO_CIRCLE * worst:
                return NOTHING
    return BENT


@njit(**LEAF)
def _stretch(
    px, py, a, b, may_be, crisp, dead_zone, sigma, worst, bound, prices, sums, line, circle, active
):
    """The cheaper of a line and an arc through points a .. b - 1: (cost, is_arc).

    ``sums`` are those of the search's last stretch (see ``vision.outline.fit.moment_kernels``).
    """
    grow(px, py, a, b, sums)
    straight = HUGE
    if may_be == ANY:
        line_of(px, py, sums, line)
        straight = prices[LINE] + line_cost(
            px, py, a, b, line, crisp, dead_zone, sigma, worst, bound - prices[LINE]
        )
    if b - a < 6 or straight < prices[ARC] or bound <= prices[ARC]:
        return straight, False
    bent = HUGE
    if circle_of(px, py, sums, circle):
        bound -= prices[ARC]
        for again in range(2):
            limit = NEAR_MISS * worst if crisp and again == 0 else worst
            bent = prices[ARC] + circle_cost(
                px, py, a, b, circle, crisp, dead_zone, sigma, limit,
                HUGE if crisp and again == 0 else bound,
            )  # fmt: skip
            if not crisp or again == 1 or not prices[ARC] < bent < HUGE:
                break
            # the staircase alone may have turned the fit: let it pass between the pixels
            separate_circle(px, py, a, b, circle, active)
    if bent < straight:
        return bent, True
    return straight, False


@njit(**LEAF)
def _longest_line(n, radius, worst, guard):
    """The most points that one line may span, with what is left out at its ends.

    On a circle that no point leaves by more than ``worst`` its chord rises by less than four
    times that; there is a point a pixel at most.
    """
    rise = 4.0 * worst
    if radius <= rise:
        return n
    return min(n, 2.0 * math.sqrt((2.0 * radius - rise) * rise) + 2.0 * guard + 2.0)


@njit(**LEAF)
def _least_rest(m, position, longest, prices, rest):
    """What the edges from every seed on cost at least, into ``rest`` (m + 1,).

    No line has more than ``longest`` points.
    """
    rest[m] = 0.0
    for i in range(m):
        lines = math.ceil((position[m] - position[i]) / longest)
        rest[i] = min(prices[ARC], prices[LINE] * lines)


@njit(cache=True, nogil=True)
def best_partition(
    px, py, n, seeds, m, start, guard, crisp, dead_zone, sigma, worst, limit, longest, prices,
    breaks, is_arc, active,
):  # fmt: skip
    """The cheapest partition of a closed border into lines and arcs that break at seeds.

    ``seeds`` holds m ascending indices; the first break is seed number ``start``. Fills
    ``breaks`` (in order along the border, starting there) and ``is_arc``; returns the number
    of edges and the cost: none, and the limit, where all partitions cost that much.
    Dynamic programming; stretches that fail are not extended far, and what is left of the border
    costs at least a line or an arc: what leads beyond ``limit`` with that is not followed up.
    """
    best = np.empty(m + 1, np.float64)
    rest = np.empty(m + 1, np.float64)
    came = np.full(m + 1, -1, np.int64)
    arc = np.zeros(m + 1, np.bool_)
    line = np.empty(4, np.float64)
    circle = np.empty(3, np.float64)
    sums = np.zeros(ROOM, np.float64)
    position = np.empty(m + 1, np.int64)
    for t in range(m + 1):
        s = start + t
        position[t] = seeds[s] if s < m else seeds[s - m] + n
    _least_rest(m, position, longest, prices, rest)
    for t in range(m + 1):
        best[t] = limit - rest[t]
    best[0] = 0.0
    came[0] = 0
    for i in range(m):
        if came[i] < 0 or best[i] + rest[i] >= best[m]:
            continue
        failed = 0
        sums[FIRST] = -1.0
        shift = n if position[i] >= n else 0
        for j in range(i + 1, min(m, i + SPAN) + 1):
            if i == 0 and j == m:
                break
            bound = min(best[j], best[m] - rest[j]) - best[i]
            if bound <= prices[LINE]:
                continue
            lo = position[i] - shift
            hi = position[j] - shift
            trim = _trim(hi - lo, guard)
            a = lo + trim
            b = hi - trim
            cost = HUGE
            bent = False
            may_be = ANY
            most = HUGE
            if j > i + 1:
                may_be = _what_seeds_allow(px, py, a, b, position, i, j, shift, worst)
                most = bound
            if may_be == BENT and bound <= prices[ARC]:
                continue
            if may_be != NOTHING:
                cost, bent = _stretch(
                    px, py, a, b + 1, may_be, crisp, dead_zone, sigma, worst, most, prices, sums,
                    line, circle, active,
                )  # fmt: skip
            if cost >= HUGE:
                if j == i + 1:
                    cost = FAILED * prices[LINE]
                    bent = False
                else:
                    failed += 1
                    if failed >= FAILURES:
                        break
                    continue
            if cost < bound:
                best[j] = best[i] + cost
                came[j] = i
                arc[j] = bent
    if came[m] < 0:
        return 0, limit
    edges = 0
    j = m
    while j > 0:
        edges += 1
        j = came[j]
    j = m
    e = edges
    while j > 0:
        e -= 1
        is_arc[e] = arc[j]
        j = came[j]
        breaks[e] = position[j] - n if position[j] >= n else position[j]
    return edges, best[m]


@njit(cache=True, nogil=True)
def partition(
    px, py, n, skip, crisp, dead_zone, sigma, worst, tolerance, limit, radius,
    prices, is_seed, seeds, breaks, is_arc, active,
):  # fmt: skip
    """Seeds, then the cheapest partition that breaks at some of them: (edges, cost).

    None is looked for that costs ``limit`` or more: no edges then. Where that is the cost of a
    circle, ``radius`` is the circle's, and otherwise 0.
    """
    longest = _longest_line(n, radius, worst, skip)
    seed_breaks(px, py, n, tolerance, is_seed, active[0])
    m = 0
    for k in range(n):
        if is_seed[k]:
            seeds[m] = k
            m += 1
    chord = _longest_line(n, radius, 0.5 * worst, 0)
    if radius > 0.0 and m > ROUND_SEEDS and prices[LINE] * n >= limit * chord:
        # no polygon is cheaper than the circle: what is left are arcs
        for t in range(ROUND_SEEDS):
            seeds[t] = seeds[t * m // ROUND_SEEDS]
        m = ROUND_SEEDS
    _snap_seeds(px, py, n, seeds, m, skip + 4)
    sharpest = -1.0
    start = 0
    for t in range(m):
        turn = _turn_at(px, py, n, seeds[t], 6)
        if turn > sharpest:
            sharpest = turn
            start = t
    edges = 0
    cost = limit
    for _ in range(2):
        found, least = best_partition(
            px, py, n, seeds, m, start, skip, crisp, dead_zone, sigma, worst,
            min(cost * (1.0 + ROUNDING), limit), longest, prices, breaks, is_arc, active,
        )  # fmt: skip
        if found == 0:
            break
        edges = found
        cost = least
        if sharpest >= CORNER or edges < 2:
            break
        # no corner to begin at: begin again at a break that the search found
        sharpest = CORNER
        again = breaks[edges // 2]
        for t in range(m):
            if seeds[t] == again:
                start = t
    return edges, cost

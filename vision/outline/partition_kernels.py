"""The cheapest partition of a border into edges that break at some of its seeds.

Rules and units
- Types: ``vision.outline.outline_types``.
- A partition costs the sum of its edges' costs and ``prices`` (see
  ``vision.outline.fit.edge_prices``): a description length.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.corners.crossing_kernels import DIRECTION_POINTS
from vision.outline.fit.edge_shape_kernels import (
    FIT_ASTRAY,
    HUGE,
    circle_cost,
    circle_of_three,
    line_cost,
)
from vision.outline.fit.moment_kernels import FIRST, circle_of, grow, line_of
from vision.outline.fit.separating_fit_kernels import separate_circle
from vision.outline.outline_types import Search, StretchFit
from vision.outline.seed_kernels import seed_breaks, snap_seeds, turn_at
from vision.shared.typed_numbers import ZERO

FAILED = 4.0
"""Cost of a stretch between seeds that is no line, in lines: chosen."""
NEAR_MISS = 1.6
"""Share of the worst deviation up to which an arc is turned between the pixels: chosen."""
SPAN = 160
"""Most seeds in one stretch: indifferent, a bound on the work."""
SURE_CORNER_RAD = 1.2
"""Turn in radians from which a seed is surely a corner: chosen, a cap of 10 px radius turns by
0.6."""
FAILURES = 3
"""Failures of stretches from one end after which none is extended: chosen, to spare work."""
ANY, ARC_ONLY, NO_SHAPE = np.int64(0), np.int64(1), np.int64(2)
"""Possible shapes of a stretch: defined, a line or an arc, an arc, neither."""
COST_ROUNDING = 1e-9
"""Rounding of costs by the order of sums: indifferent."""
ROUND_SEEDS = 12
"""Most seeds on a border that is nearly a circle and no polygon: indifferent, to spare work, as
breaks beside arcs move when edges are fitted."""


@njit(**LEAF)
def partition(border, outline, skip, costs, tolerance, prices, limit, radius, scratch):
    """Find seeds, then the cheapest partition at some of them: (edges, cost).

    ``tolerance``: largest distance of the chords between seeds from the border; ``skip``: points
    left out at the ends of a stretch. No edges if all cost ``limit`` or more; ``radius`` is the
    circle's if that is its cost, otherwise 0.
    """
    n = border.n
    longest = _longest_line(n, radius, costs.worst, skip)
    is_seed = scratch.flags[0]
    seeds = scratch.indices[0]
    seed_breaks(border, tolerance, is_seed, scratch.numbers[0], scratch.pairs)
    m = 0
    for k in range(n):
        if is_seed[k]:
            seeds[m] = k
            m += 1
    chord = _longest_line(n, radius, 0.5 * costs.worst, ZERO)
    if radius > 0.0 and m > ROUND_SEEDS and prices.line * n >= limit * chord:
        # no polygon is cheaper than the circle: only arcs remain
        for t in range(ROUND_SEEDS):
            seeds[t] = seeds[t * m // ROUND_SEEDS]
        m = ROUND_SEEDS
    seeds = seeds[:m]
    snap_seeds(border, seeds, skip + 4)
    sharpest = -1.0
    start = ZERO
    for t in range(m):
        turn = turn_at(border, seeds[t], DIRECTION_POINTS)
        if turn > sharpest:
            sharpest = turn
            start = t
    edges = 0
    cost = limit
    for _ in range(2):
        found, least = _best_partition(
            border, outline, seeds, start, skip, costs, prices,
            min(cost * (1.0 + COST_ROUNDING), limit), longest, scratch,
        )  # fmt: skip
        if found == 0:
            break
        edges = found
        cost = least
        if sharpest >= SURE_CORNER_RAD or edges < 2:
            break
        # no corner to begin at: repeat from a found break
        sharpest = SURE_CORNER_RAD
        again = outline.breaks[edges // 2]
        for t in range(m):
            if seeds[t] == again:
                start = t
    return edges, cost


@njit(**LEAF)
def _best_partition(border, outline, seeds, start, skip, costs, prices, limit, longest, scratch):
    """The cheapest partition of a closed border into lines and arcs that break at seeds.

    Fills the outline's ``breaks`` (in order, from seed number ``start``) and ``is_arc``; returns
    the number of edges and the cost: no edges, and the limit, if all partitions cost that much.

    Dynamic programming. The rest of the border costs at least a line or an arc; a path that exceeds
    ``limit`` with it is dropped.
    """
    m = seeds.shape[0]
    indices = scratch.indices
    numbers = scratch.numbers
    search = Search(indices[1], numbers[2], numbers[3], indices[2], scratch.flags[1])
    fit = StretchFit(numbers[4], numbers[5], numbers[6], numbers[0:2])
    for t in range(m + 1):
        search.came[t] = -1
    for t in range(m + 1):
        s = start + t
        search.position[t] = seeds[s] if s < m else seeds[s - m] + border.n
    search.rest[m] = 0.0
    for t in range(m):
        lines = math.ceil((search.position[m] - search.position[t]) / longest)
        search.rest[t] = min(prices.arc, prices.line * lines)
    for t in range(m + 1):
        search.best[t] = limit - search.rest[t]
    search.best[0] = 0.0
    search.came[0] = 0
    for i in range(m):
        if search.came[i] >= 0 and search.best[i] + search.rest[i] < search.best[m]:
            _extend(border, search, m, i, skip, costs, prices, fit)
    if search.came[m] < 0:
        return 0, limit
    return _write_partition(border.n, search, m, outline), search.best[m]


@njit(**LEAF)
def _extend(border, search, m, i, skip, costs, prices, fit):
    position = search.position
    best = search.best
    failed = 0
    fit.sums[FIRST] = -1.0
    shift = border.n if position[i] >= border.n else 0
    for j in range(i + 1, min(m, i + SPAN) + 1):
        if i == 0 and j == m:
            break
        bound = min(best[j], best[m] - search.rest[j]) - best[i]
        if bound <= prices.line:
            continue
        lo = position[i] - shift
        hi = position[j] - shift
        # a short stretch keeps its middle
        trim = skip if hi - lo >= 3 * skip + 4 else max((hi - lo - 3) // 3, 0)
        a = lo + trim
        b = hi - trim
        may_be = ANY
        most = HUGE
        if j > i + 1:
            may_be = _what_seeds_allow(border, a, b, position, i, j, shift, costs.worst)
            most = bound
        if may_be == ARC_ONLY and bound <= prices.arc:
            continue
        cost = HUGE
        bent = False
        if may_be != NO_SHAPE:
            cost, bent = _stretch(border, a, b + 1, may_be, costs, most, prices, fit)
        if cost >= HUGE and j > i + 1:
            failed += 1
            if failed >= FAILURES:
                break
            continue
        if cost >= HUGE:
            cost = FAILED * prices.line
            bent = False
        if cost < bound:
            best[j] = best[i] + cost
            search.came[j] = i
            search.arc[j] = bent


@njit(**LEAF)
def _write_partition(n, search, m, outline):
    edges = 0
    j = m
    while j > 0:
        edges += 1
        j = search.came[j]
    j = m
    e = edges
    while j > 0:
        e -= 1
        outline.is_arc[e] = search.arc[j]
        j = search.came[j]
        first = search.position[j]
        outline.breaks[e] = first - n if first >= n else first
    return edges


@njit(**LEAF)
def _longest_line(n, radius, worst, guard):
    """The most points that one line may span, with those left out at its ends.

    On a circle that no point leaves by more than ``worst``, its chord rises by less than four times
    that; there is at most one point a pixel.
    """
    rise = 4.0 * worst
    if radius <= rise:
        return n
    return min(n, 2.0 * math.sqrt((2.0 * radius - rise) * rise) + 2.0 * guard + 2.0)


@njit(**LEAF)
def _what_seeds_allow(border, a, b, position, i, j, shift, worst):
    """Shapes possible for points a .. b by the seeds between: ANY, ARC_ONLY or NO_SHAPE."""
    px, py = border.x, border.y
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
    if far <= FIT_ASTRAY * worst * chord:
        return ANY
    c = (a + b) // 2
    mx, my, r = circle_of_three(px[c] - x0, py[c] - y0, dx, dy)
    if chord < r:
        return ARC_ONLY
    for s in range(i, j):
        # the seeds, and half-way between them
        k = (position[s] + position[s + 1]) // 2 - shift
        if a < k < b:
            d = math.sqrt((px[k] - x0 - mx) ** 2 + (py[k] - y0 - my) ** 2) - r
            if abs(d) > FIT_ASTRAY * worst:
                return NO_SHAPE
        k = position[s] - shift
        if a < k < b:
            d = math.sqrt((px[k] - x0 - mx) ** 2 + (py[k] - y0 - my) ** 2) - r
            if abs(d) > FIT_ASTRAY * worst:
                return NO_SHAPE
    return ARC_ONLY


@njit(**LEAF)
def _stretch(border, a, b, may_be, costs, bound, prices, fit):
    """Cheaper of a line and an arc through points a .. b - 1: (cost, is_arc)."""
    px, py = border.x, border.y
    crisp = costs.crisp
    dead_zone, sigma, worst = costs.dead_zone, costs.sigma, costs.worst
    circle = fit.circle
    grow(px, py, a, b, fit.sums)
    straight = HUGE
    if may_be == ANY:
        line_of(px, py, fit.sums, fit.line)
        straight = prices.line + line_cost(
            px, py, a, b, fit.line, crisp, dead_zone, sigma, worst, bound - prices.line
        )
    if b - a < 6 or straight < prices.arc or bound <= prices.arc:
        return straight, False
    bent = HUGE
    if circle_of(px, py, fit.sums, circle):
        bound -= prices.arc
        for again in range(2):
            limit = NEAR_MISS * worst if crisp and again == 0 else worst
            bent = prices.arc + circle_cost(
                px, py, a, b, circle, crisp, dead_zone, sigma, limit,
                HUGE if crisp and again == 0 else bound,
            )  # fmt: skip
            if not crisp or again == 1 or not prices.arc < bent < HUGE:
                break
            # the staircase may have turned the fit: let it pass between the pixels
            separate_circle(px, py, a, b, circle, fit.near)
    if bent < straight:
        return bent, True
    return straight, False

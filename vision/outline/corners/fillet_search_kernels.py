"""Where fillets describe a border more cheaply than sharp corners do, and where they go.

Rules and units
- ``border``, ``outline``, ``costs``, ``prices`` and ``gains``: see
  ``vision.outline.outline_types``; pictures with grey only.
- A search that leaves out what lies near a joint sees nothing of a small arc, whose chords are
  all joints. Here every point counts: near a joint its deviation is measured from the border as
  blur rounds it there.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.corners.blurred_corner_kernels import TURN, find_corners, sum_costs
from vision.outline.corners.fillet_kernels import (
    ANCHOR_FROM,
    ANCHOR_TO,
    MOST_TURN,
    PIXEL_BLUR_PX,
    fillet_cost,
    half_variance,
    set_corner,
    solve_radius,
    try_fillet,
)
from vision.outline.fit.outline_kernels import edge_end
from vision.outline.fit.shape_kernels import HUGE, circle_rms
from vision.outline.outline_types import Fillet, Gains

LONGEST_RUN = 6
"""Edges that one fillet may replace."""
COUNTER_TURN = math.radians(3.0)
"""Edges that turn back by more are no chords of one arc."""
FLAT = 0.25
"""An arc that turns by less (radians) may be a line that took some of the arcs at its ends."""
FILLET = 1.5
"""A fillet's price in lines: it has one free number, a line and its break have two. Rather more,
so that of two that are as good the straight one stays."""
ROUNDS = 3
"""Times that a border is searched: lines are known better with their ends rounded."""
NO_GAIN = 0.0


@njit(**LEAF)
def insert_fillets(border, outline, edges, blur, costs, prices, room):
    """Put fillets where they describe a border more cheaply; returns their number.

    ``breaks``, ``is_arc`` and ``is_fillet`` are changed; whether they are is the other answer.
    """
    if edges < 3:
        return edges, False
    inwards = half_variance(blur)
    blur = math.sqrt(blur * blur + PIXEL_BLUR_PX * PIXEL_BLUR_PX)
    indices = room.indices
    gains = Gains(room.numbers[3], indices[0], indices[1], indices[2])
    if not _find_fillets(border, outline, edges, blur, inwards, costs, prices, gains, room):
        return edges, False
    return _place_fillets(border.n, outline, edges, gains, room), True


@njit(**LEAF)
def _is_flat(border, outline, lo, hi, e):
    """Whether edge e, of points lo .. hi, may be one of the lines beside a fillet."""
    if not outline.is_arc[e]:
        return True
    px = border.x
    py = border.y
    return math.sqrt((px[hi] - px[lo]) ** 2 + (py[hi] - py[lo]) ** 2) < FLAT * outline.shape[e, 2]


@njit(**LEAF)
def _find_fillets(border, outline, edges, blur, inwards, costs, prices, gains, room):
    """Find the best fillet that begins at each line: whether any saves something."""
    numbers = room.numbers
    corners = room.table
    sums = numbers[2]
    fillet = Fillet(numbers[4], numbers[5], numbers[6], room.indices[3])
    find_corners(border, outline, edges, corners)
    sum_costs(border, outline, edges, corners, blur, costs, sums)
    n = border.n
    breaks = outline.breaks
    is_arc = outline.is_arc
    any_gain = False
    for e in range(edges):
        gains.saved[e] = NO_GAIN
    for i in range(edges):
        a_lo = breaks[i]
        a_hi = edge_end(breaks, edges, n, i)
        if not _is_flat(border, outline, a_lo, a_hi, i):
            continue
        b_lo = a_hi
        saved = 0.0
        turned = 0.0
        price = FILLET * prices.line
        for run in range(min(LONGEST_RUN, edges - 2) + 1):
            j = (i + run + 1) % edges
            turn = corners[j, TURN]
            if turn * turned < 0.0 and abs(turn) > COUNTER_TURN:
                break
            turned += turn
            if abs(turned) > MOST_TURN:
                break
            length = edge_end(breaks, edges, n, j) - breaks[j]
            b_hi = b_lo + length
            if _is_flat(border, outline, b_lo, b_hi, j):
                lo = a_lo + int((a_hi - a_lo) * ANCHOR_FROM)
                hi = b_lo + int(length * ANCHOR_TO)
                now = sums[hi] - sums[lo]
                if now + saved > price:
                    cost = try_fillet(border, a_lo, a_hi, b_lo, b_hi, blur, inwards, costs, fillet)
                    gain = now + saved - price - cost
                    if gain > gains.saved[i]:
                        gains.saved[i] = gain
                        gains.run[i] = run
                        gains.first[i] = fillet.found[2]
                        gains.behind[i] = fillet.found[3] + 1
                        any_gain = True
            saved += prices.arc if is_arc[j] else prices.line
            b_lo = b_hi
    return any_gain


@njit(**LEAF)
def _place_fillets(n, outline, edges, gains, room):
    """Replace runs of edges by fillets, those that save most first; returns the new number.

    Edges that are ``gone``, lines beside a fillet that is chosen, an ``anchor``, and those that one
    follows, ``used``; where an edge ``begins`` behind a fillet, or -1.
    """
    saved = gains.saved
    runs = gains.run
    gone = room.flags[0]
    anchor = room.flags[1]
    used = room.flags[2]
    begins = room.indices[3]
    for e in range(edges):
        gone[e] = False
        anchor[e] = False
        begins[e] = -1
        used[e] = False
    while True:
        i = 0
        for e in range(1, edges):
            if saved[e] > saved[i]:
                i = e
        if saved[i] <= NO_GAIN:
            break
        saved[i] = NO_GAIN
        j = (i + runs[i] + 1) % edges
        free = not (gone[i] or gone[j])
        for t in range(1, runs[i] + 1):
            e = (i + t) % edges
            free = free and not gone[e] and not anchor[e]
        first = gains.first[i]
        last = gains.behind[i]
        # what is left of each line lies between the arcs at its ends
        if begins[i] >= 0:
            free = free and (first - begins[i]) % n < n // 2 and (first - begins[i]) % n >= 3
        if used[j]:
            ahead = (gains.first[j] - last) % n
            free = free and ahead < n // 2 and ahead >= 3
        if not free:
            continue
        used[i] = True
        anchor[i] = True
        anchor[j] = True
        begins[j] = last % n
        for t in range(1, runs[i] + 1):
            gone[(i + t) % edges] = True
    return _with_fillets(n, outline, edges, gains, room)


@njit(**LEAF)
def _with_fillets(n, outline, edges, gains, room):
    """Write the edges that are not gone, and the arc behind each that is used: the new number."""
    gone = room.flags[0]
    used = room.flags[2]
    begins = room.indices[3]
    # every edge adds at most one
    new_breaks = room.indices[4]
    bent = room.flags[3]
    fillet = room.flags[4]
    m = 0
    for e in range(edges):
        if not gone[e]:
            new_breaks[m] = begins[e] if begins[e] >= 0 else outline.breaks[e]
            bent[m] = outline.is_arc[e]
            fillet[m] = outline.is_fillet[e]
            m += 1
        if used[e]:
            new_breaks[m] = gains.first[e] % n
            bent[m] = True
            fillet[m] = True
            m += 1
    for e in range(m):
        outline.breaks[e] = new_breaks[e]
        outline.is_arc[e] = bent[e]
        outline.is_fillet[e] = fillet[e]
    return m


@njit(**LEAF)
def touch_lines(border, outline, edges, blur, costs, corner):
    """Let fillets touch the lines beside them, as these have been fitted since.

    ``corner`` (7,) is room to work in.
    """
    n = border.n
    breaks = outline.breaks
    is_arc = outline.is_arc
    shape = outline.shape
    joints = outline.joints
    inwards = half_variance(blur)
    for e in range(edges):
        before = predecessor(e, edges)
        after = successor(e, edges)
        if not outline.is_fillet[e] or not is_arc[e] or is_arc[before] or is_arc[after]:
            continue
        a = shape[before]
        b = shape[after]
        if not set_corner(a, b, corner):
            continue
        lo = breaks[before]
        hi = lo
        for t in range(3):
            hi += (breaks[(before + t + 1) % edges] - breaks[(before + t) % edges]) % n
        begin = lo + (breaks[e] - lo) % n
        end = lo + (breaks[after] - lo) % n
        lo = (lo + begin) // 2
        hi = (hi + end) // 2
        radius = solve_radius(border, lo, hi, a, b, corner, shape[e, 2], inwards)
        cost, first, last = fillet_cost(
            border, lo, hi, a, b, corner, radius, inwards, costs, costs.worst
        )
        if cost >= HUGE or last - first < 3:
            continue
        reach = radius * corner[5]
        shape[e, 0] = corner[0] + radius / corner[4] * corner[2]
        shape[e, 1] = corner[1] + radius / corner[4] * corner[3]
        shape[e, 2] = radius
        shape[e, 4] = circle_rms(border.x, border.y, first, last + 1, shape[e])
        joints[e, 0] = corner[0] - reach * a[2]
        joints[e, 1] = corner[1] - reach * a[3]
        joints[after, 0] = corner[0] + reach * b[2]
        joints[after, 1] = corner[1] + reach * b[3]
        breaks[e] = first % n
        breaks[after] = (last + 1) % n

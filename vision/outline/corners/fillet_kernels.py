"""Rounded corners: an arc that touches both neighbouring lines, where sharp corners do not fit.

Rules and units
- ``px``, ``py`` as in ``vision.outline.fit.shape_kernels``: one border's n points, twice over;
  ``breaks``, ``shape`` and ``joints`` as in ``vision.outline.corners.joint_kernels``; pictures with
  grey only.
- A search that leaves out what lies near a joint sees nothing of a small arc, whose chords are
  all joints. Here every point counts: near a joint its deviation is measured from the border as
  blur rounds it there.
- A fillet has one free number, its radius: both lines are known.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.corners.blurred_corner_kernels import CORNER_ROOM, TURN, find_corners, sum_costs
from vision.outline.corners.joint_kernels import edge_end
from vision.outline.fit.shape_kernels import circle_rms, fit_line

LONGEST_RUN = 6
"""Edges that one fillet may replace."""
LEAST_TURN, MOST_TURN = math.radians(15.0), math.radians(150.0)
"""Between which angles the lines of a rounded corner turn."""
PIXEL_BLUR_PX = 0.2887
"""The spread (sigma) of a pixel's own width: 1 / sqrt(12)."""
ROUNDED_PX, ROUNDED_BY = 1.5, 2.5
"""A fillet's tangents are at least so long, and so many times the blur: blur rounds a sharp corner
as an arc would whose tangents are 1.6 .. 1.9 times the blur's sigma."""
COUNTER_TURN = math.radians(3.0)
"""Edges that turn back by more are no chords of one arc."""
ANCHOR_FROM, ANCHOR_TO = 0.3, 0.7
"""The part of a line that surely is none of the arcs at its ends."""
FLAT = 0.25
"""An arc that turns by less (radians) may be a line that took some of the arcs at its ends."""
FILLET = 1.5
"""A fillet's price in lines: it has one free number, a line and its break have two. Rather more,
so that of two that are as good the straight one stays."""
LOOKS, ASTRAY = 6, 2.0
"""Points of a run that tell at once whether it is round, in worst deviations before the fit."""
ROUNDS = 3
"""Times that a border is searched: lines are known better with their ends rounded."""
INWARDS, MORE_INWARDS = 0.25, 0.1
"""Blur moves a round border inwards, by half its variance over the radius. That little tells much
of an arc that has to touch two lines: its radius moves four times as far where they turn by 90
degrees. Half the variance from the one that is read off profiles along rows and columns, which
meet a border aslant and end before a wide blur does, and from its square (measured: right to a
twelfth for discs at blurs of 0.5 .. 2)."""
STEPS, REFITS = 8, 3
"""Steps of Gauss-Newton for a radius; times that the lines beside a fillet are fitted again."""
NO_GAIN = 0.0


@njit(**LEAF)
def set_corner(a, b, corner):
    """The corner of two lines, into ``corner`` (7,): False where they are too nearly parallel.

    x, y of the crossing, unit vector to the centres of all fillets, sine and tangent of half the
    inner angle, and the turn's sign.
    """
    cross = a[2] * b[3] - a[3] * b[2]
    dot = a[2] * b[2] + a[3] * b[3]
    turn = math.atan2(abs(cross), dot)
    if not LEAST_TURN <= turn <= MOST_TURN:
        return False
    t = ((b[0] - a[0]) * b[3] - (b[1] - a[1]) * b[2]) / cross
    corner[0] = a[0] + t * a[2]
    corner[1] = a[1] + t * a[3]
    ux = b[2] - a[2]
    uy = b[3] - a[3]
    length = math.sqrt(ux * ux + uy * uy)
    corner[2] = ux / length
    corner[3] = uy / length
    corner[4] = math.cos(0.5 * turn)
    corner[5] = math.tan(0.5 * turn)
    corner[6] = 1.0 if cross > 0.0 else -1.0
    return True


@njit(**LEAF)
def _half_variance(blur):
    """Half the variance of the blur whose sigma reads ``blur``, in square pixels."""
    square = blur * blur
    return square * (INWARDS + MORE_INWARDS * square)


@njit(**LEAF)
def solve_radius(px, py, lo, hi, a, b, corner, radius, inwards):
    """The radius of the fillet nearest to points lo .. hi - 1: Gauss-Newton from ``radius``.

    ``inwards``: by how much blur moves its border, times the radius.
    """
    share = 1.0 / corner[4]
    for _ in range(STEPS):
        cx = corner[0] + radius * share * corner[2]
        cy = corner[1] + radius * share * corner[3]
        reach = radius * corner[5]
        num = 0.0
        den = 0.0
        for k in range(lo, hi):
            dx = px[k] - corner[0]
            dy = py[k] - corner[1]
            if dx * a[2] + dy * a[3] < -reach or dx * b[2] + dy * b[3] > reach:
                continue
            vx = px[k] - cx
            vy = py[k] - cy
            far = math.sqrt(vx * vx + vy * vy) + 1e-30
            slope = -share * (vx * corner[2] + vy * corner[3]) / far - 1.0
            num += slope * (far - radius + inwards / radius)
            den += slope * slope
        if den < 1e-9:
            return radius
        step = -num / den
        new = min(max(radius + step, 0.5 * radius), 2.0 * radius)
        moved = abs(new - radius)
        radius = new
        if moved < 1e-4:
            break
    return radius


@njit(**LEAF)
def _cut(px, py, lo, hi, corner):
    """How far the border cuts the corner: from the crossing to the border along the bisector."""
    best = 1e18
    cut = 0.0
    for k in range(lo, hi):
        dx = px[k] - corner[0]
        dy = py[k] - corner[1]
        off = abs(dx * corner[3] - dy * corner[2])
        if off < best:
            best = off
            cut = dx * corner[2] + dy * corner[3]
    return cut


@njit(**LEAF)
def _is_round(px, py, lo, hi, corner, radius, worst):
    """Whether some of the points lo .. hi lie near a fillet: most polygons are told by these."""
    cx = corner[0] + radius / corner[4] * corner[2]
    cy = corner[1] + radius / corner[4] * corner[3]
    for t in range(LOOKS + 1):
        k = lo + (hi - lo) * t // LOOKS
        if abs(math.sqrt((px[k] - cx) ** 2 + (py[k] - cy) ** 2) - radius) > worst:
            return False
    return True


@njit(**LEAF)
def _fillet_cost(px, py, lo, hi, a, b, corner, radius, inwards, dead_zone, sigma, worst, expected):
    """The cost of points lo .. hi - 1 beside line, fillet and line: (cost, first, last on arc)."""
    cx = corner[0] + radius / corner[4] * corner[2]
    cy = corner[1] + radius / corner[4] * corner[3]
    reach = radius * corner[5]
    cost = 0.0
    first = hi
    last = lo
    for k in range(lo, hi):
        dx = px[k] - corner[0]
        dy = py[k] - corner[1]
        if dx * a[2] + dy * a[3] < -reach:
            d = abs(dx * a[3] - dy * a[2])
        elif dx * b[2] + dy * b[3] > reach:
            d = abs(dx * b[3] - dy * b[2])
        else:
            d = abs(math.sqrt((px[k] - cx) ** 2 + (py[k] - cy) ** 2) - radius + inwards / radius)
            first = min(first, k)
            last = max(last, k)
        if d > worst:
            return 1e18, first, last
        over = max(d - dead_zone, 0.0) / sigma
        cost += over * over - expected
    return cost, first, last


@njit(**LEAF)
def _try_fillet(
    px, py, a_lo, a_hi, b_lo, b_hi, blur, inwards, dead_zone, sigma, worst, expected, a, b, corner,
    found,
):  # fmt: skip
    """The fillet between the lines of points a_lo .. a_hi and b_lo .. b_hi: its cost, or 1e18.

    ``found``: the first and the last of the points compared, the first and the last on the arc.
    """
    lo = a_lo + int((a_hi - a_lo) * ANCHOR_FROM)
    hi = b_lo + int((b_hi - b_lo) * ANCHOR_TO)
    a_to = a_lo + int((a_hi - a_lo) * ANCHOR_TO)
    b_from = b_lo + int((b_hi - b_lo) * ANCHOR_FROM)
    if a_to - lo < 3 or hi - b_from < 3:
        return 1e18
    fit_line(px, py, lo, a_to, 1, a)
    fit_line(px, py, b_from, hi, 1, b)
    least = max(ROUNDED_PX, ROUNDED_BY * blur)
    radius = 0.0
    cost = 1e18
    for again in range(REFITS):
        if not set_corner(a, b, corner):
            return 1e18
        if again == 0:
            radius = _cut(px, py, a_to, b_from, corner) / (1.0 / corner[4] - 1.0)
            if radius * corner[5] < 0.7 * least:
                return 1e18
            if not _is_round(px, py, a_hi, b_lo, corner, radius, ASTRAY * worst):
                return 1e18
        radius = solve_radius(px, py, lo, hi, a, b, corner, radius, inwards)
        if radius * corner[5] < least:
            return 1e18
        cost, first, last = _fillet_cost(
            px, py, lo, hi, a, b, corner, radius, inwards, dead_zone, sigma,
            worst if again == REFITS - 1 else 1e9, expected,
        )  # fmt: skip
        # both lines need points of their own beside the arc
        if cost >= 1e18 or first < lo + 2 or last > hi - 3 or last - first < 3:
            return 1e18
        found[0] = lo
        found[1] = hi
        found[2] = first
        found[3] = last
        if again < REFITS - 1:
            fit_line(px, py, lo, max(first - 1, lo + 2), 1, a)
            fit_line(px, py, min(last + 2, hi - 2), hi, 1, b)
    return cost


@njit(cache=True, nogil=True)
def round_corners(
    px, py, n, breaks, is_arc, edges, shape, joints, blur, dead_zone, sigma, worst, expected,
    prices, is_fillet,
):  # fmt: skip
    """Put fillets where they describe a border more cheaply; returns their number.

    ``breaks``, ``is_arc`` and ``is_fillet`` are changed; whether they are is the other answer.
    """
    if edges < 3:
        return edges, False
    inwards = _half_variance(blur)
    blur = math.sqrt(blur * blur + PIXEL_BLUR_PX * PIXEL_BLUR_PX)
    corners = np.empty((edges, CORNER_ROOM), np.float64)
    sums = np.empty(2 * n + 1, np.float64)
    find_corners(px, py, n, breaks, is_arc, edges, shape, joints, corners)
    sum_costs(
        px, py, n, breaks, is_arc, edges, shape, joints, corners, blur, dead_zone, sigma, expected,
        sums,
    )  # fmt: skip
    gains = np.full(edges, NO_GAIN)
    runs = np.zeros(edges, np.int64)
    arcs = np.zeros((edges, 2), np.int64)
    any_gain = _find_fillets(
        px, py, n, breaks, is_arc, edges, shape, corners, blur, inwards, dead_zone, sigma,
        worst, expected, prices, sums, gains, runs, arcs,
    )  # fmt: skip
    if not any_gain:
        return edges, False
    return _place_fillets(n, breaks, is_arc, edges, is_fillet, gains, runs, arcs), True


@njit(**LEAF)
def _is_flat(px, py, lo, hi, is_arc, shape, e):
    """Whether edge e may be one of the lines beside a fillet."""
    if not is_arc:
        return True
    return math.sqrt((px[hi] - px[lo]) ** 2 + (py[hi] - py[lo]) ** 2) < FLAT * shape[e, 2]


@njit(cache=True, nogil=True)
def _find_fillets(
    px, py, n, breaks, is_arc, edges, shape, corners, blur, inwards, dead_zone, sigma, worst,
    expected, prices, sums, gains, runs, arcs,
):  # fmt: skip
    """The best fillet that begins at each line: what it saves, its run, and its arc's points."""
    a = np.empty(4, np.float64)
    b = np.empty(4, np.float64)
    corner = np.empty(7, np.float64)
    found = np.empty(4, np.int64)
    any_gain = False
    for i in range(edges):
        a_lo = breaks[i]
        a_hi = edge_end(breaks, edges, n, i)
        if not _is_flat(px, py, a_lo, a_hi, is_arc[i], shape, i):
            continue
        b_lo = a_hi
        saved = 0.0
        turned = 0.0
        price = FILLET * prices[0]
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
            if _is_flat(px, py, b_lo, b_hi, is_arc[j], shape, j):
                lo = a_lo + int((a_hi - a_lo) * ANCHOR_FROM)
                hi = b_lo + int(length * ANCHOR_TO)
                now = sums[hi] - sums[lo]
                if now + saved > price:
                    cost = _try_fillet(
                        px, py, a_lo, a_hi, b_lo, b_hi, blur, inwards, dead_zone, sigma, worst,
                        expected, a, b, corner, found,
                    )  # fmt: skip
                    gain = now + saved - price - cost
                    if gain > gains[i]:
                        gains[i] = gain
                        runs[i] = run
                        arcs[i, 0] = found[2]
                        arcs[i, 1] = found[3] + 1
                        any_gain = True
            saved += prices[1] if is_arc[j] else prices[0]
            b_lo = b_hi
    return any_gain


@njit(cache=True, nogil=True)
def _place_fillets(n, breaks, is_arc, edges, is_fillet, gains, runs, arcs):
    """Replace runs of edges by fillets, those that save most first; returns the new number."""
    gone = np.zeros(edges, np.bool_)
    anchor = np.zeros(edges, np.bool_)
    begins = np.full(edges, -1, np.int64)
    used = np.zeros(edges, np.bool_)
    for i in np.argsort(-gains):
        if gains[i] <= NO_GAIN:
            break
        j = (i + runs[i] + 1) % edges
        free = not (gone[i] or gone[j])
        for t in range(1, runs[i] + 1):
            e = (i + t) % edges
            free = free and not gone[e] and not anchor[e]
        first = arcs[i, 0]
        last = arcs[i, 1]
        # what is left of each line lies between the arcs at its ends
        if begins[i] >= 0:
            free = free and (first - begins[i]) % n < n // 2 and (first - begins[i]) % n >= 3
        if used[j]:
            free = free and (arcs[j, 0] - last) % n < n // 2 and (arcs[j, 0] - last) % n >= 3
        if not free:
            continue
        used[i] = True
        anchor[i] = True
        anchor[j] = True
        begins[j] = last % n
        for t in range(1, runs[i] + 1):
            gone[(i + t) % edges] = True
    # every edge adds at most one
    new_breaks = np.empty(2 * edges, np.int64)
    bent = np.empty(2 * edges, np.bool_)
    fillet = np.empty(2 * edges, np.bool_)
    m = 0
    for e in range(edges):
        if not gone[e]:
            new_breaks[m] = begins[e] if begins[e] >= 0 else breaks[e]
            bent[m] = is_arc[e]
            fillet[m] = is_fillet[e]
            m += 1
        if used[e]:
            new_breaks[m] = arcs[e, 0] % n
            bent[m] = True
            fillet[m] = True
            m += 1
    for e in range(m):
        breaks[e] = new_breaks[e]
        is_arc[e] = bent[e]
        is_fillet[e] = fillet[e]
    return m


@njit(**LEAF)
def touch_lines(
    px, py, n, breaks, is_arc, edges, shape, joints, is_fillet, blur, dead_zone, sigma, worst,
    corner,
):  # fmt: skip
    """Let fillets touch the lines beside them, as these have been fitted since."""
    inwards = _half_variance(blur)
    for e in range(edges):
        before = e - 1 if e > 0 else edges - 1
        after = e + 1 if e + 1 < edges else 0
        if not is_fillet[e] or not is_arc[e] or is_arc[before] or is_arc[after]:
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
        radius = solve_radius(px, py, lo, hi, a, b, corner, shape[e, 2], inwards)
        cost, first, last = _fillet_cost(
            px, py, lo, hi, a, b, corner, radius, inwards, dead_zone, sigma, worst, 0.0
        )
        if cost >= 1e18 or last - first < 3:
            continue
        reach = radius * corner[5]
        shape[e, 0] = corner[0] + radius / corner[4] * corner[2]
        shape[e, 1] = corner[1] + radius / corner[4] * corner[3]
        shape[e, 2] = radius
        shape[e, 4] = circle_rms(px, py, first, last + 1, shape[e])
        joints[e, 0] = corner[0] - reach * a[2]
        joints[e, 1] = corner[1] - reach * a[3]
        joints[after, 0] = corner[0] + reach * b[2]
        joints[after, 1] = corner[1] + reach * b[3]
        breaks[e] = first % n
        breaks[after] = (last + 1) % n

"""Rounded corners: an arc that touches both neighbouring lines, where sharp corners do not fit.

Rules and units
- ``border``, ``costs`` and ``fillet``: see ``vision.outline.outline_types``; pictures with grey
  only.
- Where fillets are looked for: ``vision.outline.corners.fillet_search_kernels``.
- A fillet has one free number, its radius: both lines are known.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.fit.shape_kernels import HUGE, fit_line

LEAST_TURN, MOST_TURN = math.radians(15.0), math.radians(150.0)
"""Between which angles the lines of a rounded corner turn."""
PIXEL_BLUR_PX = 0.2887
"""The spread (sigma) of a pixel's own width: 1 / sqrt(12)."""
ROUNDED_PX, ROUNDED_BY = 1.5, 2.5
"""A fillet's tangents are at least so long, and so many times the blur: blur rounds a sharp corner
as an arc would whose tangents are 1.6 .. 1.9 times the blur's sigma."""
ANCHOR_FROM, ANCHOR_TO = 0.3, 0.7
"""The part of a line that surely is none of the arcs at its ends."""
LOOKS, ASTRAY = 6, 2.0
"""Points of a run that tell at once whether it is round, in worst deviations before the fit."""
INWARDS, MORE_INWARDS = 0.25, 0.1
"""Blur moves a round border inwards, by half its variance over the radius. That little tells much
of an arc that has to touch two lines: its radius moves four times as far where they turn by 90
degrees. Half the variance from the one that is read off profiles along rows and columns, which
meet a border aslant and end before a wide blur does, and from its square (measured: right to a
twelfth for discs at blurs of 0.5 .. 2)."""
STEPS, REFITS = 8, 3
"""Steps of Gauss-Newton for a radius; times that the lines beside a fillet are fitted again."""
ANY_PX = 1e9
"""No point is too far from a fillet that is still to be fitted."""


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
def half_variance(blur):
    """Half the variance of the blur whose sigma reads ``blur``, in square pixels."""
    square = blur * blur
    return square * (INWARDS + MORE_INWARDS * square)


@njit(**LEAF)
def solve_radius(border, lo, hi, a, b, corner, radius, inwards):
    """The radius of the fillet nearest to points lo .. hi - 1: Gauss-Newton from ``radius``.

    ``inwards``: by how much blur moves its border, times the radius.
    """
    px = border.x
    py = border.y
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
def _cut(border, lo, hi, corner):
    """How far the border cuts the corner: from the crossing to the border along the bisector."""
    best = HUGE
    cut = 0.0
    for k in range(lo, hi):
        dx = border.x[k] - corner[0]
        dy = border.y[k] - corner[1]
        off = abs(dx * corner[3] - dy * corner[2])
        if off < best:
            best = off
            cut = dx * corner[2] + dy * corner[3]
    return cut


@njit(**LEAF)
def _is_round(border, lo, hi, corner, radius, worst):
    """Whether some of the points lo .. hi lie near a fillet: most polygons are told by these."""
    px = border.x
    py = border.y
    cx = corner[0] + radius / corner[4] * corner[2]
    cy = corner[1] + radius / corner[4] * corner[3]
    for t in range(LOOKS + 1):
        k = lo + (hi - lo) * t // LOOKS
        if abs(math.sqrt((px[k] - cx) ** 2 + (py[k] - cy) ** 2) - radius) > worst:
            return False
    return True


@njit(**LEAF)
def fillet_cost(border, lo, hi, a, b, corner, radius, inwards, costs, worst):
    """The cost of points lo .. hi - 1 beside line, fillet and line: (cost, first, last on arc).

    HUGE where one lies farther off than ``worst``.
    """
    px = border.x
    py = border.y
    dead_zone = costs.dead_zone
    sigma = costs.sigma
    expected = costs.expected
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
            return HUGE, first, last
        over = max(d - dead_zone, 0.0) / sigma
        cost += over * over - expected
    return cost, first, last


@njit(**LEAF)
def try_fillet(border, a_lo, a_hi, b_lo, b_hi, blur, inwards, costs, fillet):
    """The fillet between the lines of points a_lo .. a_hi and b_lo .. b_hi: its cost, or HUGE."""
    px = border.x
    py = border.y
    a = fillet.a
    b = fillet.b
    corner = fillet.corner
    found = fillet.found
    lo = a_lo + int((a_hi - a_lo) * ANCHOR_FROM)
    hi = b_lo + int((b_hi - b_lo) * ANCHOR_TO)
    a_to = a_lo + int((a_hi - a_lo) * ANCHOR_TO)
    b_from = b_lo + int((b_hi - b_lo) * ANCHOR_FROM)
    if a_to - lo < 3 or hi - b_from < 3:
        return HUGE
    fit_line(px, py, lo, a_to, 1, a)
    fit_line(px, py, b_from, hi, 1, b)
    least = max(ROUNDED_PX, ROUNDED_BY * blur)
    radius = 0.0
    cost = HUGE
    for again in range(REFITS):
        if not set_corner(a, b, corner):
            return HUGE
        if again == 0:
            radius = _cut(border, a_to, b_from, corner) / (1.0 / corner[4] - 1.0)
            if radius * corner[5] < 0.7 * least:
                return HUGE
            if not _is_round(border, a_hi, b_lo, corner, radius, ASTRAY * costs.worst):
                return HUGE
        radius = solve_radius(border, lo, hi, a, b, corner, radius, inwards)
        if radius * corner[5] < least:
            return HUGE
        cost, first, last = fillet_cost(
            border, lo, hi, a, b, corner, radius, inwards, costs,
            costs.worst if again == REFITS - 1 else ANY_PX,
        )  # fmt: skip
        # both lines need points of their own beside the arc
        if cost >= HUGE or first < lo + 2 or last > hi - 3 or last - first < 3:
            return HUGE
        found[0] = lo
        found[1] = hi
        found[2] = first
        found[3] = last
        if again < REFITS - 1:
            fit_line(px, py, lo, max(first - 1, lo + 2), 1, a)
            fit_line(px, py, min(last + 2, hi - 2), hi, 1, b)
    return cost

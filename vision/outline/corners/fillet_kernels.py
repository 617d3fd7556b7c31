"""Rounded corners: an arc that touches both neighbouring lines, where sharp corners do not fit.

Rules and units
- Types: ``vision.outline.outline_types``; pictures with grey only.
- Both lines are known, so a fillet has one free number, its radius.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.corners.blurred_corner_kernels import (
    ALONG_X,
    ALONG_Y,
    STEEPNESS,
    TURN,
    change_cost,
)
from vision.outline.fit.edge_shape_kernels import FIT_ASTRAY, FIT_ROUNDS, HUGE, circle_rms, fit_line
from vision.shared.typed_numbers import YES

LEAST_TURN, MOST_TURN = math.radians(15.0), math.radians(150.0)
"""Range of turns of a rounded corner (chosen): below, the corner is ill-known, above, its fillet is
far from it."""
PIXEL_BLUR_PX = 0.2887
"""Spread (sigma) of a pixel's own width: derived, 1 / sqrt(12)."""
ROUNDED_BY = 2.5
"""Least length of a fillet's tangents as a multiple of the blur: chosen, a blurred sharp corner
looks like 1.6 .. 1.9."""
ANCHOR_FROM = 0.3
"""Part of a line that may be of the arcs at either end (chosen)."""
ANCHOR_TO = 1.0 - ANCHOR_FROM
"""Beginning of the other end's: derived."""
ARC_INWARDS, MORE_INWARDS = 0.25, 0.1
"""Shift of a round border inwards by blur, times the radius: half the variance, corrected for
profiles that meet a border aslant and end before a wide blur does (measured: right to a twelfth for
discs at blurs of 0.5 .. 2). A fillet's radius moves four times as far where its lines turn by 90
degrees."""
FILLET_PARTS = 6
"""Parts of a run at whose ends roundness is tested: indifferent, to spare work."""
OWN = 3
"""Least points of a fillet and of the lines beside it: derived, two lie on any line."""
REFITS = 3
"""Most fits of the lines beside a fillet: chosen, a bound on the work."""


@njit(**LEAF)
def set_corner(a, b, corner):
    """Fill ``corner`` (7,) for two lines; False if they are too nearly parallel.

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
    """Half the variance of a blur of measured sigma ``blur``, in square pixels."""
    square = blur * blur
    return square * (ARC_INWARDS + MORE_INWARDS * square)


@njit(**LEAF)
def solve_radius(border, lo, hi, a, b, corner, radius, inwards):
    """Radius of the fillet nearest to points lo .. hi - 1: Gauss-Newton from ``radius``.

    ``inwards``: shift of its border by blur, times the radius.
    """
    px = border.x
    py = border.y
    share = 1.0 / corner[4]
    for _ in range(FIT_ROUNDS):
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
    """Distance from the crossing to the border along the bisector."""
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
    """True if a sample of points lo .. hi lies near a fillet: this excludes most polygons."""
    px = border.x
    py = border.y
    cx = corner[0] + radius / corner[4] * corner[2]
    cy = corner[1] + radius / corner[4] * corner[3]
    for t in range(FILLET_PARTS + 1):
        k = lo + (hi - lo) * t // FILLET_PARTS
        if abs(math.sqrt((px[k] - cx) ** 2 + (py[k] - cy) ** 2) - radius) > worst:
            return False
    return True


@njit(**LEAF)
def put_fillet(border, radius, blur, costs, change):
    """Put the fillet of a radius between the lines of ``change``: the cost, or HUGE."""
    px, py = border.x, border.y
    rows, points, corner = change.rows, change.points, change.meeting
    a, b = rows[0], rows[2]
    reach = radius * corner[5]
    first = points[3]
    last = points[0]
    points[1] = points[2] = last
    inside = 0
    for k in range(points[0], points[3]):
        dx = px[k] - corner[0]
        dy = py[k] - corner[1]
        if dx * a[2] + dy * a[3] >= -reach and dx * b[2] + dy * b[3] <= reach:
            first = min(first, k)
            last = max(last, k)
            inside += 1
    if last - first < OWN or inside <= last - first:
        return HUGE
    if first - points[0] < OWN or points[3] - last - 1 < OWN:
        return HUGE
    points[1] = first
    points[2] = last + 1
    rows[1, 0] = corner[0] + radius / corner[4] * corner[2]
    rows[1, 1] = corner[1] + radius / corner[4] * corner[3]
    rows[1, 2] = radius
    for c in range(2):
        change.joints[0, c] = corner[c] - reach * a[2 + c]
        change.joints[1, c] = corner[c] + reach * b[2 + c]
        # it touches both: no corner, only the side to which it turns
        change.corners[c, ALONG_X] = 0.0
        change.corners[c, ALONG_Y] = 0.0
        change.corners[c, STEEPNESS] = 0.0
        change.corners[c, TURN] = corner[6]
    inwards = blur.half_variance / radius
    return change_cost(border, change, YES, inwards, blur.sigma, costs, costs.worst)


@njit(**LEAF)
def try_fillet(border, blur, costs, change):
    """Fit the fillet between the two lines that stay: the cost, or HUGE."""
    px, py = border.x, border.y
    rows, points, stays, corner = change.rows, change.points, change.stays, change.meeting
    lo = stays[0] + int((stays[1] - stays[0]) * ANCHOR_FROM)
    hi = stays[2] + int((stays[3] - stays[2]) * ANCHOR_TO)
    a_to = stays[0] + int((stays[1] - stays[0]) * ANCHOR_TO)
    b_from = stays[2] + int((stays[3] - stays[2]) * ANCHOR_FROM)
    if a_to - lo < 3 or hi - b_from < 3:
        return HUGE
    points[0] = lo
    points[3] = hi
    fit_line(px, py, lo, a_to, rows[0])
    fit_line(px, py, b_from, hi, rows[2])
    least = ROUNDED_BY * blur.sigma
    radius = 0.0
    cost = HUGE
    for again in range(REFITS):
        if not set_corner(rows[0], rows[2], corner):
            return HUGE
        if again == 0:
            radius = _cut(border, a_to, b_from, corner) / (1.0 / corner[4] - 1.0)
            if radius * corner[5] < 0.7 * least:
                return HUGE
            if not _is_round(border, stays[1], stays[2], corner, radius, FIT_ASTRAY * costs.worst):
                return HUGE
        radius = solve_radius(border, lo, hi, rows[0], rows[2], corner, radius, blur.half_variance)
        if radius * corner[5] < least:
            return HUGE
        cost = put_fillet(border, radius, blur, costs, change)
        if points[1] == points[2]:
            return HUGE
        if again < REFITS - 1:
            fit_line(px, py, lo, max(points[1] - 1, lo + 2), rows[0])
            fit_line(px, py, min(points[2] + 1, hi - 2), hi, rows[2])
    return cost


@njit(**LEAF)
def touch_lines(border, outline, edges, blur, costs, change):
    """Let fillets touch the lines beside them again, after these were fitted."""
    n = border.n
    breaks = outline.breaks
    is_arc = outline.is_arc
    shape = outline.shape
    joints = outline.joints
    rows, points = change.rows, change.points
    for e in range(edges):
        before = predecessor(e, edges)
        after = successor(e, edges)
        if not outline.is_fillet[e] or not is_arc[e] or is_arc[before] or is_arc[after]:
            continue
        for c in range(4):
            rows[0, c] = shape[before, c]
            rows[2, c] = shape[after, c]
        if not set_corner(rows[0], rows[2], change.meeting):
            continue
        lo = breaks[before]
        begin = lo + (breaks[e] - lo) % n
        end = begin + (breaks[after] - breaks[e]) % n
        hi = end + (breaks[successor(after, edges)] - breaks[after]) % n
        points[0] = (lo + begin) // 2
        points[3] = (hi + end) // 2
        radius = solve_radius(
            border, points[0], points[3], rows[0], rows[2], change.meeting, shape[e, 2],
            blur.half_variance,
        )  # fmt: skip
        if put_fillet(border, radius, blur, costs, change) >= HUGE:
            continue
        for c in range(3):
            shape[e, c] = rows[1, c]
        shape[e, 4] = circle_rms(border.x, border.y, points[1], points[2], shape[e])
        for c in range(2):
            joints[e, c] = change.joints[0, c]
            joints[after, c] = change.joints[1, c]
        breaks[e] = points[1] % n
        breaks[after] = points[2] % n

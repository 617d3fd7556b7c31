"""Lines and circles fitted between the pixels of a picture without grey.

Rules and units
- Points as in ``vision.outline.fit.edge_shape_kernels``, each the middle between an obstacle pixel
  and a free one. An edge within half a pixel along the axis separates them.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from vision.outline.fit.edge_shape_kernels import HUGE

HALF = 0.5
"""Distance along a pixel's axis that an edge may leave a point: derived."""
COARSE_PX = 0.01 * HALF
"""Error of an arc's polyline: chosen."""
SEPARATION_STEPS = 12
"""Most steps: chosen, a bound on the work."""
SEPARATION_MARGIN = 0.03
"""Margin below half a pixel to which edges are pulled: chosen."""
ACTIVE_PX = 0.15
"""Distance from its limit at which a point takes part: chosen."""
FAR_PX = ACTIVE_PX
"""Excess over its limit at which a point counts half: derived, as near as points take part."""
WITHIN_PX = 1.0
"""Largest change of a circle's radius: defined, the pixel that is promised."""
RADII = 128
"""Smaller radii tried, and larger ones: chosen, most pixels' distances differ by more."""


@njit(**SUMS)
def weight_of(excess):
    """Weight of a point that lies ``excess`` pixels beyond its limit.

    A pixel that juts out at a corner must not outweigh a side's.
    """
    return FAR_PX / (FAR_PX + excess)


@njit(**SUMS)
def lost_to_circle(px, py, n, circle):
    """Number of pixels beside n points that a circle misclassifies, without grey."""
    cx, cy, r = circle[0], circle[1], circle[2]
    lost = 0
    for k in range(n):
        x = abs(px[k] - cx)
        y = abs(py[k] - cy)
        away = math.sqrt(x * x + y * y)
        lost += abs(away - r) * away > HALF * max(x, y)
    return lost


@njit(**LEAF)
def lose_fewest(cracks, circle, losses, away):
    """Give a circle the radius that loses the fewest pixels; return their number.

    It keeps its radius if none loses fewer, else takes the nearest that loses fewest, half-way
    between two pixels. ``losses`` (2 * RADII + 2,) and ``away`` (2 n,) are scratch space.
    """
    cx = circle[0]
    cy = circle[1]
    step = WITHIN_PX / RADII
    least = circle[2] - WITHIN_PX
    for i in range(2 * RADII + 2):
        losses[i] = 0.0
    # a hole lies within its free pixels
    turn = 0.0
    for k in range(cracks.n):
        turn += (cracks.x[k] - cx) * cracks.free_x[k] + (cracks.y[k] - cy) * cracks.free_y[k]
    pixels = 0
    last_x = HUGE
    last_y = HUGE
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        outside = (sign > 0.0) == (turn > 0.0)
        for k in range(cracks.n):
            x = cracks.x[k] + sign * cracks.free_x[k]
            y = cracks.y[k] + sign * cracks.free_y[k]
            if x == last_x and y == last_y:
                continue
            last_x = x
            last_y = y
            here = math.sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy))
            away[pixels] = here
            pixels += 1
            i = min(max(math.ceil((here - least) / step), 0), 2 * RADII + 1)
            losses[i] += 1.0 if outside else -1.0
            losses[0] += 0.0 if outside else 1.0
    for i in range(2 * RADII):
        losses[i + 1] += losses[i]
    best = RADII
    for i in range(2 * RADII + 1):
        nearer = abs(i - RADII) < abs(best - RADII)
        if losses[i] < losses[best] or (losses[i] == losses[best] and nearer):
            best = i
    if best != RADII:
        inner = least
        outer = least + 2.0 * WITHIN_PX
        for p in range(pixels):
            if away[p] <= least + best * step:
                inner = max(inner, away[p])
            else:
                outer = min(outer, away[p])
        circle[2] = 0.5 * (inner + outer)
    return losses[best]


@njit(**SUMS)
def separate_line(px, py, lo, hi, line, near):
    """Turn and shift a line until it passes between the pixels on its two sides.

    Least squares on each point's excess over half a pixel along the axis, weighted by
    ``weight_of``. ``near`` (2, hi - lo + 1) is scratch space.
    """
    xs, ys = px[lo:hi], py[lo:hi]
    near_x, near_y = near[0], near[1]
    x, y, ux, uy = line[0], line[1], line[2], line[3]
    limit = (HALF - SEPARATION_MARGIN) * max(abs(ux), abs(uy))
    beyond = 0
    for k in range(hi - lo):
        beyond += abs((ys[k] - y) * ux - (xs[k] - x) * uy) > limit
    if beyond == 0:
        return
    count = 0
    for k in range(hi - lo):
        near_x[count] = xs[k]
        near_y[count] = ys[k]
        count += abs((ys[k] - y) * ux - (xs[k] - x) * uy) > limit - ACTIVE_PX
    half = 0.5 * (hi - lo)
    for _ in range(SEPARATION_STEPS):
        limit = (HALF - SEPARATION_MARGIN) * max(abs(ux), abs(uy))
        w = wt = wtt = b0 = b1 = 0.0
        for i in range(count):
            dx = near_x[i] - x
            dy = near_y[i] - y
            d = dy * ux - dx * uy
            excess = max(abs(d) - limit, 0.0)
            one = weight_of(excess) if excess > 0.0 else 0.0
            excess = -one * excess if d < 0.0 else one * excess
            t = dx * ux + dy * uy
            w += one
            wt += one * t
            wtt += one * t * t
            b0 += excess
            b1 += excess * t
        if w == 0.0:
            break
        # damped: one point alone must not turn the line
        a00 = w + 0.5
        a11 = wtt + 0.15 * half * half
        det = a00 * a11 - wt * wt
        shift = (b0 * a11 - b1 * wt) / det
        turn = (b1 * a00 - b0 * wt) / det
        x -= shift * uy
        y += shift * ux
        vx = ux - turn * uy
        vy = uy + turn * ux
        length = math.sqrt(vx * vx + vy * vy)
        ux = vx / length
        uy = vy / length
    line[0] = x
    line[1] = y
    line[2] = ux
    line[3] = uy


@njit(**SUMS)
def separate_circle(px, py, lo, hi, circle, near):
    """Move and grow a circle until it passes between the pixels, by plain least squares.

    Unweighted: an inexact disc leaves every circle somewhere.
    """
    xs, ys = px[lo:hi], py[lo:hi]
    near_x, near_y = near[0], near[1]
    cx, cy, r = circle[0], circle[1], circle[2]
    beyond = 0
    for k in range(hi - lo):
        dx = abs(xs[k] - cx)
        dy = abs(ys[k] - cy)
        far = math.sqrt(dx * dx + dy * dy)
        beyond += abs(far - r) > (HALF - SEPARATION_MARGIN) * max(dx, dy) / max(far, 1e-9)
    if beyond == 0:
        return
    count = 0
    for k in range(hi - lo):
        dx = abs(xs[k] - cx)
        dy = abs(ys[k] - cy)
        far = math.sqrt(dx * dx + dy * dy)
        excess = abs(far - r) - (HALF - SEPARATION_MARGIN) * max(dx, dy) / max(far, 1e-9)
        near_x[count] = xs[k]
        near_y[count] = ys[k]
        count += excess > -ACTIVE_PX
    for _ in range(SEPARATION_STEPS):
        suu = suv = svv = su = sv = s1 = bu = bv = b1 = 0.0
        for i in range(count):
            dx = near_x[i] - cx
            dy = near_y[i] - cy
            far = math.sqrt(dx * dx + dy * dy)
            inv = 1.0 / max(far, 1e-9)
            ux = dx * inv
            uy = dy * inv
            d = far - r
            excess = max(abs(d) - (HALF - SEPARATION_MARGIN) * max(abs(ux), abs(uy)), 0.0)
            one = 1.0 if excess > 0.0 else 0.0
            excess = -excess if d < 0.0 else excess
            suu += one * ux * ux
            suv += one * ux * uy
            svv += one * uy * uy
            su += one * ux
            sv += one * uy
            s1 += one
            bu += ux * excess
            bv += uy * excess
            b1 += excess
        if s1 == 0.0:
            break
        suu += 0.5
        svv += 0.5
        s1 += 0.5
        # by cofactors: numba's linear algebra would need scipy
        c0 = svv * s1 - sv * sv
        c1 = su * sv - suv * s1
        c2 = suv * sv - su * svv
        c3 = suu * s1 - su * su
        c4 = suv * su - suu * sv
        c5 = suu * svv - suv * suv
        det = suu * c0 + suv * c1 + su * c2
        cx += (c0 * bu + c1 * bv + c2 * b1) / det
        cy += (c1 * bu + c3 * bv + c4 * b1) / det
        r += (c2 * bu + c4 * bv + c5 * b1) / det
    circle[0] = cx
    circle[1] = cy
    circle[2] = r

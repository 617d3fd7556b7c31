"""Lines and circles through stretches of a border: the fits, and their costs.

Rules and units
- ``px``, ``py``: one border's points in pixels about its own origin, twice over, so that a stretch
  lo .. hi may run past its end once; y down.
- A cost is the sum of ((|deviation| - dead_zone) / sigma)^2 over a stretch's points; without grey
  the deviation is along the pixels' axis (see ``vision.outline.fit.separating_fit_kernels``).
- Lines: total least squares. Circles: Taubin's fit, then Gauss-Newton on the distances (N. Chernov,
  Circular and Linear Regression, 2010).
- Loops run without branches, several points at a time (``planner.scene.compile_options``).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF, SUMS

HUGE = 1e18
"""Cost of the impossible: defined."""
BEATEN = 1e12
"""Cost above the best known: defined."""
CHUNK = 32
"""Points after which a cost is compared with its bound: indifferent, to spare work."""
FLATTEST_RADIUS_PX = 1e6
"""Radius from which a circle is a line: indifferent, beyond any picture."""
FIT_ROUNDS = 8
"""Most repetitions of a fit, a search or a check: chosen, a bound on the work; nearly all settle
after two to four."""
FIT_ASTRAY = 3.0
"""Distance in worst deviations of a point from the chord, from the circle through ends and middle,
or from a fillet's first guess, up to which a fit is worth it (chosen)."""
CIRCLE_SETTLED_PX = 1e-6
"""Movement of a converged circle: chosen, far below a point's error."""


@njit(**SUMS)
def fit_line(px, py, lo, hi, out):
    """Total least squares through points lo .. hi - 1: out = x, y, ux, uy."""
    ox = px[lo]
    oy = py[lo]
    sx = sy = sxx = sxy = syy = 0.0
    count = hi - lo
    xs = px[lo:hi]
    ys = py[lo:hi]
    for k in range(count):
        x = xs[k] - ox
        y = ys[k] - oy
        sx += x
        sy += y
        sxx += x * x
        sxy += x * y
        syy += y * y
    means = (sx / count, sy / count, sxx / count, sxy / count, syy / count)
    put_line(ox, oy, means, px[hi - 1], py[hi - 1], out)


@njit(**SUMS)
def put_line(ox, oy, means, last_x, last_y, out):
    """Line of least squares from the mean x, y, xx, xy, yy about (ox, oy): out = x, y, ux, uy.

    It runs towards the last point.
    """
    mx, my, xx, xy, yy = means
    b = xy - mx * my
    half = 0.5 * ((xx - mx * mx) - (yy - my * my))
    # the eigenvector of the larger eigenvalue
    root = math.sqrt(half * half + b * b)
    ux = half + root if half >= 0.0 else b
    uy = b if half >= 0.0 else root - half
    length = math.sqrt(ux * ux + uy * uy)
    if length > 0.0:
        ux /= length
        uy /= length
    else:
        ux = 1.0
        uy = 0.0
    if (last_x - ox) * ux + (last_y - oy) * uy < 0.0:
        ux = -ux
        uy = -uy
    out[0] = ox + mx
    out[1] = oy + my
    out[2] = ux
    out[3] = uy


@njit(**SUMS)
def fit_circle(px, py, lo, hi, out):
    """Taubin's circle through points lo .. hi - 1: out = cx, cy, r.

    False if the points lie on a line.
    """
    count = hi - lo
    mx = my = xx = xy = yy = xz = yz = zz = 0.0
    xs = px[lo:hi]
    ys = py[lo:hi]
    for k in range(count):
        mx += xs[k]
        my += ys[k]
    mx /= count
    my /= count
    for k in range(count):
        x = xs[k] - mx
        y = ys[k] - my
        z = x * x + y * y
        xx += x * x
        xy += x * y
        yy += y * y
        xz += x * z
        yz += y * z
        zz += z * z
    xx /= count
    xy /= count
    yy /= count
    xz /= count
    yz /= count
    zz /= count
    return taubin(xx, xy, yy, xz, yz, zz, mx, my, out)


@njit(**SUMS)
def taubin(xx, xy, yy, xz, yz, zz, mx, my, out):
    """Taubin's circle from mean products about the points' mean (mx, my): out = cx, cy, r.

    z is xx + yy of a point. False if the points lie on a line.
    """
    mz = xx + yy
    cov = xx * yy - xy * xy
    var = zz - mz * mz
    a3 = 4.0 * mz
    a2 = -3.0 * mz * mz - zz
    a1 = var * mz + 4.0 * cov * mz - xz * xz - yz * yz
    a0 = xz * (xz * yy - yz * xy) + yz * (yz * xx - xz * xy) - var * cov
    eta = 0.0
    value = a0
    for _ in range(30):
        slope = a1 + eta * (2.0 * a2 + 3.0 * a3 * eta)
        if slope == 0.0:
            break
        new = eta - value / slope
        new_value = a0 + new * (a1 + new * (a2 + new * a3))
        if not abs(new_value) < abs(value):
            break
        near = abs(new - eta) <= 1e-12 * abs(new)
        eta = new
        value = new_value
        if near:
            break
    det = eta * eta - eta * mz + cov
    if abs(det) < 1e-12 * (mz * mz + 1e-300):
        return False
    cx = (xz * (yy - eta) - yz * xy) / det / 2.0
    cy = (yz * (xx - eta) - xz * xy) / det / 2.0
    square = cx * cx + cy * cy + mz
    if not square < FLATTEST_RADIUS_PX * FLATTEST_RADIUS_PX:
        return False
    out[0] = mx + cx
    out[1] = my + cy
    out[2] = math.sqrt(square)
    return out[2] > 0.0


@njit(**LEAF)
def circle_of_three(ax, ay, bx, by):
    """Centre x, y and radius of the circle through (0, 0), (ax, ay) and (bx, by).

    The radius is HUGE if all three lie on a line.
    """
    det = 2.0 * (ax * by - ay * bx)
    if abs(det) < 1e-9:
        return 0.0, 0.0, HUGE
    aa = ax * ax + ay * ay
    bb = bx * bx + by * by
    x = (by * aa - ay * bb) / det
    y = (ax * bb - bx * aa) / det
    return x, y, math.sqrt(x * x + y * y)


@njit(**SUMS)
def refine_circle(px, py, lo, hi, circle):
    """Gauss-Newton on the distances of points lo .. hi - 1 from a circle."""
    xs, ys = px[lo:hi], py[lo:hi]
    cx, cy, r = circle[0], circle[1], circle[2]
    inv = 1.0 / (hi - lo)
    for _ in range(FIT_ROUNDS):
        suu = suv = svv = su = sv = sud = svd = sd = 0.0
        for k in range(hi - lo):
            x = xs[k] - cx
            y = ys[k] - cy
            d = math.sqrt(x * x + y * y) + 1e-30
            u = x / d
            v = y / d
            d -= r
            suu += u * u
            suv += u * v
            svv += v * v
            su += u
            sv += v
            sud += u * d
            svd += v * d
            sd += d
        auu = suu - su * su * inv
        auv = suv - su * sv * inv
        avv = svv - sv * sv * inv
        bu = sud - su * sd * inv
        bv = svd - sv * sd * inv
        det = auu * avv - auv * auv
        if det <= 1e-12 * (auu + avv) * (auu + avv):
            break
        dx = (bu * avv - bv * auv) / det
        dy = (bv * auu - bu * auv) / det
        dr = (sd - su * dx - sv * dy) * inv
        if not (abs(dx) + abs(dy) < 0.5 * r and r + dr > 0.0):
            break
        cx += dx
        cy += dy
        r += dr
        if abs(dx) + abs(dy) + abs(dr) < CIRCLE_SETTLED_PX:
            break
    circle[0] = cx
    circle[1] = cy
    circle[2] = r


@njit(**SUMS)
def line_cost(px, py, lo, hi, line, crisp, dead_zone, sigma, worst, bound):
    """Cost of a line for points lo .. hi - 1; HUGE beyond ``worst``, BEATEN beyond bound."""
    scale = 1.0 / max(abs(line[2]), abs(line[3])) if crisp else 1.0
    a = line[3] * scale
    b = -line[2] * scale
    c = -(line[0] * a + line[1] * b)
    bound *= sigma * sigma
    cost = 0.0
    for first in range(lo, hi, CHUNK):
        xs = px[first : min(first + CHUNK, hi)]
        ys = py[first : min(first + CHUNK, hi)]
        beyond = 0
        for k in range(xs.shape[0]):
            d = abs(xs[k] * a + ys[k] * b + c)
            beyond += d > worst
            over = max(d - dead_zone, 0.0)
            cost += over * over
        if beyond > 0:
            return HUGE
        if cost > bound:
            return BEATEN
    return cost / (sigma * sigma)


@njit(**SUMS)
def circle_cost(px, py, lo, hi, circle, crisp, dead_zone, sigma, worst, bound):
    """Cost of a circle, as ``line_cost``."""
    cx, cy, r = circle[0], circle[1], circle[2]
    bound *= sigma * sigma
    cost = 0.0
    for first in range(lo, hi, CHUNK):
        xs = px[first : min(first + CHUNK, hi)]
        ys = py[first : min(first + CHUNK, hi)]
        beyond = 0
        if crisp:
            for k in range(xs.shape[0]):
                x = abs(xs[k] - cx)
                y = abs(ys[k] - cy)
                away = math.sqrt(x * x + y * y)
                d = abs(away - r) * away / (max(x, y) + 1e-9)
                beyond += d > worst
                over = max(d - dead_zone, 0.0)
                cost += over * over
        else:
            for k in range(xs.shape[0]):
                x = xs[k] - cx
                y = ys[k] - cy
                d = abs(math.sqrt(x * x + y * y) - r)
                beyond += d > worst
                over = max(d - dead_zone, 0.0)
                cost += over * over
        if beyond > 0:
            return HUGE
        if cost > bound:
            return BEATEN
    return cost / (sigma * sigma)


@njit(**LEAF)
def goes_round(px, py, n, x, y):
    """True if a whole border of n points, a closed polyline, winds once round (x, y).

    Residuals do not show it: both sides of a slit lie beside many circles. D. Sunday, Inclusion of
    a Point in a Polygon, 2001.
    """
    turns = 0
    for k in range(n):
        ax = px[k] - x
        ay = py[k] - y
        bx = px[k + 1] - x
        by = py[k + 1] - y
        side = ax * by - bx * ay
        turns += (ay <= 0.0) & (by > 0.0) & (side > 0.0)
        turns -= (ay > 0.0) & (by <= 0.0) & (side < 0.0)
    return abs(turns) == 1


@njit(**SUMS)
def line_rms(px, py, lo, hi, line):
    """Rms deviation of points lo .. hi - 1 from a line."""
    xs, ys = px[lo:hi], py[lo:hi]
    x0, y0, ux, uy = line[0], line[1], line[2], line[3]
    total = 0.0
    for k in range(hi - lo):
        d = (xs[k] - x0) * uy - (ys[k] - y0) * ux
        total += d * d
    return math.sqrt(total / (hi - lo))


@njit(**SUMS)
def circle_rms(px, py, lo, hi, circle):
    """Rms deviation of points lo .. hi - 1 from a circle."""
    xs, ys = px[lo:hi], py[lo:hi]
    cx, cy, r = circle[0], circle[1], circle[2]
    total = 0.0
    for k in range(hi - lo):
        x = xs[k] - cx
        y = ys[k] - cy
        d = math.sqrt(x * x + y * y) - r
        total += d * d
    return math.sqrt(total / (hi - lo))

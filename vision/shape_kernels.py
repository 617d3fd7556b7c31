"""Lines and circles through stretches of a border: the fits, and what they cost.

Rules and units
- ``px``, ``py``: one border's points in pixels, about the border's own origin, twice over, so
  that a stretch lo .. hi may run past the border's end once; y down.
- A cost is the sum of ((|deviation| - dead_zone) / sigma)^2 over a stretch's points; in a
  picture without grey the deviation is taken along the pixels' axis (see ``separate_line``).
- Lines: total least squares. Circles: Taubin's fit, then Gauss-Newton on the distances
  (N. Chernov, Circular and Linear Regression, 2010).
- Loops run over a stretch's own slice and without branches, so that they work on several points
  at a time (``vision.kernel_options``).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from vision.kernel_options import LEAF, SUMS

HUGE = 1e18
"""The cost of what may not be."""
BEATEN = 1e12
"""The cost of what is dearer than the best known."""
CHUNK = 32
"""Points after which a cost is compared with its bound."""
HALF = 0.5
"""Along a pixel's axis, how far an edge may leave the middle between two pixels' centres."""
SEPARATION_STEPS = 12
SEPARATION_MARGIN = 0.03
"""How much nearer than half a pixel an edge is pulled to the points that it must not leave."""
ACTIVE_PX = 0.15
"""Points so near to their limit take part when an edge is turned between the pixels."""
FLATTEST_RADIUS_PX = 1e6
"""A circle of a larger radius is a line."""
SETTLED_PX = 1e-6
"""A circle that moves less has converged."""


@njit(**SUMS)
def fit_line(px, py, lo, hi, step, out):
    """Total least squares through points lo, lo + step, .. < hi: out = x, y, ux, uy."""
    ox = px[lo]
    oy = py[lo]
    sx = 0.0
    sy = 0.0
    sxx = 0.0
    sxy = 0.0
    syy = 0.0
    count = (hi - lo + step - 1) // step
    if step == 1:
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
    else:
        for k in range(lo, hi, step):
            x = px[k] - ox
            y = py[k] - oy
            sx += x
            sy += y
            sxx += x * x
            sxy += x * y
            syy += y * y
    mx = sx / count
    my = sy / count
    b = sxy / count - mx * my
    half = 0.5 * ((sxx / count - mx * mx) - (syy / count - my * my))
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
    if (px[hi - 1] - ox) * ux + (py[hi - 1] - oy) * uy < 0.0:
        ux = -ux
        uy = -uy
    out[0] = ox + mx
    out[1] = oy + my
    out[2] = ux
    out[3] = uy


@njit(**SUMS)
def fit_circle(px, py, lo, hi, step, out):
    """Taubin's circle through points lo, lo + step, .. < hi: out = cx, cy, r.

    False where the points lie on a line.
    """
    count = (hi - lo + step - 1) // step
    mx = 0.0
    my = 0.0
    xx = 0.0
    xy = 0.0
    yy = 0.0
    xz = 0.0
    yz = 0.0
    zz = 0.0
    if step == 1:
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
    else:
        for k in range(lo, hi, step):
            mx += px[k]
            my += py[k]
        mx /= count
        my /= count
        for k in range(lo, hi, step):
            x = px[k] - mx
            y = py[k] - my
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


@njit(**SUMS)
def refine_circle(px, py, lo, hi, rounds, circle):
    """Gauss-Newton on the distances of points lo .. hi - 1 from a circle, at most so often."""
    xs = px[lo:hi]
    ys = py[lo:hi]
    cx = circle[0]
    cy = circle[1]
    r = circle[2]
    inv = 1.0 / (hi - lo)
    for _ in range(rounds):
        # normal equations of the distances sqrt((x - cx)^2 + (y - cy)^2) - r
        suu = 0.0
        suv = 0.0
        svv = 0.0
        su = 0.0
        sv = 0.0
        sud = 0.0
        svd = 0.0
        sd = 0.0
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
        if abs(dx) + abs(dy) + abs(dr) < SETTLED_PX:
            break
    circle[0] = cx
    circle[1] = cy
    circle[2] = r


@njit(**SUMS)
def line_cost(px, py, lo, hi, line, crisp, dead_zone, sigma, worst, bound):
    """The cost of a line for points lo .. hi - 1; HUGE beyond ``worst``, BEATEN beyond bound."""
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
    """The same for a circle."""
    cx = circle[0]
    cy = circle[1]
    r = circle[2]
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


@njit(**SUMS)
def lost_to_circle(px, py, n, circle):
    """How many pixels beside n points a circle takes for what they are not, without grey."""
    cx = circle[0]
    cy = circle[1]
    r = circle[2]
    lost = 0
    for k in range(n):
        x = abs(px[k] - cx)
        y = abs(py[k] - cy)
        away = math.sqrt(x * x + y * y)
        lost += abs(away - r) * away > HALF * max(x, y)
    return lost


@njit(**LEAF)
def pixels_lost_to_circle(qx, qy, hx, hy, cracks, ox, oy, circle):
    """How many pixels beside a border's cracks a circle about (ox, oy) takes for what they are not.

    ``qx`` to ``hy`` as in ``vision.separation_kernels``. A pixel's cracks follow one another.
    """
    cx = ox + circle[0]
    cy = oy + circle[1]
    square = circle[2] * circle[2]
    # a hole lies within its free pixels
    turn = 0.0
    for k in range(cracks):
        turn += (qx[k] - cx) * hx[k] + (qy[k] - cy) * hy[k]
    lost = 0
    last_x = -1.0
    last_y = -1.0
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        outside = (sign > 0.0) == (turn > 0.0)
        for k in range(cracks):
            x = qx[k] + sign * hx[k]
            y = qy[k] + sign * hy[k]
            away = (x - cx) * (x - cx) + (y - cy) * (y - cy)
            if (away > square) != outside and (x != last_x or y != last_y):
                lost += 1
                last_x = x
                last_y = y
    return lost


@njit(**SUMS)
def line_rms(px, py, lo, hi, line):
    """The rms deviation of points lo .. hi - 1 from a line."""
    xs = px[lo:hi]
    ys = py[lo:hi]
    x0 = line[0]
    y0 = line[1]
    ux = line[2]
    uy = line[3]
    total = 0.0
    for k in range(hi - lo):
        d = (xs[k] - x0) * uy - (ys[k] - y0) * ux
        total += d * d
    return math.sqrt(total / (hi - lo))


@njit(**SUMS)
def circle_rms(px, py, lo, hi, circle):
    """The rms deviation of points lo .. hi - 1 from a circle."""
    xs = px[lo:hi]
    ys = py[lo:hi]
    cx = circle[0]
    cy = circle[1]
    r = circle[2]
    total = 0.0
    for k in range(hi - lo):
        x = xs[k] - cx
        y = ys[k] - cy
        d = math.sqrt(x * x + y * y) - r
        total += d * d
    return math.sqrt(total / (hi - lo))


@njit(**SUMS)
def separate_line(px, py, lo, hi, line, near):
    """Turn and shift a line until it passes between the pixels on its two sides.

    In a picture without grey every point is the middle between an obstacle pixel and a free
    one: a line that leaves it by less than half a pixel along the axis keeps both on their
    sides. Least squares on what exceeds that, a few steps from the total-least-squares line;
    ``near`` (2, hi - lo + 1) is room for the points that may matter.
    """
    xs = px[lo:hi]
    ys = py[lo:hi]
    near_x = near[0]
    near_y = near[1]
    x = line[0]
    y = line[1]
    ux = line[2]
    uy = line[3]
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
        w = 0.0
        wt = 0.0
        wtt = 0.0
        b0 = 0.0
        b1 = 0.0
        for i in range(count):
            dx = near_x[i] - x
            dy = near_y[i] - y
            d = dy * ux - dx * uy
            excess = max(abs(d) - limit, 0.0)
            one = 1.0 if excess > 0.0 else 0.0
            excess = -excess if d < 0.0 else excess
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
    """The same for a circle: move and grow it until it passes between the pixels."""
    xs = px[lo:hi]
    ys = py[lo:hi]
    near_x = near[0]
    near_y = near[1]
    cx = circle[0]
    cy = circle[1]
    r = circle[2]
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
        suu = 0.0
        suv = 0.0
        svv = 0.0
        su = 0.0
        sv = 0.0
        s1 = 0.0
        bu = 0.0
        bv = 0.0
        b1 = 0.0
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
        # by cofactors: numba's linear algebra would need scipy on the user's machine
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

"""Lines, arcs and circles through the sub-pixel points of a border, and where they meet.

Rules and units
- Points (k, 2) float64 in pixels (or rectified pixels), y down, border after border, each a
  closed sequence. An index may run past the end of its border once: it wraps.
- ``dead_zone`` is the deviation that costs nothing (the staircase of a picture without grey),
  ``sigma`` the spread of the points about the true edge; a stretch's cost is the sum of
  ((|deviation| - dead_zone) / sigma)^2 over its points plus the price of the edge: a minimum
  description length, which the best partition into lines and arcs minimises.
- What lies within ``guard`` pixels of a corner, where blur rounds the border, takes no part in
  a fit; short stretches keep their middle.
- Lines: total least squares. Circles: Taubin's fit, then Gauss-Newton on the distances
  (N. Chernov, Circular and Linear Regression, 2010).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

LINE, ARC_CW, ARC_CCW = 0, 1, 2
"""Kinds of an edge; the turn as seen on the screen."""
POLYGON, CIRCLE, TINY = 0, 1, 2
"""Kinds of a border; TINY has too few points for a fit."""
LINE_PRICE, ARC_PRICE, CIRCLE_PRICE = 16.0, 22.0, 20.0
"""What an edge costs, in units of sigma squared: more than noise gains by one more break."""
FEWEST = 10
"""Points of the smallest border that is fitted."""
SAMPLES = 24
"""At most about so many points shape a stretch in the search; all of them judge it."""
CRISP_SAMPLES = 192
"""The same in a picture without grey, whose points are off by up to half a pixel."""
NEAR_MISS = 1.6
"""Share of the worst deviation up to which an arc is worth turning between the pixels."""
SPAN = 160
"""At most so many seeds in one stretch."""
ROUNDS = 4
"""Times that edges are fitted, each with the corners of the time before."""
CORNER, CRISP_CORNER = 0.6, 1.2
"""Turn in radians from which a seed is surely a corner; a staircase turns sharply by itself."""
TANGENT_PX = 0.05
CRISP_TANGENT_PX = 0.3
"""By how much two smoothly joined edges may miss or cross each other, noise aside."""
SHALLOW = 0.03
"""Sine of the angle below which two lines are taken for one."""
SNAP = 4
"""Points by which a seed moves to the middle of its corner."""
SMOOTH_SLIDE = 24
"""Points by which a break beside an arc may move to where the fits of both sides are best."""
SLIDE = 8
"""Points by which a break may move towards its corner at a time."""
CHECKS = 6
"""Times that the finished edges are compared with the border."""
HALF = 0.5
"""Along a pixel's axis, how far an edge may leave the middle between two pixels' centres."""
LOST_AXIS_PX = 0.55
"""The same where a pixel counts as lost: a straight edge may pass a staircase so closely."""
MOST_PX = 1.0
"""How far an edge may leave a border without noise: less than the pixel that is promised."""
TIP_PX = 2.5
"""Within this distance of a corner pixels are too coarse to tell where its sides run."""
CALM_LOSS_PX = 0.02
"""Deviation that does not count as area lost."""
LOSS_SHARE, LEAST_LOSS = 0.004, 1.0
"""Area that the edges of a border may lose, as a share of what it encloses, and in pixels."""
SEPARATION_STEPS = 12
SEPARATION_MARGIN = 0.03
"""How much nearer than half a pixel an edge is pulled to the points that it must not leave."""
RAGGED_SHARE = 0.15
"""Area lost per point from which a stretch counts as ragged, where its border loses too much."""
FLATTEST_PX = 1e-3
"""An arc that rises less above its chord is a line."""
CHORD_PX = 0.45
"""How far a chord of a ragged stretch may leave its border points."""
TAU = 2.0 * math.pi
HUGE = 1e18
"""The cost of what may not be."""
BEATEN = 1e12
"""The cost of what is dearer than the best known."""


@njit(cache=True, nogil=True)
def _wrapped(index, n):
    return index - n if index >= n else index


@njit(cache=True, nogil=True)
def fit_line(points, first, n, lo, hi, step, out):
    """Total least squares through points lo, lo + step, .. < hi: out = x, y, ux, uy."""
    count = 0
    sx = 0.0
    sy = 0.0
    ox = points[first + _wrapped(lo, n), 0]
    oy = points[first + _wrapped(lo, n), 1]
    sxx = 0.0
    sxy = 0.0
    syy = 0.0
    for k in range(lo, hi, step):
        p = first + _wrapped(k, n)
        x = points[p, 0] - ox
        y = points[p, 1] - oy
        sx += x
        sy += y
        sxx += x * x
        sxy += x * y
        syy += y * y
        count += 1
    mx = sx / count
    my = sy / count
    a = sxx / count - mx * mx
    b = sxy / count - mx * my
    c = syy / count - my * my
    angle = 0.5 * math.atan2(2.0 * b, a - c)
    ux = math.cos(angle)
    uy = math.sin(angle)
    q = first + _wrapped(hi - 1, n)
    if (points[q, 0] - ox) * ux + (points[q, 1] - oy) * uy < 0.0:
        ux = -ux
        uy = -uy
    out[0] = ox + mx
    out[1] = oy + my
    out[2] = ux
    out[3] = uy


@njit(cache=True, nogil=True)
def fit_circle(points, first, n, lo, hi, step, rounds, out):
    """Taubin's circle through points lo, lo + step, .. < hi, then ``rounds`` of Gauss-Newton.

    out = cx, cy, r; False where the points lie on a line.
    """
    count = 0
    mx = 0.0
    my = 0.0
    for k in range(lo, hi, step):
        p = first + _wrapped(k, n)
        mx += points[p, 0]
        my += points[p, 1]
        count += 1
    mx /= count
    my /= count
    xx = 0.0
    xy = 0.0
    yy = 0.0
    xz = 0.0
    yz = 0.0
    zz = 0.0
    for k in range(lo, hi, step):
        p = first + _wrapped(k, n)
        x = points[p, 0] - mx
        y = points[p, 1] - my
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
        if new == eta or not math.isfinite(new):
            break
        new_value = a0 + new * (a1 + new * (a2 + new * a3))
        if abs(new_value) >= abs(value):
            break
        eta = new
        value = new_value
    det = eta * eta - eta * mz + cov
    if abs(det) < 1e-12 * (mz * mz + 1e-300):
        return False
    cx = (xz * (yy - eta) - yz * xy) / det / 2.0
    cy = (yz * (xx - eta) - xz * xy) / det / 2.0
    r = math.sqrt(cx * cx + cy * cy + mz)
    if not r < 1e6:
        return False
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
        for k in range(lo, hi, step):
            p = first + _wrapped(k, n)
            x = points[p, 0] - mx - cx
            y = points[p, 1] - my - cy
            d = math.sqrt(x * x + y * y)
            if d == 0.0:
                return False
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
        inv = 1.0 / count
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
        if not (abs(dx) + abs(dy) < 0.5 * r):
            break
        cx += dx
        cy += dy
        r += dr
        if abs(dx) + abs(dy) + abs(dr) < 1e-9:
            break
    out[0] = mx + cx
    out[1] = my + cy
    out[2] = r
    return r > 0.0


@njit(cache=True, nogil=True)
def _line_cost(points, first, n, lo, hi, line, crisp, dead_zone, sigma, worst, bound):
    cost = 0.0
    scale = 1.0 / max(abs(line[2]), abs(line[3])) if crisp else 1.0
    for k in range(lo, hi):
        p = first + _wrapped(k, n)
        d = abs((points[p, 0] - line[0]) * line[3] - (points[p, 1] - line[1]) * line[2]) * scale
        if d > worst:
            return HUGE
        if d > dead_zone:
            d = (d - dead_zone) / sigma
            cost += d * d
            if cost > bound:
                return BEATEN
    return cost


@njit(cache=True, nogil=True)
def _circle_cost(points, first, n, lo, hi, circle, crisp, dead_zone, sigma, worst, bound):
    cost = 0.0
    for k in range(lo, hi):
        p = first + _wrapped(k, n)
        x = points[p, 0] - circle[0]
        y = points[p, 1] - circle[1]
        far = math.sqrt(x * x + y * y)
        d = abs(far - circle[2])
        if crisp:
            d *= far / max(abs(x), abs(y), 1e-9)
        if d > worst:
            return HUGE
        if d > dead_zone:
            d = (d - dead_zone) / sigma
            cost += d * d
            if cost > bound:
                return BEATEN
    return cost


@njit(cache=True, nogil=True)
def _trim(lo, hi, guard):
    """How many points to leave out at each end of a stretch."""
    length = hi - lo
    if length >= 3 * guard + 4:
        return guard
    if length >= 6:
        return min(guard, (length - 3) // 3)
    return 0


@njit(cache=True, nogil=True)
def _stretch(points, first, n, lo, hi, guard, crisp, dead_zone, sigma, worst, bound, line, circle):
    """The cheaper of a line and an arc through points lo .. hi: (cost, is_arc)."""
    g = _trim(lo, hi, guard)
    a = lo + g
    b = hi - g + 1
    count = b - a
    step = max(1, count // (CRISP_SAMPLES if crisp else SAMPLES))
    fit_line(points, first, n, a, b, step, line)
    line_cost = LINE_PRICE + _line_cost(
        points, first, n, a, b, line, crisp, dead_zone, sigma, worst, bound - LINE_PRICE
    )
    if count < 6 or line_cost < ARC_PRICE:
        return line_cost, False
    arc_cost = HUGE
    if fit_circle(points, first, n, a, b, step, 0, circle):
        arc_cost = ARC_PRICE + _circle_cost(
            points, first, n, a, b, circle, crisp, dead_zone, sigma, worst, bound - ARC_PRICE
        )
        if (crisp and ARC_PRICE < arc_cost < HUGE) or (
            crisp
            and arc_cost >= HUGE
            and _circle_cost(
                points, first, n, a, b, circle, crisp, dead_zone, sigma, NEAR_MISS * worst, HUGE
            )
            < HUGE
        ):
            # the staircase alone may have turned the fit: let it pass between the pixels
            _separate_circle(points, first, n, a, b, circle)
            arc_cost = ARC_PRICE + _circle_cost(
                points, first, n, a, b, circle, crisp, dead_zone, sigma, worst, bound - ARC_PRICE
            )
    if arc_cost < line_cost:
        return arc_cost, True
    return line_cost, False


@njit(cache=True, nogil=True)
def seed_breaks(points, first, n, tolerance, is_seed):
    """Mark generous breaks: split at the farthest point until chords lie within tolerance."""
    for k in range(n):
        is_seed[k] = False
    mx = 0.0
    my = 0.0
    for k in range(n):
        mx += points[first + k, 0]
        my += points[first + k, 1]
    mx /= n
    my /= n
    best = -1.0
    start = 0
    for k in range(n):
        d = (points[first + k, 0] - mx) ** 2 + (points[first + k, 1] - my) ** 2
        if d > best:
            best = d
            start = k
    best = -1.0
    other = 0
    for k in range(n):
        d = (points[first + k, 0] - points[first + start, 0]) ** 2 + (
            points[first + k, 1] - points[first + start, 1]
        ) ** 2
        if d > best:
            best = d
            other = k
    is_seed[start] = True
    is_seed[other] = True
    if other < start:
        start, other = other, start
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
        p = first + _wrapped(lo, n)
        q = first + _wrapped(hi, n)
        dx = points[q, 0] - points[p, 0]
        dy = points[q, 1] - points[p, 1]
        length = math.sqrt(dx * dx + dy * dy)
        far = -1.0
        where = lo
        for k in range(lo + 1, hi):
            i = first + _wrapped(k, n)
            x = points[i, 0] - points[p, 0]
            y = points[i, 1] - points[p, 1]
            d = math.sqrt(x * x + y * y) if length < 1e-9 else abs(x * dy - y * dx) / length
            if d > far:
                far = d
                where = k
        if far <= tolerance:
            continue
        is_seed[_wrapped(where, n)] = True
        if top + 2 > stack.shape[0]:
            bigger = np.empty((2 * stack.shape[0], 2), np.int64)
            bigger[:top] = stack[:top]
            stack = bigger
        stack[top, 0] = lo
        stack[top, 1] = where
        stack[top + 1, 0] = where
        stack[top + 1, 1] = hi
        top += 2


@njit(cache=True, nogil=True)
def _bulge(points, first, n, k, reach):
    """How far point k lies from the chord of its neighbours ``reach`` points away."""
    p = first + (k - reach) % n
    c = first + k % n
    q = first + (k + reach) % n
    dx = points[q, 0] - points[p, 0]
    dy = points[q, 1] - points[p, 1]
    length = math.sqrt(dx * dx + dy * dy)
    if length < 1e-9:
        return 0.0
    return abs((points[c, 0] - points[p, 0]) * dy - (points[c, 1] - points[p, 1]) * dx) / length


@njit(cache=True, nogil=True)
def _snap_seeds(points, first, n, seeds, m, reach):
    """Move every seed to where the border bulges most nearby, short of the next seeds."""
    reach = min(reach, n // 4)
    if reach < 2:
        return
    last = -1
    for s in range(m):
        after = seeds[s + 1] if s + 1 < m else seeds[0] + n
        before = last if s > 0 else seeds[m - 1] - n
        lo = max(seeds[s] - SNAP, before + 1, (seeds[s] + before) // 2, 0)
        hi = min(seeds[s] + SNAP, (seeds[s] + after) // 2, n - 1)
        best = -1.0
        where = seeds[s]
        for k in range(lo, hi + 1):
            bulge = _bulge(points, first, n, k, reach)
            if bulge > best:
                best = bulge
                where = k
        last = where
        seeds[s] = where


@njit(cache=True, nogil=True)
def _turn_at(points, first, n, k, reach):
    """How sharply the border turns at point k, in radians."""
    reach = min(reach, n // 4)
    p = first + (k - reach) % n
    c = first + k % n
    q = first + (k + reach) % n
    ax = points[c, 0] - points[p, 0]
    ay = points[c, 1] - points[p, 1]
    bx = points[q, 0] - points[c, 0]
    by = points[q, 1] - points[c, 1]
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))


@njit(cache=True, nogil=True)
def best_partition(
    points, first, n, seeds, m, start, guard, crisp, dead_zone, sigma, worst, breaks, is_arc
):
    """The cheapest partition of a closed border into lines and arcs that break at seeds.

    ``seeds`` holds m ascending indices; the first break is seed number ``start``. Fills
    ``breaks`` (in order along the border, starting there) and ``is_arc``; returns the number
    of edges and the cost. Dynamic programming; stretches that fail are not extended far.
    """
    best = np.full(m + 1, HUGE * 4.0)
    came = np.zeros(m + 1, np.int64)
    arc = np.zeros(m + 1, np.bool_)
    line = np.empty(4, np.float64)
    circle = np.empty(3, np.float64)
    position = np.empty(m + 1, np.int64)
    for t in range(m + 1):
        s = start + t
        position[t] = seeds[s] if s < m else seeds[s - m] + n
    base = position[0]
    wrap = 0
    if base >= n:
        wrap = n
    for t in range(m + 1):
        position[t] -= wrap
    best[0] = 0.0
    for i in range(m):
        failed = 0
        for j in range(i + 1, min(m, i + SPAN) + 1):
            if i == 0 and j == m:
                break
            lo = position[i]
            hi = position[j]
            if lo >= n:
                lo -= n
                hi -= n
            cost, bent = _stretch(
                points,
                first,
                n,
                lo,
                hi,
                guard,
                crisp,
                dead_zone,
                sigma,
                worst,
                best[j] - best[i],
                line,
                circle,
            )
            if cost >= HUGE:
                if j == i + 1:
                    cost = 4.0 * LINE_PRICE
                    bent = False
                else:
                    failed += 1
                    if failed >= 3:
                        break
                    continue
            if best[i] + cost < best[j]:
                best[j] = best[i] + cost
                came[j] = i
                arc[j] = bent
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
        breaks[e] = position[j] % n
    return edges, best[m]


@njit(cache=True, nogil=True)
def _separate_line(points, first, n, lo, hi, line):
    """Turn and shift a line until it passes between the pixels on its two sides.

    In a picture without grey every point is the middle between an obstacle pixel and a free
    one: a line that leaves it by less than half a pixel along the axis keeps both on their
    sides. Least squares on what exceeds that, a few steps from the total-least-squares line.
    """
    for _ in range(SEPARATION_STEPS):
        limit = (HALF - SEPARATION_MARGIN) * max(abs(line[2]), abs(line[3]))
        w = 0.0
        wt = 0.0
        wtt = 0.0
        b0 = 0.0
        b1 = 0.0
        for k in range(lo, hi):
            p = first + _wrapped(k, n)
            dx = points[p, 0] - line[0]
            dy = points[p, 1] - line[1]
            d = dy * line[2] - dx * line[3]
            excess = abs(d) - limit
            if excess <= 0.0:
                continue
            t = dx * line[2] + dy * line[3]
            if d < 0.0:
                excess = -excess
            w += 1.0
            wt += t
            wtt += t * t
            b0 += excess
            b1 += excess * t
        if w == 0.0:
            return
        # damped: one point alone must not turn the line
        half = 0.5 * (hi - lo)
        a00 = w + 0.5
        a11 = wtt + 0.15 * half * half
        det = a00 * a11 - wt * wt
        shift = (b0 * a11 - b1 * wt) / det
        turn = (b1 * a00 - b0 * wt) / det
        line[0] -= shift * line[3]
        line[1] += shift * line[2]
        ux = line[2] - turn * line[3]
        uy = line[3] + turn * line[2]
        length = math.sqrt(ux * ux + uy * uy)
        line[2] = ux / length
        line[3] = uy / length


@njit(cache=True, nogil=True)
def _separate_circle(points, first, n, lo, hi, circle):
    """The same for a circle: move and grow it until it passes between the pixels."""
    for _ in range(SEPARATION_STEPS):
        m = np.zeros((3, 3))
        v = np.zeros(3)
        count = 0
        for k in range(lo, hi):
            p = first + _wrapped(k, n)
            dx = points[p, 0] - circle[0]
            dy = points[p, 1] - circle[1]
            far = math.sqrt(dx * dx + dy * dy)
            if far < 1e-9:
                return
            ux = dx / far
            uy = dy / far
            d = far - circle[2]
            excess = abs(d) - (HALF - SEPARATION_MARGIN) * max(abs(ux), abs(uy))
            if excess <= 0.0:
                continue
            if d < 0.0:
                excess = -excess
            count += 1
            m[0, 0] += ux * ux
            m[0, 1] += ux * uy
            m[0, 2] += ux
            m[1, 1] += uy * uy
            m[1, 2] += uy
            m[2, 2] += 1.0
            v[0] += ux * excess
            v[1] += uy * excess
            v[2] += excess
        if count == 0:
            return
        for i in range(3):
            m[i, i] += 0.5
        # by cofactors: numba's linear algebra would need scipy on the user's machine
        c0 = m[1, 1] * m[2, 2] - m[1, 2] * m[1, 2]
        c1 = m[0, 2] * m[1, 2] - m[0, 1] * m[2, 2]
        c2 = m[0, 1] * m[1, 2] - m[0, 2] * m[1, 1]
        c3 = m[0, 0] * m[2, 2] - m[0, 2] * m[0, 2]
        c4 = m[0, 1] * m[0, 2] - m[0, 0] * m[1, 2]
        c5 = m[0, 0] * m[1, 1] - m[0, 1] * m[0, 1]
        det = m[0, 0] * c0 + m[0, 1] * c1 + m[0, 2] * c2
        circle[0] += (c0 * v[0] + c1 * v[1] + c2 * v[2]) / det
        circle[1] += (c1 * v[0] + c3 * v[1] + c4 * v[2]) / det
        circle[2] += (c2 * v[0] + c4 * v[1] + c5 * v[2]) / det


@njit(cache=True, nogil=True)
def _clear_of_joints(points, first, n, lo, hi, joints, e, after, guard):
    """The part of a stretch that keeps ``guard`` pixels from both joints, or its middle."""
    length = hi - lo
    least = max(3, (2 * length) // 5)
    a = lo
    b = hi
    near = guard * guard
    while b - a > least:
        p = first + _wrapped(a, n)
        d = (points[p, 0] - joints[e, 0]) ** 2 + (points[p, 1] - joints[e, 1]) ** 2
        q = first + _wrapped(b, n)
        f = (points[q, 0] - joints[after, 0]) ** 2 + (points[q, 1] - joints[after, 1]) ** 2
        if d >= near and f >= near:
            break
        if d < near:
            a += 1
        if f < near:
            b -= 1
    return a, b + 1


@njit(cache=True, nogil=True)
def _fit_edges(points, first, n, breaks, is_arc, edges, crisp, guard, joints, shape):
    """Fit every edge between its breaks; shape rows: x, y, ux, uy or cx, cy, r, rms last."""
    for e in range(edges):
        lo = breaks[e]
        hi = breaks[(e + 1) % edges]
        if hi <= lo:
            hi += n
        a, b = _clear_of_joints(points, first, n, lo, hi, joints, e, (e + 1) % edges, guard)
        row = shape[e]
        if is_arc[e] and not (b - a >= 5 and fit_circle(points, first, n, a, b, 1, 8, row)):
            is_arc[e] = False
        total = 0.0
        if is_arc[e]:
            if crisp:
                _separate_circle(points, first, n, a, b, row)
            for k in range(a, b):
                p = first + _wrapped(k, n)
                d = math.sqrt((points[p, 0] - row[0]) ** 2 + (points[p, 1] - row[1]) ** 2) - row[2]
                total += d * d
        else:
            fit_line(points, first, n, a, b, 1, row)
            if crisp:
                _separate_line(points, first, n, a, b, row)
            for k in range(a, b):
                p = first + _wrapped(k, n)
                d = (points[p, 0] - row[0]) * row[3] - (points[p, 1] - row[1]) * row[2]
                total += d * d
        row[4] = math.sqrt(total / (b - a))


@njit(cache=True, nogil=True)
def _onto(shape_row, is_arc, x, y):
    """The point of a fitted line or circle nearest to (x, y)."""
    if is_arc:
        dx = x - shape_row[0]
        dy = y - shape_row[1]
        d = math.sqrt(dx * dx + dy * dy)
        if d == 0.0:
            return x, y
        return shape_row[0] + dx * shape_row[2] / d, shape_row[1] + dy * shape_row[2] / d
    t = (x - shape_row[0]) * shape_row[2] + (y - shape_row[1]) * shape_row[3]
    return shape_row[0] + t * shape_row[2], shape_row[1] + t * shape_row[3]


@njit(cache=True, nogil=True)
def _crossing(a, a_arc, b, b_arc, x, y, out):
    """The crossing of two neighbouring edges nearest to (x, y); False where there is none.

    out = x, y and half the sine of the angle between the edges, as a share of the rounding.
    """
    if not a_arc and not b_arc:
        cross = a[2] * b[3] - a[3] * b[2]
        if abs(cross) < SHALLOW:
            return False
        t = ((b[0] - a[0]) * b[3] - (b[1] - a[1]) * b[2]) / cross
        out[0] = a[0] + t * a[2]
        out[1] = a[1] + t * a[3]
        # sine of half the corner's inner angle: a narrow tip is rounded far back
        out[2] = math.sqrt(max(0.5 * (1.0 + a[2] * b[2] + a[3] * b[3]), 0.0))
        return True
    out[2] = 1.0
    if a_arc and b_arc:
        dx = b[0] - a[0]
        dy = b[1] - a[1]
        d = math.sqrt(dx * dx + dy * dy)
        if d < 1e-9:
            return False
        along = (d * d + a[2] * a[2] - b[2] * b[2]) / (2.0 * d)
        base_x = a[0] + along * dx / d
        base_y = a[1] + along * dy / d
        off2 = a[2] * a[2] - along * along
        off_x = -dy / d
        off_y = dx / d
    else:
        line = b if a_arc else a
        arc = a if a_arc else b
        t = (arc[0] - line[0]) * line[2] + (arc[1] - line[1]) * line[3]
        base_x = line[0] + t * line[2]
        base_y = line[1] + t * line[3]
        off2 = arc[2] * arc[2] - (arc[0] - base_x) ** 2 - (arc[1] - base_y) ** 2
        off_x = line[2]
        off_y = line[3]
    if off2 < 0.0:
        return False
    off = math.sqrt(off2)
    if (x - base_x) * off_x + (y - base_y) * off_y < 0.0:
        off = -off
    out[0] = base_x + off * off_x
    out[1] = base_y + off * off_y
    return True


@njit(cache=True, nogil=True)
def _touch(a, a_arc, b, b_arc, out):
    """Where an arc and its neighbour come nearest; out = x, y and the gap (crossing: negative).

    Two arcs touch from outside or from inside, whichever leaves the smaller gap. A crossing's
    position is ill-defined where edges are nearly tangent; the point of contact is not.
    """
    if a_arc and b_arc:
        dx = b[0] - a[0]
        dy = b[1] - a[1]
        d = math.sqrt(dx * dx + dy * dy)
        if d < 1e-9:
            return False
        # on the line of centres, the points of both circles
        outside = d - a[2] - b[2]
        inside = d - abs(a[2] - b[2])
        ta = a[2]
        tb = d - b[2]
        gap = outside
        if abs(inside) < abs(outside):
            if a[2] >= b[2]:
                tb = d + b[2]
            else:
                ta = -a[2]
            gap = -inside
        t = 0.5 * (ta + tb) / d
        out[0] = a[0] + t * dx
        out[1] = a[1] + t * dy
        out[2] = gap
        return True
    line = b if a_arc else a
    arc = a if a_arc else b
    t = (arc[0] - line[0]) * line[2] + (arc[1] - line[1]) * line[3]
    foot_x = line[0] + t * line[2]
    foot_y = line[1] + t * line[3]
    dx = foot_x - arc[0]
    dy = foot_y - arc[1]
    d = math.sqrt(dx * dx + dy * dy)
    if d < 1e-9:
        return False
    share = 0.5 * (1.0 + arc[2] / d)
    out[0] = arc[0] + share * dx
    out[1] = arc[1] + share * dy
    out[2] = d - arc[2]
    return True


@njit(cache=True, nogil=True)
def _nearest_point(points, first, n, middle, before, after, x, y):
    """The border point nearest to (x, y) from ``before`` points ahead of ``middle`` to after."""
    best = HUGE
    where = middle
    for k in range(-before, after + 1):
        i = (middle + k) % n
        d = (points[first + i, 0] - x) ** 2 + (points[first + i, 1] - y) ** 2
        if d < best:
            best = d
            where = i
    return where, math.sqrt(best)


@njit(cache=True, nogil=True)
def _deviation(row, is_arc, x, y):
    dx = x - row[0]
    dy = y - row[1]
    if is_arc:
        return abs(math.sqrt(dx * dx + dy * dy) - row[2])
    return abs(dx * row[3] - dy * row[2])


@njit(cache=True, nogil=True)
def _best_split(points, first, n, a, a_arc, b, b_arc, middle, before, after):
    """Where a border changes from edge a to edge b: the split with the least squares."""
    total = 0.0
    best = 0.0
    where = -before
    for k in range(-before, after):
        p = first + (middle + k) % n
        da = _deviation(a, a_arc, points[p, 0], points[p, 1])
        db = _deviation(b, b_arc, points[p, 0], points[p, 1])
        total += da * da - db * db
        if total < best:
            best = total
            where = k + 1
    return (middle + where) % n


@njit(cache=True, nogil=True)
def _join(points, first, n, breaks, is_arc, edges, shape, blur, tangent, joints):
    """Where neighbouring edges meet; breaks move to the border points nearest to that.

    A crossing is believed where the border comes as near to it as blur and the corner's
    angle let it; edges that do not cross, or hardly, meet half-way between them.
    """
    found = np.empty(3, np.float64)
    moved = np.empty(edges, np.int64)
    for e in range(edges):
        before = (e - 1) % edges
        a = shape[before]
        b = shape[e]
        a_arc = is_arc[before]
        b_arc = is_arc[e]
        here = breaks[e]
        if a_arc or b_arc:
            here = _best_split(
                points, first, n, a, a_arc, b, b_arc, here,
                min(SMOOTH_SLIDE, max((here - breaks[before]) % n - 1, 0) // 2),
                min(SMOOTH_SLIDE, max((breaks[(e + 1) % edges] - here) % n - 1, 0) // 2),
            )  # fmt: skip
        x = points[first + here, 0]
        y = points[first + here, 1]
        room_before = (here - breaks[before]) % n
        room_after = (breaks[(e + 1) % edges] - here) % n
        back = min(SLIDE, max(room_before - 1, 0) // 2)
        ahead = min(SLIDE, max(room_after - 1, 0) // 2)
        moved[e] = here
        if (a_arc or b_arc) and _touch(a, a_arc, b, b_arc, found) and abs(found[2]) <= tangent:
            where, distance = _nearest_point(
                points, first, n, here,
                min(SMOOTH_SLIDE, max(room_before - 1, 0) // 2),
                min(SMOOTH_SLIDE, max(room_after - 1, 0) // 2),
                found[0], found[1],
            )  # fmt: skip
            if distance <= 1.0:
                joints[e, 0] = found[0]
                joints[e, 1] = found[1]
                moved[e] = where
                continue
        if _crossing(a, a_arc, b, b_arc, x, y, found):
            where, distance = _nearest_point(
                points, first, n, here, back, ahead, found[0], found[1]
            )
            if distance <= 0.5 + (0.3 + blur) / max(found[2], 0.1):
                joints[e, 0] = found[0]
                joints[e, 1] = found[1]
                moved[e] = where
                continue
        ax, ay = _onto(a, a_arc, x, y)
        bx, by = _onto(b, b_arc, x, y)
        joints[e, 0] = 0.5 * (ax + bx)
        joints[e, 1] = 0.5 * (ay + by)
        if (joints[e, 0] - x) ** 2 + (joints[e, 1] - y) ** 2 > 1.0:
            joints[e, 0] = x
            joints[e, 1] = y
    for e in range(edges):
        breaks[e] = moved[e]


@njit(cache=True, nogil=True)
def _through_ends(row, x0, y0, x1, y1, ccw, radius_out):
    """The circle through both ends that keeps the fitted arc's middle; cx, cy, r.

    The middle lies where the fitted circle meets the chord's bisector on the arc's side.
    """
    cx = row[0]
    cy = row[1]
    r = row[2]
    mx = 0.5 * (x0 + x1)
    my = 0.5 * (y0 + y1)
    dx = x1 - x0
    dy = y1 - y0
    chord = math.sqrt(dx * dx + dy * dy)
    if chord < 1e-9:
        radius_out[0] = cx
        radius_out[1] = cy
        radius_out[2] = math.sqrt((x0 - cx) ** 2 + (y0 - cy) ** 2)
        return
    # clockwise on the screen (y down): the arc bulges to the left of its chord, which is
    # the direction (dy, -dx)
    side = -1.0 if ccw else 1.0
    nx = side * dy / chord
    ny = -side * dx / chord
    # signed distance of the centre from the chord towards the bulge
    c = (cx - mx) * nx + (cy - my) * ny
    sag = c + r
    if sag < 1e-9:
        sag = 1e-9
    half = 0.5 * chord
    new_r = (half * half + sag * sag) / (2.0 * sag)
    radius_out[0] = mx + nx * (sag - new_r)
    radius_out[1] = my + ny * (sag - new_r)
    radius_out[2] = new_r


@njit(cache=True, nogil=True)
def _is_ccw(points, first, n, lo, hi, cx, cy):
    """Whether the border runs counter-clockwise as seen on the screen about (cx, cy)."""
    total = 0.0
    for k in range(lo, hi):
        p = first + _wrapped(k, n)
        q = first + _wrapped(k + 1, n)
        total += (points[p, 0] - cx) * (points[q, 1] - cy) - (points[p, 1] - cy) * (
            points[q, 0] - cx
        )
    return total < 0.0


@njit(cache=True, nogil=True)
def _distance_to_edge(kind, row, x1, y1, x, y, out):
    """Distance from (x, y) to a finished edge that ends at (x1, y1); out = the foot."""
    x0 = row[0]
    y0 = row[1]
    if kind != LINE:
        dx = x - row[2]
        dy = y - row[3]
        d = math.sqrt(dx * dx + dy * dy)
        if d > 0.0:
            begin = math.atan2(y0 - row[3], x0 - row[2])
            end = math.atan2(y1 - row[3], x1 - row[2])
            here = math.atan2(dy, dx)
            # y down: the angle grows along an arc that is clockwise on the screen
            if kind == ARC_CW:
                sweep = (end - begin) % TAU
                turn = (here - begin) % TAU
            else:
                sweep = (begin - end) % TAU
                turn = (begin - here) % TAU
            if turn <= sweep:
                out[0] = row[2] + dx * row[4] / d
                out[1] = row[3] + dy * row[4] / d
                return abs(d - row[4])
        near0 = math.sqrt((x - x0) ** 2 + (y - y0) ** 2)
        near1 = math.sqrt((x - x1) ** 2 + (y - y1) ** 2)
        out[0] = x0 if near0 < near1 else x1
        out[1] = y0 if near0 < near1 else y1
        return min(near0, near1)
    dx = x1 - x0
    dy = y1 - y0
    square = dx * dx + dy * dy
    t = 0.0
    if square > 0.0:
        t = min(max(((x - x0) * dx + (y - y0) * dy) / square, 0.0), 1.0)
    out[0] = x0 + t * dx
    out[1] = y0 + t * dy
    return math.sqrt((x - out[0]) ** 2 + (y - out[1]) ** 2)


@njit(cache=True, nogil=True)
def _finish_edge(points, first, n, lo, hi, bent, shape_row, x0, y0, x1, y1, row, circle):
    """Write an edge between its joints into ``row``; returns its kind."""
    row[0] = x0
    row[1] = y0
    row[2] = 0.0
    row[3] = 0.0
    row[4] = 0.0
    row[5] = shape_row[4]
    if not bent:
        return LINE
    ccw = _is_ccw(points, first, n, lo, hi, shape_row[0], shape_row[1])
    _through_ends(shape_row, x0, y0, x1, y1, ccw, circle)
    chord = math.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2)
    if chord < FLATTEST_PX or circle[2] * FLATTEST_PX > 0.125 * chord * chord:
        return LINE
    row[2] = circle[0]
    row[3] = circle[1]
    row[4] = circle[2]
    return ARC_CCW if ccw else ARC_CW


@njit(cache=True, nogil=True)
def _loss(points, first, n, lo, hi, e, edges, kinds, rows, crisp, free, guard, foot):
    """What a finished edge misses of its stretch: ``(worst deviation, area lost)``.

    A point may lie at a neighbouring edge, which the joint may have lengthened; what blur
    rounds within ``guard`` of a joint does not count. In a picture without grey a deviation
    below ``LOST_AXIS_PX`` along the axis loses nothing, beyond it a pixel; otherwise what exceeds
    ``free`` is lost.
    """
    next_ = (e + 1) % edges
    near = max(guard, TIP_PX) ** 2
    worst = 0.0
    lost = 0.0
    for k in range(lo, hi + 1):
        p = first + _wrapped(k, n)
        x = points[p, 0]
        y = points[p, 1]
        if (x - rows[e, 0]) ** 2 + (y - rows[e, 1]) ** 2 < near or (x - rows[next_, 0]) ** 2 + (
            y - rows[next_, 1]
        ) ** 2 < near:
            continue
        best = HUGE
        axis = 1.0
        for neighbour in range(3):
            if neighbour == 1 and best < 0.5:
                break
            i = (e, (e - 1) % edges, (e + 1) % edges)[neighbour]
            j = (i + 1) % edges
            d = _distance_to_edge(kinds[i], rows[i], rows[j, 0], rows[j, 1], x, y, foot)
            if d < best:
                best = d
                if d > 1e-9:
                    axis = max(abs(x - foot[0]), abs(y - foot[1])) / d
        worst = max(worst, best)
        if crisp:
            if best > LOST_AXIS_PX * axis:
                lost += 1.0
        elif best > free:
            lost += best - free
    return worst, lost


@njit(cache=True, nogil=True)
def _arc_length(kind, row, x1, y1):
    begin = math.atan2(row[1] - row[3], row[0] - row[2])
    end = math.atan2(y1 - row[3], x1 - row[2])
    sweep = (end - begin) % TAU if kind == ARC_CW else (begin - end) % TAU
    return sweep * row[4]


@njit(cache=True, nogil=True)
def fit_borders(points, point_starts, areas, crisp, dead_zone, sigma, spread, blur, guard):
    """Lines, arcs and circles of every border.

    ``areas`` (b,): the pixels that each border encloses, holes negative; ``crisp``: a picture
    without grey; ``spread``: what noise does to a point. Returns ``(border_kind, edge_starts,
    kind, data)``: per border POLYGON, CIRCLE or TINY and its first edge; per edge LINE, ARC_CW
    or ARC_CCW and data (k, 6): the edge's first point x, y, then cx, cy, r of an arc, and the
    rms deviation. A circle is one edge of kind LINE with its centre and radius in the data.
    TINY borders have no edges.
    """
    borders = point_starts.shape[0] - 1
    longest = 0
    for b in range(borders):
        longest = max(longest, point_starts[b + 1] - point_starts[b])
    room = points.shape[0] + borders
    border_kind = np.empty(borders, np.int8)
    edge_starts = np.empty(borders + 1, np.int64)
    kind = np.empty(room, np.int8)
    data = np.empty((room, 6), np.float64)
    is_seed = np.empty(longest, np.bool_)
    seeds = np.empty(longest, np.int64)
    breaks = np.empty(longest + 1, np.int64)
    is_arc = np.empty(longest + 1, np.bool_)
    ragged = np.empty(longest + 1, np.bool_)
    losses = np.empty(longest + 1, np.float64)
    shape = np.empty((longest + 1, 5), np.float64)
    joints = np.empty((longest + 1, 2), np.float64)
    kinds = np.empty(longest + 1, np.int8)
    rows = np.empty((longest + 1, 6), np.float64)
    circle = np.empty(3, np.float64)
    foot = np.empty(2, np.float64)
    worst = dead_zone + 0.12 if crisp else 0.35 + dead_zone + 4.5 * sigma
    allowed = MOST_PX + 4.5 * spread
    free = CALM_LOSS_PX + 2.0 * spread
    skip = math.ceil(guard)
    tangent = CRISP_TANGENT_PX if crisp else TANGENT_PX + spread
    seed_tolerance = 0.9 if crisp else 0.35 + dead_zone + 2.5 * sigma
    count = 0
    for b in range(borders):
        first = point_starts[b]
        n = point_starts[b + 1] - first
        edge_starts[b] = count
        if n < FEWEST:
            border_kind[b] = TINY
            continue
        circle_cost = HUGE
        # a sample tells most other shapes from a circle
        rough = max(1, n // 64)
        if (
            fit_circle(points, first, n, 0, n, rough, 1, circle)
            and _circle_cost(
                points, first, n, 0, n, circle, crisp, dead_zone, sigma, 2.0 * worst, HUGE
            )
            < HUGE
            and fit_circle(points, first, n, 0, n, 1, 8, circle)
        ):
            circle_cost = CIRCLE_PRICE + _circle_cost(
                points, first, n, 0, n, circle, crisp, dead_zone, sigma, worst, HUGE
            )
        edges = 0
        if circle_cost > 3.0 * LINE_PRICE:
            edges, cost = _partition(
                points, first, n, skip, crisp, dead_zone, sigma, worst, seed_tolerance,
                is_seed, seeds, breaks, is_arc,
            )  # fmt: skip
            if circle_cost <= cost:
                edges = 0
        if edges == 0:
            border_kind[b] = CIRCLE
            if crisp:
                _separate_circle(points, first, n, 0, n, circle)
            total = 0.0
            for k in range(n):
                d = (
                    math.sqrt(
                        (points[first + k, 0] - circle[0]) ** 2
                        + (points[first + k, 1] - circle[1]) ** 2
                    )
                    - circle[2]
                )
                total += d * d
            kind[count] = LINE
            data[count, 0] = circle[0] - circle[2]
            data[count, 1] = circle[1]
            data[count, 2] = circle[0]
            data[count, 3] = circle[1]
            data[count, 4] = circle[2]
            data[count, 5] = math.sqrt(total / n)
            count += 1
            continue
        border_kind[b] = POLYGON
        for e in range(edges):
            joints[e, 0] = points[first + breaks[e], 0]
            joints[e, 1] = points[first + breaks[e], 1]
            ragged[e] = False
        for _ in range(ROUNDS):
            _fit_edges(points, first, n, breaks, is_arc, edges, crisp, guard, joints, shape)
            _join(points, first, n, breaks, is_arc, edges, shape, blur, tangent, joints)
        budget = max(LOSS_SHARE * abs(areas[b]), LEAST_LOSS)
        _check_edges(
            points, first, n, breaks, is_arc, edges, shape, joints, crisp, free, allowed, guard,
            budget, ragged, losses, kinds, rows, circle, foot,
        )  # fmt: skip
        for e in range(edges):
            if not ragged[e]:
                kind[count] = kinds[e]
                data[count] = rows[e]
                count += 1
                continue
            lo = breaks[e]
            hi = breaks[(e + 1) % edges]
            if hi <= lo:
                hi += n
            m = _chords(points, first, n, lo, hi, CHORD_PX + 2.0 * spread, is_seed, seeds)
            for t in range(m):
                p = first + _wrapped(seeds[t], n)
                kind[count] = LINE
                data[count] = 0.0
                data[count, 0] = joints[e, 0] if t == 0 else points[p, 0]
                data[count, 1] = joints[e, 1] if t == 0 else points[p, 1]
                data[count, 5] = 0.5 * CHORD_PX
                count += 1
        bent = False
        for i in range(edge_starts[b], count):
            bent = bent or kind[i] != LINE
        if count - edge_starts[b] < 3 and not bent:
            # two lines enclose nothing: so small a border is its pixels' outline
            border_kind[b] = TINY
            count = edge_starts[b]
    edge_starts[borders] = count
    return border_kind, edge_starts, kind[:count].copy(), data[:count].copy()


@njit(cache=True, nogil=True)
def _partition(
    points, first, n, skip, crisp, dead_zone, sigma, worst, tolerance,
    is_seed, seeds, breaks, is_arc,
):  # fmt: skip
    """Seeds, then the cheapest partition that breaks at some of them: (edges, cost)."""
    seed_breaks(points, first, n, tolerance, is_seed)
    m = 0
    for k in range(n):
        if is_seed[k]:
            seeds[m] = k
            m += 1
    _snap_seeds(points, first, n, seeds, m, skip + 4)
    sharpest = -1.0
    start = 0
    for t in range(m):
        turn = _turn_at(points, first, n, seeds[t], 6)
        if turn > sharpest:
            sharpest = turn
            start = t
    edges = 0
    cost = HUGE
    sharp = CRISP_CORNER if crisp else CORNER
    for _ in range(2):
        edges, cost = best_partition(
            points, first, n, seeds, m, start, skip, crisp, dead_zone, sigma, worst, breaks, is_arc
        )
        if sharpest >= sharp or edges < 2:
            break
        # no corner to begin at: begin again at a break that the search found
        sharpest = sharp
        again = breaks[edges // 2]
        for t in range(m):
            if seeds[t] == again:
                start = t
    return edges, cost


@njit(cache=True, nogil=True)
def _check_edges(
    points, first, n, breaks, is_arc, edges, shape, joints, crisp, free, allowed, guard,
    budget, ragged, losses, kinds, rows, circle, foot,
):  # fmt: skip
    """Finish the edges, and mark as ragged what would not cover the border well enough.

    A ragged edge ends at border points; that moves its neighbours' ends, so the check is
    repeated until nothing changes.
    """
    for _ in range(CHECKS):
        _finish_all(points, first, n, breaks, is_arc, edges, shape, joints, kinds, rows, circle)
        changed = False
        total = 0.0
        for e in range(edges):
            losses[e] = 0.0
            if ragged[e]:
                continue
            after = (e + 1) % edges
            lo = breaks[e]
            hi = breaks[after]
            if hi <= lo:
                hi += n
            farthest, losses[e] = _loss(
                points, first, n, lo, hi, e, edges, kinds, rows, crisp, free, guard, foot
            )
            total += losses[e]
            bad = farthest > allowed
            if kinds[e] != LINE:
                longest = 2.0 * (hi - lo) + 4.0
                bad = (
                    bad or _arc_length(kinds[e], rows[e], rows[after, 0], rows[after, 1]) > longest
                )
            if bad:
                ragged[e] = True
                changed = True
        while total > budget:
            worst = 0
            densest = 0.0
            for e in range(edges):
                length = (breaks[(e + 1) % edges] - breaks[e]) % n
                density = losses[e] / max(length, 4)
                if density > densest:
                    densest = density
                    worst = e
            if densest < RAGGED_SHARE:
                break
            changed = True
            total -= losses[worst]
            losses[worst] = 0.0
            ragged[worst] = True
        if not changed:
            break
        for e in range(edges):
            if ragged[e]:
                for end in (e, (e + 1) % edges):
                    x = points[first + breaks[end], 0]
                    y = points[first + breaks[end], 1]
                    joints[end, 0] = x
                    joints[end, 1] = y
                    other = (e - 1) % edges if end == e else end
                    if not ragged[other]:
                        # the neighbour stays where its fit is
                        px, py = _onto(shape[other], is_arc[other], x, y)
                        if (px - x) ** 2 + (py - y) ** 2 < 1.0:
                            joints[end, 0] = px
                            joints[end, 1] = py
    _finish_all(points, first, n, breaks, is_arc, edges, shape, joints, kinds, rows, circle)


@njit(cache=True, nogil=True)
def _finish_all(points, first, n, breaks, is_arc, edges, shape, joints, kinds, rows, circle):
    for e in range(edges):
        after = (e + 1) % edges
        lo = breaks[e]
        hi = breaks[after]
        if hi <= lo:
            hi += n
        kinds[e] = _finish_edge(
            points, first, n, lo, hi, is_arc[e], shape[e],
            joints[e, 0], joints[e, 1], joints[after, 0], joints[after, 1], rows[e], circle,
        )  # fmt: skip


@njit(cache=True, nogil=True)
def _chords(points, first, n, lo, hi, tolerance, is_seed, found):
    """Break a stretch into chords within tolerance: ``found`` = their first points' indices."""
    count = hi - lo
    for k in range(count + 1):
        is_seed[k % n] = False
    found[0] = lo
    m = 1
    stack = np.empty((count + 2, 2), np.int64)
    stack[0, 0] = lo
    stack[0, 1] = hi
    top = 1
    while top > 0:
        top -= 1
        a = stack[top, 0]
        b = stack[top, 1]
        p = first + _wrapped(a, n)
        q = first + _wrapped(b, n)
        dx = points[q, 0] - points[p, 0]
        dy = points[q, 1] - points[p, 1]
        length = math.sqrt(dx * dx + dy * dy)
        far = -1.0
        where = a
        for k in range(a + 1, b):
            i = first + _wrapped(k, n)
            x = points[i, 0] - points[p, 0]
            y = points[i, 1] - points[p, 1]
            d = math.sqrt(x * x + y * y) if length < 1e-9 else abs(x * dy - y * dx) / length
            if d > far:
                far = d
                where = k
        if far > tolerance:
            is_seed[where - lo] = True
            stack[top, 0] = where
            stack[top, 1] = b
            stack[top + 1, 0] = a
            stack[top + 1, 1] = where
            top += 2
    for k in range(1, count):
        if is_seed[k]:
            found[m] = lo + k
            m += 1
    return m

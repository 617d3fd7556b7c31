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
SAMPLES = 48
"""At most about so many points shape a stretch in the search; all of them judge it."""
SPAN = 160
"""At most so many seeds in one stretch."""
ROUNDS = 3
"""Times that edges are fitted, each with the corners of the time before."""
SHALLOW = 0.03
"""Sine of the angle below which two lines are taken for one."""
SNAP = 4
"""Points by which a seed moves to the middle of its corner."""
SLIDE = 8
"""Points by which a break may move towards its corner at a time."""
HUGE = 1e18


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
def _line_cost(points, first, n, lo, hi, step, line, dead_zone, sigma, worst):
    cost = 0.0
    for k in range(lo, hi, step):
        p = first + _wrapped(k, n)
        d = abs((points[p, 0] - line[0]) * line[3] - (points[p, 1] - line[1]) * line[2])
        if d > worst:
            return HUGE
        if d > dead_zone:
            d = (d - dead_zone) / sigma
            cost += d * d
    return cost


@njit(cache=True, nogil=True)
def _circle_cost(points, first, n, lo, hi, step, circle, dead_zone, sigma, worst):
    cost = 0.0
    for k in range(lo, hi, step):
        p = first + _wrapped(k, n)
        x = points[p, 0] - circle[0]
        y = points[p, 1] - circle[1]
        d = abs(math.sqrt(x * x + y * y) - circle[2])
        if d > worst:
            return HUGE
        if d > dead_zone:
            d = (d - dead_zone) / sigma
            cost += d * d
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
def _stretch(points, first, n, lo, hi, guard, dead_zone, sigma, worst, line, circle):
    """The cheaper of a line and an arc through points lo .. hi: (cost, is_arc)."""
    g = _trim(lo, hi, guard)
    a = lo + g
    b = hi - g + 1
    count = b - a
    step = 1
    if count > SAMPLES:
        step = count // SAMPLES
    fit_line(points, first, n, a, b, step, line)
    line_cost = LINE_PRICE + _line_cost(points, first, n, a, b, 1, line, dead_zone, sigma, worst)
    if count < 6 or line_cost < ARC_PRICE:
        return line_cost, False
    arc_cost = HUGE
    if fit_circle(points, first, n, a, b, step, 1, circle):
        arc_cost = ARC_PRICE + _circle_cost(
            points, first, n, a, b, 1, circle, dead_zone, sigma, worst
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
    points, first, n, seeds, m, start, guard, dead_zone, sigma, worst, breaks, is_arc
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
                points, first, n, lo, hi, guard, dead_zone, sigma, worst, line, circle
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
def _fit_edges(points, first, n, breaks, is_arc, edges, guard, joints, shape):
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
            for k in range(a, b):
                p = first + _wrapped(k, n)
                d = math.sqrt((points[p, 0] - row[0]) ** 2 + (points[p, 1] - row[1]) ** 2) - row[2]
                total += d * d
        else:
            fit_line(points, first, n, a, b, 1, row)
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
def _join(points, first, n, breaks, is_arc, edges, shape, blur, joints):
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
        x = points[first + here, 0]
        y = points[first + here, 1]
        room_before = (here - breaks[before]) % n
        room_after = (breaks[(e + 1) % edges] - here) % n
        back = min(SLIDE, max(room_before - 1, 0) // 2)
        ahead = min(SLIDE, max(room_after - 1, 0) // 2)
        moved[e] = here
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
def fit_borders(points, point_starts, dead_zone, sigma, blur, guard):
    """Lines, arcs and circles of every border.

    Returns ``(border_kind, edge_starts, kind, data)``: per border POLYGON, CIRCLE or TINY and
    its first edge; per edge LINE, ARC_CW or ARC_CCW and data (k, 6): the edge's first point
    x, y, then cx, cy, r of an arc, and the rms deviation. A circle is one edge of kind LINE
    with its centre and radius in the data. TINY borders have no edges.
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
    shape = np.empty((longest + 1, 5), np.float64)
    joints = np.empty((longest + 1, 2), np.float64)
    circle = np.empty(3, np.float64)
    worst = 0.35 + dead_zone + 4.5 * sigma
    skip = math.ceil(guard)
    seed_tolerance = 0.35 + dead_zone + 2.5 * sigma
    count = 0
    for b in range(borders):
        first = point_starts[b]
        n = point_starts[b + 1] - first
        edge_starts[b] = count
        if n < FEWEST:
            border_kind[b] = TINY
            continue
        circle_cost = HUGE
        if fit_circle(points, first, n, 0, n, 1, 8, circle):
            circle_cost = CIRCLE_PRICE + _circle_cost(
                points, first, n, 0, n, 1, circle, dead_zone, sigma, worst
            )
        edges = 0
        if circle_cost > 3.0 * LINE_PRICE:
            seed_breaks(points, first, n, seed_tolerance, is_seed)
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
            edges, cost = best_partition(
                points, first, n, seeds, m, start, skip, dead_zone, sigma, worst, breaks, is_arc
            )
            if sharpest < 0.6 and edges > 1:
                # no corner to begin at: begin again at a break that the search found
                again = breaks[edges // 2]
                for s in range(m):
                    if seeds[s] == again:
                        start = s
                edges, cost = best_partition(
                    points,
                    first,
                    n,
                    seeds,
                    m,
                    start,
                    skip,
                    dead_zone,
                    sigma,
                    worst,
                    breaks,
                    is_arc,
                )
            if circle_cost <= cost:
                edges = 0
        if edges == 0:
            border_kind[b] = CIRCLE
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
        for _ in range(ROUNDS):
            _fit_edges(points, first, n, breaks, is_arc, edges, guard, joints, shape)
            _join(points, first, n, breaks, is_arc, edges, shape, blur, joints)
        for e in range(edges):
            after = (e + 1) % edges
            data[count, 0] = joints[e, 0]
            data[count, 1] = joints[e, 1]
            data[count, 2] = 0.0
            data[count, 3] = 0.0
            data[count, 4] = 0.0
            data[count, 5] = shape[e, 4]
            kind[count] = LINE
            if is_arc[e]:
                lo = breaks[e]
                hi = breaks[after]
                if hi <= lo:
                    hi += n
                ccw = _is_ccw(points, first, n, lo, hi, shape[e, 0], shape[e, 1])
                kind[count] = ARC_CCW if ccw else ARC_CW
                _through_ends(
                    shape[e],
                    joints[e, 0],
                    joints[e, 1],
                    joints[after, 0],
                    joints[after, 1],
                    ccw,
                    circle,
                )
                data[count, 2] = circle[0]
                data[count, 3] = circle[1]
                data[count, 4] = circle[2]
            count += 1
    edge_starts[borders] = count
    return border_kind, edge_starts, kind[:count].copy(), data[:count].copy()

"""Lines, arcs and circles through the sub-pixel points of a border, and where they meet.

Rules and units
- Points (k, 2) float64 in pixels (or rectified pixels), y down, border after border, each a
  closed sequence. An index may run past the end of its border once: it wraps.
- ``dead_zone`` is the deviation that costs nothing (the staircase of a picture without grey),
  ``sigma`` the spread of the points about the true edge; a stretch's cost is the sum of
  ((|deviation| - dead_zone) / sigma)^2 over its points plus the price of the edge: a minimum
  description length, which the best partition into lines and arcs minimises.
- ``guard`` points beside each corner, where blur rounds the border, take no part in a fit.
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
LINE_PRICE, ARC_PRICE, CIRCLE_PRICE = 25.0, 32.0, 30.0
"""What an edge costs, in units of sigma squared: more than noise gains by one more break."""
FEWEST = 10
"""Points of the smallest border that is fitted."""
SAMPLES = 48
"""At most so many points judge a stretch in the search."""
SPAN = 160
"""At most so many seeds in one stretch."""
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
    return cost * step


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
    return cost * step


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
    line_cost = LINE_PRICE + _line_cost(points, first, n, a, b, step, line, dead_zone, sigma, worst)
    if count < 6 or line_cost < ARC_PRICE:
        return line_cost, False
    arc_cost = HUGE
    if fit_circle(points, first, n, a, b, step, 1, circle):
        arc_cost = ARC_PRICE + _circle_cost(
            points, first, n, a, b, step, circle, dead_zone, sigma, worst
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
def _fit_edges(points, first, n, breaks, is_arc, edges, guard, shape):
    """Fit every edge between its breaks; shape rows: x, y, ux, uy or cx, cy, r, rms last."""
    for e in range(edges):
        lo = breaks[e]
        hi = breaks[(e + 1) % edges]
        if hi <= lo:
            hi += n
        g = _trim(lo, hi, guard)
        a = lo + g
        b = hi - g + 1
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
def _joint(a, a_arc, b, b_arc, x, y, blur):
    """Where two neighbouring edges meet near (x, y): their nearest crossing, or a compromise.

    Edges that cross at a shallow angle, or not at all, meet at the mean of the projections
    of (x, y); a crossing far from the border is not believed.
    """
    limit = 1.0
    if not a_arc and not b_arc:
        cross = a[2] * b[3] - a[3] * b[2]
        dot = a[2] * b[2] + a[3] * b[3]
        if abs(cross) > 0.03:
            t = ((b[0] - a[0]) * b[3] - (b[1] - a[1]) * b[2]) / cross
            jx = a[0] + t * a[2]
            jy = a[1] + t * a[3]
            # half of the corner's inner angle: a narrow tip is rounded far back
            half_sine = math.sqrt(max(0.5 * (1.0 + dot), 1e-6))
            limit = 1.0 + (0.5 + blur) / max(half_sine, 0.12)
            if (jx - x) ** 2 + (jy - y) ** 2 <= limit * limit:
                return jx, jy, True
    elif a_arc and b_arc:
        dx = b[0] - a[0]
        dy = b[1] - a[1]
        d = math.sqrt(dx * dx + dy * dy)
        if d > 1e-9:
            along = (d * d + a[2] * a[2] - b[2] * b[2]) / (2.0 * d)
            h2 = a[2] * a[2] - along * along
            if h2 > 0.0:
                h = math.sqrt(h2)
                bx = a[0] + along * dx / d
                by = a[1] + along * dy / d
                best = HUGE
                jx = x
                jy = y
                for sign in (-1.0, 1.0):
                    px = bx - sign * h * dy / d
                    py = by + sign * h * dx / d
                    q = (px - x) ** 2 + (py - y) ** 2
                    if q < best:
                        best = q
                        jx = px
                        jy = py
                limit = 2.0 + 2.0 * blur
                if best <= limit * limit:
                    return jx, jy, True
    else:
        line = b if a_arc else a
        arc = a if a_arc else b
        t = (arc[0] - line[0]) * line[2] + (arc[1] - line[1]) * line[3]
        fx = line[0] + t * line[2]
        fy = line[1] + t * line[3]
        h2 = arc[2] * arc[2] - (arc[0] - fx) ** 2 - (arc[1] - fy) ** 2
        if h2 > 0.0:
            h = math.sqrt(h2)
            best = HUGE
            jx = x
            jy = y
            for sign in (-1.0, 1.0):
                px = fx + sign * h * line[2]
                py = fy + sign * h * line[3]
                q = (px - x) ** 2 + (py - y) ** 2
                if q < best:
                    best = q
                    jx = px
                    jy = py
            limit = 2.0 + 2.0 * blur
            if best <= limit * limit:
                return jx, jy, True
    ax, ay = _onto(a, a_arc, x, y)
    bx, by = _onto(b, b_arc, x, y)
    jx = 0.5 * (ax + bx)
    jy = 0.5 * (ay + by)
    if (jx - x) ** 2 + (jy - y) ** 2 > limit * limit:
        return x, y, False
    return jx, jy, False


@njit(cache=True, nogil=True)
def _joints(points, first, n, breaks, is_arc, edges, shape, blur, joints):
    for e in range(edges):
        before = (e - 1) % edges
        p = first + breaks[e]
        x, y, _ = _joint(
            shape[before], is_arc[before], shape[e], is_arc[e], points[p, 0], points[p, 1], blur
        )
        joints[e, 0] = x
        joints[e, 1] = y


@njit(cache=True, nogil=True)
def _move_breaks(points, first, n, breaks, edges, joints, reach):
    """Move every break to the border point nearest to its joint, within reach."""
    for e in range(edges):
        before = breaks[(e - 1) % edges]
        after = breaks[(e + 1) % edges]
        room_before = (breaks[e] - before) % n
        room_after = (after - breaks[e]) % n
        if edges == 2:
            room_before = max(room_before, 1)
            room_after = max(room_after, 1)
        lo = -min(reach, (room_before - 1) // 2)
        hi = min(reach, (room_after - 1) // 2)
        best = HUGE
        where = breaks[e]
        for k in range(lo, hi + 1):
            i = (breaks[e] + k) % n
            d = (points[first + i, 0] - joints[e, 0]) ** 2 + (
                points[first + i, 1] - joints[e, 1]
            ) ** 2
            if d < best:
                best = d
                where = i
        breaks[e] = where


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
    seed_tolerance = 0.45 + dead_zone + 2.5 * sigma
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
            sharpest = -1.0
            start = 0
            for k in range(n):
                if is_seed[k]:
                    seeds[m] = k
                    turn = _turn_at(points, first, n, k, 6)
                    if turn > sharpest:
                        sharpest = turn
                        start = m
                    m += 1
            edges, cost = best_partition(
                points, first, n, seeds, m, start, guard, dead_zone, sigma, worst, breaks, is_arc
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
                    guard,
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
        for _ in range(2):
            _fit_edges(points, first, n, breaks, is_arc, edges, guard, shape)
            _joints(points, first, n, breaks, is_arc, edges, shape, blur, joints)
            _move_breaks(points, first, n, breaks, edges, joints, 6)
        _fit_edges(points, first, n, breaks, is_arc, edges, guard, shape)
        _joints(points, first, n, breaks, is_arc, edges, shape, blur, joints)
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

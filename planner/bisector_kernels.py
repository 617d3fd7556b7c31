"""Exact vertices and edges: the generators' topology, solved on the pieces themselves.

Rules and units
- A vertex of three different pieces is where their distances agree: Newton's method on
  ``distance_i(x) - rho = 0``, whose rows are the unit normals, started at the sampled vertex.
- A turning point is where an edge passes from a primitive to that primitive's own corner
  point: there both have the same foot, Newton's rows coincide, and the vertex is sought along
  the primitive's normal instead.
- All other vertices of a chain are slid onto the bisector of the two pieces beside them.
- Nothing is believed that its empty circle does not prove; where a border lies inside, the
  sampling got the topology wrong and has to be refined at the feet around that circle.
- Left and right are those of ``cross(along, left - right) > 0`` in the scene's coordinates.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.agvd_kernels import is_valid
from planner.distance_kernels import ARC, SEGMENT, distance, foot, nearest, segment_clearance

STEPS = 40
"""Newton steps; four were enough on random scenes, near-parallel borders take more."""
SINGULAR = 1e-7
"""Least determinant of two differences of unit normals that Newton's step divides by."""
FLAT = 2e-3
"""Normals that differ by less do not define a bisector well enough to slide onto it."""
TURN_TRIES = 4
"""Pieces tried opposite a turning point: the sampled one, then whichever lies nearer."""
HALVINGS = 20
"""How often one link is halved at most; its bulge falls by four with each."""
UNUSED, EXACT, KEPT, INTRUDED = 0, 1, 2, 3


@njit(cache=True, nogil=True)
def _normal(kind, data, i, x, y):
    """Distance from piece i and the unit vector from its foot to (x, y)."""
    fx, fy = foot(kind, data, i, x, y)
    dx, dy = x - fx, y - fy
    d = math.sqrt(dx * dx + dy * dy)
    if d == 0.0:
        return 0.0, 0.0, 0.0
    return d, dx / d, dy / d


@njit(cache=True, nogil=True)
def meet_three(kind, data, a, b, c, x, y, reach, tolerance):
    """The place equidistant to three pieces near (x, y): x, y, whether it was found."""
    sx, sy = x, y
    for _ in range(STEPS):
        da, ax, ay = _normal(kind, data, a, x, y)
        db, bx, by = _normal(kind, data, b, x, y)
        dc, cx, cy = _normal(kind, data, c, x, y)
        f, g = da - db, da - dc
        if abs(f) <= tolerance and abs(g) <= tolerance:
            return x, y, True
        px, py, qx, qy = ax - bx, ay - by, ax - cx, ay - cy
        det = px * qy - py * qx
        if abs(det) < SINGULAR:
            break
        mx, my = (f * qy - g * py) / det, (g * px - f * qx) / det
        step = math.sqrt(mx * mx + my * my)
        limit = 0.5 * reach
        if step > limit:
            mx, my = mx * limit / step, my * limit / step
        x, y = x - mx, y - my
        if (x - sx) ** 2 + (y - sy) ** 2 > reach * reach:
            break
    return sx, sy, False


@njit(cache=True, nogil=True)
def slide_between(kind, data, a, b, x, y, tolerance):
    """Slide (x, y) onto the bisector of two pieces: x, y, whether it got there."""
    sx, sy = x, y
    for _ in range(STEPS):
        da, ax, ay = _normal(kind, data, a, x, y)
        db, bx, by = _normal(kind, data, b, x, y)
        f = da - db
        if abs(f) <= tolerance:
            return x, y, True
        gx, gy = ax - bx, ay - by
        gg = gx * gx + gy * gy
        if gg < FLAT * FLAT:
            break
        x, y = x - f * gx / gg, y - f * gy / gg
    return sx, sy, False


@njit(cache=True, nogil=True)
def turn_at(kind, data, corner, side, c, x, y, tolerance):
    """The place on a primitive's normal at its corner point that piece c is as near to."""
    px, py = data[corner, 0], data[corner, 1]
    if kind[side] == SEGMENT:
        nx, ny = data[side, 1] - data[side, 3], data[side, 2] - data[side, 0]
    else:
        nx, ny = px - data[side, 0], py - data[side, 1]
    n = math.sqrt(nx * nx + ny * ny)
    nx, ny = nx / n, ny / n
    s = nx * (x - px) + ny * (y - py)
    if s < 0.0:
        nx, ny, s = -nx, -ny, -s
    for _ in range(STEPS):
        qx, qy = px + s * nx, py + s * ny
        d, ux, uy = _normal(kind, data, c, qx, qy)
        f = d - s
        if abs(f) <= tolerance:
            return qx, qy, True
        slope = ux * nx + uy * ny - 1.0
        if slope > -SINGULAR:
            break
        s -= f / slope
        if s <= 0.0:
            break
    return x, y, False


@njit(cache=True, nogil=True)
def _solve(
    kind, data, order, large, boxes, k, before, after, owner, a, b, c, x, y, spacing, tolerance
):  # fmt: skip
    """The exact place of the sampled vertex (x, y) of labels a, b, c: x, y, state."""
    if a in (b, c) or b == c:
        if a == b:
            b = c
        if a == b:
            return x, y, KEPT
        qx, qy, found = slide_between(kind, data, a, b, x, y, tolerance)
        return qx, qy, EXACT if found else KEPT
    ab = is_valid(kind, data, a, b, k, before, after, owner, False, tolerance)
    bc = is_valid(kind, data, b, c, k, before, after, owner, False, tolerance)
    ca = is_valid(kind, data, c, a, k, before, after, owner, False, tolerance)
    if ab and bc and ca:
        reach = 2.0 * spacing + distance(kind, data, a, x, y)
        qx, qy, found = meet_three(kind, data, a, b, c, x, y, reach, tolerance)
        if found:
            return qx, qy, EXACT
    elif ab + bc + ca == 2:
        if not bc:
            a, b, c = b, c, a
        elif not ca:
            a, b, c = c, a, b
        corner, side = (a, b) if a >= k else (b, a)
        if corner >= k and (before[corner - k] == side or after[corner - k] == side):
            qx, qy, found = turn_at(kind, data, corner, side, c, x, y, tolerance)
            for _ in range(TURN_TRIES):
                if not found:
                    break
                s = math.sqrt((qx - data[corner, 0]) ** 2 + (qy - data[corner, 1]) ** 2)
                _, i = nearest(kind, data, order, large, boxes, qx, qy, s - 4.0 * tolerance)
                if i < 0:
                    break
                qx, qy, found = turn_at(kind, data, corner, side, i, qx, qy, tolerance)
            if found:
                return qx, qy, EXACT
    elif ab + bc + ca == 1:
        for i in (a, b, c):
            if i < k and kind[i] == ARC:
                gone = (x - data[i, 0]) ** 2 + (y - data[i, 1]) ** 2
                if gone < (1e-3 * data[i, 2]) ** 2:
                    return data[i, 0], data[i, 1], EXACT
        if bc:
            a, b = b, c
        elif ca:
            a, b = c, a
        qx, qy, found = slide_between(kind, data, a, b, x, y, tolerance)
        return qx, qy, EXACT if found else KEPT
    return x, y, KEPT


@njit(cache=True, nogil=True)
def solve_vertices(
    edges, keep, vertices, vertex_sites, label, kind, data, owner, before, after,
    order, large, boxes, k, spacing, relevant, tolerance
):  # fmt: skip
    """Exact places of the vertices that kept edges meet.

    Returns ``xy`` (v, 2), ``rho`` (v,), the exact clearance (that of the nearest border where
    one lies nearer than the labels), ``state`` (v,) and ``extra`` (e, 2), ``extra_label``
    (e,): generators that are missing around circles that were not empty, at clearances of
    ``relevant`` and more.
    """
    v = len(vertices)
    xy = vertices.copy()
    rho = np.zeros(v)
    state = np.zeros(v, np.int8)
    bad = np.empty(v, np.int32)
    intruder = np.empty(v, np.int32)
    count = 0
    for e in range(len(edges)):
        if not keep[e]:
            continue
        for end in range(2, 4):
            w = edges[e, end]
            if state[w] != UNUSED:
                continue
            a, b, c = (
                label[vertex_sites[w, 0]],
                label[vertex_sites[w, 1]],
                label[vertex_sites[w, 2]],
            )
            x, y, got = _solve(
                kind, data, order, large, boxes, k, before, after, owner, a, b, c,
                vertices[w, 0], vertices[w, 1], spacing, tolerance
            )  # fmt: skip
            if (x - vertices[w, 0]) ** 2 + (y - vertices[w, 1]) ** 2 > 4.0 * spacing * spacing:
                x, y, got = vertices[w, 0], vertices[w, 1], KEPT
            r = min(distance(kind, data, a, x, y), distance(kind, data, b, x, y))
            r = min(r, distance(kind, data, c, x, y))
            near, i = nearest(kind, data, order, large, boxes, x, y, r - 4.0 * tolerance)
            if i >= 0:
                r = near
                got = INTRUDED
                overshot = (a in (b, c) or b == c) and not (
                    is_valid(kind, data, i, a, k, before, after, owner, False, tolerance)
                    and is_valid(kind, data, i, b, k, before, after, owner, False, tolerance)
                    and is_valid(kind, data, i, c, k, before, after, owner, False, tolerance)
                )
                if r >= relevant and not overshot:
                    bad[count], intruder[count] = w, i
                    count += 1
            xy[w, 0], xy[w, 1], rho[w], state[w] = x, y, r, got
    extra = np.empty((4 * count, 2))
    extra_label = np.empty(4 * count, np.int32)
    n = 0
    for j in range(count):
        w = bad[j]
        for m in range(4):
            lab = intruder[j] if m == 3 else label[vertex_sites[w, m]]
            if lab >= k:
                continue
            fx, fy = foot(kind, data, lab, xy[w, 0], xy[w, 1])
            extra[n, 0], extra[n, 1], extra_label[n] = fx, fy, lab
            n += 1
        xy[w, 0], xy[w, 1] = vertices[w, 0], vertices[w, 1]
        rho[w], _ = nearest(kind, data, order, large, boxes, xy[w, 0], xy[w, 1], np.inf)
    return xy, rho, state, extra[:n], extra_label[:n]


@njit(cache=True, nogil=True)
def heading(kind, data, left, right, x, y):
    """The direction along the bisector with ``left`` to the left, and how clearance grows.

    Returns the unit direction and the derivative of the clearance along it; all 0 where the
    feet coincide.
    """
    lx, ly = foot(kind, data, left, x, y)
    rx, ry = foot(kind, data, right, x, y)
    tx, ty = ly - ry, rx - lx
    n = math.sqrt(tx * tx + ty * ty)
    if n == 0.0:
        return 0.0, 0.0, 0.0
    tx, ty = tx / n, ty / n
    _, nx, ny = _normal(kind, data, left, x, y)
    return tx, ty, nx * tx + ny * ty


@njit(cache=True, nogil=True)
def narrowest(kind, data, left, right, x0, y0, x1, y1, tolerance):
    """The bisector's least clearance between two of its places, if inside: x, y, found."""
    lo, hi = 0.0, 1.0
    x, y, found = x0, y0, False
    for _ in range(50):
        m = 0.5 * (lo + hi)
        x, y, found = slide_between(
            kind, data, left, right, x0 + m * (x1 - x0), y0 + m * (y1 - y0), tolerance
        )
        if not found:
            return x, y, False
        _, _, slope = heading(kind, data, left, right, x, y)
        if abs(slope) < 1e-12:
            break
        if slope < 0.0:
            lo = m
        else:
            hi = m
    return x, y, found


@njit(cache=True, nogil=True)
def bend_chains(
    kind, data, order, large, boxes, points, pieces, first, at, rho_at, state_at, vertex_sites,
    label, spacing, tolerance
):  # fmt: skip
    """The chains' points in exact order, with the narrowest place of every run put in.

    A sampled vertex inside a run is dropped where the run's exact ends have overtaken it.
    ``at`` (p,) is each point's vertex. Returns points, pieces, rho, offsets as
    :class:`planner.agvd.Chains` has them, and ``proved`` (p,) bool: the link to the next point
    follows the bisector of its two pieces.
    """
    p, c = len(points), len(first) - 1
    xy = np.empty((2 * p, 2))
    pair = np.full((2 * p, 2), -1, np.int32)
    rho = np.empty(2 * p)
    proved = np.empty(2 * p, np.bool_)
    offset = np.zeros(c + 1, np.int32)
    n = 0
    for j in range(c):
        last = first[j + 1] - 1
        _order_turns(kind, data, points, pieces, at, first[j], last, vertex_sites, label)
        stop = first[j]
        for i in range(first[j], last + 1):
            w = at[i]
            if i > stop:
                stop = i
                while stop < last and _inside_run(label, vertex_sites, at[stop]):
                    stop += 1
            x, y = points[i, 0], points[i, 1]
            if i > first[j]:
                left, right = pieces[i - 1, 0], pieces[i - 1, 1]
                if i < stop:
                    if state_at[w] == INTRUDED:
                        continue
                    tx, ty, _ = heading(kind, data, left, right, xy[n - 1, 0], xy[n - 1, 1])
                    if (x - xy[n - 1, 0]) * tx + (y - xy[n - 1, 1]) * ty <= tolerance:
                        continue
                    ex, ey = points[stop, 0] - x, points[stop, 1] - y
                    if ex * ex + ey * ey <= 4.0 * spacing * spacing:
                        tx, ty, _ = heading(kind, data, left, right, x, y)
                        if ex * tx + ey * ty <= tolerance:
                            continue
                pair[n - 1, 0], pair[n - 1, 1] = left, right
                n = _put_narrowest(
                    kind, data, order, large, boxes, xy, pair, rho, proved, n, x, y, tolerance
                )
            xy[n, 0], xy[n, 1], rho[n] = x, y, rho_at[w]
            proved[n] = state_at[w] == EXACT
            pair[n, 0], pair[n, 1] = -1, -1
            n += 1
        offset[j + 1] = n
    for i in range(n):
        if proved[i] and pair[i, 0] >= 0:
            proved[i] = proved[i + 1] and _spans(kind, data, xy, pair, rho, i, tolerance)
        else:
            proved[i] = False
    return xy[:n], pair[:n], rho[:n], offset, proved[:n]


@njit(cache=True, nogil=True)
def _spans(kind, data, xy, pair, rho, i, tolerance):
    """Whether both ends of link i are as near to both of its pieces as to anything."""
    for end in range(2):
        x, y, r = xy[i + end, 0], xy[i + end, 1], rho[i + end]
        for side in range(2):
            if abs(distance(kind, data, pair[i, side], x, y) - r) > 4.0 * tolerance:
                return False
    return True


@njit(cache=True, nogil=True)
def _order_turns(kind, data, points, pieces, at, begin, last, vertex_sites, label):
    """Swap turning points of the two sides that sampling put in the wrong order.

    Where the left border turned from A to its corner P and then the right one from its corner
    Q to B, with P Q between, but the places are the other way round, A B is between.
    """
    i = begin + 1
    while i < last:
        stop = i + 1
        while stop < last and _inside_run(label, vertex_sites, at[stop]):
            stop += 1
        if stop >= last or _inside_run(label, vertex_sites, at[i]):
            i = stop
            continue
        left, right = pieces[i, 0], pieces[i, 1]
        mid_left, mid_right = pieces[i - 1, 0], pieces[stop, 1]
        if left == mid_left:
            mid_left, mid_right = pieces[stop, 0], pieces[i - 1, 1]
        one_each = (pieces[i - 1, 0] == left) != (pieces[i - 1, 1] == right)
        other = (pieces[stop, 0] == left) == (pieces[i - 1, 1] == right)
        tx, ty, _ = heading(kind, data, left, right, points[i, 0], points[i, 1])
        dx, dy = points[stop, 0] - points[i, 0], points[stop, 1] - points[i, 1]
        if one_each and other and dx * tx + dy * ty < 0.0:
            x, y, w = points[i, 0], points[i, 1], at[i]
            points[i, 0], points[i, 1], at[i] = points[stop, 0], points[stop, 1], at[stop]
            points[stop, 0], points[stop, 1], at[stop] = x, y, w
            for m in range(i, stop):
                pieces[m, 0], pieces[m, 1] = mid_left, mid_right
        i = stop


@njit(cache=True, nogil=True)
def _inside_run(label, vertex_sites, w):
    """Whether a chain passes a vertex without changing its two pieces."""
    a, b, c = label[vertex_sites[w, 0]], label[vertex_sites[w, 1]], label[vertex_sites[w, 2]]
    return a in (b, c) or b == c


@njit(cache=True, nogil=True)
def _put_narrowest(kind, data, order, large, boxes, xy, pair, rho, proved, n, x, y, tolerance):
    """Put in the narrowest place between the last point and (x, y), if there is one."""
    left, right = pair[n - 1, 0], pair[n - 1, 1]
    px, py = xy[n - 1, 0], xy[n - 1, 1]
    _, _, before = heading(kind, data, left, right, px, py)
    _, _, after = heading(kind, data, left, right, x, y)
    if before >= -1e-9 or after <= 1e-9:
        return n
    qx, qy, found = narrowest(kind, data, left, right, px, py, x, y, tolerance)
    away = (qx - 0.5 * (px + x)) ** 2 + (qy - 0.5 * (py + y)) ** 2
    if found and away <= (x - px) ** 2 + (y - py) ** 2:
        xy[n, 0], xy[n, 1] = qx, qy
        rho[n] = distance(kind, data, left, qx, qy)
        near, i = nearest(kind, data, order, large, boxes, qx, qy, rho[n] - 4.0 * tolerance)
        proved[n] = i < 0
        if i >= 0:
            rho[n] = near
        pair[n, 0], pair[n, 1] = left, right
        n += 1
    return n


@njit(cache=True, nogil=True)
def measure_bisectors(kind, data, order, large, boxes, points, rho, proved, first):
    """Lengths and clearances of exact chains, whose narrowest places are points of theirs.

    A proved link is as wide as its narrower end; any other is measured as a straight line
    against the borders. Returns ``gap``, ``step`` per point and ``length``, ``clearance`` per
    chain.
    """
    p, c = len(points), len(first) - 1
    gap = np.full(p, np.inf)
    step = np.zeros(p)
    length = np.zeros(c)
    clearance = np.full(c, np.inf)
    for j in range(c):
        clearance[j] = rho[first[j]]
        for i in range(first[j], first[j + 1] - 1):
            ax, ay, bx, by = points[i, 0], points[i, 1], points[i + 1, 0], points[i + 1, 1]
            step[i] = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            gap[i] = min(rho[i], rho[i + 1])
            if not proved[i]:
                gap[i], _, _ = segment_clearance(
                    kind, data, order, large, boxes, ax, ay, bx, by, gap[i]
                )
            length[j] += step[i]
            clearance[j] = min(clearance[j], gap[i])
    return gap, step, length, clearance


@njit(cache=True, nogil=True)
def follow(kind, data, order, large, boxes, points, pairs, need, flatness, tolerance):
    """A polyline that follows the bisectors its links stand for, as closely as it must.

    ``pairs`` (n, 2) are the pieces beside each link, -1 where the link is straight. A link is
    halved on its bisector while its straight line is nearer than ``need`` to a border or
    bulges by more than ``flatness``. Returns points and pairs.
    """
    n = len(points)
    room = 4 * n + 64
    xy = np.empty((room, 2))
    pair = np.empty((room, 2), np.int32)
    stack = np.empty((HALVINGS + 2, 2))
    level = np.empty(HALVINGS + 2, np.int32)
    m = 0
    for i in range(n):
        if m + 1 >= room:
            room *= 2
            xy, pair = _grown(xy, room), _grown_pairs(pair, room)
        xy[m] = points[i]
        pair[m] = pairs[i]
        m += 1
        if i + 1 == n or pairs[i, 0] < 0:
            continue
        top = 1
        stack[0, 0], stack[0, 1], level[0] = points[i + 1, 0], points[i + 1, 1], 0
        while top > 0:
            ax, ay = xy[m - 1, 0], xy[m - 1, 1]
            bx, by, deep = stack[top - 1, 0], stack[top - 1, 1], level[top - 1]
            mx, my, found = slide_between(
                kind, data, pairs[i, 0], pairs[i, 1], 0.5 * (ax + bx), 0.5 * (ay + by), tolerance
            )
            bulge = math.sqrt((mx - 0.5 * (ax + bx)) ** 2 + (my - 0.5 * (ay + by)) ** 2)
            span = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            split = found and deep < HALVINGS and tolerance < bulge < 0.5 * span
            if split and bulge <= flatness:
                _, _, which = segment_clearance(
                    kind, data, order, large, boxes, ax, ay, bx, by, need
                )
                split = which >= 0
            if split:
                stack[top, 0], stack[top, 1], level[top] = mx, my, deep + 1
                level[top - 1] = deep + 1
                top += 1
                continue
            top -= 1
            if top > 0:
                if m + 1 >= room:
                    room *= 2
                    xy, pair = _grown(xy, room), _grown_pairs(pair, room)
                xy[m, 0], xy[m, 1] = bx, by
                pair[m] = pairs[i]
                m += 1
    return xy[:m], pair[:m]


@njit(cache=True, nogil=True)
def _grown(a, room):
    out = np.empty((room, 2))
    out[: len(a)] = a
    return out


@njit(cache=True, nogil=True)
def _grown_pairs(a, room):
    out = np.empty((room, 2), np.int32)
    out[: len(a)] = a
    return out

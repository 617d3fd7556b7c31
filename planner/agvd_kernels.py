"""From borders to generators, and from their Voronoi diagram to chains of valid edges.

Rules and units
- A piece is a primitive of the scene or a corner point: the end of an open chain, or a corner
  that the free space goes round. Corners that the free space runs into need no piece: the
  bisector of their two sides reaches them by itself, with generators half a spacing away on
  either side. Where a border crosses itself its sides change, and all its corners have one.
- A label is the index of a generator's piece. A Voronoi edge is valid where the feet on the
  two labels differ: not within one piece, and not between a corner point and its own sides.
- A vertex is free where it lies inside the bounds and in no object; an edge needs two.
- A chain is a maximal run of valid edges through vertices with two of them.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borrowing_kernels import BORROWING
from planner.distance_kernels import (
    ARC,
    CIRCLE,
    POINT,
    SEGMENT,
    TAU,
    distance,
    in_object,
    nearest,
    on_sweep,
    segment_clearance,
    segment_distance,
)

ROUND_LEAST, ROUND_APART = 8.0, 0.8
"""A circle has so many generators at least; an arc's are no further apart than that, in radians,
which is as many for a whole turn."""
SMOOTH = 1e-3
"""Sine of the turn below which a joint counts as smooth, so that it needs a corner point."""


@njit(**BORROWING)
def _end(kind, data, backwards, i, last):
    """The first or last point of primitive i in its border's order."""
    if kind[i] == SEGMENT:
        return (data[i, 2], data[i, 3]) if last else (data[i, 0], data[i, 1])
    if kind[i] == POINT:
        return data[i, 0], data[i, 1]
    a = data[i, 3] + (data[i, 4] if last != backwards[i] else 0.0)
    return data[i, 0] + data[i, 2] * math.cos(a), data[i, 1] + data[i, 2] * math.sin(a)


@njit(cache=True, nogil=True)
def _tangent(kind, data, backwards, i, x, y):
    """The unit direction of travel along primitive i at its point (x, y)."""
    if kind[i] == SEGMENT:
        dx, dy = data[i, 2] - data[i, 0], data[i, 3] - data[i, 1]
    else:
        dx, dy = data[i, 1] - y, x - data[i, 0]
        if backwards[i]:
            dx, dy = -dx, -dy
    d = math.sqrt(dx * dx + dy * dy)
    return dx / d, dy / d


@njit(**BORROWING)
def _length(kind, data, i):
    if kind[i] == SEGMENT:
        return math.sqrt((data[i, 2] - data[i, 0]) ** 2 + (data[i, 3] - data[i, 1]) ** 2)
    if kind[i] == CIRCLE:
        return TAU * data[i, 2]
    if kind[i] == ARC:
        return data[i, 4] * data[i, 2]
    return 0.0


@njit(cache=True, nogil=True)
def without_repeats(kind, data, border, backwards, tolerance):
    """Degenerate primitives made points, and points at a neighbour's end left out.

    Segments, circles and arcs shorter than ``tolerance`` have no direction, and a repeated
    vertex is a segment without length. Returns ``kind`` (k,), ``data`` (k, 6) and ``keep``
    (k,) bool.
    """
    n = len(kind)
    out_kind, out = kind.copy(), data.copy()
    keep = np.ones(n, np.bool_)
    for i in range(n):
        if kind[i] != POINT and _length(kind, data, i) <= tolerance:
            if kind[i] == ARC and data[i, 2] > tolerance:
                out[i, 0], out[i, 1] = _end(kind, data, backwards, i, False)
            out[i, 2:] = 0.0
            out_kind[i] = POINT
    for turn in range(2):
        last = -1
        for j in range(n):
            i = j if turn == 0 else n - 1 - j
            if out_kind[i] == CIRCLE or not keep[i]:
                continue
            if out_kind[i] == POINT and last >= 0 and border[last] == border[i]:
                x, y = _end(out_kind, out, backwards, last, turn == 0)
                keep[i] = abs(x - out[i, 0]) > tolerance or abs(y - out[i, 1]) > tolerance
            if keep[i]:
                last = i
    return out_kind, out, keep


@njit(cache=True, nogil=True)
def link_borders(kind, data, border, is_hole, backwards, tolerance):
    """How the primitives of every border join.

    Returns ``following`` and ``preceding`` (k,) int32, -1 at the ends of open chains,
    ``solid`` (k,) int8: +1 where the solid lies to the left of travel, -1 to the right, 0
    where both sides are free, and ``crossed`` (k,) bool: part of a border that crosses itself,
    whose solid changes sides.
    """
    n = len(kind)
    following = np.full(n, -1, np.int32)
    preceding = np.full(n, -1, np.int32)
    solid = np.zeros(n, np.int8)
    crossed = np.zeros(n, np.bool_)
    first = 0
    while first < n:
        last = first
        if kind[first] == CIRCLE:
            solid[first] = -1 if is_hole[first] else 1
            first += 1
            continue
        if kind[first] == POINT:
            first += 1
            continue
        while last + 1 < n and border[last + 1] == border[first] and kind[last + 1] != CIRCLE:
            ex, ey = _end(kind, data, backwards, last, True)
            sx, sy = _end(kind, data, backwards, last + 1, False)
            if abs(ex - sx) > tolerance or abs(ey - sy) > tolerance:
                break
            following[last], preceding[last + 1] = last + 1, last
            last += 1
        ex, ey = _end(kind, data, backwards, last, True)
        sx, sy = _end(kind, data, backwards, first, False)
        if (
            abs(ex - sx) <= tolerance
            and abs(ey - sy) <= tolerance
            and (last > first or kind[first] == ARC)
        ):
            following[last], preceding[first] = first, last
            area = _signed_area(kind, data, backwards, first, last)
            side = 1 if (area > 0.0) != is_hole[first] else -1
            solid[first : last + 1] = 0 if area == 0.0 else side
            crossed[first : last + 1] = _crosses_itself(kind, data, first, last)
        first = last + 1
    return following, preceding, solid, crossed


@njit(**BORROWING)
def _x_range(kind, data, i):
    """A range of x that primitive i lies within."""
    if kind[i] == SEGMENT:
        return min(data[i, 0], data[i, 2]), max(data[i, 0], data[i, 2])
    return data[i, 0] - data[i, 2], data[i, 0] + data[i, 2]


@njit(cache=True, nogil=True)
def _crosses_itself(kind, data, first, last):
    """Whether two sides of a closed border that are no neighbours meet. O(n log n) for most."""
    n = last + 1 - first
    if n < 4:
        return False
    if n <= 12:
        for i in range(n):
            for j in range(i + 2, n if i > 0 else n - 1):
                if _meet(kind, data, first + i, first + j):
                    return True
        return False
    low, high = np.empty(n), np.empty(n)
    for i in range(n):
        low[i], high[i] = _x_range(kind, data, first + i)
    order = np.argsort(low)
    for a in range(n):
        i = order[a]
        for b in range(a + 1, n):
            j = order[b]
            if low[j] > high[i]:
                break
            apart = abs(i - j)
            if 1 < apart < n - 1 and _meet(kind, data, first + i, first + j):
                return True
    return False


@njit(**BORROWING)
def _meet(kind, data, i, j):
    """Whether two segments or arcs have a point in common."""
    if kind[j] == SEGMENT:
        i, j = j, i
    if kind[i] == SEGMENT:
        ax, ay, bx, by = data[i, 0], data[i, 1], data[i, 2], data[i, 3]
        return segment_distance(kind, data, j, ax, ay, bx, by)[0] == 0.0
    dx, dy = data[j, 0] - data[i, 0], data[j, 1] - data[i, 1]
    r, s, square = data[i, 2], data[j, 2], dx * dx + dy * dy
    if square == 0.0 or square > (r + s) ** 2 or square < (r - s) ** 2:
        return False
    along = 0.5 * (1.0 + (r * r - s * s) / square)
    across = math.sqrt(max(r * r / square - along * along, 0.0))
    for sign in (-1.0, 1.0):
        x = data[i, 0] + along * dx - sign * across * dy
        y = data[i, 1] + along * dy + sign * across * dx
        if on_sweep(data, i, x, y) and on_sweep(data, j, x, y):
            return True
    return False


@njit(**BORROWING)
def _signed_area(kind, data, backwards, first, last):
    """Area inside a closed chain, positive where it turns from x to y."""
    area = 0.0
    ox, oy = _end(kind, data, backwards, first, False)
    for i in range(first, last + 1):
        ax, ay = _end(kind, data, backwards, i, False)
        bx, by = _end(kind, data, backwards, i, True)
        area += 0.5 * ((ax - ox) * (by - oy) - (ay - oy) * (bx - ox))
        if kind[i] == ARC:
            part = 0.5 * data[i, 2] ** 2 * (data[i, 4] - math.sin(data[i, 4]))
            area += -part if backwards[i] else part
    return area


@njit(cache=True, nogil=True)
def corner_points(kind, data, backwards, following, preceding, solid, every):
    """The corners that need a point of their own.

    Returns ``at`` (c, 2), ``before`` and ``after`` (c,) the primitives that meet there (-1
    where a chain ends). ``every`` (k,): each joint of the primitive has one.
    """
    n = len(kind)
    at = np.empty((2 * n, 2), np.float64)
    before = np.empty(2 * n, np.int32)
    after = np.empty(2 * n, np.int32)
    c = 0
    for i in range(n):
        if kind[i] == POINT or kind[i] == CIRCLE:
            continue
        if preceding[i] < 0:
            at[c, 0], at[c, 1] = _end(kind, data, backwards, i, False)
            before[c], after[c] = -1, i
            c += 1
        x, y = _end(kind, data, backwards, i, True)
        j = following[i]
        if j >= 0 and not every[i] and solid[i] != 0:
            ux, uy = _tangent(kind, data, backwards, i, x, y)
            sx, sy = _end(kind, data, backwards, j, False)
            vx, vy = _tangent(kind, data, backwards, j, sx, sy)
            if (ux * vy - uy * vx) * solid[i] < -SMOOTH:
                continue
        at[c, 0], at[c, 1] = x, y
        before[c], after[c] = i, j
        c += 1
    return at[:c], before[:c], after[:c]


@njit(**BORROWING)
def count_generators(kind, data, spacing):
    """An upper bound of the number of generators, as a float: it may be astronomical."""
    total = 0.0
    for i in range(len(kind)):
        total += math.ceil(_length(kind, data, i) / spacing) + ROUND_LEAST
    return total


@njit(cache=True, nogil=True)
def place_generators(kind, data, backwards, at, before, after, spacing, room):
    """Generators at most ``spacing`` apart along every primitive, and on every corner point.

    Returns ``sites`` (n, 2) and ``label`` (n,): the primitive, or k + c for corner point c.
    """
    k = len(kind)
    sites = np.empty((room, 2), np.float64)
    label = np.empty(room, np.int32)
    point_at_start = np.zeros(k, np.bool_)
    point_at_end = np.zeros(k, np.bool_)
    for c in range(len(before)):
        if before[c] >= 0:
            point_at_end[before[c]] = True
        if after[c] >= 0:
            point_at_start[after[c]] = True
    n = 0
    for i in range(k):
        if kind[i] == POINT:
            sites[n, 0], sites[n, 1], label[n] = data[i, 0], data[i, 1], i
            n += 1
            continue
        length = _length(kind, data, i)
        lead = 1.0 if point_at_start[i] else 0.5
        tail = 1.0 if point_at_end[i] else 0.5
        if kind[i] == CIRCLE:
            lead, tail = 0.5, 0.5
            count = max(ROUND_LEAST, math.ceil(length / spacing))
        else:
            least = 1.0 if kind[i] == SEGMENT else math.ceil(data[i, 4] / ROUND_APART)
            count = max(least, math.ceil(length / spacing - lead - tail) + 1.0)
        step = length / (count - 1.0 + lead + tail)
        turned = kind[i] == ARC and backwards[i]
        for j in range(int(count)):
            t = (lead + j) * step / length
            if kind[i] == SEGMENT:
                sites[n, 0] = data[i, 0] + t * (data[i, 2] - data[i, 0])
                sites[n, 1] = data[i, 1] + t * (data[i, 3] - data[i, 1])
            else:
                sweep = TAU if kind[i] == CIRCLE else data[i, 4]
                a = data[i, 3] + sweep * (1.0 - t if turned else t)
                sites[n, 0] = data[i, 0] + data[i, 2] * math.cos(a)
                sites[n, 1] = data[i, 1] + data[i, 2] * math.sin(a)
            label[n] = i
            n += 1
    for c in range(len(before)):
        sites[n, 0], sites[n, 1], label[n] = at[c, 0], at[c, 1], k + c
        n += 1
    return sites[:n], label[:n]


@njit(cache=True, nogil=True)
def _root(parent, i):
    """The set of i, halving the way there."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(cache=True, nogil=True)
def free_vertices(
    edges, vertices, sites, kind, data, owner, solid, object_boxes, span, box, spacing
):  # fmt: skip
    """Which vertices lie in free space: inside the bounds, and in no object by even-odd.

    A Voronoi edge that stays further than half the spacing from its generators crosses no
    border, so that all vertices joined by such edges lie on one side and one is asked for
    all: the one with the most room.
    """
    v = len(vertices)
    parent = np.arange(v)
    room = np.zeros(v)
    limit = (0.5 * spacing) ** 2 * (1.0 + 1e-9)
    for e in range(len(edges)):
        u, w = edges[e, 2], edges[e, 3]
        ax, ay = sites[edges[e, 0], 0], sites[edges[e, 0], 1]
        bx, by = sites[edges[e, 1], 0], sites[edges[e, 1], 1]
        du, dw = 0.0, 0.0
        if u >= 0:
            du = (vertices[u, 0] - ax) ** 2 + (vertices[u, 1] - ay) ** 2
            room[u] = du
        if w >= 0:
            dw = (vertices[w, 0] - ax) ** 2 + (vertices[w, 1] - ay) ** 2
            room[w] = dw
        if u < 0 or w < 0:
            continue
        least = min(du, dw)
        mx, my = 0.5 * (ax + bx), 0.5 * (ay + by)
        tx, ty = vertices[w, 0] - vertices[u, 0], vertices[w, 1] - vertices[u, 1]
        before = (mx - vertices[u, 0]) * tx + (my - vertices[u, 1]) * ty
        after = (vertices[w, 0] - mx) * tx + (vertices[w, 1] - my) * ty
        if before > 0.0 and after > 0.0:
            least = 0.25 * ((bx - ax) ** 2 + (by - ay) ** 2)
        if least > limit:
            parent[_root(parent, u)] = _root(parent, w)
    widest = np.full(v, -1)
    for w in range(v):
        x, y = vertices[w, 0], vertices[w, 1]
        if box[0] < x < box[2] and box[1] < y < box[3]:
            r = _root(parent, w)
            if widest[r] < 0 or room[w] > room[widest[r]]:
                widest[r] = w
    free = np.zeros(v, np.bool_)
    for r in range(v):
        w = widest[r]
        if w >= 0:
            free[r] = not in_object(
                kind, data, owner, solid, object_boxes, span,
                vertices[w, 0], vertices[w, 1], math.sqrt(room[w])
            )  # fmt: skip
    out = np.zeros(v, np.bool_)
    for w in range(v):
        x, y = vertices[w, 0], vertices[w, 1]
        if box[0] < x < box[2] and box[1] < y < box[3]:
            out[w] = free[_root(parent, w)]
    return out


@njit(**BORROWING, error_model="numpy", forceinline=True)
def is_valid(kind, data, label_a, label_b, k, before, after, owner, paper, tolerance):
    """Whether a Voronoi edge between two labels belongs to the diagram."""
    if paper:
        return owner[label_a] != owner[label_b]
    if label_a == label_b:
        return False
    if label_a < k and label_b < k and kind[label_a] != POINT and kind[label_b] != POINT:
        return True
    return not (
        is_end(kind, data, label_a, label_b, k, before, after, tolerance)
        or is_end(kind, data, label_b, label_a, k, before, after, tolerance)
    )


@njit(**BORROWING, error_model="numpy")
def is_end(kind, data, p, q, k, before, after, tolerance):
    """Whether p is a point that lies on piece q, as a corner point on its sides."""
    if p >= k:
        if before[p - k] == q or after[p - k] == q:
            return True
    elif kind[p] != POINT:
        return False
    x, y = data[p, 0], data[p, 1]
    # most are far away, which takes no root to see
    if kind[q] == POINT:
        if abs(x - data[q, 0]) > tolerance or abs(y - data[q, 1]) > tolerance:
            return False
    elif kind[q] == SEGMENT:
        ax, ay = data[q, 0], data[q, 1]
        dx, dy = data[q, 2] - ax, data[q, 3] - ay
        if abs((x - ax) * dy - (y - ay) * dx) > 2.0 * tolerance * (abs(dx) + abs(dy)):
            return False
    return distance(kind, data, q, x, y) <= tolerance


@njit(cache=True, nogil=True)
def valid_edges(
    edges, vertices, sites, label, kind, data, owner, solid, before, after, object_boxes, span,
    box, spacing, tolerance, paper
):  # fmt: skip
    """The valid edges between two free vertices: ``keep`` (m,) bool."""
    m, k = len(edges), len(solid)
    keep = np.zeros(m, np.bool_)
    free = free_vertices(
        edges, vertices, sites, kind, data, owner, solid, object_boxes, span, box, spacing
    )
    for e in range(m):
        u, w = edges[e, 2], edges[e, 3]
        if u >= 0 and w >= 0 and free[u] and free[w]:
            a, b = label[edges[e, 0]], label[edges[e, 1]]
            keep[e] = is_valid(kind, data, a, b, k, before, after, owner, paper, tolerance)
    return keep


@njit(cache=True, nogil=True)
def trace_chains(edges, keep, vertex_count):
    """Runs of kept edges through vertices with two of them.

    Returns ``node_vertex`` (n,) int32, ``ends`` (c, 2) int32 node numbers, ``first`` (c + 1,)
    offsets into ``link`` (l,) int32, the Voronoi edges of the chains in order, and ``along``
    (l,) bool: whether the edge is walked from its first to its second vertex. A closed run
    without a node gets one at its first vertex.
    """
    m = len(edges)
    degree = np.zeros(vertex_count + 1, np.int32)
    total = 0
    for e in range(m):
        if keep[e]:
            degree[edges[e, 2]] += 1
            degree[edges[e, 3]] += 1
            total += 1
    start = np.zeros(vertex_count + 2, np.int32)
    for w in range(vertex_count):
        start[w + 1] = start[w] + degree[w]
    fill = start.copy()
    incident = np.empty(2 * total, np.int32)
    for e in range(m):
        if keep[e]:
            for end in range(2, 4):
                w = edges[e, end]
                incident[fill[w]] = e
                fill[w] += 1
    node_of = np.full(vertex_count, -1, np.int32)
    node_vertex = np.empty(2 * total, np.int32)
    nodes = 0
    for w in range(vertex_count):
        if degree[w] > 0 and degree[w] != 2:
            node_of[w] = nodes
            node_vertex[nodes] = w
            nodes += 1
    used = np.zeros(m, np.bool_)
    ends = np.empty((total, 2), np.int32)
    first = np.zeros(total + 1, np.int32)
    link = np.empty(total, np.int32)
    along = np.empty(total, np.bool_)
    chains, links = 0, 0
    for sweep in range(2):
        for e0 in range(m):
            if not keep[e0] or used[e0]:
                continue
            w = -1
            if node_of[edges[e0, 2]] >= 0:
                w = edges[e0, 2]
            elif node_of[edges[e0, 3]] >= 0:
                w = edges[e0, 3]
            elif sweep == 1:
                w = edges[e0, 2]
                node_of[w] = nodes
                node_vertex[nodes] = w
                nodes += 1
            if w < 0:
                continue
            e = e0
            ends[chains, 0] = node_of[w]
            while True:
                used[e] = True
                forward = edges[e, 2] == w
                link[links], along[links] = e, forward
                links += 1
                w = edges[e, 3] if forward else edges[e, 2]
                if node_of[w] >= 0:
                    break
                other = incident[start[w]]
                e = incident[start[w] + 1] if other == e else other
            ends[chains, 1] = node_of[w]
            chains += 1
            first[chains] = links
    return node_vertex[:nodes], ends[:chains], first[: chains + 1], link[:links], along[:links]


@njit(cache=True, nogil=True)
def measure_chains(kind, data, order, large, boxes, points, first):
    """Length and exact clearance of every straight link of the chains.

    ``points`` (p, 2) hold chain c at ``first[c] : first[c + 1]``. Returns ``rho`` (p,), the
    exact clearance of every point, ``gap`` and ``step`` (p,), the clearance and length of the
    link from each point to the next (inf and 0 at a chain's last point), and per chain
    ``length`` and ``clearance``.
    """
    p, c = len(points), len(first) - 1
    rho = np.empty(p)
    gap = np.full(p, np.inf)
    step = np.zeros(p)
    length = np.zeros(c)
    clearance = np.full(c, np.inf)
    for i in range(p):
        rho[i] = nearest(kind, data, order, large, boxes, points[i, 0], points[i, 1], np.inf)[0]
    for j in range(c):
        if first[j + 1] - first[j] == 1:
            clearance[j] = rho[first[j]]
        for i in range(first[j], first[j + 1] - 1):
            ax, ay, bx, by = points[i, 0], points[i, 1], points[i + 1, 0], points[i + 1, 1]
            step[i] = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            bound = min(rho[i], rho[i + 1])
            gap[i], _, _ = segment_clearance(kind, data, order, large, boxes, ax, ay, bx, by, bound)
            length[j] += step[i]
            clearance[j] = min(clearance[j], gap[i])
    return rho, gap, step, length, clearance


@njit(cache=True, nogil=True)
def chain_points(edges, vertices, label, first, link, along):
    """The chains' points in order: one more than links for every chain.

    Returns ``points`` (l + c, 2), ``pieces`` (l + c, 2), the labels to the left and right of
    the link that follows (-1 at a chain's last point), the offsets of the chains' points, and
    ``at`` (l + c,), the vertex of every point.
    """
    c = len(first) - 1
    points = np.empty((len(link) + c, 2))
    pieces = np.full((len(link) + c, 2), -1, np.int32)
    offset = np.empty(c + 1, np.int32)
    at = np.empty(len(link) + c, np.int32)
    for j in range(c):
        offset[j] = first[j] + j
        for i in range(first[j], first[j + 1]):
            e = link[i]
            p = i + j
            w = edges[e, 2] if along[i] else edges[e, 3]
            points[p, 0], points[p, 1] = vertices[w, 0], vertices[w, 1]
            at[p] = w
            pieces[p, 0], pieces[p, 1] = label[edges[e, 0]], label[edges[e, 1]]
            if not along[i]:
                pieces[p, 0], pieces[p, 1] = pieces[p, 1], pieces[p, 0]
        e = link[first[j + 1] - 1]
        w = edges[e, 3] if along[first[j + 1] - 1] else edges[e, 2]
        p = first[j + 1] + j
        points[p, 0], points[p, 1] = vertices[w, 0], vertices[w, 1]
        at[p] = w
    offset[c] = len(link) + c
    return points, pieces, offset, at


@njit(cache=True, nogil=True)
def lonely_centres(
    kind, data, owner, backwards, solid, order, large, boxes, box, points, tolerance
):  # fmt: skip
    """Centres of circles and arcs that are free, as near to nothing else, and on no chain."""
    out = np.empty((len(solid), 2))
    n = 0
    for i in range(len(solid)):
        if kind[i] != CIRCLE and kind[i] != ARC:
            continue
        if solid[i] != 0 and ((solid[i] > 0) != backwards[i]):
            continue
        x, y, r = data[i, 0], data[i, 1], data[i, 2]
        if not (box[0] < x < box[2] and box[1] < y < box[3]):
            continue
        d, _ = nearest(kind, data, order, large, boxes, x, y, r)
        if d < r - tolerance:
            continue
        alone = True
        for j in range(len(points)):
            if abs(points[j, 0] - x) + abs(points[j, 1] - y) <= tolerance:
                alone = False
                break
        for j in range(n):
            if abs(out[j, 0] - x) + abs(out[j, 1] - y) <= tolerance:
                alone = False
        if alone:
            out[n, 0], out[n, 1] = x, y
            n += 1
    return out[:n]

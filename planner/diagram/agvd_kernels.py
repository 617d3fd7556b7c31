"""From the generators' Voronoi diagram to chains of valid edges.

Rules
- A label is the index of a generator's piece, see :mod:`planner.borders.corner_point_kernels`. A
  Voronoi edge is valid where the feet on the two labels differ: not within one piece, and not
  between a corner point and its own sides.
- A vertex is free where it lies inside the bounds and in no object; an edge needs two.
- A chain is a maximal run of valid edges through vertices with two of them.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import nearest
from planner.borders.inside_kernels import in_object
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import POINT, SEGMENT, distance, is_round, root_of


@njit(**OWNING)
def free_vertices(edges, vertices, sites, kind, data, closed, box, spacing):
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
            parent[root_of(parent, u)] = root_of(parent, w)
    widest = np.full(v, -1)
    for w in range(v):
        x, y = vertices[w, 0], vertices[w, 1]
        if box[0] < x < box[2] and box[1] < y < box[3]:
            r = root_of(parent, w)
            if widest[r] < 0 or room[w] > room[widest[r]]:
                widest[r] = w
    free = np.zeros(v, np.bool_)
    for r in range(v):
        w = widest[r]
        if w >= 0:
            free[r] = not in_object(
                kind, data, closed, vertices[w, 0], vertices[w, 1], math.sqrt(room[w])
            )
    out = np.zeros(v, np.bool_)
    for w in range(v):
        x, y = vertices[w, 0], vertices[w, 1]
        if box[0] < x < box[2] and box[1] < y < box[3]:
            out[w] = free[root_of(parent, w)]
    return out


@njit(**LEAF, forceinline=True)
def is_valid(pieces, label_a, label_b, paper, tolerance):
    """Whether a Voronoi edge between two labels belongs to the diagram."""
    if paper:
        return pieces.owner[label_a] != pieces.owner[label_b]
    if label_a == label_b:
        return False
    kind = pieces.kind
    k = len(kind) - len(pieces.before)
    if label_a < k and label_b < k and kind[label_a] != POINT and kind[label_b] != POINT:
        return True
    return not (
        is_end(pieces, label_a, label_b, tolerance) or is_end(pieces, label_b, label_a, tolerance)
    )


@njit(**LEAF)
def is_end(pieces, p, q, tolerance):
    """Whether p is a point that lies on piece q, as a corner point on its sides."""
    kind, data, before, after = pieces.kind, pieces.data, pieces.before, pieces.after
    k = len(kind) - len(before)
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


@njit(**OWNING)
def valid_edges(edges, vertices, sites, label, pieces, closed, box, spacing, tolerance, paper):
    """The valid edges between two free vertices: ``keep`` (m,) bool."""
    m = len(edges)
    keep = np.zeros(m, np.bool_)
    free = free_vertices(edges, vertices, sites, pieces.kind, pieces.data, closed, box, spacing)
    for e in range(m):
        u, w = edges[e, 2], edges[e, 3]
        if u >= 0 and w >= 0 and free[u] and free[w]:
            a, b = label[edges[e, 0]], label[edges[e, 1]]
            keep[e] = is_valid(pieces, a, b, paper, tolerance)
    return keep


@njit(**OWNING)
def trace_chains(edges, keep, vertex_count):
    """Runs of kept edges through vertices with two of them.

    Returns ``node_vertex`` (n,) int32, ``ends`` (c, 2) int32 node numbers, ``first`` (c + 1,)
    offsets into ``link`` (l,) int32, the Voronoi edges of the chains in order, and ``along``
    (l,) bool: whether the edge is walked from its first to its second vertex. A closed run
    without a node gets one at its first vertex.
    """
    m = len(edges)
    degree, start, incident = _edges_around(edges, keep, vertex_count)
    total = len(incident) // 2
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


@njit(**OWNING)
def _edges_around(edges, keep, vertex_count):
    """How many kept edges meet every vertex, and which: offsets into the vertices' edges."""
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
    return degree, start, incident


@njit(**OWNING)
def chain_points(edges, vertices, label, first, link, along):
    """The chains' points in order: one more than links for every chain.

    Returns ``points`` (l + c, 2), ``pieces`` (l + c, 2), the labels to the left and right of
    the link that follows (-1 at a chain's last point), and the offsets of the chains' points.
    """
    c = len(first) - 1
    points = np.empty((len(link) + c, 2))
    pieces = np.full((len(link) + c, 2), -1, np.int32)
    offset = np.empty(c + 1, np.int32)
    for j in range(c):
        offset[j] = first[j] + j
        for i in range(first[j], first[j + 1]):
            e = link[i]
            p = i + j
            w = edges[e, 2] if along[i] else edges[e, 3]
            points[p, 0], points[p, 1] = vertices[w, 0], vertices[w, 1]
            pieces[p, 0], pieces[p, 1] = label[edges[e, 0]], label[edges[e, 1]]
            if not along[i]:
                pieces[p, 0], pieces[p, 1] = pieces[p, 1], pieces[p, 0]
        e = link[first[j + 1] - 1]
        w = edges[e, 3] if along[first[j + 1] - 1] else edges[e, 2]
        p = first[j + 1] + j
        points[p, 0], points[p, 1] = vertices[w, 0], vertices[w, 1]
    offset[c] = len(link) + c
    return points, pieces, offset


@njit(**OWNING)
def lonely_centres(pieces, tree, closed, box, points, tolerance):
    """Centres of circles and arcs that are free, as near to nothing else, and on no chain.

    Rows (n, 3): x, y and clearance. Within one such border nothing else is equidistant to two
    places, but the clearance is greatest there: the way from one place to another leads over it.
    """
    data, solid = pieces.data, pieces.solid
    out = np.empty((len(solid), 3))
    n = 0
    for i in range(len(solid)):
        if not is_round(pieces.kind[i]):
            continue
        if solid[i] != 0 and ((solid[i] > 0) != pieces.backwards[i]):
            continue
        x, y, r = data[i, 0], data[i, 1], data[i, 2]
        if not (box[0] < x < box[2] and box[1] < y < box[3]):
            continue
        d, _ = nearest(tree, x, y, r)
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
        # nor where another object lies around
        d, _ = nearest(tree, x, y, np.inf)
        if alone and not in_object(pieces.kind, data, closed, x, y, d):
            out[n, 0], out[n, 1], out[n, 2] = x, y, d
            n += 1
    return out[:n]

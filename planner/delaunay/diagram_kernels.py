"""Voronoi diagram's arrays from a triangulation, and a proof of them.

Edges without length, between vertices of cocircular sites, are included and flagged.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.delaunay.insertion_kernels import conflict, triangulate
from planner.delaunay.predicate_kernels import SCRATCH, circumcentre, in_circle, orient
from planner.delaunay.site_order_kernels import load_sites
from planner.delaunay.triangle_kernels import (
    DEAD,
    next_side,
    previous_side,
    side_of,
    triangle_of,
)
from planner.scene.compile_options import OWNING

VERTEX_TOLERANCE = 1e-11
"""Error bound, in parts of the scene or its circle, from which a vertex is computed again."""
TURNED, NOT_EMPTY, WRONG_FLAG, NOT_CONVEX = 1, 2, 3, 4
"""Faults that `certify` finds: at a vertex, at an edge, at an edge, at a half-edge."""


@njit(**OWNING, error_model="numpy")
def _label(order, alias):
    """(n + 1,) int32: each place's row in the sites; the first row of coincident ones."""
    n = order.shape[0]
    label = np.empty(n + 1, np.int32)
    for i in range(n):
        label[i] = order[i]
    for i in range(n):
        v = alias[i]
        if v != i and order[i] < label[v]:
            label[v] = order[i]
    label[n] = -1
    return label


@njit(**OWNING, error_model="numpy")
def finite_vertices(w, xy, ghost, exponent, tri, circ, label):
    """Finite triangles' centres (m, 2) and sites (m, 3); each triangle's spare gets its row.

    A centre beyond VERTEX_TOLERANCE is recomputed by expansions.
    """
    vertices = np.empty((2 * ghost, 2))
    vertex_sites = np.empty((2 * ghost, 3), np.int32)
    half = exponent // 2
    up_1, up_2 = math.ldexp(1.0, half), math.ldexp(1.0, exponent - half)
    m = 0
    for t in range(0, 16 * ghost, 8):
        a, b, c = np.int64(tri[t]), np.int64(tri[t + 1]), np.int64(tri[t + 2])
        if a == DEAD:
            continue
        if a == ghost or b == ghost or c == ghost:
            tri[t + 3] = DEAD
            continue
        x, y = circ[t >> 1], circ[(t >> 1) + 1]
        band = circ[(t >> 1) + 3] - circ[(t >> 1) + 2]
        square = 0.5 * (circ[(t >> 1) + 3] + circ[(t >> 1) + 2])
        if not band <= 8.0 * VERTEX_TOLERANCE * square:
            reach = math.sqrt(square)
            if not band <= 8.0 * VERTEX_TOLERANCE * reach * (1.0 + reach):
                x, y = circumcentre(
                    w, xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1], xy[2 * c], xy[2 * c + 1]
                )
        vertices[m, 0] = x * up_1 * up_2
        vertices[m, 1] = y * up_1 * up_2
        vertex_sites[m, 0] = label[a]
        vertex_sites[m, 1] = label[b]
        vertex_sites[m, 2] = label[c]
        tri[t + 3] = m
        m += 1
    return vertices[:m], vertex_sites[:m]


@njit(**OWNING, error_model="numpy")
def list_edges(w, xy, ghost, tri, circ, label, ties, linked):
    """(k, 4) int32 edges and (k,) flags of those without length; half-edge ids by triangle.

    The ids link edges to their successors; they are empty unless ``linked``. An edge is the site on
    its left, the site on its right, and the vertices it comes from and goes to; -1 is at infinity.
    Edges have length zero only if some site lay on a circle.
    """
    edges = np.empty((3 * ghost, 4), np.int32)
    flat = np.zeros(3 * ghost, np.bool_)
    ids = np.full(8 * ghost if linked else 0, -1, np.int32)
    j = 0
    for t in range(0, 16 * ghost, 8):
        if np.int64(tri[t]) == DEAD:
            continue
        for k in range(3):
            e = t + k
            o = np.int64(tri[e + 4])
            if o < e:
                continue
            a = np.int64(tri[t + next_side(k)])
            b = np.int64(tri[t + previous_side(k)])
            if a == ghost or b == ghost:
                continue
            back = triangle_of(o)
            edges[j, 0] = label[a]
            edges[j, 1] = label[b]
            edges[j, 2] = np.int32(tri[back + 3])
            edges[j, 3] = np.int32(tri[t + 3])
            if linked:
                ids[4 * (t >> 3) + k] = 2 * j
                ids[4 * (back >> 3) + (o & 3)] = 2 * j + 1
            v = np.int64(tri[t + k])
            if ties > 0 and v != ghost and np.int64(tri[o]) != ghost:
                px, py = xy[2 * v], xy[2 * v + 1]
                q = back >> 1
                square = (px - circ[q]) * (px - circ[q]) + (py - circ[q + 1]) * (py - circ[q + 1])
                if not (square < circ[q + 2] or square > circ[q + 3]):
                    flat[j] = conflict(w, xy, ghost, tri, back, px, py) == 0
            j += 1
    return edges[:j], flat[:j], ids


@njit(**OWNING, error_model="numpy")
def _links(n, tri, ids, n_half_edges):
    """(next, prev) of each half-edge around the cell on its left, passing over infinity."""
    after = np.empty(n_half_edges, np.int32)
    before = np.empty(n_half_edges, np.int32)
    for t in range(0, 16 * n, 8):
        if np.int64(tri[t]) == DEAD:
            continue
        for k in range(3):
            here = ids[4 * (t >> 3) + k]
            if here < 0:
                continue
            # the half-edge of the same cell that leaves this triangle; its twin is edge k + 2
            o = np.int64(tri[t + 4 + previous_side(k)])
            if ids[4 * (o >> 3) + (o & 3)] < 0:
                o = np.int64(tri[triangle_of(o) + 4 + previous_side(side_of(o))])
            there = ids[4 * (o >> 3) + (o & 3)]
            after[here] = there
            before[there] = here
    return after, before


@njit(**OWNING, error_model="numpy")
def diagram(sites, linked):
    """Diagram of (n, 2) finite float64 sites.

    Returns status (0: done, 1: all sites on one line, the rest is not set), vertices (m, 2),
    vertex_sites (m, 3), edges (k, 4), flat (k,), representative (n,), and next and prev (2 k,),
    empty unless `linked`. Linear time on average after sorting.
    """
    n = sites.shape[0]
    status, order, xy, tri, circ, alias, exponent, ties = triangulate(sites, 0)
    none = np.empty(0, np.int32)
    if status != 0:
        return (
            1, np.empty((0, 2)), np.empty((0, 3), np.int32), np.empty((0, 4), np.int32),
            np.empty(0, np.bool_), none, none, none,
        )  # fmt: skip
    w = np.empty(SCRATCH)
    label = _label(order, alias)
    representative = np.empty(n, np.int32)
    for i in range(n):
        representative[order[i]] = label[alias[i]]
    vertices, vertex_sites = finite_vertices(w, xy, n, exponent, tri, circ, label)
    edges, flat, ids = list_edges(w, xy, n, tri, circ, label, ties, linked)
    after, before = none, none
    if linked:
        after, before = _links(n, tri, ids, 2 * edges.shape[0])
    return 0, vertices, vertex_sites, edges, flat, representative, after, before


@njit(**OWNING, error_model="numpy")
def certify(sites, vertex_sites, origin, before, cell, flat):
    """Check a diagram's circles exactly; return (0, 0) or the first fault and its place.

    Each vertex's sites turn left; no site beyond an edge lies inside the circle of the vertex
    before it, and on it only if the edge is flagged as without length; the unbounded cells' sites
    form a convex ring. By Delaunay's lemma all circles are then empty, if the triangles cover the
    hull once.
    """
    n = sites.shape[0]
    xy = np.empty(2 * n + 2)
    load_sites(sites, np.arange(n), xy)
    w = np.empty(SCRATCH)
    for v in range(vertex_sites.shape[0]):
        a, b, c = vertex_sites[v, 0], vertex_sites[v, 1], vertex_sites[v, 2]
        ax, ay, bx, by = xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1]
        if orient(w, ax, ay, bx, by, xy[2 * c], xy[2 * c + 1]) <= 0:
            return TURNED, v
    for j in range(flat.shape[0]):
        v, u = origin[2 * j], origin[2 * j + 1]
        if v < 0 or u < 0:
            continue
        a, b, c = vertex_sites[v, 0], vertex_sites[v, 1], vertex_sites[v, 2]
        p = -1
        for k in range(3):
            s = vertex_sites[u, k]
            if s != cell[2 * j] and s != cell[2 * j + 1]:
                p = s
        ax, ay, bx, by = xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1]
        cx, cy, px, py = xy[2 * c], xy[2 * c + 1], xy[2 * p], xy[2 * p + 1]
        side = in_circle(w, ax, ay, bx, by, cx, cy, px, py)
        if side > 0:
            return NOT_EMPTY, j
        if (side == 0) != flat[j]:
            return WRONG_FLAG, j
    for e in range(origin.shape[0]):
        if origin[e] >= 0:
            continue
        q, s, r = cell[before[e] ^ 1], cell[e], cell[e ^ 1]
        if q == r:
            continue
        qx, qy, sx, sy = xy[2 * q], xy[2 * q + 1], xy[2 * s], xy[2 * s + 1]
        rx, ry = xy[2 * r], xy[2 * r + 1]
        side = orient(w, qx, qy, sx, sy, rx, ry)
        between = min(qx, rx) <= sx <= max(qx, rx) and min(qy, ry) <= sy <= max(qy, ry)
        if side < 0 or (side == 0 and not between):
            return NOT_CONVEX, e
    return 0, 0

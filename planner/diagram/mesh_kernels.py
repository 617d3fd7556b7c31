"""Queries on the generators' triangulation: circles' centres, the free part, the nearest piece.

Rules and units
- A mesh is the result of :func:`planner.delaunay.insertion_kernels.triangulate`, in units of
  ``up``, a power of two.
- ``label`` is every site's piece. Of coincident sites one is in the mesh; ``also`` leads to the
  next one, -1 ends the list.
- No point of a border is further than ``half`` from a site of its own piece, along the border (half
  a spacing; at most 0.4 radii on round pieces).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.inside_kernels import in_object
from planner.delaunay.diagram_kernels import finite_vertices, list_edges
from planner.delaunay.insertion_kernels import insert
from planner.delaunay.predicate_kernels import SCRATCH, circumcentre
from planner.delaunay.site_order_kernels import TINY_COORDINATE
from planner.delaunay.triangle_kernels import (
    DEAD,
    next_side,
    previous_side,
    side_of,
    triangle_of,
)
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import NONE, distance

FREE, BLOCKED, PENDING = 1, 2, 3
LOOSE = 1e-9
"""Width of a circle's band, as a share of it, above which its centre is computed again."""


@njit(**OWNING, error_model="numpy")
def link_coincident(alias, label, count):
    """``also`` (count,) int32: the next site at the same place, -1 at the end.

    The least ``label`` is swapped to the first site: of coincident borders the same one represents
    both everywhere.
    """
    also = np.full(count, -1, np.int32)
    for p in range(count):
        v = alias[p]
        if v != p:
            also[p] = also[v]
            also[v] = p
            if label[p] < label[v]:
                label[p], label[v] = label[v], label[p]
    return also


@njit(**LEAF)
def find_changed(mesh, circ, triangles, changed, w):
    """Write the centres of new ``triangles`` into their ``at``, in the scene's units.

    A row is NaN if its triangle does not exist or reaches infinity. Changed triangles get ``state``
    and ``side`` 0 and become ``stale``. Writes the ``changed`` rows and returns their number. ``w``
    is working space.
    """
    xy, tri, up, ghost = mesh.xy, mesh.tri, mesh.up, len(mesh.label)
    seen, at, state, side = triangles.seen, triangles.at, triangles.state, triangles.side
    n = 0
    for i in range(2 * ghost):
        t = 8 * i
        a, b, c = tri[t], tri[t + 1], tri[t + 2]
        if a == seen[i, 0] and (a == DEAD or (b == seen[i, 1] and c == seen[i, 2])):
            continue
        seen[i, 0], seen[i, 1], seen[i, 2] = a, b, c
        state[i], side[i], triangles.stale[i] = 0, 0, True
        changed[n] = i
        n += 1
        if a == DEAD or ghost in (a, b, c):
            at[i, 0], at[i, 1] = np.nan, np.nan
            continue
        q = t >> 1
        x, y = circ[q], circ[q + 1]
        if not circ[q + 3] - circ[q + 2] <= LOOSE * circ[q + 2]:
            x, y = circumcentre(
                w, xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1], xy[2 * c], xy[2 * c + 1]
            )
        at[i, 0], at[i, 1] = x * up, y * up
    return n


@njit(**LEAF)
def _is_joined(xy, up, tri, at, i, k, j, limit):
    """True if the Voronoi edge from i over half-edge k to j stays off the borders."""
    a, b = np.int64(tri[8 * i + next_side(k)]), np.int64(tri[8 * i + previous_side(k)])
    ax, ay = xy[2 * a] * up, xy[2 * a + 1] * up
    bx, by = xy[2 * b] * up, xy[2 * b + 1] * up
    if 0.25 * ((bx - ax) ** 2 + (by - ay) ** 2) > limit:
        return True
    x, y, u, v = at[i, 0], at[i, 1], at[j, 0], at[j, 1]
    mx, my = 0.5 * (ax + bx), 0.5 * (ay + by)
    tx, ty = u - x, v - y
    if (mx - x) * tx + (my - y) * ty > 0.0 and (u - mx) * tx + (v - my) * ty > 0.0:
        return False
    return min((ax - x) ** 2 + (ay - y) ** 2, (ax - u) ** 2 + (ay - v) ** 2) > limit


@njit(**LEAF)
def mark_sides(mesh, triangles, changed, pieces, closed, box, half, queue):
    """Mark the changed triangles FREE (in the bounds and in no object) or BLOCKED.

    ``closed`` is the index of :mod:`planner.borders.inside_kernels`. A Voronoi edge further than
    ``half`` a spacing from its generators crosses no border, so all vertices joined by such edges
    lie on one side. ``queue`` (2 ghost,) is working space.
    """
    xy, tri, up, at, side = mesh.xy, mesh.tri, mesh.up, triangles.at, triangles.side
    limit = half**2 * (1.0 + 1e-9)
    for first in changed:
        if side[first] != 0:
            continue
        x, y = at[first, 0], at[first, 1]
        if not (box[0] < x < box[2] and box[1] < y < box[3]):
            side[first] = BLOCKED
            continue
        side[first] = PENDING
        queue[0] = first
        head, tail = 0, 1
        widest, widest_squared, known = first, 0.0, 0
        while head < tail:
            i = queue[head]
            head += 1
            x, y = at[i, 0], at[i, 1]
            s = np.int64(tri[8 * i])
            r = (xy[2 * s] * up - x) ** 2 + (xy[2 * s + 1] * up - y) ** 2
            if r > widest_squared:
                widest, widest_squared = i, r
            for k in range(3):
                j = np.int64(tri[8 * i + 4 + k]) >> 3
                if side[j] == PENDING or (side[j] != 0 and known != 0):
                    continue
                u, v = at[j, 0], at[j, 1]
                if not (box[0] < u < box[2] and box[1] < v < box[3]):
                    continue
                if _is_joined(xy, up, tri, at, i, k, j, limit):
                    if side[j] != 0:
                        known = side[j]
                        continue
                    side[j] = PENDING
                    queue[tail] = j
                    tail += 1
        if known == 0:
            x, y = at[widest, 0], at[widest, 1]
            known = FREE
            if in_object(pieces.kind, pieces.data, closed, x, y, math.sqrt(widest_squared)):
                known = BLOCKED
        for m in range(tail):
            side[queue[m]] = known


@njit(**LEAF)
def _nearest_site(xy, tri, h, x, y):
    """Half-edge opposite the site nearest to (x, y), scaled, by walking from h's site."""
    s = np.int64(tri[h])
    best = (xy[2 * s] - x) ** 2 + (xy[2 * s + 1] - y) ** 2
    while True:
        to = np.int64(-1)
        e = h
        while True:
            v = triangle_of(e) + next_side(side_of(e))
            s = np.int64(tri[v])
            d = (xy[2 * s] - x) ** 2 + (xy[2 * s + 1] - y) ** 2
            if d < best:
                best, to = d, v
            o = np.int64(tri[v + 4])
            e = triangle_of(o) + next_side(side_of(o))
            if e == h:
                break
        if to < 0:
            return h, best
        h = to


@njit(**OWNING, error_model="numpy")
def insert_sites(xy, circ, sites, down, todo, places, labels, where, refined):
    """Insert the sites ``todo``, each searched for from triangle ``where``; return superfluous
    ones.

    With ``places``, the sites are new, lie there, have these ``labels``, and are ``refined`` or
    not; ``down`` scales the places. A site that coincides with others of the same piece is
    superfluous.
    """
    tri, label, alias, also = sites.tri, sites.label, sites.alias, sites.also
    for j in range(len(places)):
        p = np.int64(todo[j])
        x, y = places[j, 0] * down, places[j, 1] * down
        if abs(x) < TINY_COORDINATE:
            x = (x + TINY_COORDINATE) - TINY_COORDINATE
        if abs(y) < TINY_COORDINATE:
            y = (y + TINY_COORDINATE) - TINY_COORDINATE
        xy[2 * p], xy[2 * p + 1] = x, y
        label[p], also[p], sites.refined[p] = labels[j], -1, refined
        tri[16 * p], tri[16 * p + 8] = DEAD, DEAD
    insert(np.empty(SCRATCH), xy, len(alias), tri, circ, alias, todo, where)
    spare = np.empty(len(todo), np.int32)
    n = 0
    for p in todo:
        v = alias[p]
        if v == p:
            continue
        q = v
        while q >= 0 and label[q] != label[p]:
            q = np.int64(also[q])
        if q >= 0:
            alias[p], label[p] = p, -1
            spare[n] = p
            n += 1
        else:
            also[p] = also[v]
            also[v] = p
    return spare[:n]


@njit(**LEAF)
def nearest_piece(mesh, pieces, t, x, y, bound, half, but_a=NONE, but_b=NONE, but_c=NONE):
    """Distance to and number of the primitive nearest to (x, y), if nearer than ``bound``.

    Otherwise (bound, -1). Skips the primitives ``but_a``, ``but_b`` and ``but_c``. ``t`` is a
    triangle to start from, without a site at infinity.

    If a primitive is nearer, the site nearest to its foot is its own or its corner's and within
    ``half`` of it, and so nearer to (x, y) than the root of bound^2 + half^2 + sag bound: on a
    round piece of radius R the chord s to that site adds s^2 bound / R, and ``sag`` is the largest
    s^2 / R. The sites in a disc are connected in the triangulation, so only those are visited.
    """
    xy, tri, label, also, stamp, queue, up, sag = mesh
    kind, data, before, after = pieces.kind, pieces.data, pieces.before, pieces.after
    k = len(kind) - len(before)
    down = 1.0 / up
    sx, sy = x * down, y * down
    h, square = _nearest_site(xy, tri, np.int64(t), sx, sy)
    best = bound
    reach = min(bound, math.sqrt(square) * up)
    which = NONE
    within = (reach * reach + half * half + sag * reach) * (1.0 + 1e-6) * down * down
    last = len(stamp) - 1
    stamp[last] += 1
    query = stamp[last]
    # half-edges opposite the sites to visit
    queue[0] = h
    head, tail = 0, 1
    stamp[np.int64(tri[h])] = query
    known = NONE
    while head < tail:
        h = queue[head]
        head += 1
        s = np.int64(tri[h])
        while s >= 0:
            if label[s] != known:
                known = np.int64(label[s])
                for end in range(2):
                    i = known
                    if known >= k:
                        i = np.int64(before[known - k] if end == 0 else after[known - k])
                    elif end == 1:
                        break
                    if i < 0 or i in (but_a, but_b, but_c):
                        continue
                    d = distance(kind, data, i, x, y)
                    if d < best:
                        best, which = d, i
            s = np.int64(also[s])
        e = h
        while True:
            v = triangle_of(e) + next_side(side_of(e))
            s = np.int64(tri[v])
            if stamp[s] != query:
                stamp[s] = query
                if (xy[2 * s] - sx) ** 2 + (xy[2 * s + 1] - sy) ** 2 <= within:
                    queue[tail] = v
                    tail += 1
            o = np.int64(tri[v + 4])
            e = triangle_of(o) + next_side(side_of(o))
            if e == h:
                break
    return best, which


@njit(**OWNING, error_model="numpy")
def ordinary(xy, ghost, exponent, tri, circ, alias, used, mask, vacant):
    """The sites' own diagram as arrays of :class:`~planner.delaunay.voronoi_diagram.DiagramArrays`.

    Also returns the edges that are valid by ``mask`` (2 ghost,). The ``vacant`` sites are left out.
    """
    w = np.empty(SCRATCH)
    tri = tri.copy()
    label = np.zeros(ghost + 1, np.int32)
    label[vacant] = -1
    label[ghost] = -1
    count = 0
    for p in range(used):
        if label[p] == 0:
            label[p] = count
            count += 1
    representative = np.empty(count, np.int32)
    for p in range(used):
        if label[p] >= 0:
            representative[label[p]] = label[alias[p]]
    vertices, vertex_sites = finite_vertices(w, xy, ghost, exponent, tri, circ, label)
    edges, flat, ids = list_edges(w, xy, ghost, tri, circ, label, 1, True)
    valid = np.zeros(len(edges), np.bool_)
    for i in range(2 * ghost):
        for k in range(3):
            if mask[i] >> k & 1 and ids[4 * i + k] >= 0:
                valid[ids[4 * i + k] >> 1] = True
    return vertices, vertex_sites, edges, flat, representative, valid

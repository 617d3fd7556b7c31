"""Exact geometry of chains: their points on the bisectors, their widths and lengths.

Rules and units
- Chains are those of :mod:`planner.diagram.chains.trace_kernels`. A chain's stations are its
  solved nodes and turning points; between two stations, a run, it follows the bisector of one pair
  of pieces, see :mod:`planner.diagram.chains.bend_kernels`.
- Left and right are as in :mod:`planner.diagram.bisector_kernels`.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import segment_clearance
from planner.delaunay.triangle_kernels import next_side, previous_side
from planner.diagram.bisector_kernels import heading, slide_between
from planner.diagram.chains.bend_kernels import bend_run
from planner.diagram.chains.kept_run_kernels import find_run, index_runs
from planner.diagram.chains.trace_kernels import trace_chains
from planner.diagram.mesh_kernels import nearest_piece
from planner.diagram.vertex_kernels import EXACT, INTRUDED, KEPT, UNUSED
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import NONE, distance


@njit(**LEAF)
def solve_rings(mesh, pieces, triangles, node, tolerances):
    """Slide the nodes of closed runs onto their bisectors."""
    tri, label, kind, data = mesh.tri, mesh.label, pieces.kind, pieces.data
    at, xy, rho, state = triangles.at, triangles.place, triangles.rho, triangles.state
    half, _, tolerance = tolerances
    for i in node:
        if state[i] != UNUSED:
            continue
        a, b = np.int64(label[np.int64(tri[8 * i])]), np.int64(label[np.int64(tri[8 * i + 1])])
        if a == b:
            b = np.int64(label[np.int64(tri[8 * i + 2])])
        x, y, found = slide_between(kind, data, a, b, at[i, 0], at[i, 1], tolerance)
        if not found or (x - at[i, 0]) ** 2 + (y - at[i, 1]) ** 2 > 16.0 * half * half:
            x, y, found = at[i, 0], at[i, 1], False
        r = min(distance(kind, data, a, x, y), distance(kind, data, b, x, y))
        d, which = nearest_piece(mesh, pieces, 8 * i, x, y, r - 4.0 * tolerance, half, a, b, NONE)
        xy[i, 0], xy[i, 1], rho[i] = x, y, r if which < 0 else d
        state[i] = INTRUDED if which >= 0 else (EXACT if found else KEPT)


@njit(**LEAF, forceinline=True)
def _order_turns(pieces, at, link, half, stations, last):
    """Swap turning points of the two sides that sampling put in the wrong order.

    If the left border turns from A to its corner P and then the right one from its corner Q to B,
    with P Q between, but the places are in reverse order, A B is between. Sampling only confuses
    near places.
    """
    kind, data = pieces.kind, pieces.data
    place, pair, run = stations.place, stations.sides, stations.run
    near = 16.0 * half * half
    for i in range(1, last - 1):
        m = link[(run[i, 0] + run[i, 1]) // 2] >> 3
        if (at[m, 0] - place[i, 0]) ** 2 + (at[m, 1] - place[i, 1]) ** 2 > near:
            continue
        if (place[i + 1, 0] - place[i, 0]) ** 2 + (place[i + 1, 1] - place[i, 1]) ** 2 > near:
            continue
        left, right = np.int64(pair[i, 0]), np.int64(pair[i, 1])
        mid_left, mid_right = pair[i - 1, 0], pair[i + 1, 1]
        if left == mid_left:
            mid_left, mid_right = pair[i + 1, 0], pair[i - 1, 1]
        one_each = (pair[i - 1, 0] == left) != (pair[i - 1, 1] == right)
        other = (pair[i + 1, 0] == left) == (pair[i - 1, 1] == right)
        tx, ty, _ = heading(kind, data, left, right, place[i, 0], place[i, 1])
        dx, dy = place[i + 1, 0] - place[i, 0], place[i + 1, 1] - place[i, 1]
        if one_each and other and dx * tx + dy * ty < 0.0:
            for c in range(4):
                place[i, c], place[i + 1, c] = place[i + 1, c], place[i, c]
            pair[i, 0], pair[i, 1] = mid_left, mid_right
            run[i, 1] = run[i, 0]


@njit(**LEAF, forceinline=True)
def _lay_stations(mesh, triangles, link, lo, hi, stations):
    """Write the stations of the chain with links ``lo`` to ``hi``; return the last one's number."""
    tri, label = mesh.tri, mesh.label
    place, sides, run = stations.place, stations.sides, stations.run
    m = 0
    for q in range(lo, hi + 1):
        h = link[q] if q < hi else np.int64(tri[link[hi - 1] + 4])
        i = h >> 3
        if lo < q < hi:
            s0, s1 = label[np.int64(tri[8 * i])], label[np.int64(tri[8 * i + 1])]
            s2 = label[np.int64(tri[8 * i + 2])]
            if s0 == s1 or s1 == s2 or s2 == s0:
                run[m - 1, 1] = q + 1
                continue
        place[m, 0], place[m, 1] = triangles.place[i, 0], triangles.place[i, 1]
        place[m, 2], place[m, 3] = triangles.rho[i], triangles.state[i]
        if q < hi:
            j = h - 8 * i
            sides[m, 0] = label[np.int64(tri[8 * i + previous_side(j)])]
            sides[m, 1] = label[np.int64(tri[8 * i + next_side(j)])]
            run[m, 0], run[m, 1] = q, q + 1
        m += 1
    return m - 1


@njit(**LEAF, forceinline=True)
def _copy_run(known, p, way, stations, s, out, n):
    """Copy the known run after station s, from its point p; return the new number of points.

    Returns -1 if space ran out.
    """
    left, right = stations.sides[s, 0], stations.sides[s, 1]
    end_x, end_y = stations.place[s + 1, 0], stations.place[s + 1, 1]
    while True:
        out.pieces[n - 1, 0], out.pieces[n - 1, 1] = left, right
        p += way
        x, y = known.points[p, 0], known.points[p, 1]
        if x == end_x and y == end_y:
            return n
        if n >= len(out.points) - 2:
            return -1
        out.points[n, 0], out.points[n, 1], out.points[n, 2] = x, y, known.points[p, 2]
        out.sure[n], out.ahead[n] = True, True
        n += 1


@njit(**LEAF)
def bend(mesh, pieces, triangles, first, link, tolerances, known, arrays):
    """Bend the chains onto their bisectors, with the narrowest place of every run.

    Fills ``arrays``, a :class:`planner.diagram.chains.bend_kernels.BendArrays`; a link is proved if
    both its points are and it follows their bisector. Returns the numbers of points and missing
    sites, -1 if space ran out.
    """
    out, stations = arrays.out, arrays.stations
    place, sides = stations.place, stations.sides
    n, missing = np.int64(0), np.int64(0)
    for c in range(len(first) - 1):
        lo, hi = first[c], first[c + 1]
        last = _lay_stations(mesh, triangles, link, lo, hi, stations)
        _order_turns(pieces, triangles.at, link, tolerances.half, stations, last)
        for s in range(last + 1):
            if n >= len(out.points) - 2:
                return -1, missing
            out.points[n, 0], out.points[n, 1], out.points[n, 2] = (
                place[s, 0], place[s, 1], place[s, 2],
            )  # fmt: skip
            out.sure[n], out.ahead[n] = place[s, 3] == EXACT, True
            out.pieces[n, 0], out.pieces[n, 1] = -1, -1
            n += 1
            if s == last:
                break
            p, way = find_run(known, place, stations.bits, s, sides[s, 0], sides[s, 1])
            if way != 0:
                n = _copy_run(known, p, way, stations, s, out, n)
            else:
                n, missing = bend_run(
                    mesh, pieces, triangles, link, hi, tolerances, arrays, s, (n, missing)
                )
            if n < 0 or missing < 0:
                return n, missing
        for i in range(out.start[c], n - 1):
            out.proved[i] = out.ahead[i] and out.sure[i] and out.sure[i + 1]
        out.proved[n - 1] = False
        out.start[c + 1] = n
    return n, missing


@njit(**OWNING, error_model="numpy")
def trace_again(mesh, pieces, triangles, old, bent, tolerances):
    """Trace the chains that changed, and solve the nodes that closed runs get.

    ``old`` and ``bent`` are the previous chains (:mod:`planner.diagram.diagram_arrays`). Returns
    the kept ones of these; the chains as in ``Traced``; the table of
    :func:`planner.diagram.chains.kept_run_kernels.index_runs`; and the number of links of the
    longest new chain, at least 1. Afterwards no triangle is stale.
    """
    mask = triangles.mask
    kept, node, ends, first, link = trace_chains(mesh.tri, mask, triangles.stale, old)
    triangles.stale[:] = False
    solve_rings(mesh, pieces, triangles, node, tolerances)
    longest = 1
    for c in range(len(kept), len(first) - 1):
        longest = max(longest, first[c + 1] - first[c])
    return kept, mask.copy(), node, ends, first, link, index_runs(kept, bent), longest


@njit(**OWNING, error_model="numpy")
def measure_chains(tree, points, proved, first, ends, nodes):
    """Measure chains whose narrowest places are among their points.

    A proved link is as wide as its narrower end; others are measured. Returns the ``points`` (p, 3)
    as places (p, 2) and clearances (p,), ``gap``, ``step`` per point, ``length``, ``clearance`` per
    chain, and the clearances of the ``nodes`` in the chains' ``ends`` (c, 2).
    """
    p, c = len(points), len(first) - 1
    xy, rho = np.empty((p, 2)), np.empty(p)
    for i in range(p):
        xy[i, 0], xy[i, 1], rho[i] = points[i, 0], points[i, 1], points[i, 2]
    gap = np.full(p, np.inf)
    step = np.zeros(p)
    length = np.zeros(c)
    clearance = np.full(c, np.inf)
    for j in range(c):
        clearance[j] = points[first[j], 2]
        for i in range(first[j], first[j + 1] - 1):
            ax, ay, bx, by = points[i, 0], points[i, 1], points[i + 1, 0], points[i + 1, 1]
            step[i] = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            gap[i] = min(points[i, 2], points[i + 1, 2])
            if not proved[i]:
                gap[i], _, _ = segment_clearance(tree, ax, ay, bx, by, gap[i])
            length[j] += step[i]
            clearance[j] = min(clearance[j], gap[i])
    node_rho = np.empty(nodes)
    for side in range(2):
        for j in range(c):
            node_rho[ends[j, side]] = rho[first[j] if side == 0 else first[j + 1] - 1]
    return xy, rho, gap, step, length, clearance, node_rho

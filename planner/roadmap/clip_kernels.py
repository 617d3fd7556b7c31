"""Cuts chains where their clearance passes the robot's radius, on flat arrays.

Rules and units
- Chain c's points are ``points[first[c] : first[c + 1]]``, and link i runs from point i to point
  i + 1, as in :func:`planner.diagram.chains.trace_kernels.trace_chains`.
- A wide part is a stretch of a chain that keeps ``radius``. Places narrower only by rounding,
  down to ``floor``, do not end it.
- A cut keeps the radius, and lies on its link's bisector, or on the link if that is straight.
- A dead end off its own bisector is an artefact of sampling, in a gap much narrower than the
  generators' spacing: the unproved links to it are part of nothing.
"""

# numba infers types; docstrings state them.
# mypy: allow-untyped-defs

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from planner.borders.box_tree_kernels import nearest, segment_clearance
from planner.borders.inside_kernels import ClosedBorders, in_object
from planner.diagram.bisector_kernels import slide_between
from planner.diagram.diagram_arrays import ChainArrays
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import distance, grown, put_rows, root_of

CUT_HALVINGS = 52
"""Steps of the search for a cut: as many as a number has digits."""


class Solids(NamedTuple):
    """Places that no disc fits: in a closed border, or out of the ``box`` x_min, y_min, x_max,
    y_max.
    """

    closed: ClosedBorders
    box: NDArray[np.float64]


class PartLimits(NamedTuple):
    """Definition of a part: as wide as ``radius``, or ``floor`` by rounding, and longer than
    ``least``.

    Places are equidistant within ``equal``; a dead end may be ``astray`` off its bisector.
    """

    radius: float
    floor: float
    least: float
    equal: float
    astray: float


class Parts(NamedTuple):
    """Wide parts of chains.

    ``where`` (m, 3): the chain and the links that the part begins and ends in; ``places``
    (m, 2, 3): x, y and clearance of both ends.
    """

    where: NDArray[np.int32]
    places: NDArray[np.float64]


@njit(**LEAF)
def _copy(chains, i, out):
    """Write x, y and clearance of point i."""
    out[0], out[1], out[2] = chains.points[i, 0], chains.points[i, 1], chains.rho[i]


@njit(**LEAF)
def _reach(tree, chains, link, a, b, limits, out):
    """Write the end of the link's part from ``a`` (3,), wide, to b that keeps the radius: x, y,
    rho.
    """
    kind, data, radius = tree.kind, tree.data, limits.radius
    left, right = np.int64(chains.pieces[link, 0]), np.int64(chains.pieces[link, 1])
    out[0], out[1], out[2] = a[0], a[1], a[2]
    lo, hi = 0.0, 1.0
    for _ in range(CUT_HALVINGS):
        m = 0.5 * (lo + hi)
        x, y = a[0] + m * (b[0] - a[0]), a[1] + m * (b[1] - a[1])
        if chains.proved[link]:
            x, y, found = slide_between(kind, data, left, right, x, y, limits.equal)
            d = min(distance(kind, data, left, x, y), distance(kind, data, right, x, y))
            wide = found and d >= radius
        else:
            d, _ = nearest(tree, x, y, np.inf)
            _, _, which = segment_clearance(tree, a[0], a[1], x, y, radius)
            wide = which < 0
        if wide:
            lo = m
            out[0], out[1], out[2] = x, y, d
        else:
            hi = m


@njit(**LEAF)
def _is_longer(points, where, ends, least):
    """True if a part is longer than ``least``."""
    x, y, total = ends[0, 0], ends[0, 1], 0.0
    for i in range(where[1] + 1, where[2] + 2):
        px, py = points[i, 0], points[i, 1]
        if i == where[2] + 1:
            px, py = ends[1, 0], ends[1, 1]
        total += math.sqrt((px - x) ** 2 + (py - y) ** 2)
        if total > least:
            return True
        x, y = px, py
    return False


@njit(**LEAF)
def _is_astray(tree, solids, chains, i, link, tolerance):
    """True if a chain's end, point i, is off the bisector of its link, or behind a border."""
    kind, data, box = tree.kind, tree.data, solids.box
    x, y, r = chains.points[i, 0], chains.points[i, 1], chains.rho[i]
    for side in range(2):
        if abs(distance(kind, data, np.int64(chains.pieces[link, side]), x, y) - r) > tolerance:
            return True
    if not (box[0] < x < box[2] and box[1] < y < box[3]):
        return True
    return in_object(kind, data, solids.closed, x, y, r)


@njit(**LEAF)
def _trusted(tree, solids, chains, is_end, c, limits):
    """First and last point of a chain without its astray dead ends.

    ``is_end`` are two flags, True if the chain is a dead end there.
    """
    proved, rho, radius = chains.proved, chains.rho, limits.radius
    lo, hi = np.int64(chains.first[c]), np.int64(chains.first[c + 1]) - 1
    a, b = lo, hi
    if lo == hi:
        return a, b
    doubted = is_end[0] and not proved[lo] and rho[lo] >= radius
    if doubted and _is_astray(tree, solids, chains, lo, lo, limits.astray):
        while a < hi and not proved[a]:
            a += 1
    doubted = is_end[1] and not proved[hi - 1] and rho[hi] >= radius
    if doubted and _is_astray(tree, solids, chains, hi, hi - 1, limits.astray):
        while b > a and not proved[b - 1]:
            b -= 1
    return a, b


@njit(**LEAF)
def _parts_of(tree, chains, c, lo, hi, limits, parts, m, here):
    """Write the wide parts of chain c between its points lo and hi; return the number of parts.

    ``m`` parts exist before; there is space for one per link, and one more. ``here`` (2, 3) is
    working space.
    """
    where, places = parts
    rho, gap, radius, floor = chains.rho, chains.gap, limits.radius, limits.floor
    begin, end = chains.first[c], chains.first[c + 1] - 1
    begun, is_open = m, False
    # since the last part's end, or the chain's beginning
    narrowest = np.inf if lo == begin else -np.inf
    for i in range(lo, hi):
        _copy(chains, i, here[0])
        _copy(chains, i + 1, here[1])
        if i == lo and rho[i] >= radius:
            where[m, 0], where[m, 1], is_open = c, i, True
            _copy(chains, i, places[m, 0])
        if is_open and gap[i] >= radius:
            continue
        if is_open:
            _reach(tree, chains, i, here[0], here[1], limits, places[m, 1])
            where[m, 2] = i
            m += 1
            is_open, narrowest = False, np.inf
        narrowest = min(narrowest, gap[i])
        if rho[i + 1] < radius:
            continue
        is_open = True
        if narrowest >= floor and m > begun:
            m -= 1  # only narrow by rounding: continue the last part
        elif narrowest >= floor:
            where[m, 0], where[m, 1] = c, lo
            _copy(chains, lo, places[m, 0])
        else:
            where[m, 0], where[m, 1] = c, i
            _reach(tree, chains, i, here[1], here[0], limits, places[m, 0])
    if not is_open and hi == end and narrowest >= floor and m > begun:
        m, is_open = m - 1, True
    if is_open:
        where[m, 2] = hi - 1
        _copy(chains, hi, places[m, 1])
        m += 1
    return m


@njit(**OWNING, error_model="numpy")
def wide_parts(tree, solids, chains, nodes, limits):
    """Parts that keep the radius, of all chains that keep it only in places.

    ``nodes`` is the chains' number of nodes. Short parts are left out. Chains that keep the floor
    throughout have no parts and are ``whole`` (c,), the second value; chains that keep the radius
    nowhere have none either.
    """
    first, ends = chains.first, chains.ends
    parts = Parts(np.empty((64, 3), np.int32), np.empty((64, 2, 3)))
    here = np.empty((2, 3))
    whole = np.zeros(len(first) - 1, np.bool_)
    degree = np.zeros(nodes, np.int32)
    for c in range(len(first) - 1):
        degree[ends[c, 0]] += 1
        degree[ends[c, 1]] += 1
    m = np.int64(0)
    for c in range(len(first) - 1):
        begin, end = first[c], first[c + 1] - 1
        is_end = degree[ends[c, 0]] == 1, degree[ends[c, 1]] == 1
        lo, hi = _trusted(tree, solids, chains, is_end, c, limits)
        if lo == begin and hi == end and chains.clearance[c] >= limits.floor:
            whole[c] = True
            continue
        capacity = m + hi - lo + 2
        if capacity > len(parts.where):
            parts = Parts(grown(parts.where, 2 * capacity), grown(parts.places, 2 * capacity))
        kept = m
        for k in range(m, _parts_of(tree, chains, c, lo, hi, limits, parts, m, here)):
            where, places = parts.where[k], parts.places[k]
            if _is_longer(chains.points, where, places, limits.least):
                put_rows(parts.where, kept, where)
                put_rows(parts.places, kept, places)
                kept += 1
        m = kept
    return Parts(parts.where[:m], parts.places[:m]), whole


@njit(**LEAF)
def _copy_point(chains, i, out, n):
    """Write point i of the chains, and the next link, as point n."""
    for c in range(2):
        out.points[n, c], out.pieces[n, c] = chains.points[i, c], chains.pieces[i, c]
    out.proved[n], out.rho[n] = chains.proved[i], chains.rho[i]
    out.gap[n], out.step[n] = chains.gap[i], chains.step[i]


@njit(**LEAF)
def _write(tree, chains, a, s, b, e, out, n):
    """Write a chain from the place a in link s to b in link e; return the number of points."""
    points, rho = chains.points, chains.rho
    if s < e and a[0] == points[s + 1, 0] and a[1] == points[s + 1, 1]:
        s += 1
    if s < e and b[0] == points[e, 0] and b[1] == points[e, 1]:
        e -= 1
    for k in range(s, e + 1):
        _copy_point(chains, k, out, n)
        if k == s:
            out.points[n, 0], out.points[n, 1], out.rho[n] = a[0], a[1], a[2]
        bx, by, there = points[k + 1, 0], points[k + 1, 1], rho[k + 1]
        if k == e:
            bx, by, there = b[0], b[1], b[2]
        ax, ay = out.points[n, 0], out.points[n, 1]
        out.step[n] = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        if k in (s, e):
            out.gap[n] = min(out.rho[n], there)
            if not chains.proved[k]:
                out.gap[n], _, _ = segment_clearance(tree, ax, ay, bx, by, out.gap[n])
        n += 1
    out.points[n, 0], out.points[n, 1], out.rho[n] = b[0], b[1], b[2]
    out.pieces[n, 0], out.pieces[n, 1], out.proved[n] = -1, -1, False
    out.gap[n], out.step[n] = np.inf, 0.0
    return n + 1


@njit(**OWNING, error_model="numpy")
def cut_chains(tree, chains, nodes, parts, whole):
    """Cut chains into their wide parts and those between, in order.

    ``parts`` and ``whole`` are those of :func:`wide_parts`, ``nodes`` is the number of nodes.
    Returns the chains, flags of the wide ones, and the new nodes' x, y and clearance (k, 3).
    """
    where, places = parts
    first, ends = chains.first, chains.ends
    m = len(where)
    most, capacity = len(first) - 1 + 2 * m, len(chains.points) + 4 * m
    out = ChainArrays(
        np.empty((capacity, 2)), np.zeros(most + 1, np.int32), np.empty((capacity, 2), np.int32),
        np.empty(capacity, np.bool_), np.empty(capacity), np.empty(capacity), np.empty(capacity),
        np.empty((most, 2), np.int32), np.zeros(most), np.empty(most),
    )  # fmt: skip
    wide = np.zeros(most, np.bool_)
    node = np.empty((2 * m, 3))
    mark, link = np.empty((2 * m + 2, 3)), np.empty(2 * m + 2, np.int32)
    number = np.empty(2 * m + 2, np.int32)
    made, n, count, k = 0, np.int64(0), np.int64(0), 0
    for c in range(len(first) - 1):
        lo, hi = np.int64(first[c]), np.int64(first[c + 1]) - 1
        if k == m or where[k, 0] != c:
            for i in range(lo, hi + 1):
                _copy_point(chains, i, out, n)
                n += 1
            out.ends[count, 0], out.ends[count, 1] = ends[c, 0], ends[c, 1]
            wide[count] = whole[c]
            count += 1
            out.first[count] = n
            continue
        # the chain's beginning, beginning and end of every wide part, the chain's end
        _copy(chains, lo, mark[0])
        link[0], number[0] = lo, ends[c, 0]
        marks = 1
        while k < m and where[k, 0] == c:
            for side in range(2):
                put_rows(mark, marks, places[k, side])
                link[marks] = where[k, 1 + side]
                number[marks] = -1
                marks += 1
            k += 1
        _copy(chains, hi, mark[marks])
        link[marks], number[marks] = hi - 1, ends[c, 1]
        whole_before = link[1] == lo and mark[1, 0] == mark[0, 0] and mark[1, 1] == mark[0, 1]
        j = marks - 1
        whole_after = link[j] == hi - 1
        whole_after &= mark[j, 0] == mark[marks, 0] and mark[j, 1] == mark[marks, 1]
        for i in range(1, marks):
            if i == 1 and whole_before:
                number[i] = ends[c, 0]
            elif i == j and whole_after:
                number[i] = ends[c, 1]
            else:
                number[i] = nodes + made
                put_rows(node, made, mark[i])
                made += 1
        for i in range(marks):
            if (i == 0 and whole_before) or (i == j and whole_after):
                continue
            n = _write(tree, chains, mark[i], link[i], mark[i + 1], link[i + 1], out, n)
            out.ends[count, 0], out.ends[count, 1] = number[i], number[i + 1]
            wide[count] = i % 2 == 1
            count += 1
            out.first[count] = n
    _measure(out, count)
    cut = ChainArrays(
        out.points[:n], out.first[: count + 1], out.pieces[:n], out.proved[:n], out.rho[:n],
        out.gap[:n], out.step[:n], out.ends[:count], out.length[:count], out.clearance[:count],
    )  # fmt: skip
    return cut, wide[:count], node[:made]


@njit(**LEAF)
def _measure(chains, count):
    """Write length and clearance of the first ``count`` chains; their lengths start at 0."""
    for c in range(count):
        chains.clearance[c] = chains.rho[chains.first[c]]
        for i in range(chains.first[c], chains.first[c + 1] - 1):
            chains.length[c] += chains.step[i]
            chains.clearance[c] = min(chains.clearance[c], chains.gap[i])


@njit(**OWNING, error_model="numpy")
def same_nodes(node_xy, ends, wide, tolerance):
    """Merged node (n,) int32 of each node: the other one at its place, or itself.

    Only nodes of wide chains are merged, and only if no wide chains connect them already.
    """
    n = len(node_xy)
    above = np.arange(n)
    used = np.zeros(n, np.bool_)
    for c in range(len(ends)):
        if wide[c]:
            used[ends[c, 0]], used[ends[c, 1]] = True, True
            above[root_of(above, np.int64(ends[c, 0]))] = root_of(above, np.int64(ends[c, 1]))
    same = np.arange(n).astype(np.int32)
    here = np.flatnonzero(used)
    here = here[np.argsort(node_xy[here, 0], kind="mergesort")]
    for i in range(len(here)):
        a = here[i]
        for j in range(i + 1, len(here)):
            b = here[j]
            if node_xy[b, 0] - node_xy[a, 0] > tolerance:
                break
            if abs(node_xy[b, 1] - node_xy[a, 1]) > tolerance:
                continue
            p, q = root_of(above, a), root_of(above, b)
            if p != q:
                above[p] = q
                same[max(a, b)] = min(a, b)
    for i in range(n):
        same[i] = same[same[i]]
    return same

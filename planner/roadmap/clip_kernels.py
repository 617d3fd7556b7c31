"""Cutting chains where their clearance passes the robot's radius, on flat arrays.

Rules and units
- Chains are numbered as :func:`planner.diagram.trace_kernels.trace_chains` leaves them; chain c's
  points are ``points[first[c] : first[c + 1]]``, and link i runs from point i to point i + 1.
- A wide part is a stretch of a chain that keeps ``radius``. What is narrower than that only by
  rounding, down to ``floor``, does not end it.
- A cut lies on the bisector that its link follows, or on the link where that is straight, and
  keeps the radius itself.
- A dead end off the bisector that it should end is sampling's, in a gap much narrower than the
  generators' spacing: what leads to it and is not proved is no part.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import nearest, segment_clearance
from planner.borders.inside_kernels import in_object
from planner.diagram.bisector_kernels import slide_between
from planner.scene.primitive_kernels import distance

HALVINGS = 52
"""Steps of the search for a cut: as many as a number has digits."""


@njit(cache=True, nogil=True, error_model="numpy")
def _copy(points, rho, i, out):
    """Write x, y and clearance of point i."""
    out[0], out[1], out[2] = points[i, 0], points[i, 1], rho[i]


@njit(cache=True, nogil=True, error_model="numpy")
def _reach(kind, data, order, large, boxes, a, b, left, right, proved, radius, tolerance, out):
    """Write how far from ``a`` (3,), which is wide, the link to b keeps the radius: x, y, rho."""
    out[:] = a
    lo, hi = 0.0, 1.0
    for _ in range(HALVINGS):
        m = 0.5 * (lo + hi)
        x, y = a[0] + m * (b[0] - a[0]), a[1] + m * (b[1] - a[1])
        if proved:
            x, y, found = slide_between(kind, data, left, right, x, y, tolerance)
            d = min(distance(kind, data, left, x, y), distance(kind, data, right, x, y))
            wide = found and d >= radius
        else:
            d, _ = nearest(kind, data, order, large, boxes, x, y, np.inf)
            _, _, which = segment_clearance(
                kind, data, order, large, boxes, a[0], a[1], x, y, radius
            )
            wide = which < 0
        if wide:
            lo = m
            out[0], out[1], out[2] = x, y, d
        else:
            hi = m


@njit(cache=True, nogil=True, error_model="numpy")
def _is_longer(points, where, ends, least):
    """Whether a part is longer than ``least``."""
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


@njit(cache=True, nogil=True, error_model="numpy")
def _is_astray(kind, data, solids, points, pieces, rho, i, link, tolerance):
    """Whether a chain's end, point i, is off the bisector of its link, or behind a border."""
    closed, box = solids
    x, y, r = points[i, 0], points[i, 1], rho[i]
    for side in range(2):
        if abs(distance(kind, data, pieces[link, side], x, y) - r) > tolerance:
            return True
    if not (box[0] < x < box[2] and box[1] < y < box[3]):
        return True
    return in_object(kind, data, closed, x, y, r)


@njit(cache=True, nogil=True, error_model="numpy")
def _trusted(kind, data, solids, points, first, pieces, proved, rho, is_end, c, radius, tolerance):
    """The first and the last point of a chain between which it is not a dead end gone astray.

    ``is_end`` are two flags, whether the chain is a dead end there.
    """
    lo, hi = first[c], first[c + 1] - 1
    a, b = lo, hi
    if lo == hi:
        return a, b
    doubted = is_end[0] and not proved[lo] and rho[lo] >= radius
    if doubted and _is_astray(kind, data, solids, points, pieces, rho, lo, lo, tolerance):
        while a < hi and not proved[a]:
            a += 1
    doubted = is_end[1] and not proved[hi - 1] and rho[hi] >= radius
    if doubted and _is_astray(kind, data, solids, points, pieces, rho, hi, hi - 1, tolerance):
        while b > a and not proved[b - 1]:
            b -= 1
    return a, b


@njit(cache=True, nogil=True, error_model="numpy")
def wide_parts(
    kind, data, order, large, boxes, solids, points, first, pieces, proved, rho, gap, clearance,
    ends, nodes, radius, floor, least, tolerance, astray,
):  # fmt: skip
    """The parts of chains that keep the radius, of every chain that does so in places only.

    Returns ``where`` (m, 3) int32, the chain and the links that the part begins and ends in, and
    ``places`` (m, 2, 3), x, y and clearance of both ends. Parts no longer than ``least`` are left
    out. Chains that keep ``floor`` throughout have none, nor those that keep the radius nowhere:
    ``whole`` (c,) says which are the former. ``solids`` are the index of
    :mod:`planner.borders.inside_kernels` and the box of the bounds; dead ends may be ``astray`` off
    their bisectors.
    """
    where, places = np.empty((64, 3), np.int32), np.empty((64, 2, 3))
    whole = np.zeros(len(first) - 1, np.bool_)
    degree = np.zeros(nodes, np.int32)
    for c in range(len(first) - 1):
        degree[ends[c, 0]] += 1
        degree[ends[c, 1]] += 1
    here = np.empty((2, 3))
    m = 0
    for c in range(len(first) - 1):
        begin, end = first[c], first[c + 1] - 1
        is_end = degree[ends[c, 0]] == 1, degree[ends[c, 1]] == 1
        lo, hi = _trusted(
            kind, data, solids, points, first, pieces, proved, rho, is_end, c, radius, astray
        )
        if lo == begin and hi == end and clearance[c] >= floor:
            whole[c] = True
            continue
        begun, is_open = m, False
        # since the last part's end, or the chain's beginning
        narrowest = np.inf if lo == begin else -np.inf
        for i in range(lo, hi):
            if m + 1 >= len(where):
                more, others = np.empty((2 * m + 2, 3), np.int32), np.empty((2 * m + 2, 2, 3))
                more[:m], others[:m] = where[:m], places[:m]
                where, places = more, others
            _copy(points, rho, i, here[0])
            _copy(points, rho, i + 1, here[1])
            if i == lo and rho[i] >= radius:
                where[m, 0], where[m, 1], is_open = c, i, True
                places[m, 0] = here[0]
            if is_open and gap[i] >= radius:
                continue
            if is_open:
                _reach(
                    kind, data, order, large, boxes, here[0], here[1], pieces[i, 0],
                    pieces[i, 1], proved[i], radius, tolerance, places[m, 1],
                )  # fmt: skip
                where[m, 2] = i
                m += 1
                is_open, narrowest = False, np.inf
            narrowest = min(narrowest, gap[i])
            if rho[i + 1] < radius:
                continue
            is_open = True
            if narrowest >= floor and m > begun:
                m -= 1  # narrow by rounding only: as if it had not ended
            elif narrowest >= floor:
                where[m, 0], where[m, 1] = c, lo
                places[m, 0, 0], places[m, 0, 1], places[m, 0, 2] = (
                    points[lo, 0],
                    points[lo, 1],
                    rho[lo],
                )
            else:
                where[m, 0], where[m, 1] = c, i
                _reach(
                    kind, data, order, large, boxes, here[1], here[0], pieces[i, 0],
                    pieces[i, 1], proved[i], radius, tolerance, places[m, 0],
                )  # fmt: skip
        if not is_open and hi == end and narrowest >= floor and m > begun:
            m, is_open = m - 1, True
        if is_open:
            where[m, 2] = hi - 1
            places[m, 1, 0], places[m, 1, 1], places[m, 1, 2] = (
                points[hi, 0],
                points[hi, 1],
                rho[hi],
            )
            m += 1
        kept = begun
        for k in range(begun, m):
            if _is_longer(points, where[k], places[k], least):
                where[kept], places[kept] = where[k], places[k]
                kept += 1
        m = kept
    return where[:m], places[:m], whole


@njit(cache=True, nogil=True, error_model="numpy")
def _write(
    kind, data, order, large, boxes, points, pieces, proved, rho, gap, a, s, b, e,
    xy, pair, sure, new_rho, new_gap, new_step, n,
):  # fmt: skip
    """Write a chain from the place a in link s to the place b in link e; how many points then."""
    if s < e and a[0] == points[s + 1, 0] and a[1] == points[s + 1, 1]:
        s += 1
    if s < e and b[0] == points[e, 0] and b[1] == points[e, 1]:
        e -= 1
    for k in range(s, e + 1):
        xy[n], pair[n], sure[n], new_rho[n] = points[k], pieces[k], proved[k], rho[k]
        if k == s:
            xy[n, 0], xy[n, 1], new_rho[n] = a[0], a[1], a[2]
        bx, by, there = points[k + 1, 0], points[k + 1, 1], rho[k + 1]
        if k == e:
            bx, by, there = b[0], b[1], b[2]
        ax, ay = xy[n, 0], xy[n, 1]
        new_step[n] = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        new_gap[n] = gap[k]
        if k in (s, e):
            new_gap[n] = min(new_rho[n], there)
            if not proved[k]:
                new_gap[n], _, _ = segment_clearance(
                    kind, data, order, large, boxes, ax, ay, bx, by, new_gap[n]
                )
        n += 1
    xy[n, 0], xy[n, 1], new_rho[n] = b[0], b[1], b[2]
    pair[n, 0], pair[n, 1], sure[n] = -1, -1, False
    new_gap[n], new_step[n] = np.inf, 0.0
    return n + 1


@njit(cache=True, nogil=True, error_model="numpy")
def cut_chains(
    kind, data, order, large, boxes, points, first, pieces, proved, rho, gap, step, ends, nodes,
    where, places, whole,
):  # fmt: skip
    """The chains, those with wide parts cut into these and what is between them, in order.

    ``where``, ``places`` and ``whole`` are as :func:`wide_parts` returns them, ``nodes`` is how
    many nodes there are. Returns points, first, pieces, proved, rho, gap, step, ends, length and
    clearance of the chains, which of them are wide, and the new nodes' x, y and clearance (k, 3).
    """
    m = len(where)
    most, room = len(first) - 1 + 2 * m, len(points) + 4 * m
    xy, pair, sure = np.empty((room, 2)), np.empty((room, 2), np.int32), np.empty(room, np.bool_)
    new_rho, new_gap, new_step = np.empty(room), np.empty(room), np.empty(room)
    new_first, new_ends = np.zeros(most + 1, np.int32), np.empty((most, 2), np.int32)
    wide = np.zeros(most, np.bool_)
    node = np.empty((2 * m, 3))
    mark, link = np.empty((2 * m + 2, 3)), np.empty(2 * m + 2, np.int32)
    number = np.empty(2 * m + 2, np.int32)
    made, n, count, k = 0, 0, 0, 0
    for c in range(len(first) - 1):
        lo, hi = first[c], first[c + 1] - 1
        if k == m or where[k, 0] != c:
            for i in range(lo, hi + 1):
                xy[n], pair[n], sure[n] = points[i], pieces[i], proved[i]
                new_rho[n], new_gap[n], new_step[n] = rho[i], gap[i], step[i]
                n += 1
            new_ends[count], wide[count] = ends[c], whole[c]
            count += 1
            new_first[count] = n
            continue
        # the chain's beginning, beginning and end of every wide part, the chain's end
        _copy(points, rho, lo, mark[0])
        link[0], number[0] = lo, ends[c, 0]
        marks = 1
        while k < m and where[k, 0] == c:
            for side in range(2):
                mark[marks], link[marks] = places[k, side], where[k, 1 + side]
                number[marks] = -1
                marks += 1
            k += 1
        _copy(points, rho, hi, mark[marks])
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
                number[i], node[made] = nodes + made, mark[i]
                made += 1
        for i in range(marks):
            if (i == 0 and whole_before) or (i == j and whole_after):
                continue
            n = _write(
                kind, data, order, large, boxes, points, pieces, proved, rho, gap, mark[i],
                link[i], mark[i + 1], link[i + 1], xy, pair, sure, new_rho, new_gap, new_step, n,
            )  # fmt: skip
            new_ends[count, 0], new_ends[count, 1] = number[i], number[i + 1]
            wide[count] = i % 2 == 1
            count += 1
            new_first[count] = n
    length, clearance = np.zeros(count), np.empty(count)
    for c in range(count):
        clearance[c] = new_rho[new_first[c]]
        for i in range(new_first[c], new_first[c + 1] - 1):
            length[c] += new_step[i]
            clearance[c] = min(clearance[c], new_gap[i])
    return (
        xy[:n], new_first[: count + 1], pair[:n], sure[:n], new_rho[:n], new_gap[:n],
        new_step[:n], new_ends[:count], length, clearance, wide[:count], node[:made],
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def _root(above, n):
    """The representative of a set of nodes."""
    while above[n] != n:
        above[n] = above[above[n]]
        n = above[n]
    return n


@njit(cache=True, nogil=True, error_model="numpy")
def same_nodes(node_xy, ends, wide, tolerance):
    """The node that each one is (n,) int32: the other one at its place, or itself.

    Only wide chains' nodes are joined, and only such as no wide chains join already.
    """
    n = len(node_xy)
    above = np.arange(n)
    used = np.zeros(n, np.bool_)
    for c in range(len(ends)):
        if wide[c]:
            used[ends[c, 0]], used[ends[c, 1]] = True, True
            above[_root(above, ends[c, 0])] = _root(above, ends[c, 1])
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
            p, q = _root(above, a), _root(above, b)
            if p != q:
                above[p] = q
                same[max(a, b)] = min(a, b)
    for i in range(n):
        same[i] = same[same[i]]
    return same

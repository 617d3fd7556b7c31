"""Removal of sites from a triangulation.

Rules and units
- Arrays are those of :mod:`planner.delaunay.insertion_kernels`. A site's star becomes a hole,
  filled ear by ear: three consecutive corners whose circle holds no other corner are a new triangle
  (Devillers 2002).
- Site i owns the triangles 2 i and 2 i + 1, which must be free when it is inserted again: the
  removal moves triangles from there.
- A site on the convex hull is not removed; the caller then triangulates again.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.delaunay.insertion_kernels import circle_band
from planner.delaunay.predicate_kernels import SCRATCH, in_circle, orient
from planner.delaunay.triangle_kernels import DEAD, next_side, side_of, triangle_of
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import predecessor, successor


@njit(**LEAF)
def _circle(px, py, ax, ay, bx, by):
    """Circle of three sites: x, y, and the squared radii of `circle_band`."""
    ax, ay, bx, by = ax - px, ay - py, bx - px, by - py
    return circle_band(
        px, py, ax, ay, ax * ax + ay * ay, abs(ax) + abs(ay),
        bx, by, bx * bx + by * by, abs(bx) + abs(by),
    )  # fmt: skip


@njit(**LEAF)
def _find_ear(w, xy, ring, m, circle):
    """First corner of a hole that forms an empty-circle triangle with its neighbours, or -1.

    ``circle`` (4,) becomes the ear's.
    """
    before = m - 1
    for i in range(m):
        after = successor(i, m)
        a, b, c = ring[before], ring[i], ring[after]
        ax, ay, bx, by = xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1]
        cx, cy = xy[2 * c], xy[2 * c + 1]
        if orient(w, ax, ay, bx, by, cx, cy) > 0:
            x, y, low, high = _circle(ax, ay, bx, by, cx, cy)
            is_empty = True
            for j in range(m):
                if j in (before, i, after):
                    continue
                qx, qy = xy[2 * ring[j]], xy[2 * ring[j] + 1]
                square = (qx - x) * (qx - x) + (qy - y) * (qy - y)
                if square > high:
                    continue
                # decide NaN, and anything in the band, exactly
                if square < low or in_circle(w, ax, ay, bx, by, cx, cy, qx, qy) > 0:
                    is_empty = False
                    break
            if is_empty:
                circle[0], circle[1], circle[2], circle[3] = x, y, low, high
                return i
        before = i
    return -1


@njit(**LEAF)
def _place(tri, at, s, a, b, c, outer_a, outer_b, outer_c):
    """Write triangle a, b, c into slot s; outer_x is the half-edge across from x, or -1."""
    tri[s], tri[s + 1], tri[s + 2] = a, b, c
    at[a], at[b], at[c] = s, s + 1, s + 2
    if outer_a >= 0:
        tri[s + 4], tri[outer_a + 4] = outer_a, s
    if outer_b >= 0:
        tri[s + 5], tri[outer_b + 4] = outer_b, s + 1
    if outer_c >= 0:
        tri[s + 6], tri[outer_c + 4] = outer_c, s + 2


@njit(**LEAF)
def _move(tri, circ, at, old, new):
    for k in range(3):
        site, o = np.int64(tri[old + k]), np.int64(tri[old + 4 + k])
        tri[new + k], tri[new + 4 + k] = site, o
        tri[o + 4] = new + k
        at[site] = new + k
    for k in range(4):
        circ[(new >> 1) + k] = circ[(old >> 1) + k]


@njit(**LEAF)
def _find_stars(tri, wanted, at):
    """Set in ``at`` (ghost + 1,) a half-edge opposite each ``wanted`` (ghost + 1,) site."""
    for h in range(0, len(tri), 8):
        a = np.int64(tri[h])
        if a == DEAD:
            continue
        b, c = np.int64(tri[h + 1]), np.int64(tri[h + 2])
        if wanted[a] | wanted[b] | wanted[c]:
            at[a], at[b], at[c] = h, h + 1, h + 2


@njit(**LEAF)
def _star(tri, ghost, start, ring, outer, slot):
    """Write the star of the site opposite half-edge ``start``, counter-clockwise; return its size.

    ``ring`` are the sites around it, ``outer`` the half-edges across from it, ``slot`` its
    triangles. Returns -1 if the site is on the hull.
    """
    m = 0
    e = start
    while True:
        t = triangle_of(e)
        v = t + next_side(side_of(e))
        ring[m], outer[m], slot[m] = np.int64(tri[v]), np.int64(tri[e + 4]), t
        if ring[m] == ghost:
            return -1
        m += 1
        o = np.int64(tri[v + 4])
        e = triangle_of(o) + next_side(side_of(o))
        if e == start:
            return m


@njit(**LEAF)
def _free_own(tri, circ, at, p, free_0, free_1):
    """Move the contents of site p's two triangles to two free ones."""
    tri[free_0], tri[free_1] = DEAD, DEAD
    for own in (16 * p, 16 * p + 8):
        if np.int64(tri[own]) == DEAD:
            continue
        if free_0 not in (16 * p, 16 * p + 8):
            _move(tri, circ, at, own, free_0)
            free_0 = np.int64(own)
        else:
            _move(tri, circ, at, own, free_1)
            free_1 = np.int64(own)
        tri[own] = DEAD
    at[p] = -1


@njit(**LEAF)
def _remove(w, xy, ghost, tri, circ, order, at, circle, space):
    r""":func:`remove` in ``order``, with a half-edge ``at`` each of them, and space to work in.

    The star of site p becomes a hole; each ear that is cut off it is a triangle of what stays.

          before                 a hole                 an ear at b
        d ------- c            d ------- c            d ------- c
        | \     / |            |         |            |       / |
        |    p    |            |         |            |     /   |
        | /     \ |            |         |            |   /     |
        a ------- b            a ------- b            a ------- b
    """
    ring, outer, slot = space[0], space[1], space[2]
    for p in order:
        m = _star(tri, ghost, at[p], ring, outer, slot)
        if m < 0:
            return False
        # put the site's own two triangles last among the slots
        last = m - 1
        for own in (16 * p + 8, 16 * p):
            for j in range(last):
                if slot[j] == own:
                    slot[j], slot[last] = slot[last], slot[j]
            if slot[last] == own:
                last -= 1
        free_0, free_1 = slot[m - 1], slot[m - 2]
        n = 0
        while m > 3:
            ear = _find_ear(w, xy, ring, m, circle)
            if ear < 0:
                return False
            before, after = predecessor(ear, m), successor(ear, m)
            s = slot[n]
            n += 1
            _place(
                tri, at, s, ring[before], ring[ear], ring[after], outer[ear], np.int64(-1),
                outer[before],
            )  # fmt: skip
            for k in range(4):
                circ[(s >> 1) + k] = circle[k]
            outer[before] = s + 1
            for i in range(ear, m - 1):
                ring[i], outer[i] = ring[i + 1], outer[i + 1]
            m -= 1
        s = slot[n]
        a, b, c = ring[0], ring[1], ring[2]
        _place(tri, at, s, a, b, c, outer[1], outer[2], outer[0])
        circ[s >> 1], circ[(s >> 1) + 1], circ[(s >> 1) + 2], circ[(s >> 1) + 3] = _circle(
            xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1], xy[2 * c], xy[2 * c + 1]
        )
        _free_own(tri, circ, at, p, free_0, free_1)
    return True


@njit(**OWNING, error_model="numpy")
def remove(xy, ghost, tri, circ, gone):
    """Take the sites ``gone`` out of tri and circ; False if one is on the hull.

    Or if a hole cannot be filled; the arrays are then unfinished.
    """
    wanted = np.zeros(ghost + 1, np.bool_)
    for g in gone:
        wanted[g] = True
    at = np.full(ghost + 1, -1, np.int64)
    _find_stars(tri, wanted, at)
    # every other site first, then every other one of the rest: keeps stars small
    step = 2
    order = np.empty(len(gone), np.int64)
    count = 0
    while count < len(gone):
        for j in range(step // 2 - 1, len(gone), step):
            order[count] = gone[j]
            count += 1
        step *= 2
    space = np.empty((3, 2 * ghost), np.int64)
    return _remove(np.empty(SCRATCH), xy, ghost, tri, circ, order, at, np.empty(4), space)

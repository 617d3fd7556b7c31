"""Voronoi diagram by incremental insertion: Sugihara and Iri's method on flat arrays.

The method. Sites are inserted one at a time; a new site removes the Voronoi vertices whose empty
circle it enters and puts its own cell in their place. Topology comes first (Sugihara and Iri 1992):
the removed vertices must form a non-empty tree, and each touched cell must meet that tree in one
connected piece. `insert` enforces this with one rule: whatever the numbers say, the result is a
sphere's triangulation. Doubtful signs are computed exactly
(:mod:`planner.delaunay.predicate_kernels`). The order is that of
:mod:`planner.delaunay.site_order_kernels`.

The arrays. A Voronoi vertex is a triangle of three sites, counter-clockwise in x right, y up;
`ghost`, the site at infinity, closes the sphere. ``tri`` holds the triangles as in
``triangle_kernels.py``. circ[4t: 4t + 4] is the vertex: x, y, and the squared radii below which a
site is surely inside and above which it is surely outside. Anything between, and any NaN, as for
all ghosts, is decided exactly. Site i owns the triangles 2i and 2i + 1. Coordinates are scaled by a
power of two to at most 1 and rounded to multiples of 2^-268.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.delaunay.predicate_kernels import SCRATCH, UNIT, in_circle, orient
from planner.delaunay.site_order_kernels import coarse_to_fine, load_sites, spatial_order
from planner.delaunay.triangle_kernels import (
    DEAD,
    next_side,
    previous_side,
    side_of,
    triangle_of,
)
from planner.scene.compile_options import LEAF, OWNING

CIRCLE_SLACK = 32.0 * UNIT
"""Twice the first-order error bound of a circle's centre, see `circle_band`."""


@njit(**LEAF)
def conflict(w, xy, ghost, tri, t, px, py):
    """1 if p removes triangle t (given as 8 t), 0 if it lies on its circle, else -1; exact.

    A ghost's circle is the half-plane beyond its two sites, with the open segment between them.
    """
    a, b, c = np.int64(tri[t]), np.int64(tri[t + 1]), np.int64(tri[t + 2])
    if a == ghost:
        a, b, c = b, c, a
    elif b == ghost:
        a, b, c = c, a, b
    ax, ay = xy[2 * a], xy[2 * a + 1]
    bx, by = xy[2 * b], xy[2 * b + 1]
    if c != ghost:
        cx, cy = xy[2 * c], xy[2 * c + 1]
        return in_circle(w, ax, ay, bx, by, cx, cy, px, py)
    side = orient(w, ax, ay, bx, by, px, py)
    if side != 0:
        return side
    if ax != bx:
        return 1 if min(ax, bx) < px < max(ax, bx) else -1
    return 1 if min(ay, by) < py < max(ay, by) else -1


@njit(**LEAF)
def _locate(w, xy, ghost, tri, t, px, py):
    """Triangle (as 8 t) that p removes, or -1 - site if p coincides with that site.

    An exact visibility walk, which cannot circle in a Delaunay triangulation. If it does, all
    triangles are tried; if p removes none, the walk's last one is returned.
    """
    n_slots = tri.shape[0] // 8
    for _ in range(n_slots + 1):
        if conflict(w, xy, ghost, tri, t, px, py) == 1:
            return t
        over = -1
        for k in range(3):
            v = np.int64(tri[t + k])
            if v != ghost and xy[2 * v] == px and xy[2 * v + 1] == py:
                return -1 - v
            a = np.int64(tri[t + next_side(k)])
            b = np.int64(tri[t + previous_side(k)])
            if a == ghost or b == ghost:
                continue
            side = orient(w, xy[2 * a], xy[2 * a + 1], xy[2 * b], xy[2 * b + 1], px, py)
            # leave a ghost through its only edge, even for a site on that edge's line
            if side < 0 or (side == 0 and v == ghost):
                over = k
        if over < 0:
            break
        t = triangle_of(np.int64(tri[t + 4 + over]))
    for s in range(n_slots):
        if np.int64(tri[8 * s]) != DEAD:
            if conflict(w, xy, ghost, tri, 8 * s, px, py) == 1:
                return 8 * s
            for k in range(3):
                v = np.int64(tri[8 * s + k])
                if v != ghost and xy[2 * v] == px and xy[2 * v + 1] == py:
                    return -1 - v
    return t


@njit(**LEAF)
def _first_triangle(w, xy, n, ghost, tri, circ):
    """Make the first triangle and its ghosts; return its three sites, or -1."""
    second = 1
    while second < n and xy[2 * second] == xy[0] and xy[2 * second + 1] == xy[1]:
        second += 1
    if second >= n:
        return 0, -1, -1
    third = second + 1
    side = 0
    while third < n:
        side = orient(
            w, xy[0], xy[1], xy[2 * second], xy[2 * second + 1], xy[2 * third], xy[2 * third + 1]
        )
        if side != 0:
            break
        third += 1
    if third >= n:
        return 0, second, -1
    a, b, c = 0, second, third
    if side < 0:
        b, c = c, b
    corner = (a, b, c)
    slot = (0, 8, 16 * second, 16 * second + 8)
    tri[16 * third] = DEAD
    tri[16 * third + 8] = DEAD
    for k in range(3):
        tri[k] = corner[k]
        tri[4 + k] = slot[k + 1] + 2
        g = slot[k + 1]
        tri[g] = corner[previous_side(k)]
        tri[g + 1] = corner[next_side(k)]
        tri[g + 2] = ghost
        tri[g + 4] = slot[1 + previous_side(k)] + 1
        tri[g + 5] = slot[1 + next_side(k)]
        tri[g + 6] = k
    for k in range(4):
        # no circle: decide exactly
        circ[(slot[k] >> 1) + 0] = np.nan
        circ[(slot[k] >> 1) + 1] = np.nan
        circ[(slot[k] >> 1) + 2] = np.nan
        circ[(slot[k] >> 1) + 3] = np.nan
    return a, second, third


@njit(**LEAF, forceinline=True)
def circle_band(px, py, ax, ay, a_square, a_sum, bx, by, b_square, b_sum):
    """Circle through p and the sites at a and b from it: x, y, and its squared radii.

    ``a_square`` and ``a_sum`` are the sums of a's coordinates' squares and magnitudes.

    The error of a circle through p, a, b with A = a - p, B = b - p, sums of magnitudes s and t,
    squares la and lb, determinant d and centre p + C, |C| <= c is to first order E <= u (7 (la t +
    lb s) / 2d + 11 s t c / 2d + 3 c + 2). A site is surely inside below (r - 2 E)^2 and outside
    above (r + 2 E)^2; 32 u for each coefficient leaves a factor of two for rounding r^2, the
    distance, and this bound.
    """
    half = 0.5 / (ax * by - ay * bx)
    cx = (a_square * by - b_square * ay) * half
    cy = (b_square * ax - a_square * bx) * half
    spread = abs(half) * a_sum * b_sum
    reach = abs(cx) + abs(cy)
    error = CIRCLE_SLACK * (
        abs(half) * (a_square * b_sum + b_square * a_sum) + spread * reach + reach + 1.0
    )
    if spread * CIRCLE_SLACK > 0.25:
        error = np.inf
    x, y = px + cx, py + cy
    dx, dy = px - x, py - y
    square = dx * dx + dy * dy
    band = 4.0 * error * (reach + error)
    return x, y, square - band, square + band


@njit(**LEAF, forceinline=True)
def _walk(xy, tri, circ, t, px, py, limit):
    """Walk from triangle t towards p: the triangle, and True if p surely lies in its circle.

    At most ``limit`` steps; :func:`_locate` resolves doubtful cases.
    """
    found = False
    for _ in range(limit):
        dx, dy = px - circ[t >> 1], py - circ[(t >> 1) + 1]
        if dx * dx + dy * dy < circ[(t >> 1) + 2]:
            found = True
            break
        a, b, c = np.int64(tri[t]), np.int64(tri[t + 1]), np.int64(tri[t + 2])
        ax, ay = xy[2 * a] - px, xy[2 * a + 1] - py
        bx, by = xy[2 * b] - px, xy[2 * b + 1] - py
        cx, cy = xy[2 * c] - px, xy[2 * c + 1] - py
        least = 0.0
        over = -1
        side = bx * cy - by * cx
        if side < least:
            least, over = side, 0
        side = cx * ay - cy * ax
        if side < least:
            least, over = side, 1
        side = ax * by - ay * bx
        if side < least:
            least, over = side, 2
        if over < 0:
            break
        t = triangle_of(np.int64(tri[t + 4 + over]))
    return t, found


@njit(**LEAF, forceinline=True)
def _grow_removed(w, xy, ghost, tri, circ, t, p, space):
    """Removed tree, from triangle t outwards, its rim counter-clockwise.

    Returns the numbers of removed triangles, of half-edges on the rim, and of circles with p on
    them. ``space[3]`` holds the triangles, ``space[1]`` the rim's kept half-edges, ``space[2]`` the
    sites where they end.
    """
    stamp, rim, rim_site, gone, stack = space[0], space[1], space[2], space[3], space[4]
    px, py = xy[2 * p], xy[2 * p + 1]
    n_gone, n_rim, depth, ties = 1, 0, 2, 0
    gone[0] = t
    stamp[tri[t]] = p
    stamp[tri[t + 1]] = p
    stamp[tri[t + 2]] = p
    stack[0], stack[1] = t + 2, t + 1
    e = t
    while True:
        o = np.int64(tri[e + 4])
        t = triangle_of(o)
        dx, dy = px - circ[t >> 1], py - circ[(t >> 1) + 1]
        square = dx * dx + dy * dy
        k = side_of(o)
        if square > circ[(t >> 1) + 3]:
            hit = False
        elif square < circ[(t >> 1) + 2]:
            hit = stamp[tri[o]] != p
        else:
            sign = conflict(w, xy, ghost, tri, t, px, py)
            ties += sign == 0
            hit = sign > 0 and stamp[tri[o]] != p
        if hit:
            stamp[tri[o]] = p
            gone[n_gone] = t
            n_gone += 1
            stack[depth] = t + previous_side(k)
            depth += 1
            e = t + next_side(k)
            continue
        rim_site[n_rim] = tri[t + previous_side(k)]
        rim[n_rim] = o
        n_rim += 1
        if depth == 0:
            return n_gone, n_rim, ties
        depth -= 1
        e = np.int64(stack[depth])


@njit(**LEAF, forceinline=True)
def _fill(xy, tri, circ, p, n_gone, n_rim, space):
    r"""Fill the hole with a fan of triangles around p, the new cell; return the last triangle.

      before                 after
    d ------- c            d ------- c
    | \       |            | \     / |       the rim a, b, c, d stays; the fan takes
    |   \  p  |            |    p    |       p's own two triangles, and the removed ones
    |     \   |            | /     \ |
    a ------- b            a ------- b
    """
    rim, rim_site, gone = space[1], space[2], space[3]
    px, py = xy[2 * p], xy[2 * p + 1]
    gone[n_gone] = 16 * p
    gone[n_gone + 1] = 16 * p + 8
    before = np.int64(gone[n_rim - 1])
    here = np.int64(gone[0])
    a = np.int64(rim_site[0])
    rim_site[n_rim] = a
    gone[n_rim] = here
    ax, ay = xy[2 * a] - px, xy[2 * a + 1] - py
    a_square = ax * ax + ay * ay
    a_sum = abs(ax) + abs(ay)
    for j in range(n_rim):
        b = np.int64(rim_site[j + 1])
        after = np.int64(gone[j + 1])
        o = np.int64(rim[j])
        tri[here] = p
        tri[here + 1] = a
        tri[here + 2] = b
        tri[here + 4] = o
        tri[here + 5] = after + 2
        tri[here + 6] = before + 1
        tri[o + 4] = here
        bx, by = xy[2 * b] - px, xy[2 * b + 1] - py
        b_square = bx * bx + by * by
        b_sum = abs(bx) + abs(by)
        x, y, low, high = circle_band(px, py, ax, ay, a_square, a_sum, bx, by, b_square, b_sum)
        circ[here >> 1] = x
        circ[(here >> 1) + 1] = y
        circ[(here >> 1) + 2] = low
        circ[(here >> 1) + 3] = high
        a, ax, ay, a_square, a_sum = b, bx, by, b_square, b_sum
        before, here = here, after
    return before


@njit(**LEAF)
def _insert(w, xy, ghost, tri, circ, alias, todo, start, space):
    """Work of :func:`insert`, with ``space`` (5, 2 ghost + 8) uint32.

    A triangle joins the removed tree only through an edge, and only if its far corner is not yet on
    the tree's rim. So the removed part stays a disc with every corner once on its rim: a tree that
    each touched cell meets in one piece.
    """
    ties = 0
    given = start.shape[0]
    limit = 64 + 4 * np.int64(math.sqrt(ghost))
    last = np.int64(0)
    while np.int64(tri[last]) == DEAD:
        last += 8
    for j in range(todo.shape[0]):
        p = np.int64(todo[j])
        px, py = xy[2 * p], xy[2 * p + 1]
        t = np.int64(last)
        if j < given and start[j] >= 0:
            t = np.int64(start[j])
        t, found = _walk(xy, tri, circ, t, px, py, limit)
        if not found:
            t = _locate(w, xy, ghost, tri, t, px, py)
            if t < 0:
                alias[p] = -1 - t
                tri[16 * p] = DEAD
                tri[16 * p + 8] = DEAD
                continue
        n_gone, n_rim, on_circle = _grow_removed(w, xy, ghost, tri, circ, t, p, space)
        ties += on_circle
        last = _fill(xy, tri, circ, p, n_gone, n_rim, space)
    return ties


@njit(**OWNING, error_model="numpy")
def insert(w, xy, ghost, tri, circ, alias, todo, start):
    """Insert the sites ``todo`` into tri and circ.

    alias[i] becomes the site that i coincides with. The search for ``todo[j]`` begins at triangle
    ``start[j]`` if given, otherwise where the last one ended. Returns the number of times that a
    site lay exactly on a circle.
    """
    space = np.empty((5, 2 * ghost + 8), np.uint32)
    space[0, : ghost + 1] = DEAD
    return _insert(w, xy, ghost, tri, circ, alias, todo, start, space)


@njit(**OWNING, error_model="numpy")
def triangulate(sites, spare):
    """Triangulation of (n, 2) finite float64 sites, with space for ``spare`` more.

    Returns status (0: done, 1: all sites on one line, the rest is not set), order (n,), the row of
    every site, xy, tri, circ and alias (the ghost is site n + spare), the exponent that scales xy
    back, and the number of times that a site lay on a circle.
    """
    n = sites.shape[0]
    ghost = n + spare
    order = spatial_order(sites)
    xy = np.empty(2 * ghost + 2)
    exponent = load_sites(sites, order, xy)
    xy[2 * ghost], xy[2 * ghost + 1] = np.nan, np.nan
    tri = np.empty(16 * ghost, np.uint32)
    tri[::8] = DEAD
    circ = np.empty(8 * ghost)
    alias = np.arange(ghost)
    w = np.empty(SCRATCH)
    first, second, third = _first_triangle(w, xy, n, ghost, tri, circ)
    ties = 0
    if third >= 0:
        todo = coarse_to_fine(n, first, second, third)
        ties = insert(w, xy, ghost, tri, circ, alias, todo, np.empty(0, np.int64))
    return 0 if third >= 0 else 1, order, xy, tri, circ, alias, exponent, ties

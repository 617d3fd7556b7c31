"""Places on the borders' bisectors: vertices, turning points, and polylines along an edge.

Rules and units
- A vertex of three different pieces is where their distances agree: Newton's method on
  ``distance_i(x) - rho = 0``, whose rows are the unit normals, started at the sampled vertex.
- At a turning point an edge passes from a primitive to its own corner point: both have the same
  foot, and the search follows the primitive's normal.
- All other places of a chain are slid onto the bisector of the two pieces beside them.
- Left and right are those of ``cross(along, left - right) > 0`` in the scene's coordinates.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import segment_clearance
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import foot, grown
from planner.scene.shape_kernels import normal_at

NEWTON_STEPS = 40
"""Newton steps; four suffice on random scenes, near-parallel borders take more."""
SINGULAR = 1e-7
"""Least determinant of two differences of unit normals for Newton's step."""
SAME_NORMALS = 2e-3
"""Difference of normals below which a bisector is too ill-defined to slide onto."""
LINK_HALVINGS = 20
"""Most halvings of a link; its bulge falls by four with each."""


@njit(**LEAF, forceinline=True)
def _normal(kind, data, i, x, y):
    """Distance from piece i and the unit vector from its foot to (x, y)."""
    fx, fy = foot(kind, data, i, x, y)
    dx, dy = x - fx, y - fy
    d = math.sqrt(dx * dx + dy * dy)
    if d == 0.0:
        return 0.0, 0.0, 0.0
    return d, dx / d, dy / d


@njit(**LEAF)
def meet_three(kind, data, a, b, c, x, y, reach, tolerance):
    """Place equidistant to three pieces near (x, y): x, y, found."""
    sx, sy = x, y
    for _ in range(NEWTON_STEPS):
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


@njit(**LEAF)
def slide_between(kind, data, a, b, x, y, tolerance):
    """Slide (x, y) onto the bisector of two pieces: x, y, found."""
    sx, sy = x, y
    for _ in range(NEWTON_STEPS):
        da, ax, ay = _normal(kind, data, a, x, y)
        db, bx, by = _normal(kind, data, b, x, y)
        f = da - db
        if abs(f) <= tolerance:
            return x, y, True
        gx, gy = ax - bx, ay - by
        gg = gx * gx + gy * gy
        if gg < SAME_NORMALS * SAME_NORMALS:
            break
        x, y = x - f * gx / gg, y - f * gy / gg
    return sx, sy, False


@njit(**LEAF)
def turn_at(kind, data, corner, side, c, x, y, tolerance):
    """Place on a primitive's normal at its corner point that is equally near to piece c."""
    px, py = data[corner, 0], data[corner, 1]
    nx, ny = normal_at(kind, data, side, px, py)
    n = math.sqrt(nx * nx + ny * ny)
    nx, ny = nx / n, ny / n
    s = nx * (x - px) + ny * (y - py)
    if s < 0.0:
        nx, ny, s = -nx, -ny, -s
    for _ in range(NEWTON_STEPS):
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


@njit(**LEAF)
def heading(kind, data, left, right, x, y):
    """Direction along the bisector with ``left`` to the left, and the clearance's growth.

    Returns the unit direction and the clearance's derivative along it; all 0 if the feet coincide.
    """
    lx, ly = foot(kind, data, left, x, y)
    rx, ry = foot(kind, data, right, x, y)
    tx, ty = ly - ry, rx - lx
    n = math.sqrt(tx * tx + ty * ty)
    if n == 0.0:
        return 0.0, 0.0, 0.0
    tx, ty = tx / n, ty / n
    nx, ny = x - lx, y - ly
    d = math.sqrt(nx * nx + ny * ny)
    if d == 0.0:
        return tx, ty, 0.0
    return tx, ty, (nx * tx + ny * ty) / d


@njit(**LEAF)
def narrowest(kind, data, left, right, x0, y0, x1, y1, tolerance):
    """Place of the bisector's least clearance between two of its places, if inside: x, y, found."""
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


@njit(**LEAF)
def _tangents_meet(kind, data, left, right, ax, ay, bx, by):
    """Intersection, between a and b, of the bisector's tangents there: x, y, found."""
    ux, uy, _ = heading(kind, data, left, right, ax, ay)
    vx, vy, _ = heading(kind, data, left, right, bx, by)
    dx, dy = bx - ax, by - ay
    turn = ux * vy - uy * vx
    if turn == 0.0:
        return ax, ay, False
    ahead, back = (dx * vy - dy * vx) / turn, (ux * dy - uy * dx) / turn
    span = math.sqrt(dx * dx + dy * dy)
    if abs(ahead) > span or abs(back) > span or (ahead > 0.0) != (back > 0.0):
        return ax, ay, False
    return ax + ahead * ux, ay + ahead * uy, True


@njit(**LEAF)
def _keeps(tree, ax, ay, bx, by, need):
    _, _, which = segment_clearance(tree, ax, ay, bx, by, need)
    return which < 0


@njit(**OWNING, error_model="numpy")
def follow(tree, points, pairs, need, flatness, tolerance, exact):
    """Polyline that follows its links' bisectors as closely as required.

    ``pairs`` (n, 2) are the pieces beside each link, -1 if the link is straight. A link is halved
    on its bisector while its straight line is nearer than ``need`` to a border or bulges by more
    than ``flatness``. A line nearer than a finite ``exact`` is replaced by the corner of the
    bisector's tangents, if that keeps it. Returns points and pairs.
    """
    kind, data = tree.kind, tree.data
    n = len(points)
    capacity = 4 * n + 64
    xy = np.empty((capacity, 2))
    pair = np.empty((capacity, 2), np.int32)
    stack = np.empty((LINK_HALVINGS + 2, 2))
    level = np.empty(LINK_HALVINGS + 2, np.int32)
    m = 0
    for i in range(n):
        if m + 1 >= capacity:
            capacity *= 2
            xy, pair = grown(xy, capacity), grown(pair, capacity)
        xy[m, 0], xy[m, 1] = points[i, 0], points[i, 1]
        pair[m, 0], pair[m, 1] = pairs[i, 0], pairs[i, 1]
        m += 1
        if i + 1 == n or pairs[i, 0] < 0:
            continue
        left, right = np.int64(pairs[i, 0]), np.int64(pairs[i, 1])
        top = 1
        stack[0, 0], stack[0, 1], level[0] = points[i + 1, 0], points[i + 1, 1], 0
        while top > 0:
            ax, ay = xy[m - 1, 0], xy[m - 1, 1]
            bx, by, deep = stack[top - 1, 0], stack[top - 1, 1], level[top - 1]
            mx, my, found = slide_between(
                kind, data, left, right, 0.5 * (ax + bx), 0.5 * (ay + by), tolerance
            )
            bulge = math.sqrt((mx - 0.5 * (ax + bx)) ** 2 + (my - 0.5 * (ay + by)) ** 2)
            span = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            split = found and deep < LINK_HALVINGS and tolerance < bulge < 0.5 * span
            if split and bulge <= flatness:
                if exact < np.inf and not _keeps(tree, ax, ay, bx, by, exact):
                    qx, qy, met = _tangents_meet(kind, data, left, right, ax, ay, bx, by)
                    if (
                        met
                        and _keeps(tree, ax, ay, qx, qy, exact)
                        and _keeps(tree, qx, qy, bx, by, exact)
                    ):
                        if m + 2 >= capacity:
                            capacity *= 2
                            xy, pair = grown(xy, capacity), grown(pair, capacity)
                        xy[m, 0], xy[m, 1] = qx, qy
                        pair[m, 0], pair[m, 1] = pairs[i, 0], pairs[i, 1]
                        m += 1
                        split = False
                if split:
                    split = not _keeps(tree, ax, ay, bx, by, need)
            if split:
                stack[top, 0], stack[top, 1], level[top] = mx, my, deep + 1
                level[top - 1] = deep + 1
                top += 1
                continue
            top -= 1
            if top > 0:
                if m + 1 >= capacity:
                    capacity *= 2
                    xy, pair = grown(xy, capacity), grown(pair, capacity)
                xy[m, 0], xy[m, 1] = bx, by
                pair[m, 0], pair[m, 1] = pairs[i, 0], pairs[i, 1]
                m += 1
    return xy[:m], pair[:m]

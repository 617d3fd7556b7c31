"""Crossing or point of contact of two neighbouring fitted edges, and their directions there.

Rules and units
- A fitted edge is a row x, y, ux, uy of a line or cx, cy, r of a circle (see ``Outline`` in
  ``vision.outline.outline_types``); pixels, y down.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF

SHALLOW = 0.03
"""Sine of the angle below which two lines are one: chosen, 1.7 degrees."""
DIRECTION_POINTS = np.int64(6)
"""Points on either side of a break, or of a wall's end, that give the border's direction: chosen, a
wall's half width and the rounding."""


@njit(**LEAF)
def onto(shape, e, is_arc, x, y):
    """Point nearest to (x, y) on the fitted line or circle of edge e."""
    if is_arc:
        dx = x - shape[e, 0]
        dy = y - shape[e, 1]
        d = math.sqrt(dx * dx + dy * dy)
        if d == 0.0:
            return x, y
        return shape[e, 0] + dx * shape[e, 2] / d, shape[e, 1] + dy * shape[e, 2] / d
    t = (x - shape[e, 0]) * shape[e, 2] + (y - shape[e, 1]) * shape[e, 3]
    return shape[e, 0] + t * shape[e, 2], shape[e, 1] + t * shape[e, 3]


@njit(**LEAF)
def tangent_at(row, is_arc, x, y, along_x, along_y):
    """Unit vector along a fitted edge at (x, y), towards (along_x, along_y)."""
    tx = row[2]
    ty = row[3]
    if is_arc:
        tx = (row[1] - y) / row[2]
        ty = (x - row[0]) / row[2]
    if tx * along_x + ty * along_y < 0.0:
        return -tx, -ty
    return tx, ty


@njit(**LEAF)
def crossing(border, here, a, a_arc, b, b_arc, out):
    """Find the crossing of two neighbouring edges nearest to point ``here``; False without one.

    out = x, y and the sine of half the corner's inner angle, which scales the rounding.
    """
    if not a_arc and not b_arc:
        cross = a[2] * b[3] - a[3] * b[2]
        if abs(cross) < SHALLOW:
            return False
        t = ((b[0] - a[0]) * b[3] - (b[1] - a[1]) * b[2]) / cross
        out[0] = a[0] + t * a[2]
        out[1] = a[1] + t * a[3]
        # a narrow tip is rounded far back
        out[2] = math.sqrt(max(0.5 * (1.0 + a[2] * b[2] + a[3] * b[3]), 0.0))
        return True
    if a_arc and b_arc:
        dx = b[0] - a[0]
        dy = b[1] - a[1]
        d = math.sqrt(dx * dx + dy * dy)
        if d < 1e-9:
            return False
        along = (d * d + a[2] * a[2] - b[2] * b[2]) / (2.0 * d)
        base_x = a[0] + along * dx / d
        base_y = a[1] + along * dy / d
        off2 = a[2] * a[2] - along * along
        off_x = -dy / d
        off_y = dx / d
    else:
        line = b if a_arc else a
        arc = a if a_arc else b
        t = (arc[0] - line[0]) * line[2] + (arc[1] - line[1]) * line[3]
        base_x = line[0] + t * line[2]
        base_y = line[1] + t * line[3]
        off2 = arc[2] * arc[2] - (arc[0] - base_x) ** 2 - (arc[1] - base_y) ** 2
        off_x = line[2]
        off_y = line[3]
    if off2 < 0.0:
        return False
    off = math.sqrt(off2)
    x = border.x[here]
    y = border.y[here]
    if (x - base_x) * off_x + (y - base_y) * off_y < 0.0:
        off = -off
    out[0] = base_x + off * off_x
    out[1] = base_y + off * off_y
    # the border's directions before and after
    p = here - min(DIRECTION_POINTS, border.n // 4)
    q = here + min(DIRECTION_POINTS, border.n // 4)
    p = p + border.n if p < 0 else p
    ax, ay = tangent_at(a, a_arc, out[0], out[1], x - border.x[p], y - border.y[p])
    bx, by = tangent_at(b, b_arc, out[0], out[1], border.x[q] - x, border.y[q] - y)
    out[2] = math.sqrt(max(0.5 * (1.0 + ax * bx + ay * by), 0.0))
    return True


@njit(**LEAF)
def touch(a, a_arc, b, b_arc, out):
    """Place where an arc and its neighbour come nearest; out = x, y and the gap (crossing:
    negative).

    Two arcs touch from outside or inside, whichever leaves the smaller gap.
    """
    if a_arc and b_arc:
        dx = b[0] - a[0]
        dy = b[1] - a[1]
        d = math.sqrt(dx * dx + dy * dy)
        if d < 1e-9:
            return False
        outside = d - a[2] - b[2]
        inside = d - abs(a[2] - b[2])
        ta = a[2]
        tb = d - b[2]
        gap = outside
        if abs(inside) < abs(outside):
            if a[2] >= b[2]:
                tb = d + b[2]
            else:
                ta = -a[2]
            gap = -inside
        t = 0.5 * (ta + tb) / d
        out[0] = a[0] + t * dx
        out[1] = a[1] + t * dy
        out[2] = gap
        return True
    line = b if a_arc else a
    arc = a if a_arc else b
    t = (arc[0] - line[0]) * line[2] + (arc[1] - line[1]) * line[3]
    foot_x = line[0] + t * line[2]
    foot_y = line[1] + t * line[3]
    dx = foot_x - arc[0]
    dy = foot_y - arc[1]
    d = math.sqrt(dx * dx + dy * dy)
    if d < 1e-9:
        return False
    share = 0.5 * (1.0 + arc[2] / d)
    out[0] = arc[0] + share * dx
    out[1] = arc[1] + share * dy
    out[2] = d - arc[2]
    return True

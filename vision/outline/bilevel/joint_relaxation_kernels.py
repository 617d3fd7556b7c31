"""A chain of edges moved until it passes between the pixels, in a picture without grey.

Rules and units
- Types: ``vision.outline.outline_types``. Every point is the middle between an obstacle pixel and a
  free one: an edge within half a pixel along the axis separates them.
- A point follows both joints of its edge as on a lever, and the arc's rise as a parabola. Each
  sweep solves every joint and rise by damped least squares on the excess over the limit, weighted
  less the farther.
- ``push`` (2 * edges, 6): for each edge the normal equations of its first joint, xx, xy, yy and x,
  y, and its rise; then the rise's equations, and the joint's first position.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from planner.scene.primitive_kernels import successor
from vision.outline.fit.outline_kernels import edge_end
from vision.outline.fit.separating_fit_kernels import HALF, SEPARATION_MARGIN, weight_of
from vision.outline.fitted_borders import ARC_CW, LINE

SWEEPS = 24
"""Most sweeps: chosen, a bound on the work."""
PACE = 0.6
"""Share of a step taken: chosen, as neighbours step too."""
DAMPING = 0.3
"""Resistance in points: chosen, one point must not move a joint far."""
JOINT_MOVE_PX = 6.0
"""Largest movement of a joint: chosen, a bound on errors."""


@njit(**LEAF)
def relax_joints(border, outline, edges, finished, push):
    """Move the joints and the arcs of finished edges between the pixels.

    Changes ``joints``, ``shape`` and ``is_arc``; finish the edges again. ``push`` is scratch space.
    """
    joints = outline.joints
    kinds = finished.kind
    rows = finished.rows
    for e in range(edges):
        after = successor(e, edges)
        rise = 0.0
        if kinds[e] != LINE:
            rise = _rise(rows, e, after, kinds[e])
        push[e, 5] = rise
        push[edges + e, 3] = joints[e, 0]
        push[edges + e, 4] = joints[e, 1]
    for _ in range(SWEEPS):
        for e in range(edges):
            for c in range(5):
                push[e, c] = 0.0
            for c in range(3):
                push[edges + e, c] = 0.0
        beyond = 0.0
        for e in range(edges):
            beyond += _pushes(border, outline, edges, kinds, push, e)
        if beyond == 0.0:
            break
        _step(outline, edges, kinds, push)
    for e in range(edges):
        outline.is_arc[e] = kinds[e] != LINE
        _shape_of(outline, e, successor(e, edges), push[e, 5])


@njit(**LEAF)
def _step(outline, edges, kinds, push):
    joints = outline.joints
    for e in range(edges):
        xx = push[e, 0] + DAMPING
        yy = push[e, 2] + DAMPING
        det = xx * yy - push[e, 1] * push[e, 1]
        dx = PACE * (push[e, 3] * yy - push[e, 4] * push[e, 1]) / det
        dy = PACE * (push[e, 4] * xx - push[e, 3] * push[e, 1]) / det
        x = joints[e, 0] + dx
        y = joints[e, 1] + dy
        if (x - push[edges + e, 3]) ** 2 + (y - push[edges + e, 4]) ** 2 < JOINT_MOVE_PX**2:
            joints[e, 0] = x
            joints[e, 1] = y
        if kinds[e] != LINE:
            push[e, 5] += PACE * push[edges + e, 1] / (push[edges + e, 0] + DAMPING)


@njit(**LEAF)
def _rise(rows, e, after, kind):
    """Distance of an arc's middle to the left of its chord, signed; y down."""
    x0 = rows[e, 0]
    y0 = rows[e, 1]
    dx = rows[after, 0] - x0
    dy = rows[after, 1] - y0
    chord = math.sqrt(dx * dx + dy * dy)
    if chord < 1e-9:
        return 0.0
    c = ((rows[e, 2] - x0 - 0.5 * dx) * dy - (rows[e, 3] - y0 - 0.5 * dy) * dx) / chord
    return c + rows[e, 4] if kind == ARC_CW else c - rows[e, 4]


@njit(**LEAF)
def circle_through(x0, y0, x1, y1, rise):
    """Centre and radius of the arc that rises by ``rise`` to the left of its chord."""
    dx = x1 - x0
    dy = y1 - y0
    chord = math.sqrt(dx * dx + dy * dy)
    c = 0.5 * (rise - 0.25 * chord * chord / rise)
    cx = x0 + 0.5 * dx + c * dy / chord
    cy = y0 + 0.5 * dy - c * dx / chord
    return cx, cy, abs(rise - c)


@njit(**LEAF)
def _pushes(border, outline, edges, kinds, push, e):
    """Add the pushes of edge e's points on its joints and its rise; return their weight."""
    joints = outline.joints
    after = successor(e, edges)
    dx = joints[after, 0] - joints[e, 0]
    dy = joints[after, 1] - joints[e, 1]
    if dx * dx + dy * dy < 1e-9:
        return 0.0
    lo = outline.breaks[e]
    hi = edge_end(outline.breaks, edges, border.n, e) + 1
    xs = border.x[lo:hi]
    ys = border.y[lo:hi]
    if kinds[e] == LINE or abs(push[e, 5]) <= 1e-3:
        return _line_pushes(xs, ys, joints, edges, e, push)
    return _arc_pushes(xs, ys, joints, edges, e, push)


@njit(**SUMS)
def _line_pushes(xs, ys, joints, edges, e, push):
    """Add the pushes of points ``xs``, ``ys`` on line e; return their weight."""
    after = successor(e, edges)
    x0 = joints[e, 0]
    y0 = joints[e, 1]
    dx = joints[after, 0] - x0
    dy = joints[after, 1] - y0
    square = dx * dx + dy * dy
    length = math.sqrt(square)
    inv = 1.0 / square
    beyond = 0.0
    rise_ww = 0.0
    rise_w = 0.0
    nx = dy / length
    ny = -dx / length
    limit = (HALF - SEPARATION_MARGIN) * max(abs(nx), abs(ny))
    ww = 0.0
    tt = 0.0
    wd = 0.0
    td = 0.0
    for k in range(xs.shape[0]):
        x = xs[k] - x0
        y = ys[k] - y0
        d = x * nx + y * ny
        t = (x * dx + y * dy) * inv
        inside = (abs(d) > limit) & (t >= 0.0) & (t <= 1.0)
        counts = weight_of(max(abs(d) - limit, 0.0)) if inside else 0.0
        excess = counts * (d + limit if d < 0.0 else d - limit)
        w = 1.0 - t
        ww += counts * w * w
        tt += counts * t * t
        wd += w * excess
        td += t * excess
        middle = 4.0 * t * w
        rise_ww += counts * middle * middle
        rise_w += middle * excess
        beyond += counts
    push[e, 0] += ww * nx * nx
    push[e, 1] += ww * nx * ny
    push[e, 2] += ww * ny * ny
    push[e, 3] += wd * nx
    push[e, 4] += wd * ny
    push[after, 0] += tt * nx * nx
    push[after, 1] += tt * nx * ny
    push[after, 2] += tt * ny * ny
    push[after, 3] += td * nx
    push[after, 4] += td * ny
    push[edges + e, 0] += rise_ww
    push[edges + e, 1] += rise_w
    return beyond


@njit(**SUMS)
def _arc_pushes(xs, ys, joints, edges, e, push):  # noqa: PLR0915 - sums of one loop, side by side
    """Add the pushes of points ``xs``, ``ys`` on arc e; return their weight."""
    after = successor(e, edges)
    x0 = joints[e, 0]
    y0 = joints[e, 1]
    dx = joints[after, 0] - x0
    dy = joints[after, 1] - y0
    inv = 1.0 / (dx * dx + dy * dy)
    beyond = 0.0
    rise_ww = 0.0
    rise_w = 0.0
    cx, cy, r = circle_through(x0, y0, x0 + dx, y0 + dy, push[e, 5])
    sign = 1.0 if push[e, 5] > 0.0 else -1.0
    a0 = 0.0
    a1 = 0.0
    a2 = 0.0
    a3 = 0.0
    a4 = 0.0
    b0 = 0.0
    b1 = 0.0
    b2 = 0.0
    b3 = 0.0
    b4 = 0.0
    for k in range(xs.shape[0]):
        nx = sign * (xs[k] - cx)
        ny = sign * (ys[k] - cy)
        far = math.sqrt(nx * nx + ny * ny)
        share = 1.0 / max(far, 1e-9)
        nx *= share
        ny *= share
        d = sign * (far - r)
        t = ((xs[k] - x0) * dx + (ys[k] - y0) * dy) * inv
        limit = (HALF - SEPARATION_MARGIN) * max(abs(nx), abs(ny))
        inside = (abs(d) > limit) & (t >= 0.0) & (t <= 1.0)
        counts = weight_of(max(abs(d) - limit, 0.0)) if inside else 0.0
        excess = counts * (d + limit if d < 0.0 else d - limit)
        w = 1.0 - t
        ww = counts * w * w
        tt = counts * t * t
        a0 += ww * nx * nx
        a1 += ww * nx * ny
        a2 += ww * ny * ny
        a3 += w * excess * nx
        a4 += w * excess * ny
        b0 += tt * nx * nx
        b1 += tt * nx * ny
        b2 += tt * ny * ny
        b3 += t * excess * nx
        b4 += t * excess * ny
        middle = 4.0 * t * w
        rise_ww += counts * middle * middle
        rise_w += middle * excess
        beyond += counts
    push[e, 0] += a0
    push[e, 1] += a1
    push[e, 2] += a2
    push[e, 3] += a3
    push[e, 4] += a4
    push[after, 0] += b0
    push[after, 1] += b1
    push[after, 2] += b2
    push[after, 3] += b3
    push[after, 4] += b4
    push[edges + e, 0] += rise_ww
    push[edges + e, 1] += rise_w
    return beyond


@njit(**LEAF)
def _shape_of(outline, e, after, rise):
    joints = outline.joints
    shape = outline.shape
    x0 = joints[e, 0]
    y0 = joints[e, 1]
    x1 = joints[after, 0]
    y1 = joints[after, 1]
    length = math.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2)
    if length < 1e-9:
        return
    if outline.is_arc[e]:
        if abs(rise) < 1e-6:
            rise = 1e-6 if rise >= 0.0 else -1e-6
        shape[e, 0], shape[e, 1], shape[e, 2] = circle_through(x0, y0, x1, y1, rise)
    else:
        shape[e, 0] = x0
        shape[e, 1] = y0
        shape[e, 2] = (x1 - x0) / length
        shape[e, 3] = (y1 - y0) / length

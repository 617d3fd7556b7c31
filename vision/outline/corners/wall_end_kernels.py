"""Ends of narrow walls: the short side between two lines where the border turns back.

Pictures with grey only; types: ``vision.outline.outline_types``. A search that ignores points near
its breaks misses a side no longer than blur rounds at its corners.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.corners.blurred_corner_kernels import change_cost, put_corner
from vision.outline.corners.crossing_kernels import DIRECTION_POINTS
from vision.outline.corners.fillet_kernels import MOST_TURN
from vision.outline.corners.joint_kernels import nearest_point
from vision.outline.fit.edge_shape_kernels import HUGE
from vision.shared.typed_numbers import NO

BACK = math.cos(MOST_TURN)
"""Cosine between two lines from which the border turns back: where there is no fillet."""
LEAST_WALL_POINTS = 8
"""Points of such a line: less is no wall (indifferent)."""
WIDTH_BY = 2.2
"""Width of a sharp tip's border in sigmas of the blur (chosen), besides `WIDTH_MORE_PX`; the
half-way level alone would make it 1.35."""
WIDTH_MORE_PX = 0.5
"""Addition to `WIDTH_BY`: indifferent."""
PLAIN_PX = 2.5
"""Excess over what blur rounds at its corners from which the search finds a side: chosen, the
points of its fit."""
SHORTEST = 2
"""Points of the shortest side: derived, they make a line."""
SQUARE_PX = 1.5
"""Distance by which one end of a square side may lie behind the other: chosen, its few points do
not decide."""


@njit(**LEAF)
def turns_back(a, b, stays):
    """True if the border turns back between two lines with enough points."""
    if stays[1] - stays[0] < LEAST_WALL_POINTS or stays[3] - stays[2] < LEAST_WALL_POINTS:
        return False
    return a[2] * b[2] + a[3] * b[3] < BACK


@njit(**LEAF)
def try_end(border, blur, costs, change):
    """Put a side square to the wall between the two lines that stay: the cost, or HUGE."""
    px = border.x
    py = border.y
    n = border.n
    rows, joints, points = change.rows, change.joints, change.points
    a = rows[0]
    b = rows[2]
    # along the wall, towards its end
    ux = a[2] - b[2]
    uy = a[3] - b[3]
    length = math.sqrt(ux * ux + uy * uy)
    ux /= length
    uy /= length
    best = -HUGE
    tip = change.stays[1]
    width = 0.0
    first = change.stays[1] - DIRECTION_POINTS
    here = first % n
    for k in range(first, change.stays[2] + DIRECTION_POINTS + 1):
        x = px[here]
        y = py[here]
        here = successor(here, n)
        from_a = (x - a[0]) * a[3] - (y - a[1]) * a[2]
        from_b = (x - b[0]) * b[3] - (y - b[1]) * b[2]
        far = x * ux + y * uy - abs(from_a - from_b)
        if far > best:
            best = far
            tip = k
            width = abs(from_a + from_b)
    if not WIDTH_BY * blur.sigma + WIDTH_MORE_PX < width < WIDTH_BY * blur.guard + PLAIN_PX:
        return HUGE
    x = px[tip % n]
    y = py[tip % n]
    rows[1, 0] = x
    rows[1, 1] = y
    rows[1, 2] = -uy
    rows[1, 3] = ux
    if (b[0] - a[0]) * rows[1, 2] + (b[1] - a[1]) * rows[1, 3] < 0.0:
        rows[1, 2] = uy
        rows[1, 3] = -ux
    for side in range(2):
        row = a if side == 0 else b
        t = ((x - row[0]) * ux + (y - row[1]) * uy) / (row[2] * ux + row[3] * uy)
        joints[side, 0] = row[0] + t * row[2]
        joints[side, 1] = row[1] + t * row[3]
        found, _ = nearest_point(
            border, tip % n, DIRECTION_POINTS, DIRECTION_POINTS, joints[side, 0], joints[side, 1]
        )
        points[1 + side] = tip + (found - tip + n // 2) % n - n // 2
    if points[2] - points[1] < SHORTEST:
        points[1] = tip - 1
        points[2] = tip + 1
    points[0] = min(points[0], points[1] - 1)
    points[3] = max(points[3], points[2] + 1)
    inside = points[0] >= 0 and points[3] <= 2 * n
    if points[2] - points[1] > 2 * DIRECTION_POINTS + 1 or not inside:
        return HUGE
    put_corner(a[2], a[3], rows[1, 2], rows[1, 3], change.corners[0])
    put_corner(rows[1, 2], rows[1, 3], b[2], b[3], change.corners[1])
    return change_cost(border, change, NO, 0.0, blur.sigma, costs, HUGE)


@njit(**LEAF, forceinline=False)
def square_ends(outline, edges, blur):
    """Turn nearly square sides at walls' ends square to their walls."""
    is_arc = outline.is_arc
    shape = outline.shape
    joints = outline.joints
    for e in range(edges):
        before = predecessor(e, edges)
        after = successor(e, edges)
        if is_arc[e] or is_arc[before] or is_arc[after]:
            continue
        a = shape[before]
        b = shape[after]
        if a[2] * b[2] + a[3] * b[3] >= BACK:
            continue
        dx = joints[after, 0] - joints[e, 0]
        dy = joints[after, 1] - joints[e, 1]
        if dx * dx + dy * dy > (WIDTH_BY * blur.guard + PLAIN_PX) ** 2:
            continue
        ux = a[2] - b[2]
        uy = a[3] - b[3]
        length = math.sqrt(ux * ux + uy * uy)
        ux /= length
        uy /= length
        askew = shape[e, 2] * ux + shape[e, 3] * uy
        width = (b[0] - a[0]) * a[3] - (b[1] - a[1]) * a[2]
        if abs(askew * width) > SQUARE_PX:
            continue
        vx = shape[e, 2] - askew * ux
        vy = shape[e, 3] - askew * uy
        length = math.sqrt(vx * vx + vy * vy)
        shape[e, 2] = vx / length
        shape[e, 3] = vy / length
        for side in range(2):
            row = a if side == 0 else b
            joint = e if side == 0 else after
            t = (shape[e, 0] - row[0]) * ux + (shape[e, 1] - row[1]) * uy
            t /= row[2] * ux + row[3] * uy
            joints[joint, 0] = row[0] + t * row[2]
            joints[joint, 1] = row[1] + t * row[3]

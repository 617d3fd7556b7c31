"""Tests that straight lines keep a distance to every border, stopping at the first nearer one.

They are several times faster than :func:`planner.borders.box_tree_kernels.segment_clearance` with a
bound, as the least distance is not computed.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import LEAF_BOXES, after_branch, box_distance2
from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import NONE, distance, segment_distance
from planner.scene.shape_kernels import is_beyond


@njit(**BORROWING)
def blocker(tree, ax, ay, bx, by, keep, guess):
    """Primitive nearer than ``keep`` to the segment a b, or -1.

    ``guess`` is a primitive to try first, or -1.
    """
    kind, data, order, large, boxes = tree
    if guess >= 0 and segment_distance(kind, data, guess, ax, ay, bx, by)[0] < keep:
        return guess
    x0, x1 = min(ax, bx) - keep, max(ax, bx) + keep
    y0, y1 = min(ay, by) - keep, max(ay, by) + keep
    around = x0, y0, x1, y1
    length = math.hypot(bx - ax, by - ay)
    nx, ny = 0.0, 0.0
    if length > 0.0:
        nx, ny = (ay - by) / length, (bx - ax) / length
    # measure primitives that are this far apart except for rounding
    sure = keep * (1.0 + 1e-9)
    for j in range(large):
        i = np.int64(order[j])
        if is_beyond(kind, data, i, ax, ay, nx, ny, around, sure):
            continue
        if segment_distance(kind, data, i, ax, ay, bx, by)[0] < keep:
            return i
    steep_x, steep_y = 0.5 * abs(nx), 0.5 * abs(ny)
    n, leaves = len(order), len(boxes) // 2
    node, later = np.int64(1), np.int64(0)
    while node > 0:
        u0, v0, u1, v1 = boxes[node, 0], boxes[node, 1], boxes[node, 2], boxes[node, 3]
        # an empty box is (inf, inf, -inf, -inf) and lies beyond every line
        apart = u0 >= x1 or u1 <= x0 or v0 >= y1 or v1 <= y0
        if not apart:
            off = abs(nx * (0.5 * (u0 + u1) - ax) + ny * (0.5 * (v0 + v1) - ay))
            apart = off - steep_x * (u1 - u0) - steep_y * (v1 - v0) >= sure
        if not apart:
            if node < leaves:
                node, later = 2 * node, 2 * later + 1
                continue
            first = large + (node - leaves) * LEAF_BOXES
            for j in range(first, min(first + LEAF_BOXES, n)):
                i = np.int64(order[j])
                if is_beyond(kind, data, i, ax, ay, nx, ny, around, sure):
                    continue
                if segment_distance(kind, data, i, ax, ay, bx, by)[0] < keep:
                    return i
        node, later = after_branch(node, later)
    return -1


@njit(**BORROWING)
def keeps(tree, line, keep):
    """True if the polyline (n, 2), n >= 1, is nowhere nearer than ``keep`` to any primitive."""
    last = len(line) - 1
    for i in range(max(last, 1)):
        j = min(i + 1, last)
        met = blocker(tree, line[i, 0], line[i, 1], line[j, 0], line[j, 1], keep, NONE)
        if met >= 0:
            return False
    return True


@njit(**OWNING)
def within(tree, x, y, reach):
    """Primitives no farther than ``reach`` from (x, y), in the tree's order."""
    kind, data, order, large, boxes = tree
    out = np.empty(len(order), np.int32)
    m = 0
    for j in range(large):
        if distance(kind, data, np.int64(order[j]), x, y) <= reach:
            out[m] = order[j]
            m += 1
    n, leaves = len(order), len(boxes) // 2
    node, later = np.int64(1), np.int64(0)
    while node > 0:
        if box_distance2(boxes, node, x, y) <= reach * reach:
            if node < leaves:
                node, later = 2 * node, 2 * later + 1
                continue
            first = large + (node - leaves) * LEAF_BOXES
            for j in range(first, min(first + LEAF_BOXES, n)):
                if distance(kind, data, np.int64(order[j]), x, y) <= reach:
                    out[m] = order[j]
                    m += 1
        node, later = after_branch(node, later)
    return out[:m].copy()

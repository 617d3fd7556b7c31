"""Box tree over flat primitives that finds the nearest one.

Rules and units
- The primitives are those of :mod:`planner.scene.primitive_kernels`; distances are in the scene's
  units.
- The tree is an implicit binary tree over the boxes in Morton order: node 1 is the root, node i has
  children 2i and 2i + 1, and every leaf holds ``LEAF_BOXES`` primitives. Primitives that span much
  of the scene (its walls) would bloat every box above them: a separate list has them, and is tried
  first.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.borders.border_arrays import Tree
from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import NONE, box_of, distance, segment_distance

LEAF_BOXES = 4
"""Primitives in a leaf of the tree."""
LARGE_PRIMITIVE = 0.25
"""Length from which a primitive stays out of the tree, as a share of the scene's extent."""


@njit(**BORROWING)
def _spread(v):
    """Spread the 16 low bits of v, one every second bit."""
    v = (v | (v << 8)) & 0x00FF00FF
    v = (v | (v << 4)) & 0x0F0F0F0F
    v = (v | (v << 2)) & 0x33333333
    return (v | (v << 1)) & 0x55555555


@njit(**OWNING)
def morton_codes(boxes):
    """Numbers (n,) that grow along a curve past the middles of boxes (n, 4), and their extent.

    An empty box has the number 0.
    """
    x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
    for i in range(len(boxes)):
        x0, y0 = min(x0, boxes[i, 0]), min(y0, boxes[i, 1])
        x1, y1 = max(x1, boxes[i, 2]), max(y1, boxes[i, 3])
    extent = max(x1 - x0, y1 - y0)
    scale = 65535.0 / extent if extent > 0.0 else 0.0
    code = np.zeros(len(boxes), np.int64)
    for i in range(len(boxes)):
        if boxes[i, 0] <= boxes[i, 2]:
            mx = int((0.5 * (boxes[i, 0] + boxes[i, 2]) - x0) * scale)
            my = int((0.5 * (boxes[i, 1] + boxes[i, 3]) - y0) * scale)
            code[i] = _spread(mx) | (_spread(my) << 1)
    return code, extent


@njit(**OWNING)
def build_tree(kind, data):
    """Build the box tree of all primitives; an empty box is (inf, inf, -inf, -inf)."""
    n = len(kind)
    own = np.empty((n, 4), np.float64)
    for i in range(n):
        box_of(kind, data, i, own[i])
    code, extent = morton_codes(own)
    large = 0
    for i in range(n):
        if max(own[i, 2] - own[i, 0], own[i, 3] - own[i, 1]) > LARGE_PRIMITIVE * extent:
            code[i] = -1
            large += 1
    order = np.argsort(code).astype(np.int32)
    leaves = 1
    while leaves * LEAF_BOXES < n - large:
        leaves *= 2
    boxes = np.empty((2 * leaves, 4), np.float64)
    boxes[:, :2] = np.inf
    boxes[:, 2:] = -np.inf
    for j in range(n - large):
        node, i = leaves + j // LEAF_BOXES, order[large + j]
        boxes[node, 0] = min(boxes[node, 0], own[i, 0])
        boxes[node, 1] = min(boxes[node, 1], own[i, 1])
        boxes[node, 2] = max(boxes[node, 2], own[i, 2])
        boxes[node, 3] = max(boxes[node, 3], own[i, 3])
    for node in range(leaves - 1, 0, -1):
        for c in range(2):
            boxes[node, c] = min(boxes[2 * node, c], boxes[2 * node + 1, c])
            boxes[node, c + 2] = max(boxes[2 * node, c + 2], boxes[2 * node + 1, c + 2])
    return Tree(kind, data, order, large, boxes)


@njit(**BORROWING)
def box_distance2(boxes, node, x, y):
    """Squared distance from (x, y) to a node's box; infinite for an empty one."""
    dx = max(boxes[node, 0] - x, 0.0, x - boxes[node, 2])
    dy = max(boxes[node, 1] - y, 0.0, y - boxes[node, 3])
    return dx * dx + dy * dy


@njit(**BORROWING)
def after_branch(node, later):
    """Next node after a branch of the box tree, and the new ``later``; 0 at the end.

    ``later`` has a bit for every level above, the last one lowest, set if the node's sibling there
    is still to be visited.
    """
    while node > 1 and later & 1 == 0:
        node >>= 1
        later >>= 1
    if node == 1:
        return 0, 0
    return node ^ 1, later ^ 1


@njit(**BORROWING)
def nearest(tree, x, y, bound):
    """Distance to and index of the primitive nearest to (x, y), if nearer than ``bound``.

    Otherwise returns (bound, -1).
    """
    kind, data, order, large, boxes = tree
    best, which = bound, NONE
    for j in range(large):
        i = np.int64(order[j])
        d = distance(kind, data, i, x, y)
        if d < best:
            best, which = d, i
    n, leaves = len(order), len(boxes) // 2
    node, later = np.int64(1), np.int64(0)
    while node > 0:
        if box_distance2(boxes, node, x, y) < best * best:
            if node < leaves:
                # the nearer branch first
                node = 2 * node
                if not box_distance2(boxes, node, x, y) < box_distance2(boxes, node + 1, x, y):
                    node += 1
                later = 2 * later + 1
                continue
            first = large + (node - leaves) * LEAF_BOXES
            for j in range(first, min(first + LEAF_BOXES, n)):
                i = np.int64(order[j])
                d = distance(kind, data, i, x, y)
                if d < best:
                    best, which = d, i
        node, later = after_branch(node, later)
    return best, which


@njit(**BORROWING)
def _box_to_segment(boxes, node, ax, ay, bx, by, nx, ny):
    """Lower bound of the distance between a box and a segment with unit normal (nx, ny)."""
    x0, y0, x1, y1 = boxes[node, 0], boxes[node, 1], boxes[node, 2], boxes[node, 3]
    if x0 > x1:
        return np.inf
    dx = max(x0 - max(ax, bx), 0.0, min(ax, bx) - x1)
    dy = max(y0 - max(ay, by), 0.0, min(ay, by) - y1)
    off = nx * (0.5 * (x0 + x1) - ax) + ny * (0.5 * (y0 + y1) - ay)
    half = 0.5 * (abs(nx) * (x1 - x0) + abs(ny) * (y1 - y0))
    return max(math.sqrt(dx * dx + dy * dy), abs(off) - half)


@njit(**BORROWING)
def segment_clearance(tree, ax, ay, bx, by, bound):
    """Least distance of the segment a b to any primitive, if less than ``bound``.

    Returns the distance, its place along a b, and the primitive; otherwise (bound, 0, -1).
    """
    kind, data, order, large, boxes = tree
    best, at, which = bound, 0.0, NONE
    for j in range(large):
        i = np.int64(order[j])
        d, t = segment_distance(kind, data, i, ax, ay, bx, by)
        if d < best:
            best, at, which = d, t, i
    length = math.hypot(bx - ax, by - ay)
    nx, ny = 0.0, 0.0
    if length > 0.0:
        nx, ny = (ay - by) / length, (bx - ax) / length
    n, leaves = len(order), len(boxes) // 2
    node, later = np.int64(1), np.int64(0)
    while node > 0:
        if _box_to_segment(boxes, node, ax, ay, bx, by, nx, ny) < best:
            if node < leaves:
                node, later = 2 * node + 1, 2 * later + 1
                continue
            first = large + (node - leaves) * LEAF_BOXES
            for j in range(first, min(first + LEAF_BOXES, n)):
                i = np.int64(order[j])
                d, t = segment_distance(kind, data, i, ax, ay, bx, by)
                if d < best:
                    best, at, which = d, t, i
        node, later = after_branch(node, later)
    return best, at, which


@njit(**OWNING)
def nearest_many(tree, points):
    """Distance and nearest primitive of every point."""
    out = np.empty(len(points), np.float64)
    which = np.empty(len(points), np.int32)
    for i in range(len(points)):
        out[i], which[i] = nearest(tree, points[i, 0], points[i, 1], np.inf)
    return out, which


@njit(**OWNING)
def polyline_clearance(tree, points):
    """Least distance of a polyline to any primitive: distance, place, piece, primitive."""
    best, where = nearest(tree, points[0, 0], points[0, 1], np.inf)
    px, py, piece = points[0, 0], points[0, 1], 0
    for i in range(len(points) - 1):
        ax, ay, bx, by = points[i, 0], points[i, 1], points[i + 1, 0], points[i + 1, 1]
        d, t, which = segment_clearance(tree, ax, ay, bx, by, best)
        if which >= 0:
            best, where, piece = d, which, i
            px, py = ax + t * (bx - ax), ay + t * (by - ay)
    return best, px, py, piece, where


@njit(**OWNING)
def object_spans(kind, data, owner, count):
    """Objects' boxes (o, 4) and their primitives' range (o, 2), first and last + 1."""
    most = -1
    for i in range(count):
        most = max(most, owner[i])
    boxes = np.empty((most + 1, 4))
    boxes[:, :2], boxes[:, 2:] = np.inf, -np.inf
    span = np.zeros((most + 1, 2), np.int32)
    span[:, 0] = count
    own = np.empty(4)
    for i in range(count):
        o = owner[i]
        if o < 0:
            continue
        box_of(kind, data, i, own)
        span[o, 0] = min(span[o, 0], i)
        span[o, 1] = i + 1
        for c in range(2):
            boxes[o, c] = min(boxes[o, c], own[c])
            boxes[o, c + 2] = max(boxes[o, c + 2], own[c + 2])
    return boxes, span

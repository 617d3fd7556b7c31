"""Exact distances to flat primitives, and a box tree that finds the nearest of many.

Rules and units
- A primitive is a row of :class:`planner.scene.Primitives`: ``kind`` and six numbers, and
  three more that :func:`with_middles` adds.
- Distances are unsigned and in the scene's units; a border has no inside here.
- The tree is an implicit binary tree over the boxes in Morton order: node 1 is the root,
  node i has children 2i and 2i + 1, and every leaf holds ``LEAF`` primitives. Primitives that
  span a large part of the scene (its walls) would bloat every box above them: they are kept
  in a list of their own and tried first, which also gives a good first bound.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.shared.compile_options import BORROWING

POINT, SEGMENT, CIRCLE, ARC = 0, 1, 2, 3
LEAF = 4
"""Primitives in a leaf of the tree."""
LARGE = 0.25
"""A primitive longer than this share of the scene's extent is kept out of the tree."""
TAU = 2.0 * math.pi
SURE_COSINE = 1e-14
"""Cosines of unit vectors are equal within this: some 40 roundings of 2^-53."""
TURN_SLACK = (3.0 + 16.0 * 2.0**-53) * 2.0**-53
"""Error bound of a turn's determinant over its two products (Shewchuk 1997, ccwerrboundA)."""


@njit(**BORROWING, error_model="numpy", forceinline=True)
def on_sweep(data, i, x, y):
    """Whether the direction from an arc's centre to (x, y) lies within its sweep."""
    dx, dy = x - data[i, 0], y - data[i, 1]
    along, d = dx * data[i, 6] + dy * data[i, 7], math.sqrt(dx * dx + dy * dy)
    past = along - data[i, 8] * d
    if abs(past) > SURE_COSINE * d:
        return past > 0.0
    return _on_sweep_by_angle(data, i, dx, dy, along)


@njit(**BORROWING, error_model="numpy")
def _on_sweep_by_angle(data, i, dx, dy, along):
    """:func:`on_sweep` where cosines are too flat to say: near either end, and of thin arcs."""
    if data[i, 8] < -1.0:
        return True
    across = dy * data[i, 6] - dx * data[i, 7]
    return abs(math.atan2(across, along)) <= 0.5 * data[i, 4]


@njit(cache=True, nogil=True)
def with_middles(kind, data):
    """The primitives' rows with three more numbers for arcs, so that no query needs angles.

    The unit vector from the centre to the arc's middle, and the cosine of half its sweep (-2
    for the whole circle).
    """
    out = np.zeros((len(kind), 9))
    out[:, :6] = data
    for i in range(len(kind)):
        if kind[i] == ARC:
            half = 0.5 * data[i, 4]
            out[i, 6], out[i, 7] = math.cos(data[i, 3] + half), math.sin(data[i, 3] + half)
            out[i, 8] = -2.0 if data[i, 4] >= TAU else math.cos(half)
    return out


@njit(**BORROWING, error_model="numpy", forceinline=True)
def foot_on_segment(px, py, ax, ay, bx, by):
    """The point of the segment a b nearest to p, and how far along (0 to 1) it lies."""
    dx, dy = bx - ax, by - ay
    ahead = (px - ax) * dx + (py - ay) * dy
    # also where a and b are one place, or so near that their squares vanish
    if not ahead > 0.0:
        return ax, ay, 0.0
    dd = dx * dx + dy * dy
    if ahead >= dd:
        return bx, by, 1.0
    t = ahead / dd
    return ax + t * dx, ay + t * dy, t


@njit(**BORROWING, error_model="numpy", forceinline=True)
def foot(kind, data, i, x, y):
    """The point of primitive i that is nearest to (x, y)."""
    k = kind[i]
    if k == POINT:
        return data[i, 0], data[i, 1]
    if k == SEGMENT:
        fx, fy, _ = foot_on_segment(x, y, data[i, 0], data[i, 1], data[i, 2], data[i, 3])
        return fx, fy
    return _round_foot(kind, data, i, x, y)


@njit(**BORROWING, error_model="numpy")
def _round_foot(kind, data, i, x, y):
    """The point of a circle or an arc that is nearest to (x, y)."""
    cx, cy, r = data[i, 0], data[i, 1], data[i, 2]
    dx, dy = x - cx, y - cy
    d = math.sqrt(dx * dx + dy * dy)
    if kind[i] == CIRCLE or on_sweep(data, i, x, y):
        if d > 0.0:
            return cx + r * dx / d, cy + r * dy / d
        a = data[i, 3]
        return cx + r * math.cos(a), cy + r * math.sin(a)
    a0 = data[i, 3]
    a1 = a0 + data[i, 4]
    x0, y0 = cx + r * math.cos(a0), cy + r * math.sin(a0)
    x1, y1 = cx + r * math.cos(a1), cy + r * math.sin(a1)
    if (x - x0) ** 2 + (y - y0) ** 2 <= (x - x1) ** 2 + (y - y1) ** 2:
        return x0, y0
    return x1, y1


@njit(**BORROWING, error_model="numpy", forceinline=True)
def distance(kind, data, i, x, y):
    """Distance from (x, y) to primitive i."""
    k = kind[i]
    if k == CIRCLE or (k == ARC and on_sweep(data, i, x, y)):
        dx, dy = x - data[i, 0], y - data[i, 1]
        return abs(math.sqrt(dx * dx + dy * dy) - data[i, 2])
    fx, fy = foot(kind, data, i, x, y)
    return math.sqrt((x - fx) ** 2 + (y - fy) ** 2)


@njit(**BORROWING)
def point_to_segment(px, py, ax, ay, bx, by):
    """Distance from p to the segment a b, and how far along (0 to 1) its foot lies."""
    fx, fy, t = foot_on_segment(px, py, ax, ay, bx, by)
    return math.sqrt((px - fx) ** 2 + (py - fy) ** 2), t


@njit(**BORROWING, error_model="numpy", forceinline=True)
def _turn(ux, uy, vx, vy):
    """The determinant of u and v, differences to one point, or 0 where its sign is not sure."""
    left, right = ux * vy, uy * vx
    det = left - right
    if abs(det) <= TURN_SLACK * (abs(left) + abs(right)):
        return 0.0
    return det


@njit(**BORROWING, error_model="numpy", forceinline=True)
def _nearer_end(px, py, turn, ax, ay, bx, by, best):
    """The square of the distance from p to a segment, if less than ``best``; where; whether.

    ``turn`` is the segment's turn to p: where that is not sure and p lies beside the segment, p
    lies on it, to the rounding of its length.
    """
    fx, fy, t = foot_on_segment(px, py, ax, ay, bx, by)
    d = (px - fx) ** 2 + (py - fy) ** 2
    if turn == 0.0 and 0.0 < t < 1.0:
        d = 0.0
    return d, t, d < best


@njit(**BORROWING, error_model="numpy")
def _segments_distance(ax, ay, bx, by, cx, cy, dx, dy):
    """Distance between segments a b and c d, and where along a b it is taken.

    They cross where each one's ends lie on sides of the other that are sure; else an end is
    nearest. Of segments on one line but for rounding no end's side is sure: nothing is divided
    by such a turn.
    """
    ux, uy, vx, vy = bx - ax, by - ay, dx - cx, dy - cy
    to_c, to_d = _turn(ux, uy, cx - ax, cy - ay), _turn(ux, uy, dx - ax, dy - ay)
    to_a, to_b = _turn(vx, vy, ax - cx, ay - cy), _turn(vx, vy, bx - cx, by - cy)
    if (to_c < 0.0 < to_d or to_d < 0.0 < to_c) and (to_a < 0.0 < to_b or to_b < 0.0 < to_a):
        return 0.0, to_a / (to_a - to_b)
    best, at, _ = _nearer_end(cx, cy, to_c, ax, ay, bx, by, np.inf)
    d, t, nearer = _nearer_end(dx, dy, to_d, ax, ay, bx, by, best)
    if nearer:
        best, at = d, t
    d, _, nearer = _nearer_end(ax, ay, to_a, cx, cy, dx, dy, best)
    if nearer:
        best, at = d, 0.0
    d, _, nearer = _nearer_end(bx, by, to_b, cx, cy, dx, dy, best)
    if nearer:
        best, at = d, 1.0
    return math.sqrt(best), at


@njit(**BORROWING)
def segment_distance(kind, data, i, ax, ay, bx, by):
    """Distance between the segment a b and primitive i, and where along a b it is taken.

    The least distance to an arc is taken at an end of either, at the segment's foot of the
    arc's centre, or where the two cross.
    """
    if kind[i] == POINT:
        return point_to_segment(data[i, 0], data[i, 1], ax, ay, bx, by)
    if kind[i] == SEGMENT:
        return _segments_distance(ax, ay, bx, by, data[i, 0], data[i, 1], data[i, 2], data[i, 3])
    return _round_to_segment(kind, data, i, ax, ay, bx, by)


@njit(**BORROWING)
def _round_to_segment(kind, data, i, ax, ay, bx, by):
    """:func:`segment_distance` to a circle or an arc."""
    cx, cy, r = data[i, 0], data[i, 1], data[i, 2]
    best, at = distance(kind, data, i, ax, ay), 0.0
    d = distance(kind, data, i, bx, by)
    if d < best:
        best, at = d, 1.0
    fx, fy, t = foot_on_segment(cx, cy, ax, ay, bx, by)
    d = distance(kind, data, i, fx, fy)
    if d < best:
        best, at = d, t
    dx, dy = bx - ax, by - ay
    dd = dx * dx + dy * dy
    if dd > 0.0:
        m = ((cx - ax) * dx + (cy - ay) * dy) / dd
        h2 = (ax + m * dx - cx) ** 2 + (ay + m * dy - cy) ** 2
        if h2 <= r * r:
            half = math.sqrt((r * r - h2) / dd)
            for t in (m - half, m + half):
                if 0.0 <= t <= 1.0 and (
                    kind[i] == CIRCLE or on_sweep(data, i, ax + t * dx, ay + t * dy)
                ):
                    return 0.0, t
    if kind[i] == ARC and data[i, 4] < TAU:
        for end in range(2):
            a = data[i, 3] + end * data[i, 4]
            d, t = point_to_segment(cx + r * math.cos(a), cy + r * math.sin(a), ax, ay, bx, by)
            if d < best:
                best, at = d, t
    return best, at


@njit(**BORROWING)
def box_of(kind, data, i, box):
    """The box of primitive i: x_min, y_min, x_max, y_max (of the whole circle for an arc)."""
    if kind[i] == SEGMENT:
        box[0], box[2] = min(data[i, 0], data[i, 2]), max(data[i, 0], data[i, 2])
        box[1], box[3] = min(data[i, 1], data[i, 3]), max(data[i, 1], data[i, 3])
        return
    r = 0.0 if kind[i] == POINT else data[i, 2]
    box[0], box[2] = data[i, 0] - r, data[i, 0] + r
    box[1], box[3] = data[i, 1] - r, data[i, 1] + r


@njit(**BORROWING)
def _spread(v):
    """The 16 low bits of v, one every second bit."""
    v = (v | (v << 8)) & 0x00FF00FF
    v = (v | (v << 4)) & 0x0F0F0F0F
    v = (v | (v << 2)) & 0x33333333
    return (v | (v << 1)) & 0x55555555


@njit(cache=True, nogil=True)
def morton_codes(boxes):
    """Numbers (n,) that grow along a curve past the middles of boxes (n, 4), and their extent.

    An empty box, (inf, inf, -inf, -inf), has the number 0.
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


@njit(cache=True, nogil=True)
def build_tree(kind, data):
    """The box tree of all primitives.

    Returns ``order`` (k,) int32 with the large ones first, ``large`` how many those are, and
    ``boxes`` (2 leaves, 4) float64, empty boxes being (inf, inf, -inf, -inf).
    """
    n = len(kind)
    own = np.empty((n, 4), np.float64)
    for i in range(n):
        box_of(kind, data, i, own[i])
    code, extent = morton_codes(own)
    large = 0
    for i in range(n):
        if max(own[i, 2] - own[i, 0], own[i, 3] - own[i, 1]) > LARGE * extent:
            code[i] = -1
            large += 1
    order = np.argsort(code).astype(np.int32)
    leaves = 1
    while leaves * LEAF < n - large:
        leaves *= 2
    boxes = np.empty((2 * leaves, 4), np.float64)
    boxes[:, :2] = np.inf
    boxes[:, 2:] = -np.inf
    for j in range(n - large):
        node, i = leaves + j // LEAF, order[large + j]
        boxes[node, 0] = min(boxes[node, 0], own[i, 0])
        boxes[node, 1] = min(boxes[node, 1], own[i, 1])
        boxes[node, 2] = max(boxes[node, 2], own[i, 2])
        boxes[node, 3] = max(boxes[node, 3], own[i, 3])
    for node in range(leaves - 1, 0, -1):
        for c in range(2):
            boxes[node, c] = min(boxes[2 * node, c], boxes[2 * node + 1, c])
            boxes[node, c + 2] = max(boxes[2 * node, c + 2], boxes[2 * node + 1, c + 2])
    return order, large, boxes


@njit(**BORROWING)
def _box_distance2(boxes, node, x, y):
    dx = max(boxes[node, 0] - x, 0.0, x - boxes[node, 2])
    dy = max(boxes[node, 1] - y, 0.0, y - boxes[node, 3])
    return dx * dx + dy * dy


@njit(**BORROWING)
def _after_branch(node, later):
    """The node to go on with after a branch of the box tree, and what then waits; 0 at the end.

    ``later`` has a bit for every level above, the last one's lowest: whether the node's sibling
    waits for its turn there.
    """
    while node > 1 and later & 1 == 0:
        node >>= 1
        later >>= 1
    if node == 1:
        return 0, 0
    return node ^ 1, later ^ 1


@njit(**BORROWING)
def nearest(kind, data, order, large, boxes, x, y, bound):
    """Distance to and index of the primitive nearest to (x, y), if nearer than ``bound``.

    Returns (bound, -1) where none is.
    """
    best, which = bound, -1
    for j in range(large):
        d = distance(kind, data, order[j], x, y)
        if d < best:
            best, which = d, order[j]
    n, leaves = len(order), len(boxes) // 2
    node, later = 1, 0
    while node > 0:
        if _box_distance2(boxes, node, x, y) < best * best:
            if node < leaves:
                # the nearer branch first
                node = 2 * node
                if not _box_distance2(boxes, node, x, y) < _box_distance2(boxes, node + 1, x, y):
                    node += 1
                later = 2 * later + 1
                continue
            first = large + (node - leaves) * LEAF
            for j in range(first, min(first + LEAF, n)):
                d = distance(kind, data, order[j], x, y)
                if d < best:
                    best, which = d, order[j]
        node, later = _after_branch(node, later)
    return best, which


@njit(**BORROWING)
def _box_to_segment(boxes, node, ax, ay, bx, by, nx, ny):
    """A lower bound of the distance between a box and a segment with unit normal (nx, ny)."""
    x0, y0, x1, y1 = boxes[node, 0], boxes[node, 1], boxes[node, 2], boxes[node, 3]
    if x0 > x1:
        return np.inf
    dx = max(x0 - max(ax, bx), 0.0, min(ax, bx) - x1)
    dy = max(y0 - max(ay, by), 0.0, min(ay, by) - y1)
    off = nx * (0.5 * (x0 + x1) - ax) + ny * (0.5 * (y0 + y1) - ay)
    half = 0.5 * (abs(nx) * (x1 - x0) + abs(ny) * (y1 - y0))
    return max(math.sqrt(dx * dx + dy * dy), abs(off) - half)


@njit(**BORROWING)
def segment_clearance(kind, data, order, large, boxes, ax, ay, bx, by, bound):
    """Least distance between the segment a b and any primitive, if less than ``bound``.

    Returns the distance, where along a b it is taken, and the primitive; (bound, 0, -1)
    where none is nearer.
    """
    best, at, which = bound, 0.0, -1
    for j in range(large):
        d, t = segment_distance(kind, data, order[j], ax, ay, bx, by)
        if d < best:
            best, at, which = d, t, order[j]
    length = math.hypot(bx - ax, by - ay)
    nx, ny = 0.0, 0.0
    if length > 0.0:
        nx, ny = (ay - by) / length, (bx - ax) / length
    n, leaves = len(order), len(boxes) // 2
    node, later = 1, 0
    while node > 0:
        if _box_to_segment(boxes, node, ax, ay, bx, by, nx, ny) < best:
            if node < leaves:
                node, later = 2 * node + 1, 2 * later + 1
                continue
            first = large + (node - leaves) * LEAF
            for j in range(first, min(first + LEAF, n)):
                d, t = segment_distance(kind, data, order[j], ax, ay, bx, by)
                if d < best:
                    best, at, which = d, t, order[j]
        node, later = _after_branch(node, later)
    return best, at, which


@njit(cache=True, nogil=True)
def nearest_many(kind, data, order, large, boxes, points):
    """Distance and nearest primitive of every point."""
    out = np.empty(len(points), np.float64)
    which = np.empty(len(points), np.int32)
    for i in range(len(points)):
        out[i], which[i] = nearest(
            kind, data, order, large, boxes, points[i, 0], points[i, 1], np.inf
        )
    return out, which


@njit(cache=True, nogil=True)
def polyline_clearance(kind, data, order, large, boxes, points):
    """Least distance between a polyline and any primitive: distance, place, piece, primitive."""
    best, where = nearest(kind, data, order, large, boxes, points[0, 0], points[0, 1], np.inf)
    px, py, piece = points[0, 0], points[0, 1], 0
    for i in range(len(points) - 1):
        ax, ay, bx, by = points[i, 0], points[i, 1], points[i + 1, 0], points[i + 1, 1]
        d, t, which = segment_clearance(kind, data, order, large, boxes, ax, ay, bx, by, best)
        if which >= 0:
            best, where, piece = d, which, i
            px, py = ax + t * (bx - ax), ay + t * (by - ay)
    return best, px, py, piece, where


@njit(cache=True, nogil=True)
def object_spans(kind, data, owner, count):
    """The objects' boxes (o, 4) and their primitives' range (o, 2), first and last + 1."""
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

"""Objects that contain a place: rays over closed borders, and an index that skips most of them.

Rules and units
- A place lies in an object if a rightward ray crosses the object's closed borders, those with a
  ``solid`` side, an odd number of times.
- The index holds the closed borders' primitives border by border and object by object, close ones
  next to each other. Every aligned block of 1, 2, 4, ... primitives has its box and the y of its
  ends. A block wholly to the right is crossed an odd number of times if its ends lie on both sides
  of the ray; others are opened: O(log n) for most borders.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from planner.borders.box_tree_kernels import morton_codes, nearest
from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import FIRST, LAST, box_of
from planner.scene.shape_kernels import crosses_ray, end_of

RAYS = (0.0, 0.31830988618, -0.43429448190)
"""Heights of the rays, in parts of the clearance: no two graze joints at once."""


SAME_SIDE = 1.0 - 1e-9
"""Share of a place's clearance that is surely free of borders."""
RAYS_THAT_DECIDE = 2
"""Number of the three rays that decide."""


class ClosedBorders(NamedTuple):
    """The index: ``order`` (n,) the primitives, ``owner`` (n,) each one's object.

    ``blocks`` (b, 8) are x_min, y_min, x_max, y_max, and the y at which the block's first border is
    entered and left, and its last one if that is another. Blocks of 2 ** l primitives begin at
    ``level[l]``. ``none`` (0,) is empty.
    """

    order: NDArray[np.int32]
    owner: NDArray[np.int32]
    level: NDArray[np.int32]
    blocks: NDArray[np.float64]
    none: NDArray[np.int32]


@njit(**OWNING)
def _closed_runs(pieces):
    """Objects' closed borders: rows (m, 3), first and last primitive, and owner."""
    owner, solid = pieces.owner, pieces.solid
    following, preceding = pieces.following, pieces.preceding
    runs = np.empty((len(solid), 3), np.int32)
    m, i = 0, 0
    while i < len(solid):
        last = i
        if solid[i] != 0 and following[i] >= 0:
            last = max(i, preceding[i])
        if solid[i] != 0 and owner[i] >= 0:
            runs[m, 0], runs[m, 1], runs[m, 2] = i, last, owner[i]
            m += 1
        i = last + 1
    return runs[:m]


@njit(**OWNING)
def _in_order(kind, data, runs, objects):
    m = len(runs)
    boxes, around = np.empty((m, 4)), np.empty((objects, 4))
    around[:, :2], around[:, 2:] = np.inf, -np.inf
    own = np.empty(4)
    for r in range(m):
        boxes[r, :2], boxes[r, 2:] = np.inf, -np.inf
        for i in range(runs[r, 0], runs[r, 1] + 1):
            box_of(kind, data, i, own)
            for c in range(2):
                boxes[r, c] = min(boxes[r, c], own[c])
                boxes[r, c + 2] = max(boxes[r, c + 2], own[c + 2])
        for c in range(2):
            around[runs[r, 2], c] = min(around[runs[r, 2], c], boxes[r, c])
            around[runs[r, 2], c + 2] = max(around[runs[r, 2], c + 2], boxes[r, c + 2])
    code, outer = morton_codes(boxes)[0], morton_codes(around)[0]
    rank = np.empty(objects, np.int64)
    order = np.argsort(outer)
    for i in range(objects):
        rank[order[i]] = i
    for r in range(m):
        code[r] |= rank[runs[r, 2]] << 32
    return runs[np.argsort(code)]


@njit(**OWNING, inline="always")
def index_closed(pieces):
    """Index the closed borders among the pieces (:class:`ClosedBorders`). O(n log n)."""
    objects = np.int64(0)
    for i in range(len(pieces.solid)):
        objects = max(objects, pieces.owner[i] + 1)
    runs = _in_order(pieces.kind, pieces.data, _closed_runs(pieces), objects)
    n = 0
    for r in range(len(runs)):
        n += runs[r, 1] + 1 - runs[r, 0]
    order, holder = np.empty(n, np.int32), np.empty(n, np.int32)
    begin, end = np.empty(n, np.int32), np.empty(n, np.int32)
    p = 0
    for r in range(len(runs)):
        first = p
        for i in range(runs[r, 0], runs[r, 1] + 1):
            order[p], holder[p], begin[p] = i, runs[r, 2], first
            p += 1
        end[first:p] = p
    level = np.zeros(34, np.int32)
    top = 0
    while True:
        level[top + 1] = level[top] + ((n - 1) >> top) + 1
        if 1 << top >= n:
            break
        top += 1
    level = level[: top + 2].copy()
    blocks = np.empty((max(level[top + 1], 0), 8))
    _fill_boxes(pieces, order, level, blocks)
    _fill_heights(pieces, order, begin, end, level, blocks)
    return ClosedBorders(order, holder, level, blocks, np.empty(0, np.int32))


@njit(**OWNING)
def _fill_boxes(pieces, order, level, blocks):
    for p in range(len(order)):
        box_of(pieces.kind, pieces.data, np.int64(order[p]), blocks[p])
    top = len(level) - 2
    for tier in range(1, top + 1):
        for b in range(level[tier + 1] - level[tier]):
            row, left = blocks[level[tier] + b], level[tier - 1] + 2 * b
            for c in range(4):
                row[c] = blocks[left, c]
            if left + 1 < level[tier]:
                for c in range(2):
                    row[c] = min(row[c], blocks[left + 1, c])
                    row[c + 2] = max(row[c + 2], blocks[left + 1, c + 2])


@njit(**BORROWING)
def _fill_heights(pieces, order, begin, end, level, blocks):
    """Write the y at which the first and last border of every block are entered and left."""
    kind, data, backwards = pieces.kind, pieces.data, pieces.backwards
    n = len(order)
    for tier in range(len(level) - 1):
        for b in range(level[tier + 1] - level[tier]):
            first, last = b << tier, min((b + 1) << tier, n) - 1
            row = blocks[level[tier] + b]
            one, other = np.int64(order[first]), np.int64(order[last])
            row[4] = end_of(kind, data, backwards, one, FIRST)[1]
            row[5] = row[6] = row[7] = end_of(kind, data, backwards, other, LAST)[1]
            if begin[first] != begin[last]:
                one, other = np.int64(order[begin[first]]), np.int64(order[begin[last]])
                row[5] = end_of(kind, data, backwards, one, FIRST)[1]
                row[6] = end_of(kind, data, backwards, other, FIRST)[1]
            if begin[last] >= first and end[last] == last + 1:
                row[7] = row[6] if begin[first] != begin[last] else row[7]
                row[4] = row[5] if begin[first] == begin[last] else row[4]


@njit(**BORROWING)
def _ray(kind, data, closed, x, y, only, votes):
    """True if one ray finds (x, y) in object ``only``, or in any object if ``only`` < 0.

    Each such object gets one of the ``votes`` (objects,), unless empty.
    """
    order, owner, level, blocks, _ = closed
    n, tier = len(order), len(level) - 2
    p, holder, odd, found = 0, -1, False, False
    while p < n:
        b = level[tier] + (p >> tier)
        last = min(p + (1 << tier), n) - 1
        if y >= blocks[b, 1] and y < blocks[b, 3] and x <= blocks[b, 2]:
            if x >= blocks[b, 0] and tier > 0:
                tier -= 1
                continue
            enters = (blocks[b, 4] <= y) != (blocks[b, 5] <= y)
            leaves = (blocks[b, 6] <= y) != (blocks[b, 7] <= y)
            if x >= blocks[b, 0]:
                enters, leaves = crosses_ray(kind, data, order[p], x, y), False
            for end in range(2):
                o = owner[last] if end else owner[p]
                if o != holder:
                    if odd and (only < 0 or only == holder):
                        found = True
                        if len(votes) > 0:
                            votes[holder] += 1
                    holder, odd = o, False
                odd = odd != (leaves if end else enters)
        p += 1 << tier
        while p & ((2 << tier) - 1) == 0 and tier < len(level) - 2:
            tier += 1
    if odd and (only < 0 or only == holder):
        found = True
        if len(votes) > 0:
            votes[holder] += 1
    return found


@njit(**BORROWING)
def in_object(kind, data, closed, x, y, reach, only=-1):
    """True if (x, y), ``reach`` away from every border, lies in an object, by even-odd.

    Only object ``only`` counts if it is >= 0. Of three rays, two outvote one that grazes a joint.
    """
    votes = 0
    for j in range(3):
        if _ray(kind, data, closed, x, y + RAYS[j] * reach, only, closed.none):
            votes += 1
        if votes == RAYS_THAT_DECIDE or (j == 1 and votes == 0):
            break
    return votes >= RAYS_THAT_DECIDE


@njit(**BORROWING)
def standing(tree, closed, x, y):
    """Distance from (x, y) to the nearest primitive, that primitive, and True in an object."""
    d, which = nearest(tree, x, y, np.inf)
    return d, which, in_object(tree.kind, tree.data, closed, x, y, d)


@njit(**OWNING)
def vote(kind, data, closed, x, y, reach, objects):
    """Count the rays, of three, that find (x, y) in each of the objects: (objects,) int32."""
    votes = np.zeros(objects, np.int32)
    for part in RAYS:
        _ray(kind, data, closed, x, y + part * reach, -1, votes)
    return votes


@njit(**OWNING)
def signed_distances(tree, closed, box, points):
    """Distance of every point (n, 2), negative in an object and out of the ``box``."""
    kind, data = tree.kind, tree.data
    out = np.empty(len(points))
    last_x, last_y, near, solid = 0.0, 0.0, -1.0, False
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        d, _ = nearest(tree, x, y, np.inf)
        if not (x - last_x) ** 2 + (y - last_y) ** 2 < near * abs(near):
            solid = in_object(kind, data, closed, x, y, d)
            last_x, last_y, near = x, y, d * SAME_SIDE
        outside = not (box[0] <= x <= box[2] and box[1] <= y <= box[3])
        out[i] = -d if outside or solid else d
    return out

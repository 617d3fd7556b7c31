"""Pieces of a scene: joined from flat primitives, or patched from a slightly different scene.

Rules and units
- Pieces are those of :class:`planner.borders.border_arrays.Pieces`: the primitives in the order of
  their objects, the bounds last, then the corner points likewise.
- An object's pieces do not depend on other objects, except for their numbers.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from planner.borders.border_arrays import Pieces, Tree
from planner.borders.box_tree_kernels import build_tree, object_spans
from planner.borders.corner_point_kernels import corner_points, link_borders, without_repeats
from planner.borders.generator_kernels import count_generators, place_generators
from planner.borders.inside_kernels import index_closed
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import POINT, put_rows, with_middles


class NewBorders(NamedTuple):
    """The borders of new objects.

    ``kind`` (m,) and ``rows`` (m, 6) are their primitives, ``turned`` (t,) the rows that run
    backwards; ``borders`` (b, 3) are each border's number of rows, its owner, and 1 for a hole.
    """

    kind: NDArray[np.int8]
    rows: NDArray[np.float64]
    turned: NDArray[np.int32]
    borders: NDArray[np.int32]


@njit(**OWNING)
def join_primitives(kind, data, owner, border, is_hole, backwards, no_length, joint, every):
    """Pieces of flat primitives and how they join.

    Edges up to ``no_length`` become points; ends up to ``joint`` apart are one joint. With
    ``every``, each joint has a corner point.
    """
    all_kind, all_data, keep = without_repeats(kind, data, border, backwards, no_length)
    k = 0
    for i in range(len(keep)):
        k += keep[i]
    flat_kind, flat = np.empty(k, np.int8), np.empty((k, 6))
    flat_owner, flat_border = np.empty(k, np.int32), np.empty(k, np.int32)
    hole, turned = np.empty(k, np.bool_), np.empty(k, np.bool_)
    n = 0
    for i in range(len(keep)):
        if keep[i]:
            flat_kind[n], flat_owner[n], flat_border[n] = all_kind[i], owner[i], border[i]
            hole[n], turned[n] = is_hole[i], backwards[i]
            for c in range(6):
                flat[n, c] = all_data[i, c]
            n += 1
    rows = with_middles(flat_kind, flat)
    following, preceding, solid, crossed = link_borders(
        flat_kind, rows, flat_border, hole, turned, joint
    )
    if every:
        crossed[:] = True
    at, before, after = corner_points(flat_kind, rows, turned, following, preceding, solid, crossed)
    c = len(at)
    out_kind, out = np.empty(k + c, np.int8), np.zeros((k + c, 9))
    out_owner = np.empty(k + c, np.int32)
    for i in range(k):
        out_kind[i], out_owner[i] = flat_kind[i], flat_owner[i]
        for d in range(9):
            out[i, d] = rows[i, d]
    for i in range(c):
        out_kind[k + i] = POINT
        out[k + i, 0], out[k + i, 1] = at[i, 0], at[i, 1]
        out_owner[k + i] = flat_owner[max(before[i], after[i])]
    return Pieces(out_kind, out, out_owner, turned, following, preceding, solid, before, after)


@njit(**LEAF)
def walls_box(data, owner):
    """Return x_min, y_min, x_max, y_max of the bounds' walls; inverted infinities without walls."""
    x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
    for i in range(len(owner)):
        if owner[i] == -1:
            x0, x1 = min(x0, data[i, 0], data[i, 2]), max(x1, data[i, 0], data[i, 2])
            y0, y1 = min(y0, data[i, 1], data[i, 3]), max(y1, data[i, 1], data[i, 3])
    return x0, y0, x1, y1


@njit(**OWNING)
def find_pieces(pieces):
    """Primitives' box tree, the objects' boxes and spans, and the closed borders' index."""
    kind, data = pieces.kind, pieces.data
    k = len(pieces.solid)
    own = build_tree(kind[:k], data[:k])
    # queries that find a primitive also ask for corner points
    tree = Tree(kind, data, own.order, own.large, own.boxes)
    object_boxes, span = object_spans(kind, data, pieces.owner, k)
    return tree, object_boxes, span, index_closed(pieces)


@njit(**OWNING, error_model="numpy")
def _flatten(new):
    borders = new.borders
    n = len(new.rows)
    owner, border = np.empty(n, np.int32), np.empty(n, np.int32)
    is_hole, backwards = np.empty(n, np.bool_), np.zeros(n, np.bool_)
    m = 0
    for b in range(len(borders)):
        for _ in range(borders[b, 0]):
            owner[m], border[m], is_hole[m] = borders[b, 1], b, borders[b, 2] != 0
            m += 1
    for i in new.turned:
        backwards[i] = True
    return owner, border, is_hole, backwards


@njit(**OWNING, error_model="numpy")
def change_borders(kept, objects, old, old_boxes, new, no_length, joint, disc, spacing):
    """Borders of a scene of ``kept`` objects, see :func:`patch_borders`, and new ones.

    ``new`` are the new objects' borders (:class:`NewBorders`), ``no_length`` and ``joint`` as in
    :func:`join_primitives`, ``old_boxes`` (o, 4) the old objects' boxes. Returns all pieces; the
    results of :func:`find_pieces`; the new places of the old pieces; the new objects' generators,
    at most ``spacing`` apart in the ``disc``, and their pieces; and (b, 4) the boxes of the objects
    added and removed.
    """
    came = np.int64(0)
    for j in range(len(kept)):
        came += kept[j] < 0
    owner, border, is_hole, backwards = _flatten(new)
    fresh = join_primitives(
        new.kind, new.rows, owner, border, is_hole, backwards, no_length, joint, np.bool_(False)
    )
    pieces, label, fresh_label = patch_borders(kept, objects, old, came, fresh)
    found = find_pieces(pieces)
    object_boxes = found[1]
    touched = np.empty((objects + came, 4))
    stays = np.zeros(objects, np.bool_)
    n = 0
    for j in range(len(kept)):
        if kept[j] >= 0:
            stays[kept[j]] = True
        elif j < len(object_boxes):
            put_rows(touched, n, object_boxes[j])
            n += 1
    # trailing objects without pieces have no boxes
    for o in range(min(objects, len(old_boxes))):
        if not stays[o]:
            put_rows(touched, n, old_boxes[o])
            n += 1
    k = len(fresh.backwards)
    fresh_kind, fresh_data, at = fresh.kind[:k], fresh.data[:k], fresh.data[k:, :2]
    backwards = fresh.backwards
    capacity = int(count_generators(fresh_kind, fresh_data, backwards, disc, spacing)) + len(at)
    places, labels = place_generators(
        fresh_kind, fresh_data, backwards, at, fresh.before, fresh.after, disc, spacing, capacity
    )
    for i in range(len(labels)):
        labels[i] = fresh_label[labels[i]]
    return pieces, found, label, places, labels, touched[:n]


@njit(**OWNING, error_model="numpy")
def _ranges(owner, begin, end, objects):
    """First index and count of each object's pieces in ``begin`` to ``end``; bounds last."""
    first, count = np.zeros(objects + 1, np.int64), np.zeros(objects + 1, np.int64)
    for i in range(end - 1, begin - 1, -1):
        o = owner[i] if owner[i] >= 0 else objects
        first[o] = i
        count[o] += 1
    return first, count


@njit(**OWNING, error_model="numpy", inline="always")
def patch_borders(kept, objects, old, came, fresh):
    """Pieces of kept objects, of new ones, and of the old bounds.

    ``kept`` (n,) gives each object's number among the old ``objects``, or -1 for the ``came`` new
    ones in turn. ``old`` and ``fresh`` are pieces, the latter of the new objects alone. Returns all
    pieces, the new places of the old ones (-1 for removed ones, and at the end), and those of the
    fresh ones.
    """
    kind, data, owner = old.kind, old.data, old.owner
    new_kind, new_data, new_owner = fresh.kind, fresh.data, fresh.owner
    old_k, new_k, n = len(old.solid), len(fresh.solid), len(kept)
    label = np.full(len(kind) + 1, -1, np.int32)
    new_label = np.empty(len(new_kind), np.int32)
    total = len(kind) + len(new_kind)
    out_kind, out = np.empty(total, np.int8), np.empty((total, 9))
    out_owner = np.empty(total, np.int32)
    m, k = 0, 0
    for part in range(2):
        lo, hi = (0, old_k) if part == 0 else (old_k, len(kind))
        first, count = _ranges(owner, lo, hi, objects)
        lo, hi = (0, new_k) if part == 0 else (new_k, len(new_kind))
        new_first, new_count = _ranges(new_owner, lo, hi, came)
        which = 0
        for j in range(n + 1):
            if j < n and kept[j] < 0:
                for i in range(new_first[which], new_first[which] + new_count[which]):
                    new_label[i] = m
                    out_kind[m], out_owner[m] = new_kind[i], j
                    for c in range(9):
                        out[m, c] = new_data[i, c]
                    m += 1
                which += 1
                continue
            o = objects
            if j < n:
                o = kept[j]
            for i in range(first[o], first[o] + count[o]):
                label[i] = m
                out_kind[m], out_owner[m] = kind[i], j if j < n else -1
                for c in range(9):
                    out[m, c] = data[i, c]
                m += 1
        if part == 0:
            k = m
    pieces = Pieces(
        out_kind[:m], out[:m], out_owner[:m], np.empty(k, np.bool_), np.empty(k, np.int32),
        np.empty(k, np.int32), np.empty(k, np.int8), np.empty(m - k, np.int32),
        np.empty(m - k, np.int32),
    )  # fmt: skip
    _renumber(label, old, pieces)
    _renumber(new_label, fresh, pieces)
    return pieces, label, new_label


@njit(**LEAF)
def _renumber(label, old, out):
    following, preceding, before, after = old.following, old.preceding, old.before, old.after
    k = len(out.solid)
    for i in range(len(old.solid)):
        m = label[i]
        if m >= 0:
            out.backwards[m], out.solid[m] = old.backwards[i], old.solid[i]
            out.following[m] = label[following[i]] if following[i] >= 0 else -1
            out.preceding[m] = label[preceding[i]] if preceding[i] >= 0 else -1
    for c in range(len(before)):
        m = label[len(old.solid) + c] - k
        if m >= 0:
            out.before[m] = label[before[c]] if before[c] >= 0 else -1
            out.after[m] = label[after[c]] if after[c] >= 0 else -1

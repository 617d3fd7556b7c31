"""Valid edges of the generators' Voronoi diagram, and the centres that no chain passes.

Rules
- A label is the index of a generator's piece, see :mod:`planner.borders.corner_point_kernels`.
  A Voronoi edge is valid if the feet on the two labels differ: not within one piece, and not
  between a corner point and its own sides.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.borders.box_tree_kernels import nearest
from planner.borders.inside_kernels import in_object
from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import POINT, SEGMENT, distance, is_round


@njit(**LEAF, forceinline=True)
def is_valid(pieces, label_a, label_b, tolerance):
    """True if a Voronoi edge between two labels belongs to the diagram."""
    if label_a == label_b:
        return False
    kind = pieces.kind
    k = len(kind) - len(pieces.before)
    if label_a < k and label_b < k and kind[label_a] != POINT and kind[label_b] != POINT:
        return True
    return not (
        is_end(pieces, label_a, label_b, tolerance) or is_end(pieces, label_b, label_a, tolerance)
    )


@njit(**LEAF)
def is_end(pieces, p, q, tolerance):
    """True if p is a point on piece q, as a corner point is on its sides."""
    kind, data, before, after = pieces.kind, pieces.data, pieces.before, pieces.after
    k = len(kind) - len(before)
    if p >= k:
        if before[p - k] == q or after[p - k] == q:
            return True
    elif kind[p] != POINT:
        return False
    x, y = data[p, 0], data[p, 1]
    # most are far away, which needs no root
    if kind[q] == POINT:
        if abs(x - data[q, 0]) > tolerance or abs(y - data[q, 1]) > tolerance:
            return False
    elif kind[q] == SEGMENT:
        ax, ay = data[q, 0], data[q, 1]
        dx, dy = data[q, 2] - ax, data[q, 3] - ay
        if abs((x - ax) * dy - (y - ay) * dx) > 2.0 * tolerance * (abs(dx) + abs(dy)):
            return False
    return distance(kind, data, q, x, y) <= tolerance


@njit(**OWNING)
def lonely_centres(pieces, tree, closed, box, points, tolerance):
    """Free centres of circles and arcs that have no other border as near, and lie on no chain.

    Rows (n, 3): x, y and clearance. The clearance is greatest there.
    """
    data, solid = pieces.data, pieces.solid
    out = np.empty((len(solid), 3))
    n = 0
    for i in range(len(solid)):
        if not is_round(pieces.kind[i]):
            continue
        if solid[i] != 0 and ((solid[i] > 0) != pieces.backwards[i]):
            continue
        x, y, r = data[i, 0], data[i, 1], data[i, 2]
        if not (box[0] < x < box[2] and box[1] < y < box[3]):
            continue
        d, _ = nearest(tree, x, y, r)
        if d < r - tolerance:
            continue
        alone = True
        for j in range(len(points)):
            if abs(points[j, 0] - x) + abs(points[j, 1] - y) <= tolerance:
                alone = False
                break
        for j in range(n):
            if abs(out[j, 0] - x) + abs(out[j, 1] - y) <= tolerance:
                alone = False
        d, _ = nearest(tree, x, y, np.inf)
        if alone and not in_object(pieces.kind, data, closed, x, y, d):
            out[n, 0], out[n, 1], out[n, 2] = x, y, d
            n += 1
    return out[:n]

"""Pairs of objects that meet, or of which one lies within the other.

Rules and units
- Scene's units; borders within ``tolerance`` meet.
- Objects are compared only if their boxes overlap.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.borders.inside_kernels import in_object
from planner.scene.compile_options import OWNING
from planner.scene.primitive_kernels import (
    box_of,
    grown,
)
from planner.scene.shape_kernels import meet, place_on

MEET, WITHIN = 1, 2
"""Relations of two objects: their borders meet, or the first lies inside the second."""


@njit(**OWNING)
def _related(kind, data, closed, boxes, span, a, b, tolerance):
    """Return MEET, WITHIN (a inside b), or 0."""
    own = np.empty(4)
    for i in range(span[a, 0], span[a, 1]):
        box_of(kind, data, i, own)
        if own[0] > boxes[b, 2] + tolerance or own[2] < boxes[b, 0] - tolerance:
            continue
        if own[1] > boxes[b, 3] + tolerance or own[3] < boxes[b, 1] - tolerance:
            continue
        for j in range(span[b, 0], span[b, 1]):
            if meet(kind, data, i, j, tolerance):
                return MEET
    x, y = place_on(kind, data, span[a, 0])
    # the borders do not meet
    if in_object(kind, data, closed, x, y, tolerance, b):
        return WITHIN
    return 0


@njit(**OWNING)
def related_objects(kind, data, closed, boxes, span, tolerance):
    """Pairs of objects that meet or lie within: rows (n, 3) a, b, how; a within b.

    O(o log o) for o objects whose boxes overlap few others', plus the product of each such pair's
    primitives.
    """
    o = len(boxes)
    order = np.argsort(boxes[:, 0])
    out = np.empty((16, 3), np.int32)
    n = 0
    for u in range(o):
        a = order[u]
        for v in range(u + 1, o):
            b = order[v]
            if boxes[b, 0] > boxes[a, 2] + tolerance:
                break
            if boxes[b, 1] > boxes[a, 3] + tolerance or boxes[a, 1] > boxes[b, 3] + tolerance:
                continue
            first, second = a, b
            how = _related(kind, data, closed, boxes, span, a, b, tolerance)
            if how == 0:
                how = _related(kind, data, closed, boxes, span, b, a, tolerance)
                first, second = b, a
            if how == 0:
                continue
            if n == len(out):
                out = grown(out, 2 * n)
            if how == MEET:
                first, second = min(a, b), max(a, b)
            out[n, 0], out[n, 1], out[n, 2] = first, second, how
            n += 1
    return out[:n]

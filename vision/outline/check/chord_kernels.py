"""Chords from border point to border point, where no edges cover their border well enough.

Types are those of ``vision.outline.outline_types``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.fit.edge_shape_kernels import HUGE
from vision.outline.fit.outline_kernels import edge_end, write_line
from vision.shared.typed_numbers import ZERO


@njit(**LEAF, forceinline=False)
def finish_with_chords(border, outline, edges, trial, review, tolerance, scratch, finished):
    """Write the edges of ``trial``, and chords instead of the ragged ones; returns their number.

    ``tolerance``: largest distance of a chord from its points, in pixels.
    """
    px = border.x
    py = border.y
    n = border.n
    breaks = outline.breaks
    joints = outline.joints
    found = scratch.indices[0]
    count = ZERO
    for e in range(edges):
        if not review.ragged[e]:
            finished.kind[count] = trial.kind[e]
            finished.at[count] = breaks[e]
            for c in range(6):
                finished.rows[count, c] = trial.rows[e, c]
            count += 1
            continue
        m = _chords(border, breaks[e], edge_end(breaks, edges, n, e), tolerance, found, scratch)
        for t in range(m):
            x = joints[e, 0] if t == 0 else px[found[t]]
            y = joints[e, 1] if t == 0 else py[found[t]]
            k = found[t] - n if found[t] >= n else found[t]
            write_line(finished, count, x, y, k)
            count += 1
    return count


@njit(**LEAF, forceinline=False)
def chords_around(border, tolerance, scratch, finished):
    """Write chords all around a border, from point to point; returns their number."""
    found = scratch.indices[0]
    count = _chords(border, ZERO, border.n, tolerance, found, scratch)
    for t in range(count):
        write_line(finished, t, border.x[found[t]], border.y[found[t]], found[t])
    return count


@njit(**LEAF)
def _chords(border, lo, hi, tolerance, found, scratch):
    px = border.x
    py = border.y
    is_seed = scratch.flags[0]
    stack = scratch.pairs
    count = hi - lo
    for k in range(count + 1):
        is_seed[k] = False
    found[0] = lo
    m = 1
    stack[0, 0] = lo
    stack[0, 1] = hi
    top = 1
    while top > 0:
        top -= 1
        a = stack[top, 0]
        b = stack[top, 1]
        dx = px[b] - px[a]
        dy = py[b] - py[a]
        length = math.sqrt(dx * dx + dy * dy)
        far = -HUGE
        where = a
        for k in range(a + 1, b):
            x = px[k] - px[a]
            y = py[k] - py[a]
            d = math.sqrt(x * x + y * y) if length < 1e-9 else abs(x * dy - y * dx) / length
            if d > far:
                far = d
                where = k
        if far > tolerance:
            is_seed[where - lo] = True
            stack[top, 0] = where
            stack[top, 1] = b
            stack[top + 1, 0] = a
            stack[top + 1, 1] = where
            top += 2
    for k in range(1, count):
        if is_seed[k]:
            found[m] = lo + k
            m += 1
    return m

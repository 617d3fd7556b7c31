"""Local search over edits of an outline: the largest savings first, until none is left.

Pictures with grey only. The edits: ``vision.outline.corners.edit_kernels``; types:
``vision.outline.outline_types``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.corners.edit_kernels import CORNER, FILLET, find_edits
from vision.outline.corners.fillet_kernels import PIXEL_BLUR_PX, half_variance, touch_lines
from vision.outline.corners.joint_kernels import fit_and_join
from vision.outline.corners.wall_end_kernels import square_ends
from vision.outline.fit.edge_shape_kernels import FIT_ROUNDS
from vision.outline.fit.outline_kernels import edge_end
from vision.outline.outline_types import Blur, EdgeChange, Edits
from vision.shared.typed_numbers import ZERO

GONE, ANCHOR, USED, NEW_IS_ARC, NEW_IS_FILLET = 0, 1, 2, 3, 4
"""Rows of the scratch flags: defined."""
BEGINS, NEW_BREAKS = 4, 5
"""Rows of the scratch indices behind those of the edits: defined."""
LEFT = 3
"""Least points of an edge between two edits: derived, two lie on any line."""
MOVED = 16
"""Points by which an edge may be longer between two edits: derived, these look for an end among
``vision.outline.corners.crossing_kernels.DIRECTION_POINTS`` points beyond it, on either side."""


@njit(**LEAF, inline="always")
def edit_outline(border, outline, edges, limits, blur_px, costs, prices, scratch):
    """Apply the edits that save most and fit again, until none saves; return the edges' number."""
    sigma = math.sqrt(blur_px * blur_px + PIXEL_BLUR_PX * PIXEL_BLUR_PX)
    blur = Blur(sigma, half_variance(blur_px), limits.guard)
    indices = scratch.indices
    edits = Edits(
        scratch.numbers[2], scratch.numbers[3], indices[0], indices[1], indices[2], indices[3]
    )
    last = scratch.table.shape[0]
    change = EdgeChange(
        scratch.table[last - 3 : last], scratch.table[last - 5 : last - 3],
        scratch.table[last - 7 : last - 5], scratch.table[last - 8], indices[5], indices[6],
        scratch.numbers[4],
    )  # fmt: skip
    for e in range(edges):
        outline.is_fillet[e] = False
    for taken in range(FIT_ROUNDS):
        if not find_edits(
            border, outline, edges, taken == 0, blur, costs, prices, edits, change, scratch
        ):
            break
        edges = _take_edits(border.n, outline, edges, edits, scratch)
        fit_and_join(border, outline, edges, limits, scratch)
        touch_lines(border, outline, edges, blur, costs, change)
        square_ends(outline, edges, blur)
    return edges


@njit(**LEAF)
def _take_edits(n, outline, edges, edits, scratch):
    """Apply edits by falling saving, without any that touch another; return the number of edges.

    ``gone``: edges removed; ``anchor``: edges beside an edit; ``used``: edges that an edit follows;
    ``begins``: first point of an edge behind an edit, or -1.
    """
    saved = edits.saved
    gone = scratch.flags[GONE]
    anchor = scratch.flags[ANCHOR]
    used = scratch.flags[USED]
    begins = scratch.indices[BEGINS]
    for e in range(edges):
        gone[e] = False
        anchor[e] = False
        begins[e] = -1
        used[e] = False
    while True:
        i = ZERO
        for e in range(1, edges):
            if saved[e] > saved[i]:
                i = e
        if saved[i] <= 0.0:
            break
        saved[i] = 0.0
        j = (i + edits.run[i] + 1) % edges
        free = not (gone[i] or gone[j])
        for t in range(1, edits.run[i] + 1):
            e = (i + t) % edges
            free = free and not gone[e] and not anchor[e]
        first = edits.first[i]
        behind = edits.behind[i]
        if begins[i] >= 0:
            free = free and _is_left(n, outline, edges, i, begins[i], first)
        if used[j]:
            free = free and _is_left(n, outline, edges, j, behind, edits.first[j])
        if not free:
            continue
        used[i] = True
        anchor[i] = True
        anchor[j] = True
        begins[j] = behind % n
        for t in range(1, edits.run[i] + 1):
            gone[(i + t) % edges] = True
    return _write_edits(n, outline, edges, edits, scratch)


@njit(**LEAF)
def _is_left(n, outline, edges, e, begin, end):
    """True if edge e keeps points between two edits, which may have passed each other."""
    points = edge_end(outline.breaks, edges, n, e) - outline.breaks[e]
    return LEFT <= (end - begin) % n <= points + MOVED


@njit(**LEAF)
def _write_edits(n, outline, edges, edits, scratch):
    gone = scratch.flags[GONE]
    used = scratch.flags[USED]
    begins = scratch.indices[BEGINS]
    # every edge adds at most one
    breaks = scratch.indices[NEW_BREAKS]
    is_arc = scratch.flags[NEW_IS_ARC]
    is_fillet = scratch.flags[NEW_IS_FILLET]
    m = 0
    for e in range(edges):
        if not gone[e]:
            breaks[m] = begins[e] if begins[e] >= 0 else outline.breaks[e]
            is_arc[m] = outline.is_arc[e]
            is_fillet[m] = outline.is_fillet[e]
            m += 1
        if used[e] and edits.kind[e] != CORNER:
            breaks[m] = edits.first[e] % n
            is_arc[m] = edits.kind[e] == FILLET
            is_fillet[m] = is_arc[m]
            m += 1
    for e in range(m):
        outline.breaks[e] = breaks[e]
        outline.is_arc[e] = is_arc[e]
        outline.is_fillet[e] = is_fillet[e]
    return m

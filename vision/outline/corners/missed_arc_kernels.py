"""Bent lines, which a search accepts as straight because a small deviation is free."""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import successor
from vision.outline.fit.edge_shape_kernels import circle_rms, fit_circle
from vision.outline.fit.outline_kernels import KNOWN_PX

BENT_PX = 3.0 * KNOWN_PX
"""Rise of a bent line's arc over its chord: derived, a line through it is off by a third, the least
spread of points."""
BENT_BY = 2.0
"""Added to it, as a multiple of a point's noise: chosen."""
BETTER_BY = 0.5
"""Share of the line's residual that its arc leaves at most (indifferent)."""
LEAST_BEND_POINTS = 2 * 3 + 1
"""Points that show a bend: derived, more than twice a circle's numbers."""
ARC_TURN_COS = 0.9
"""Cosine of the turn up to which two lines may be chords of one arc: 26 degrees (indifferent)."""
AS_GOOD_PX = 0.02
"""Residual by which an arc may exceed both of them (indifferent, below the 0.05 px of edge
points)."""


@njit(**LEAF)
def any_bent_line(border, outline, edges, spread, circle):
    """True if an arc fits a line's points far better, or those of two lines as well.

    ``spread``: a point's noise; ``circle`` (3,) is scratch space.
    """
    px = border.x
    py = border.y
    n = border.n
    is_arc = outline.is_arc
    shape = outline.shape
    ranges = outline.ranges
    least = BENT_PX + BENT_BY * spread
    for e in range(edges):
        a = ranges[e, 0]
        b = ranges[e, 1]
        if is_arc[e] or a < 0 or b - a < LEAST_BEND_POINTS:
            continue
        after = successor(e, edges)
        dot = shape[e, 2] * shape[after, 2] + shape[e, 3] * shape[after, 3]
        pair = after != e and not is_arc[after] and ranges[after, 0] >= 0 and dot > ARC_TURN_COS
        if pair and ranges[after, 1] - ranges[after, 0] >= LEAST_BEND_POINTS:
            end = ranges[after, 1]
            end = end + n if end <= a else end
            if end <= 2 * n and fit_circle(px, py, a, end, circle):
                allowed = max(shape[e, 4], shape[after, 4]) + AS_GOOD_PX
                if circle_rms(px, py, a, end, circle) < allowed:
                    return True
        if shape[e, 4] < 0.2 * least or not fit_circle(px, py, a, b, circle):
            continue
        dx = px[b - 1] - px[a]
        dy = py[b - 1] - py[a]
        if dx * dx + dy * dy < 8.0 * circle[2] * least:
            continue
        if circle_rms(px, py, a, b, circle) < BETTER_BY * shape[e, 4]:
            return True
    return False

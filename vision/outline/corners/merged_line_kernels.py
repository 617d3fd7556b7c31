"""Neighbouring edges that are one line: a search breaks lines at its seeds, which may lie astray.

Rules and units
- ``border``, ``outline``, ``costs`` and ``prices``: see ``vision.outline.outline_types``; pictures
  with grey only.
- Beside an arc a seed may lie some points from where the line begins. A stretch that ends there
  is no line, and the search puts a break into the line instead, or takes it for a flat arc. Once
  the edges are fitted and their joints known, the same prices tell that it is one.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import successor
from vision.outline.fit.outline_kernels import edge_end
from vision.outline.fit.shape_kernels import HUGE, circle_cost, fit_line, line_cost

FEWEST = 3
"""Edges of a border with an arc of which two may be one; without arcs it takes one more."""
SHORT = 8
"""A shorter edge may point anywhere."""
ALONG = 0.9
"""Cosine of the turn up to which two lines may be one."""
FLAT = 0.25
"""An arc that turns by less (radians) may be a line."""
STEP = 1
"""Every point takes part in a fit."""
ENDLESS = 1e9
"""No point is too far from the edge that it has."""


@njit(**LEAF)
def _may_be_line(outline, points, e):
    """Whether edge e of so many points is a line, or may pass for one."""
    if not outline.is_arc[e]:
        return True
    return not outline.is_fillet[e] and points < FLAT * outline.shape[e, 2]


@njit(**LEAF)
def _cost(border, lo, hi, outline, e, costs):
    """What points lo .. hi - 1 cost beside edge e, which they have."""
    row = outline.shape[e]
    if outline.is_arc[e]:
        return circle_cost(
            border.x, border.y, lo, hi, row, False, costs.dead_zone, costs.sigma, ENDLESS, HUGE
        )
    return line_cost(
        border.x, border.y, lo, hi, row, False, costs.dead_zone, costs.sigma, ENDLESS, HUGE
    )


@njit(**LEAF)
def _gain(border, outline, edges, e, both, costs, prices, line):
    """What one line saves in the place of edge e, or of it and the next one (``both``)."""
    n = border.n
    breaks, is_arc = outline.breaks, outline.is_arc
    shape, ranges = outline.shape, outline.ranges
    begin = breaks[e]
    middle = edge_end(breaks, edges, n, e)
    if not _may_be_line(outline, middle - begin, e):
        return 0.0
    lo = ranges[e, 0]
    hi = ranges[e, 1]
    saved = prices.arc if is_arc[e] else prices.line
    if both:
        after = successor(e, edges)
        points = edge_end(breaks, edges, n, after) - breaks[after]
        if not _may_be_line(outline, points, after):
            return 0.0
        long = min(points, middle - begin) >= SHORT and not (is_arc[e] or is_arc[after])
        if long and shape[e, 2] * shape[after, 2] + shape[e, 3] * shape[after, 3] < ALONG:
            return 0.0
        shift = middle - breaks[after]
        hi = ranges[after, 1] + shift
        saved += prices.arc if is_arc[after] else prices.line
        saved += _cost(border, lo, middle, outline, e, costs)
        saved += _cost(border, breaks[after], ranges[after, 1], outline, after, costs)
    else:
        saved += _cost(border, lo, hi, outline, e, costs)
    saved -= prices.line
    if hi > 2 * n or saved <= 0.0:
        return 0.0
    fit_line(border.x, border.y, lo, hi, STEP, line)
    return saved - line_cost(
        border.x, border.y, lo, hi, line, False, costs.dead_zone, costs.sigma, costs.worst, saved
    )


@njit(**LEAF)
def merge_lines(border, outline, edges, costs, prices, line):
    """Make one line of edges where it describes a border more cheaply.

    ``breaks``, ``is_arc`` and ``is_fillet`` are changed; returns the new number of edges, and
    whether they are. ``shape`` and ``ranges`` do not fit them any more then. ``line`` (4,) is room
    to work in.
    """
    is_arc = outline.is_arc
    best = 0.0
    where = -1
    pair = False
    arcs = False
    for e in range(edges):
        arcs = arcs or is_arc[e]
    least = FEWEST if arcs else FEWEST + 1
    for e in range(edges):
        if is_arc[e]:
            gain = _gain(border, outline, edges, e, False, costs, prices, line)
            if gain > best:
                best = gain
                where = e
                pair = False
        if edges >= least:
            gain = _gain(border, outline, edges, e, True, costs, prices, line)
            if gain > best:
                best = gain
                where = e
                pair = True
    if where < 0:
        return edges, False
    is_arc[where] = False
    outline.is_fillet[where] = False
    if not pair:
        return edges, True
    drop_edge(outline, edges, successor(where, edges))
    return edges - 1, True


@njit(**LEAF)
def drop_edge(outline, edges, gone):
    """Take edge ``gone`` out of an outline's breaks and kinds; what follows moves up."""
    for e in range(gone, edges - 1):
        outline.breaks[e] = outline.breaks[e + 1]
        outline.is_arc[e] = outline.is_arc[e + 1]
        outline.is_fillet[e] = outline.is_fillet[e + 1]

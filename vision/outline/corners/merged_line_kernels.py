"""Neighbouring edges that are one line: a search breaks lines at its seeds, which may lie astray.

Rules and units
- ``px``, ``py`` as in ``vision.outline.fit.shape_kernels``: one border's n points, twice over;
  ``breaks``, ``shape`` and ``ranges`` as in ``vision.outline.corners.joint_kernels``; pictures with
  grey only.
- Beside an arc a seed may lie some points from where the line begins. A stretch that ends there
  is no line, and the search puts a break into the line instead, or takes it for a flat arc. Once
  the edges are fitted and their joints known, the same prices tell that it is one.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.corners.joint_kernels import edge_end
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
LINE, ARC = 0, 1
"""Where the prices of a line and of an arc stand."""


@njit(**LEAF)
def _may_be_line(is_arc, is_fillet, shape, points, e):
    """Whether edge e of so many points is a line, or may pass for one."""
    return not is_arc[e] or (not is_fillet[e] and points < FLAT * shape[e, 2])


@njit(**LEAF)
def _cost(px, py, lo, hi, row, is_arc, dead_zone, sigma):
    """What points lo .. hi - 1 cost beside the edge that they have."""
    if is_arc:
        return circle_cost(px, py, lo, hi, row, False, dead_zone, sigma, ENDLESS, HUGE)
    return line_cost(px, py, lo, hi, row, False, dead_zone, sigma, ENDLESS, HUGE)


@njit(**LEAF)
def _gain(
    px, py, n, breaks, is_arc, is_fillet, edges, e, both, shape, ranges, dead_zone, sigma, worst,
    prices, line,
):  # fmt: skip
    """What one line saves in the place of edge e, or of it and the next one (``both``)."""
    begin = breaks[e]
    middle = edge_end(breaks, edges, n, e)
    if not _may_be_line(is_arc, is_fillet, shape, middle - begin, e):
        return 0.0
    lo = ranges[e, 0]
    hi = ranges[e, 1]
    saved = prices[ARC] if is_arc[e] else prices[LINE]
    if both:
        after = e + 1 if e + 1 < edges else 0
        points = edge_end(breaks, edges, n, after) - breaks[after]
        if not _may_be_line(is_arc, is_fillet, shape, points, after):
            return 0.0
        long = min(points, middle - begin) >= SHORT and not (is_arc[e] or is_arc[after])
        if long and shape[e, 2] * shape[after, 2] + shape[e, 3] * shape[after, 3] < ALONG:
            return 0.0
        shift = middle - breaks[after]
        hi = ranges[after, 1] + shift
        saved += prices[ARC] if is_arc[after] else prices[LINE]
        saved += _cost(px, py, lo, middle, shape[e], is_arc[e], dead_zone, sigma)
        saved += _cost(
            px, py, breaks[after], ranges[after, 1], shape[after], is_arc[after], dead_zone, sigma
        )
    else:
        saved += _cost(px, py, lo, hi, shape[e], is_arc[e], dead_zone, sigma)
    saved -= prices[LINE]
    if hi > 2 * n or saved <= 0.0:
        return 0.0
    fit_line(px, py, lo, hi, STEP, line)
    return saved - line_cost(px, py, lo, hi, line, False, dead_zone, sigma, worst, saved)


@njit(cache=True, nogil=True)
def straighten(
    px, py, n, breaks, is_arc, edges, shape, ranges, dead_zone, sigma, worst, prices, is_fillet,
    line,
):  # fmt: skip
    """Make one line of edges where it describes a border more cheaply.

    ``breaks``, ``is_arc`` and ``is_fillet`` are changed; returns the new number of edges, and
    whether they are. ``shape`` and ``ranges`` do not fit them any more then.
    """
    best = 0.0
    where = -1
    pair = False
    arcs = False
    for e in range(edges):
        arcs = arcs or is_arc[e]
    least = FEWEST if arcs else FEWEST + 1
    for e in range(edges):
        if is_arc[e]:
            gain = _gain(
                px, py, n, breaks, is_arc, is_fillet, edges, e, False, shape, ranges, dead_zone,
                sigma, worst, prices, line,
            )  # fmt: skip
            if gain > best:
                best = gain
                where = e
                pair = False
        if edges >= least:
            gain = _gain(
                px, py, n, breaks, is_arc, is_fillet, edges, e, True, shape, ranges, dead_zone,
                sigma, worst, prices, line,
            )  # fmt: skip
            if gain > best:
                best = gain
                where = e
                pair = True
    if where < 0:
        return edges, False
    is_arc[where] = False
    is_fillet[where] = False
    if not pair:
        return edges, True
    gone = where + 1 if where + 1 < edges else 0
    for e in range(gone, edges - 1):
        breaks[e] = breaks[e + 1]
        is_arc[e] = is_arc[e + 1]
        is_fillet[e] = is_fillet[e + 1]
    return edges - 1, True

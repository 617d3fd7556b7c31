"""Corners that blur cut: short sides that noise and blur make of one sharp corner.

Rules and units
- ``border``, ``outline`` and ``costs``: see ``vision.outline.outline_types``; pictures with grey
  only.
- Under noise a search comes nearer to the joints than blur's rounding of a corner ends; what is
  left of that and what noise saves pay for a side together. Where both lines beside such a side
  and the corner that blur would make of them explain the border's points, it is none.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.corners.blurred_corner_kernels import (
    EXCESS,
    PER_SIGMA,
    REACH,
    find_corners,
    sum_costs,
)
from vision.outline.corners.fillet_kernels import PIXEL_BLUR_PX, set_corner
from vision.outline.corners.merged_line_kernels import drop_edge
from vision.outline.fit.outline_kernels import edge_end
from vision.outline.fit.shape_kernels import HUGE

FEWEST = 4
"""Edges of a border of which one may go."""
LONGEST_BY = 4.5
"""A longer side, in sigmas of the blur, is no corner."""


@njit(**LEAF)
def _sharp_cost(border, lo, hi, a, b, corner, blur, costs):
    """What points lo .. hi - 1 cost beside two lines and the corner that blur makes of them."""
    px, py = border.x, border.y
    dead_zone, sigma, worst = costs.dead_zone, costs.sigma, costs.worst
    expected = costs.expected
    along_x = a[2] + b[2]
    along_y = a[3] + b[3]
    length = math.sqrt(along_x * along_x + along_y * along_y)
    # twice the sine of half the turn, and the side to which the corner is rounded
    height = corner[6] * 2.0 * math.sqrt(max(1.0 - corner[4] * corner[4], 0.0)) * blur
    cost = 0.0
    for k in range(lo, hi):
        dx = px[k] - corner[0]
        dy = py[k] - corner[1]
        t = (dx * along_x + dy * along_y) / length
        row = a if t < 0.0 else b
        d = row[2] * dy - row[3] * dx
        where = abs(t) / blur
        if where < REACH:
            where *= PER_SIGMA
            i = int(where)
            share = where - i
            d -= height * ((1.0 - share) * EXCESS[i] + share * EXCESS[i + 1])
        d = abs(d)
        if d > worst:
            return HUGE
        over = max(d - dead_zone, 0.0) / sigma
        cost += over * over - expected
    return cost


@njit(**LEAF)
def drop_side(border, outline, edges, blur, costs, price, room):
    """Leave out the short side that a sharp corner explains best.

    ``price`` is a line's; ``room``: ``Scratch``. ``breaks``, ``is_arc`` and
    ``is_fillet`` are changed; returns the new number of edges, and whether they are.
    """
    n = border.n
    breaks = outline.breaks
    is_arc = outline.is_arc
    shape = outline.shape
    joints = outline.joints
    if edges < FEWEST:
        return edges, False
    blur = math.sqrt(blur * blur + PIXEL_BLUR_PX * PIXEL_BLUR_PX)
    span = int(REACH * blur) + 1
    longest = (LONGEST_BY * blur) ** 2
    corner = room.numbers[6]
    corners = room.table
    sums = room.numbers[2]
    summed = False
    best = 0.0
    gone = -1
    for e in range(edges):
        before = predecessor(e, edges)
        after = successor(e, edges)
        if is_arc[e] or is_arc[before] or is_arc[after]:
            continue
        dx = joints[after, 0] - joints[e, 0]
        dy = joints[after, 1] - joints[e, 1]
        if dx * dx + dy * dy > longest or not set_corner(shape[before], shape[after], corner):
            continue
        # the lines' points up to their middles at most
        lo = breaks[e] - min(span, ((breaks[e] - breaks[before]) % n) // 2)
        hi = edge_end(breaks, edges, n, e)
        hi += min(span, (edge_end(breaks, edges, n, after) - breaks[after]) // 2)
        if lo < 0:
            lo += n
            hi += n
        if hi > 2 * n:
            continue
        cost = _sharp_cost(border, lo, hi, shape[before], shape[after], corner, blur, costs)
        if cost >= HUGE:
            continue
        if not summed:
            # only few borders have such a side
            summed = True
            find_corners(border, outline, edges, corners)
            sum_costs(border, outline, edges, corners, blur, costs, sums)
        gain = sums[hi] - sums[lo] + price - cost
        if gain > best:
            best = gain
            gone = e
    if gone < 0:
        return edges, False
    _join_sides_of(border, outline, edges, gone)
    return edges - 1, True


@njit(**LEAF)
def _join_sides_of(border, outline, edges, gone):
    """Take side ``gone`` out of an outline: its neighbours meet in its middle."""
    n = border.n
    breaks = outline.breaks
    is_arc = outline.is_arc
    is_fillet = outline.is_fillet
    middle = (breaks[gone] + edge_end(breaks, edges, n, gone)) // 2
    if gone + 1 < edges:
        breaks[gone + 1] = middle
    elif middle >= n:
        breaks[0] = middle - n
    else:
        # the first edge begins before the border's first point now: it is the last one
        breaks[gone] = middle
        is_arc[gone] = is_arc[0]
        is_fillet[gone] = is_fillet[0]
        gone = 0
    drop_edge(outline, edges, gone)

"""Corners that blur cut: short sides that noise and blur make of one sharp corner.

Rules and units
- ``px``, ``py`` as in ``vision.outline.fit.shape_kernels``: one border's n points, twice over;
  ``breaks``, ``shape`` and ``joints`` as in ``vision.outline.corners.joint_kernels``; pictures with
  grey only.
- Under noise a search comes nearer to the joints than blur's rounding of a corner ends; what is
  left of that and what noise saves pay for a side together. Where both lines beside such a side
  and the corner that blur would make of them explain the border's points, it is none.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.corners.blurred_corner_kernels import (
    CORNER_ROOM,
    EXCESS,
    PER_SIGMA,
    REACH,
    find_corners,
    sum_costs,
)
from vision.outline.corners.fillet_kernels import PIXEL_BLUR_PX, set_corner
from vision.outline.corners.joint_kernels import edge_end

FEWEST = 4
"""Edges of a border of which one may go."""
LONGEST_BY = 4.5
"""A longer side, in sigmas of the blur, is no corner."""


@njit(**LEAF)
def _sharp_cost(px, py, lo, hi, a, b, corner, blur, dead_zone, sigma, worst, expected):
    """What points lo .. hi - 1 cost beside two lines and the corner that blur makes of them."""
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
            return 1e18
        over = max(d - dead_zone, 0.0) / sigma
        cost += over * over - expected
    return cost


@njit(cache=True, nogil=True)
def sharpen(
    px, py, n, breaks, is_arc, edges, shape, joints, blur, dead_zone, sigma, worst, expected,
    price, is_fillet, corner,
):  # fmt: skip
    """Leave out the short side that a sharp corner explains best.

    ``price`` is a line's. ``breaks``, ``is_arc`` and ``is_fillet`` are changed; returns the new
    number of edges, and whether they are.
    """
    if edges < FEWEST:
        return edges, False
    blur = math.sqrt(blur * blur + PIXEL_BLUR_PX * PIXEL_BLUR_PX)
    span = int(REACH * blur) + 1
    longest = (LONGEST_BY * blur) ** 2
    corners = np.empty((0, CORNER_ROOM), np.float64)
    sums = np.empty(0, np.float64)
    best = 0.0
    gone = -1
    for e in range(edges):
        before = e - 1 if e > 0 else edges - 1
        after = e + 1 if e + 1 < edges else 0
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
        cost = _sharp_cost(
            px, py, lo, hi, shape[before], shape[after], corner, blur, dead_zone, sigma, worst,
            expected,
        )  # fmt: skip
        if cost >= 1e18:
            continue
        if sums.shape[0] == 0:
            # only few borders have such a side
            corners = np.empty((edges, CORNER_ROOM), np.float64)
            sums = np.empty(2 * n + 1, np.float64)
            find_corners(px, py, n, breaks, is_arc, edges, shape, joints, corners)
            sum_costs(
                px, py, n, breaks, is_arc, edges, shape, joints, corners, blur, dead_zone, sigma,
                expected, sums,
            )  # fmt: skip
        gain = sums[hi] - sums[lo] + price - cost
        if gain > best:
            best = gain
            gone = e
    if gone < 0:
        return edges, False
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
    for e in range(gone, edges - 1):
        breaks[e] = breaks[e + 1]
        is_arc[e] = is_arc[e + 1]
        is_fillet[e] = is_fillet[e + 1]
    return edges - 1, True

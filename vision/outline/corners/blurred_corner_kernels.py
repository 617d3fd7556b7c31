"""Rounding of a border's corners by blur, and the cost of its points beside that.

Rules and units
- Types: ``vision.outline.outline_types``.
- ``corners`` (edges, 8), a row a joint: unit vectors of the border before and after it, the unit
  vector between both, twice the sine of half the turn, positive clockwise on the screen, and the
  turn in radians with the same sign.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, SUMS
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.corners.crossing_kernels import tangent_at
from vision.outline.fit.edge_shape_kernels import HUGE
from vision.outline.fit.outline_kernels import edge_end
from vision.shared.typed_numbers import NO

CORNER_FIELDS = 8
"""Numbers of a corner's row: defined."""
ALONG_X, ALONG_Y, STEEPNESS, TURN = 4, 5, 6, 7
"""Places in it: defined."""
ROUNDING_REACH = 4.0
"""Range of rounding from a joint, in sigmas of the blur: chosen."""
PER_SIGMA = 32
"""Entries of the table for a sigma: chosen, linear interpolation is right to 5e-5 of the blur."""


def _excess(t: float) -> float:
    """Mean of max(x - t, 0) under a Gaussian of sigma 1."""
    tail = 0.5 * math.erfc(t / math.sqrt(2.0))
    return math.exp(-0.5 * t * t) / math.sqrt(2.0 * math.pi) - t * tail


TABLE_END = ROUNDING_REACH * PER_SIGMA
"""End of the table, where the excess is none."""
EXCESS = np.array([_excess(k / PER_SIGMA) for k in range(int(ROUNDING_REACH * PER_SIGMA) + 2)])
"""The table: derived, see above."""


@njit(**LEAF)
def find_corners(border, outline, edges, corners):
    """Fill ``corners``: the border's directions before and after every joint."""
    px = border.x
    py = border.y
    breaks = outline.breaks
    is_arc = outline.is_arc
    shape = outline.shape
    joints = outline.joints
    for e in range(edges):
        before = predecessor(e, edges)
        x = joints[e, 0]
        y = joints[e, 1]
        here = breaks[e]
        back = breaks[before]
        p = back + max((here - back) % border.n, 2) // 2
        q = here + max(edge_end(breaks, edges, border.n, e) - here, 2) // 2
        ax, ay = tangent_at(shape[before], is_arc[before], x, y, x - px[p], y - py[p])
        bx, by = tangent_at(shape[e], is_arc[e], x, y, px[q] - x, py[q] - y)
        put_corner(ax, ay, bx, by, corners[e])


@njit(**LEAF)
def put_corner(ax, ay, bx, by, corner):
    """Fill the row of a corner between the directions (ax, ay) and (bx, by)."""
    cross = ax * by - ay * bx
    dot = ax * bx + ay * by
    length = math.sqrt(max(2.0 + 2.0 * dot, 0.0))
    share = 1.0 / length if length > 1e-9 else 0.0
    steepness = math.sqrt(max(2.0 - 2.0 * dot, 0.0)) if length > 1e-9 else 0.0
    corner[0] = ax
    corner[1] = ay
    corner[2] = bx
    corner[3] = by
    corner[ALONG_X] = (ax + bx) * share
    corner[ALONG_Y] = (ay + by) * share
    corner[STEEPNESS] = steepness if cross > 0.0 else -steepness
    corner[TURN] = math.atan2(cross, dot)


@njit(**SUMS)
def _measure(px, py, lo, hi, row, is_arc, side, deviations):
    """Deviations of points lo .. hi - 1 from a line or a circle, positive to the right."""
    xs = px[lo:hi]
    ys = py[lo:hi]
    x0 = row[0]
    y0 = row[1]
    if is_arc:
        r = row[2]
        for k in range(hi - lo):
            dx = xs[k] - x0
            dy = ys[k] - y0
            deviations[k] = side * (math.sqrt(dx * dx + dy * dy) - r)
        return
    ux = row[2]
    uy = row[3]
    for k in range(hi - lo):
        deviations[k] = ux * (ys[k] - y0) - uy * (xs[k] - x0)


@njit(**LEAF)
def _explain(border, lo, hi, from_, joint, corner, blur, deviations):
    """Subtract a corner's share from points lo .. hi - 1; ``deviations`` begin at ``from_``.

    ``joint`` (2,): the corner's position. In a slight turn, the half level lies at the mean height
    of both sides under a Gaussian.
    """
    reach = (ROUNDING_REACH * blur) ** 2
    scale = PER_SIGMA / blur
    height = corner[STEEPNESS] * blur
    joint_x = joint[0]
    joint_y = joint[1]
    for k in range(lo, hi):
        dx = border.x[k] - joint_x
        dy = border.y[k] - joint_y
        if dx * dx + dy * dy > reach:
            continue
        t = abs(dx * corner[ALONG_X] + dy * corner[ALONG_Y]) * scale
        # tangents of arcs that miss their joint are no unit vectors
        t = min(t, TABLE_END)
        i = int(t)
        share = t - i
        deviations[k - from_] -= height * ((1.0 - share) * EXCESS[i] + share * EXCESS[i + 1])


@njit(**SUMS)
def _price(deviations, dead_zone, sigma, expected):
    inv = 1.0 / sigma
    for k in range(deviations.shape[0]):
        over = max(abs(deviations[k]) - dead_zone, 0.0) * inv
        deviations[k] = over * over - expected


@njit(**LEAF)
def _measure_edge(border, outline, corners, e, after, lo, hi, blur, deviations):
    """Deviations of an edge, less what blur explains at both its ends."""
    row = outline.shape[e]
    joints = outline.joints
    side = 1.0
    if outline.is_arc[e]:
        # positive to the right of the path, as for a line
        x = joints[e, 0] - row[0]
        y = joints[e, 1] - row[1]
        side = -1.0 if x * corners[e, 3] - y * corners[e, 2] > 0.0 else 1.0
    span = int(2.0 * ROUNDING_REACH * blur) + 2
    _measure(border.x, border.y, lo, hi, row, outline.is_arc[e], side, deviations)
    _explain(border, lo, min(lo + span, hi), lo, joints[e], corners[e], blur, deviations)
    _explain(border, max(hi - span, lo), hi, lo, joints[after], corners[after], blur, deviations)


@njit(**LEAF)
def sum_costs(border, outline, edges, corners, blur, costs, sums):
    """Cumulative cost of the border's points, over two rounds, less the share of noise.

    ``sums`` (2 * n + 1,).
    """
    n = border.n
    for e in range(edges):
        after = successor(e, edges)
        lo = outline.breaks[e]
        hi = edge_end(outline.breaks, edges, n, e)
        here = sums[lo + 1 : hi + 1]
        _measure_edge(border, outline, corners, e, after, lo, hi, blur, here)
        _price(here, costs.dead_zone, costs.sigma, costs.expected)
        for k in range(n, hi):
            sums[k - n + 1] = sums[k + 1]
    sums[0] = 0.0
    for k in range(n):
        sums[k + 1] += sums[k]
    for k in range(n):
        sums[n + k + 1] = sums[n] + sums[k + 1]


@njit(**LEAF)
def change_cost(border, change, is_arc, inwards, blur, costs, worst):
    """Cost of an edge and its two neighbours, points ``lo`` .. ``hi`` - 1 of ``change``.

    As ``sum_costs``; HUGE if a point lies farther off than ``worst``. ``inwards``: the arc's shift
    towards its centre, by blur.
    """
    rows, joints, corners = change.rows, change.joints, change.corners
    lo, first, behind, hi = change.points[0], change.points[1], change.points[2], change.points[3]
    left = change.deviations[: hi - lo]
    span = int(2.0 * ROUNDING_REACH * blur) + 2
    _measure(border.x, border.y, lo, first, rows[0], NO, 1.0, left)
    _explain(border, max(first - span, lo), first, lo, joints[0], corners[0], blur, left)
    if behind > first:
        side = -1.0 if corners[0, TURN] + corners[1, TURN] > 0.0 else 1.0
        there = left[first - lo : behind - lo]
        _measure(border.x, border.y, first, behind, rows[1], is_arc, side, there)
        if is_arc:
            for k in range(there.shape[0]):
                there[k] += side * inwards
        else:
            _explain(border, first, behind, first, joints[0], corners[0], blur, there)
            _explain(border, first, behind, first, joints[1], corners[1], blur, there)
    _measure(border.x, border.y, behind, hi, rows[2], NO, 1.0, left[behind - lo :])
    _explain(border, behind, min(behind + span, hi), lo, joints[1], corners[1], blur, left)
    for k in range(hi - lo):
        if abs(left[k]) > worst:
            return HUGE
    _price(left, costs.dead_zone, costs.sigma, costs.expected)
    total = 0.0
    for k in range(hi - lo):
        total += left[k]
    return total

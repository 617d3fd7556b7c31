"""Edits that may improve an outline, and the saving of each.

Rules and units
- Types: ``vision.outline.outline_types``; pictures with grey only.
- A partition ignores points near its breaks, and breaks at seeds only. An edit is judged by all
  points, with corners as blur rounds them (``vision.outline.corners.blurred_corner_kernels``): it
  saves the cost and prices of the edges that it replaces, less its own.
- An edit replaces a run of edges, possibly empty, between two that stay, ``i`` and ``j``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.corners.blurred_corner_kernels import (
    ROUNDING_REACH,
    TURN,
    change_cost,
    find_corners,
    put_corner,
    sum_costs,
)
from vision.outline.corners.crossing_kernels import crossing
from vision.outline.corners.fillet_kernels import (
    ANCHOR_FROM,
    ANCHOR_TO,
    MOST_TURN,
    set_corner,
    try_fillet,
)
from vision.outline.corners.wall_end_kernels import try_end, turns_back
from vision.outline.fit.edge_shape_kernels import BEATEN, HUGE, fit_line, line_cost
from vision.outline.fit.outline_kernels import edge_end
from vision.outline.fitted_borders import FEWEST_LINES
from vision.outline.outline_types import EdgeRun
from vision.shared.typed_numbers import NO

CORNER, ONE_LINE, WALL_END, FILLET = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
"""Replacements of a run of edges (defined): the corner of the two that stay, one line, a line
square to both at the end of a wall, an arc that touches both. Typed, so that kernels are compiled
once."""
KINDS = 4
"""Their number: defined."""
EDIT_SHARES = 0.0, 1.0, 1.0, 1.5
"""Their prices in lines. A fillet has one free number, a line and its break two: it is dearer than
a line, so that a bevel stays straight (chosen)."""
LONGEST_RUN = 6
"""Most edges that one edit replaces: a bound on the work (indifferent)."""
SHORT_RUN = 2
"""Most edges that a corner or a wall's end replaces: blur rounds a corner to two sides at most
(chosen)."""
COUNTER_TURN = math.radians(3.0)
"""Least turn back of edges that are no chords of one arc: noise turns short ones (chosen)."""
FLAT_ARC_RAD = 0.25
"""Turn in radians of an arc below which it may be a line that took some of the arcs at its ends: up
to 60 px long it rises by less than 2 px (chosen)."""


@njit(**LEAF, inline="always")
def find_edits(border, outline, edges, untouched, blur, costs, prices, edits, change, scratch):
    """Find the best edit behind every edge; True if any saves something.

    ``untouched``: the outline is as partitioned.
    """
    corners = scratch.table
    sums = edits.sums
    find_corners(border, outline, edges, corners)
    sum_costs(border, outline, edges, corners, blur.sigma, costs, sums)
    # an outline with an arc needs one edge fewer
    spare = edges - FEWEST_LINES
    for e in range(edges):
        if outline.is_arc[e]:
            spare = edges - FEWEST_LINES + 1
    stays = change.stays
    any_edit = False
    for i in range(edges):
        edits.saved[i] = 0.0
        stays[0] = outline.breaks[i]
        stays[1] = edge_end(outline.breaks, edges, border.n, i)
        stays[2] = stays[1]
        price = turned = 0.0
        bent = False
        convex = True
        for run in range(min(LONGEST_RUN, edges - 1) + 1):
            j = (i + run + 1) % edges
            points = edge_end(outline.breaks, edges, border.n, j) - outline.breaks[j]
            stays[3] = stays[2] + points
            turn = corners[j, TURN]
            convex = convex and (turn * turned >= 0.0 or abs(turn) <= COUNTER_TURN)
            turned += turn
            convex = convex and abs(turned) <= MOST_TURN
            if run > SHORT_RUN and bent and not convex:
                break
            saved = price
            if run < edges - 1:
                lo = stays[0] + int((stays[1] - stays[0]) * ANCHOR_FROM)
                hi = stays[2] + int((stays[3] - stays[2]) * ANCHOR_TO)
                saved = price + (sums[hi] - sums[lo])
            state = EdgeRun(i, j, run, spare, untouched, convex, bent, price, saved)
            for kind in range(KINDS):
                if _may_be(border, outline, edges, state, kind, prices.line, blur, stays):
                    any_edit |= _try_edit(
                        border, outline, edges, state, kind, blur, costs, prices, edits, change
                    )
            if run < edges - 1 and not bent:
                bent = run > 0 and _is_wide(border, stays[1], stays[2], stays[3], costs)
                if outline.is_arc[j] and not bent:
                    middle = (stays[2] + stays[3]) // 2
                    bent = _is_wide(border, stays[2], middle, stays[3], costs)
            if outline.is_fillet[j]:
                price += EDIT_SHARES[FILLET] * prices.line
            else:
                price += prices.arc if outline.is_arc[j] else prices.line
            stays[2] = stays[3]
    return any_edit


@njit(**LEAF)
def _is_wide(border, p, q, r, costs):
    """True if no line passes within the limit of three points of the border, or of more.

    The line nearest to a triangle's corners is half a height away. The limit is doubled, as blur
    moves points near corners.
    """
    px, py = border.x, border.y
    ax = px[q] - px[p]
    ay = py[q] - py[p]
    bx = px[r] - px[p]
    by = py[r] - py[p]
    longest = max(ax * ax + ay * ay, bx * bx + by * by, (bx - ax) ** 2 + (by - ay) ** 2)
    return abs(ax * by - ay * bx) > 4.0 * costs.worst * math.sqrt(longest)


@njit(**LEAF)
def _may_be(border, outline, edges, run, kind, line_price, blur, stays):
    """True if an edit is worth a closer look, by the edges alone."""
    if run.length - (kind != CORNER) > run.spare:
        return False
    if kind == ONE_LINE:
        return run.price > line_price and not run.bent and _may_be_line(outline, edges, run)
    i = run.before
    j = run.behind
    if run.length > edges - 2:
        return False
    if kind == FILLET:
        return (
            run.convex
            and run.saved > EDIT_SHARES[FILLET] * line_price
            and not (run.length == 1 and outline.is_fillet[(i + 1) % edges])
            and _is_flat(border, outline, stays[0], stays[1], i)
            and _is_flat(border, outline, stays[2], stays[3], j)
        )
    if run.length > SHORT_RUN or outline.is_arc[i] or outline.is_arc[j]:
        return False
    if kind == WALL_END:
        return run.untouched and turns_back(outline.shape[i], outline.shape[j], stays)
    # blur rounds no farther to both sides
    return run.length > 0 and stays[2] - stays[1] <= 2.0 * ROUNDING_REACH * blur.sigma


@njit(**LEAF)
def _may_be_line(outline, edges, run):
    arcs = False
    for t in range(run.length):
        e = (run.before + 1 + t) % edges
        if outline.is_fillet[e]:
            return False
        arcs = arcs or outline.is_arc[e]
    return run.length > 1 or arcs


@njit(**LEAF)
def _is_flat(border, outline, lo, hi, e):
    if not outline.is_arc[e]:
        return True
    px, py = border.x, border.y
    return (
        math.sqrt((px[hi] - px[lo]) ** 2 + (py[hi] - py[lo]) ** 2)
        < FLAT_ARC_RAD * outline.shape[e, 2]
    )


@njit(**LEAF, inline="always")
def _try_edit(border, outline, edges, run, kind, blur, costs, prices, edits, change):
    """Note an edit if it saves more than the best one behind its edge; True if so."""
    points = change.points
    cost = _cost_of_edit(border, outline, edges, run, kind, blur, costs, change)
    if cost >= HUGE:
        return False
    now = edits.sums[points[3]] - edits.sums[points[0]]
    saved = now + run.price - cost - EDIT_SHARES[kind] * prices.line
    if kind == WALL_END:
        # the corners' model fails at so narrow an end: its width and place decide
        saved = max(saved, BEATEN)
    i = run.before
    if saved <= edits.saved[i]:
        return False
    edits.saved[i] = saved
    edits.run[i] = run.length
    edits.kind[i] = kind
    edits.first[i] = points[1]
    edits.behind[i] = points[2]
    return True


@njit(**LEAF, inline="always")
def _cost_of_edit(border, outline, edges, run, kind, blur, costs, change):
    """Cost of an edit's points with it, HUGE if it is impossible; fills ``points``."""
    if kind == ONE_LINE:
        return _try_line(border, outline, edges, run, blur, costs, change)
    if kind == FILLET:
        return try_fillet(border, blur, costs, change)
    if not _compare_from(border, outline, run, blur, change):
        return HUGE
    if kind == WALL_END:
        return try_end(border, blur, costs, change)
    return _try_corner(border, blur, costs, change)


@njit(**LEAF)
def _compare_from(border, outline, run, blur, change):
    """Copy the lines beside a run and choose points nearby to compare; False if too many."""
    for c in range(4):
        change.rows[0, c] = outline.shape[run.before, c]
        change.rows[2, c] = outline.shape[run.behind, c]
    # up to their middles at most
    span = int(ROUNDING_REACH * blur.sigma) + 1
    stays = change.stays
    change.points[0] = stays[1] - min(span, (stays[1] - stays[0]) // 2)
    change.points[3] = stays[2] + min(span, (stays[3] - stays[2]) // 2)
    return change.points[3] <= 2 * border.n


@njit(**LEAF)
def _are_lines(outline, edges, run):
    if run.length > edges - 2:
        return False
    for t in range(run.length + 2):  # noqa: SIM110 (numba knows no generators)
        if outline.is_arc[(run.before + t) % edges]:
            return False
    return True


@njit(**LEAF)
def _try_line(border, outline, edges, run, blur, costs, change):
    """One line for a run of edges, through the points of their fits.

    With arcs, whose ends move, only those points are compared.
    """
    begin = (run.before + 1) % edges
    last = (run.before + run.length) % edges
    rows, stays, points = change.rows, change.stays, change.points
    lo = stays[1] + outline.ranges[begin, 0] - outline.breaks[begin]
    hi = stays[2] + outline.ranges[last, 1] - edge_end(outline.breaks, edges, border.n, last)
    if lo < 0 or hi - lo < 2 or hi > 2 * border.n:  # an edge never fitted
        return HUGE
    line = rows[1]
    fit_line(border.x, border.y, lo, hi, line)
    cost = line_cost(
        border.x, border.y, lo, hi, line, NO, costs.dead_zone, costs.sigma, costs.worst, HUGE
    )
    points[1] = stays[1]
    points[2] = stays[2]
    if cost >= HUGE:
        return HUGE
    if _are_lines(outline, edges, run) and _compare_from(border, outline, run, blur, change):
        joints, corners = change.joints, change.corners
        meet = crossing(border, stays[1] % border.n, rows[0], NO, line, NO, joints[0])
        if meet and crossing(border, stays[2] % border.n, line, NO, rows[2], NO, joints[1]):
            put_corner(rows[0, 2], rows[0, 3], line[2], line[3], corners[0])
            put_corner(line[2], line[3], rows[2, 2], rows[2, 3], corners[1])
            return change_cost(border, change, NO, 0.0, blur.sigma, costs, HUGE)
    points[0] = lo
    points[3] = hi
    return cost - costs.expected * (hi - lo)


@njit(**LEAF)
def _try_corner(border, blur, costs, change):
    """The corner of the two edges that stay, for a run no longer than blur rounds."""
    px, py = border.x, border.y
    rows, points, meeting = change.rows, change.points, change.meeting
    if not set_corner(rows[0], rows[2], meeting):
        return HUGE
    middle = (change.stays[1] + change.stays[2]) // 2
    dx = px[middle] - meeting[0]
    dy = py[middle] - meeting[1]
    if dx * dx + dy * dy > (ROUNDING_REACH * blur.sigma) ** 2:
        return HUGE
    along_x = rows[0, 2] + rows[2, 2]
    along_y = rows[0, 3] + rows[2, 3]
    points[1] = points[2] = change.stays[2]
    for k in range(change.stays[2], change.stays[1] - 1, -1):
        if (px[k] - meeting[0]) * along_x + (py[k] - meeting[1]) * along_y >= 0.0:
            points[1] = points[2] = k
    for side in range(2):
        change.joints[side, 0] = meeting[0]
        change.joints[side, 1] = meeting[1]
        put_corner(rows[0, 2], rows[0, 3], rows[2, 2], rows[2, 3], change.corners[side])
    return change_cost(border, change, NO, 0.0, blur.sigma, costs, costs.worst)

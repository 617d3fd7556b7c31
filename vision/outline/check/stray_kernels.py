"""The invariant of every outline: it lies on its border, and its border lies on it.

Rules and units
- ``border`` and ``finished``, edges ``0 .. count - 1`` around it: see
  ``vision.outline.outline_types``.
- Points of an edge, ``STRAY_PX`` apart, must lie beside the border.
- A fit's residuals ignore points near its ends, and their positions along an edge.
- The tip of a pointed corner that blur rounded may reach ``LONGEST_TIP_PX`` beyond where its sides
  are ``STRAY_PX`` apart.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import successor
from vision.outline.check.loss_kernels import LONGEST_TIP_PX, loss_beside
from vision.outline.fit.edge_shape_kernels import HUGE
from vision.outline.fit.outline_kernels import STRAY_PX, arc_sweep, distance_to_edge
from vision.outline.fitted_borders import LINE

LONGEST_EDGE = 4.0
"""Largest length of an edge, as a multiple of its points' stretch, plus tips: indifferent."""


@njit(**LEAF)
def outline_strays(border, finished, count):
    """True if an outline leaves its border by more than ``STRAY_PX``, or its border the outline."""
    n = border.n
    at = finished.at
    first_x = 0.0
    first_y = 0.0
    last_x = 0.0
    last_y = 0.0
    for i in range(count):
        after = successor(i, count)
        lo = at[i]
        hi = at[after]
        hi = hi + n if hi < lo or count == 1 else hi
        far, _ = loss_beside(border, lo, hi, finished, i, after, HUGE, 0.0, 0.0)
        if far > STRAY_PX and not _beside_any(border, lo, hi, finished, count):
            return True
        if _runs_along(border, lo, hi, finished, i, after, far):
            lies = True
            ax, ay, bx, by = _ends(finished.rows, i, after)
        else:
            lies, ax, ay, bx, by = _beside_border(border, lo, hi, finished, i, after)
        if not lies:
            return True
        if i == 0:
            first_x = ax
            first_y = ay
        elif _is_wide(last_x, last_y, ax, ay):
            return True
        last_x = bx
        last_y = by
    return _is_wide(last_x, last_y, first_x, first_y)


@njit(**LEAF)
def _is_wide(ax, ay, bx, by):
    """True if a corner whose sides leave the border at a and b is not a pointed one."""
    return (ax - bx) ** 2 + (ay - by) ** 2 > STRAY_PX * STRAY_PX


@njit(**LEAF)
def _beside_any(border, lo, hi, finished, count):
    for k in range(lo, hi + 1):
        near = False
        for i in range(count):
            after = successor(i, count)
            away, _, _ = distance_to_edge(
                finished.kind, finished.rows, i, after, border.x[k], border.y[k]
            )
            if away <= STRAY_PX:
                near = True
                break
        if not near:
            return False
    return True


@njit(**LEAF)
def _ends(rows, i, after):
    return rows[i, 0], rows[i, 1], rows[after, 0], rows[after, 1]


@njit(**LEAF)
def _runs_along(border, lo, hi, finished, i, after, far):
    """True if points lo .. hi lead along all of a line, none farther from it than ``far``.

    This spares most lines a search for each point.
    """
    if finished.kind[i] != LINE or far > STRAY_PX:
        return False
    x0, y0, x1, y1 = _ends(finished.rows, i, after)
    limit = STRAY_PX * STRAY_PX
    to_begin = (border.x[lo] - x0) ** 2 + (border.y[lo] - y0) ** 2
    to_end = (border.x[hi] - x1) ** 2 + (border.y[hi] - y1) ** 2
    return to_begin <= limit and to_end <= limit


@njit(**LEAF)
def _beside_border(border, lo, hi, finished, i, after):
    """True if edge i lies beside its border points lo .. hi, except tips at its ends.

    Returns ``(True if so, x, y, x, y)``: its first and last places beside the border.
    """
    kind = finished.kind
    rows = finished.rows
    x0 = rows[i, 0]
    y0 = rows[i, 1]
    dx = rows[after, 0] - x0
    dy = rows[after, 1] - y0
    length = math.sqrt(dx * dx + dy * dy)
    begin = 0.0
    sweep = 0.0
    if kind[i] != LINE:
        begin, sweep = arc_sweep(kind, rows, i, after)
        length = abs(sweep) * rows[i, 4]
    if length > LONGEST_EDGE * (hi - lo + 1) + 2.0 * LONGEST_TIP_PX:
        return False, x0, y0, x0, y0
    steps = max(math.ceil(length / STRAY_PX), 1)
    step = length / steps
    found = False
    ahead = 0.0
    first_x = x0
    first_y = y0
    last_x = x0
    last_y = y0
    here = lo
    for t in range(steps + 1):
        share = t / steps
        x = x0 + share * dx
        y = y0 + share * dy
        if kind[i] != LINE:
            angle = begin + share * sweep
            x = rows[i, 2] + rows[i, 4] * math.cos(angle)
            y = rows[i, 3] + rows[i, 4] * math.sin(angle)
        near, here = _find_beside(border, lo, hi, here, x, y)
        if near and ahead > 0.0 and found:
            # it left the border between two points that lie on it
            return False, first_x, first_y, last_x, last_y
        if near and not found:
            found = True
            first_x = x
            first_y = y
        if near:
            ahead = 0.0
            last_x = x
            last_y = y
        else:
            ahead += step
            if ahead > LONGEST_TIP_PX:
                return False, first_x, first_y, last_x, last_y
    return found, first_x, first_y, last_x, last_y


@njit(**LEAF)
def _find_beside(border, lo, hi, here, x, y):
    """True if the border lies beside (x, y), and the nearest of points lo .. hi.

    The search continues from point ``here``, the previous result, then over all points: a joint may
    lie away from its break.
    """
    px = border.x
    py = border.y
    n = border.n
    best = (px[here] - x) ** 2 + (py[here] - y) ** 2
    while here < hi:
        next_ = (px[here + 1] - x) ** 2 + (py[here + 1] - y) ** 2
        if next_ > best:
            break
        best = next_
        here += 1
    limit = STRAY_PX * STRAY_PX
    if best <= limit:
        return True, here
    for k in range(n):
        d = _square_to_link(px, py, k, x, y)
        if d < best:
            best = d
            ahead = k if k >= lo else k + n
            here = ahead if ahead <= hi else here
    return best <= limit, here


@njit(**LEAF)
def _square_to_link(px, py, k, x, y):
    """Squared distance from (x, y) to the link of point k and the next: noise leaves gaps."""
    dx = px[k + 1] - px[k]
    dy = py[k + 1] - py[k]
    x -= px[k]
    y -= py[k]
    square = dx * dx + dy * dy
    t = min(max((x * dx + y * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return (x - t * dx) ** 2 + (y - t * dy) ** 2

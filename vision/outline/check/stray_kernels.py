"""The invariant of every outline: it lies on its border, and its border lies on it.

Rules and units
- ``border`` and ``finished``, edges ``0 .. count - 1`` around it: see
  ``vision.outline.outline_types``.
- Points of an edge that are ``STRAY_PX`` apart are looked for beside the border.
- What is checked is the finished outline, joints and chords and all, however it came about: a
  fit's residuals leave out what lies near its ends, and where along an edge its points lie.
- Where blur rounded a pointed corner back, the outline has the corner that the sides make: a tip
  may reach ``LONGEST_TIP_PX`` farther, from where its sides are no farther apart than ``STRAY_PX``:
  no robot fits into that.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import successor
from vision.outline.check.loss_kernels import LONGEST_TIP_PX, loss_beside
from vision.outline.fit.outline_kernels import STRAY_PX, arc_sweep, distance_to_edge
from vision.outline.fit.shape_kernels import HUGE
from vision.outline.fitted_borders import LINE

LONGEST = 4.0
"""What is longer than so many of its stretch's points, and a tip at either end, is not its edge:
indifferent."""


@njit(**LEAF)
def outline_strays(border, finished, count):
    """Whether an outline leaves its border by more than ``STRAY_PX``, or its border the outline."""
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
    """Whether a corner whose sides leave the border at a and b is no pointed one."""
    return (ax - bx) ** 2 + (ay - by) ** 2 > STRAY_PX * STRAY_PX


@njit(**LEAF)
def _beside_any(border, lo, hi, finished, count):
    """Whether points lo .. hi each lie beside some edge of the outline."""
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
    """Where edge i begins and ends."""
    return rows[i, 0], rows[i, 1], rows[after, 0], rows[after, 1]


@njit(**LEAF)
def _runs_along(border, lo, hi, finished, i, after, far):
    """Whether points lo .. hi lead along all of a line, none farther from it than ``far``.

    What leads from one end of a line to the other, and stays near it, has every point of the line
    beside it, however far apart its own points are. That spares most lines the search for each of
    their points. It does not hold for arcs: a link between two points far apart cuts across.
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
    """Whether edge i lies beside its border points lo .. hi, but for tips at its ends.

    Returns ``(whether, x, y, x, y)``: where it does so first, and last: its ends without tips.
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
    if length > LONGEST * (hi - lo + 1) + 2.0 * LONGEST_TIP_PX:
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
            # it left the border between two points that lie there
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
    """Whether the border lies beside (x, y), and which of points lo .. hi is nearest.

    The search goes on from point ``here``, the last one's: points and edge run side by side. Where
    that leads nowhere all are looked at: a joint may lie some points away from its break.
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
    """The squared distance from (x, y) to what joins point k and the next: noise leaves gaps."""
    dx = px[k + 1] - px[k]
    dy = py[k + 1] - py[k]
    x -= px[k]
    y -= py[k]
    square = dx * dx + dy * dy
    t = min(max((x * dx + y * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return (x - t * dx) ** 2 + (y - t * dy) ** 2

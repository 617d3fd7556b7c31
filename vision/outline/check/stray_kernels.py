"""The invariant of every outline: it lies on its border, and its border lies on it.

Rules and units
- Edges ``0 .. count - 1`` of ``kind`` and ``rows`` (see ``vision.outline.fit.outline_kernels``),
  whose first points' indices are in ``at``, around the border; ``px``, ``py``: its n points, twice
  over.
- What is checked is the finished outline, joints and chords and all, however it came about: a
  fit's residuals leave out what lies near its ends, and where along an edge its points lie.
- Where blur rounded a pointed corner back, the outline has the corner that the sides make: a tip
  may reach farther, see ``TIP_PX``.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from vision.outline.check.area_lost_kernels import loss_beside
from vision.outline.fit.outline_kernels import STRAY_PX, TAU, distance_to_edge
from vision.outline.fit.shape_kernels import HUGE
from vision.outline.fitted_borders import ARC_CCW, LINE

TIP_PX, TIP_BASE_PX = 12.0, 2.0
"""How long a pointed corner's sides may be where they leave the border by more than ``STRAY_PX``,
and how far apart where they begin to. A tip reaches as far back as the blur's sigma over the
sine of half its angle: these are 10 degrees at a sigma of 1 px. No robot fits into its base."""
EVERY_PX = 2.0
"""Points of an edge so far apart are looked for beside the border."""
LONGEST = 4.0
"""What is longer than so many of its stretch's points, and a tip at either end, is not its edge."""


@njit(**LEAF)
def outline_strays(px, py, n, at, kind, rows, count):
    """Whether an outline leaves its border by more than ``STRAY_PX``, or its border the outline."""
    first_x = 0.0
    first_y = 0.0
    last_x = 0.0
    last_y = 0.0
    for i in range(count):
        after = i + 1 if i + 1 < count else 0
        lo = at[i]
        hi = at[after]
        hi = hi + n if hi < lo or count == 1 else hi
        far, _ = loss_beside(px, py, lo, hi, i, after, kind, rows, HUGE, 0.0, 0.0)
        if far > STRAY_PX and not _beside_any(px, py, lo, hi, kind, rows, count):
            return True
        lies, ax, ay, bx, by = _beside_border(px, py, n, lo, hi, kind, rows, i, after)
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
    return (ax - bx) ** 2 + (ay - by) ** 2 > TIP_BASE_PX * TIP_BASE_PX


@njit(**LEAF)
def _beside_any(px, py, lo, hi, kind, rows, count):
    """Whether points lo .. hi each lie beside some edge of the outline."""
    for k in range(lo, hi + 1):
        near = False
        for i in range(count):
            after = i + 1 if i + 1 < count else 0
            away, _, _ = distance_to_edge(kind, rows, i, after, px[k], py[k])
            if away <= STRAY_PX:
                near = True
                break
        if not near:
            return False
    return True


@njit(**LEAF)
def _beside_border(px, py, n, lo, hi, kind, rows, i, after):
    """Whether edge i lies beside its border points lo .. hi, but for tips at its ends.

    Returns ``(whether, x, y, x, y)``: where it does so first, and last: its ends without tips.
    """
    x0 = rows[i, 0]
    y0 = rows[i, 1]
    dx = rows[after, 0] - x0
    dy = rows[after, 1] - y0
    length = math.sqrt(dx * dx + dy * dy)
    begin, sweep = _turn(kind, rows, i, after)
    if kind[i] != LINE:
        length = abs(sweep) * rows[i, 4]
    if length > LONGEST * (hi - lo + 1) + 2.0 * TIP_PX:
        return False, x0, y0, x0, y0
    steps = max(math.ceil(length / EVERY_PX), 1)
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
        near, here = _find_beside(px, py, n, lo, hi, here, x, y)
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
            if ahead > TIP_PX:
                return False, first_x, first_y, last_x, last_y
    return found, first_x, first_y, last_x, last_y


@njit(**LEAF)
def _turn(kind, rows, i, after):
    """Where an arc begins and by how much it turns, in radians as y grows down; 0 for lines."""
    if kind[i] == LINE:
        return 0.0, 0.0
    begin = math.atan2(rows[i, 1] - rows[i, 3], rows[i, 0] - rows[i, 2])
    end = math.atan2(rows[after, 1] - rows[i, 3], rows[after, 0] - rows[i, 2])
    # the angle grows along an arc that is clockwise on the screen
    return begin, -((begin - end) % TAU) if kind[i] == ARC_CCW else (end - begin) % TAU


@njit(**LEAF)
def _find_beside(px, py, n, lo, hi, here, x, y):
    """Whether the border lies beside (x, y), and which of points lo .. hi is nearest.

    The search goes on from point ``here``, the last one's: points and edge run side by side. Where
    that leads nowhere all are looked at: a joint may lie some points away from its break.
    """
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

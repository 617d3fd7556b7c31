"""Finished edges of a closed outline: their format, distances and lengths.

Rules and units
- ``rows`` (k, 6): the first point x, y of an edge, the centre and radius of an arc, and the rms
  deviation; an edge ends where the next begins, the last where the first does.
- Pixels, y down; an arc's kind is its turn as seen on the screen.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import TAU, successor
from vision.outline.fitted_borders import ARC_CCW, ARC_CW, LINE

KNOWN_PX = 0.05
"""Least error of an edge point: chosen, lenses, prints and edges are no lines."""
FLATTEST_PX = KNOWN_PX / 50.0
"""Least rise of a written arc over its chord: derived, far below a point's error."""
STRAY_PX = 2.0
"""Largest distance between a written outline and its border (chosen), but for a pointed corner that
blur rounded. Edges leave their points by at most a pixel and 4.5 sigma of their noise
(``vision.outline.limit_kernels.MOST_MISS_PX``), and points are a row or column apart.
``tests/support/drawn/outline_judge.py`` allows 3 px (``python -m benchmarks.outlines``)."""
TURNS = 8
"""Steps of an arc's points that show its turning sense: indifferent."""


@njit(**LEAF)
def edge_end(breaks, edges, n, e):
    """Last point of edge e, behind its first; it may run past the border's end."""
    hi = breaks[successor(e, edges)]
    return hi + n if hi <= breaks[e] else hi


@njit(**LEAF)
def _through_ends(shape, e, x0, y0, x1, y1, ccw, circle):
    """Circle through both ends and the fitted arc's middle; cx, cy, r."""
    cx = shape[e, 0]
    cy = shape[e, 1]
    r = shape[e, 2]
    mx = 0.5 * (x0 + x1)
    my = 0.5 * (y0 + y1)
    dx = x1 - x0
    dy = y1 - y0
    chord = math.sqrt(dx * dx + dy * dy)
    if chord < 1e-9:
        circle[0] = cx
        circle[1] = cy
        circle[2] = math.sqrt((x0 - cx) ** 2 + (y0 - cy) ** 2)
        return
    # clockwise on the screen the arc bulges to the left of its chord: (dy, -dx)
    side = -1.0 if ccw else 1.0
    nx = side * dy / chord
    ny = -side * dx / chord
    c = (cx - mx) * nx + (cy - my) * ny
    sag = c + r
    if sag < 1e-9:
        sag = 1e-9
    half = 0.5 * chord
    new_r = (half * half + sag * sag) / (2.0 * sag)
    circle[0] = mx + nx * (sag - new_r)
    circle[1] = my + ny * (sag - new_r)
    circle[2] = new_r


@njit(**LEAF)
def _is_ccw(px, py, lo, hi, cx, cy):
    total = 0.0
    p = lo
    for t in range(1, TURNS + 1):
        q = lo + (hi - lo) * t // TURNS
        total += (px[p] - cx) * (py[q] - cy) - (py[p] - cy) * (px[q] - cx)
        p = q
    return total < 0.0


@njit(**LEAF)
def write_line(finished, i, x, y, k):
    """Make finished edge i a line from (x, y) on, which begins at crack or point k."""
    finished.at[i] = k
    finished.kind[i] = LINE
    finished.rows[i, 0] = x
    finished.rows[i, 1] = y
    finished.rows[i, 2] = 0.0
    finished.rows[i, 3] = 0.0
    finished.rows[i, 4] = 0.0


@njit(**LEAF)
def finish_edge(border, outline, edges, e, rows, circle):
    """Write edge e between its joints into ``rows``, except the deviation; return its kind.

    ``circle`` (3,) is scratch space.
    """
    joints = outline.joints
    shape = outline.shape
    x0 = joints[e, 0]
    y0 = joints[e, 1]
    rows[e, 0] = x0
    rows[e, 1] = y0
    rows[e, 2] = 0.0
    rows[e, 3] = 0.0
    rows[e, 4] = 0.0
    if not outline.is_arc[e]:
        return LINE
    lo = outline.breaks[e]
    hi = edge_end(outline.breaks, edges, border.n, e)
    after = successor(e, edges)
    x1 = joints[after, 0]
    y1 = joints[after, 1]
    ccw = _is_ccw(border.x, border.y, lo, hi, shape[e, 0], shape[e, 1])
    _through_ends(shape, e, x0, y0, x1, y1, ccw, circle)
    chord = math.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2)
    if chord < FLATTEST_PX or circle[2] * FLATTEST_PX > 0.125 * chord * chord:
        return LINE
    rows[e, 2] = circle[0]
    rows[e, 3] = circle[1]
    rows[e, 4] = circle[2]
    return ARC_CCW if ccw else ARC_CW


@njit(**LEAF)
def arc_ends(kinds, rows, e, after):
    """Vectors from an arc's centre to its ends, by growing angle."""
    ax = rows[e, 0] - rows[e, 2]
    ay = rows[e, 1] - rows[e, 3]
    bx = rows[after, 0] - rows[e, 2]
    by = rows[after, 1] - rows[e, 3]
    if kinds[e] == ARC_CCW:
        return bx, by, ax, ay
    return ax, ay, bx, by


@njit(**LEAF)
def in_sweep(kinds, rows, e, after, x, y):
    """True if (x, y) lies in the sector of arc e."""
    ax, ay, bx, by = arc_ends(kinds, rows, e, after)
    dx = x - rows[e, 2]
    dy = y - rows[e, 3]
    after_a = ax * dy - ay * dx >= 0.0
    before_b = dx * by - dy * bx >= 0.0
    return (after_a and before_b) if ax * by - ay * bx >= 0.0 else (after_a or before_b)


@njit(**LEAF)
def distance_to_edge(kinds, rows, e, after, x, y):
    """Distance from (x, y) to finished edge e, and its foot: ``(distance, x, y)``."""
    x0 = rows[e, 0]
    y0 = rows[e, 1]
    x1 = rows[after, 0]
    y1 = rows[after, 1]
    if kinds[e] != LINE:
        cx = rows[e, 2]
        cy = rows[e, 3]
        dx = x - cx
        dy = y - cy
        d = math.sqrt(dx * dx + dy * dy)
        within = in_sweep(kinds, rows, e, after, x, y)
        if within and d > 0.0:
            share = rows[e, 4] / d
            return abs(d - rows[e, 4]), cx + dx * share, cy + dy * share
        near0 = math.sqrt((x - x0) ** 2 + (y - y0) ** 2)
        near1 = math.sqrt((x - x1) ** 2 + (y - y1) ** 2)
        if near0 < near1:
            return near0, x0, y0
        return near1, x1, y1
    dx = x1 - x0
    dy = y1 - y0
    square = dx * dx + dy * dy
    t = 0.0
    if square > 0.0:
        t = min(max(((x - x0) * dx + (y - y0) * dy) / square, 0.0), 1.0)
    fx = x0 + t * dx
    fy = y0 + t * dy
    return math.sqrt((x - fx) ** 2 + (y - fy) ** 2), fx, fy


@njit(**LEAF)
def arc_sweep(kinds, rows, e, after):
    """Beginning and turn of arc e, in radians with y down."""
    begin = math.atan2(rows[e, 1] - rows[e, 3], rows[e, 0] - rows[e, 2])
    end = math.atan2(rows[after, 1] - rows[e, 3], rows[after, 0] - rows[e, 2])
    if kinds[e] == ARC_CCW:
        return begin, -((begin - end) % TAU)
    return begin, (end - begin) % TAU

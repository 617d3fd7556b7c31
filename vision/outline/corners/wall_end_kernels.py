"""The ends of walls: the short side at the end of a narrow wall, between two lines that turn back.

Rules and units
- ``border`` and ``outline``: see ``vision.outline.outline_types``; pictures with grey only.
- A search that leaves out what lies near its breaks sees nothing of a side that is no longer than
  what blur rounds at its corners. But where the border turns back between two long lines, a sharp
  tip would be as narrow as blur leaves one: what is wider has a side of its own.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.corners.joint_kernels import nearest_point
from vision.outline.fit.outline_kernels import edge_end
from vision.outline.fit.shape_kernels import HUGE

BACK = -0.5
"""Cosine between two lines from which on the border turns back."""
LEAST = 8
"""Points of a line that the border turns back from or to."""
BETWEEN = 2
"""Edges that may lie between the two."""
AROUND = 6
"""Points on either side of what lies between among which the wall's end is."""
SHARP_BY, SHARP_PX = 2.2, 0.5
"""A sharp tip's border is no wider than so many times the blur's sigma, and so much more. The
half-way level alone would be where it is 1.35 sigma wide."""
PLAIN_BY, PLAIN_PX = 2.0, 2.5
"""A side is seen by the search from so many times what blur rounds at a corner on, and more."""
SHORTEST = 2
"""Points of the shortest side."""
SQUARE_PX = 1.5
"""By how much one end of a side may lie behind the other and still be taken for square: the few
points amid its corners cannot tell."""


@njit(**LEAF)
def cut_ends(border, outline, edges, blur, guard, is_end, room):
    """Put a side where two lines that turn back have a blunt end between them.

    ``breaks`` and ``is_arc`` are changed and ``is_end`` (edges + 1,) filled; returns the new number
    of edges, and whether it is. ``room``: ``Scratch``.
    """
    breaks = outline.breaks
    is_arc = outline.is_arc
    shape = outline.shape
    n = border.n
    gone = room.flags[0]
    first = room.indices[0]
    behind = room.indices[1]
    found = room.indices[2]
    any_end = False
    for e in range(edges):
        gone[e] = False
        first[e] = -1
        behind[e] = -1
    for e in range(edges):
        if gone[e] or is_arc[e] or edge_end(breaks, edges, n, e) - breaks[e] < LEAST:
            continue
        for run in range(min(BETWEEN, edges - 2) + 1):
            j = (e + run + 1) % edges
            if is_arc[j] or edge_end(breaks, edges, n, j) - breaks[j] < LEAST:
                continue
            dot = shape[e, 2] * shape[j, 2] + shape[e, 3] * shape[j, 3]
            if dot < BACK and _find_end(border, outline, edges, e, j, blur, guard, found):
                first[e] = found[0]
                behind[e] = found[1]
                any_end = True
                for t in range(run):
                    gone[(e + t + 1) % edges] = True
            break
    for e in range(edges + 1):
        is_end[e] = False
    if not any_end:
        return edges, False
    return _put_sides(outline, edges, room, is_end), True


@njit(**LEAF)
def _put_sides(outline, edges, room, is_end):
    """Put the sides at walls' ends in the place of edges that are gone: how many are left."""
    gone = room.flags[0]
    first = room.indices[0]
    behind = room.indices[1]
    breaks = outline.breaks
    is_arc = outline.is_arc
    old_breaks = room.indices[2]
    old_arcs = room.flags[1]
    for e in range(edges):
        old_breaks[e] = breaks[e]
        old_arcs[e] = is_arc[e]
    m = 0
    for e in range(edges):
        if gone[e]:
            continue
        before = predecessor(e, edges)
        while gone[before]:
            before = predecessor(before, edges)
        breaks[m] = behind[before] if behind[before] >= 0 else old_breaks[e]
        is_arc[m] = old_arcs[e]
        is_end[m] = False
        m += 1
        if first[e] >= 0:
            breaks[m] = first[e]
            is_arc[m] = False
            is_end[m] = True
            m += 1
    return m


@njit(**LEAF, forceinline=False)
def square_ends(outline, edges, is_end):
    """Turn the sides at walls' ends square to their walls where they nearly are."""
    is_arc = outline.is_arc
    shape = outline.shape
    joints = outline.joints
    for e in range(edges):
        before = predecessor(e, edges)
        after = successor(e, edges)
        if not is_end[e] or is_arc[e] or is_arc[before] or is_arc[after]:
            continue
        a = shape[before]
        b = shape[after]
        ux = a[2] - b[2]
        uy = a[3] - b[3]
        length = math.sqrt(ux * ux + uy * uy)
        if length < 1e-9:
            continue
        ux /= length
        uy /= length
        askew = shape[e, 2] * ux + shape[e, 3] * uy
        width = (b[0] - a[0]) * a[3] - (b[1] - a[1]) * a[2]
        if abs(askew * width) > SQUARE_PX:
            continue
        # square to the wall, the way that the side runs
        vx = shape[e, 2] - askew * ux
        vy = shape[e, 3] - askew * uy
        length = math.sqrt(vx * vx + vy * vy)
        shape[e, 2] = vx / length
        shape[e, 3] = vy / length
        for side in range(2):
            row = a if side == 0 else b
            joint = e if side == 0 else after
            t = (shape[e, 0] - row[0]) * ux + (shape[e, 1] - row[1]) * uy
            t /= row[2] * ux + row[3] * uy
            joints[joint, 0] = row[0] + t * row[2]
            joints[joint, 1] = row[1] + t * row[3]


@njit(**LEAF)
def _find_end(border, outline, edges, e, j, blur, guard, found):
    """The points at the corners of the wall's end between lines e and j: False for none."""
    px = border.x
    py = border.y
    n = border.n
    breaks = outline.breaks
    a = outline.shape[e]
    b = outline.shape[j]
    # along the wall, towards its end
    ux = a[2] - b[2]
    uy = a[3] - b[3]
    length = math.sqrt(ux * ux + uy * uy)
    ux /= length
    uy /= length
    lo = edge_end(breaks, edges, n, e) - AROUND
    hi = lo + AROUND + (breaks[j] - lo - AROUND) % n + AROUND
    best = -HUGE
    tip = lo
    width = 0.0
    for k in range(lo, hi + 1):
        x = px[k % n]
        y = py[k % n]
        from_a = (x - a[0]) * a[3] - (y - a[1]) * a[2]
        from_b = (x - b[0]) * b[3] - (y - b[1]) * b[2]
        # amid the two lines, and far out
        far = x * ux + y * uy - abs(from_a - from_b)
        if far > best:
            best = far
            tip = k
            width = abs(from_a + from_b)
    spread = math.sqrt(blur * blur + 1.0 / 12.0)
    if not SHARP_BY * spread + SHARP_PX < width < PLAIN_BY * guard + PLAIN_PX:
        return False
    x = px[tip % n]
    y = py[tip % n]
    for side in range(2):
        row = a if side == 0 else b
        t = ((x - row[0]) * ux + (y - row[1]) * uy) / (row[2] * ux + row[3] * uy)
        found[side], _ = nearest_point(
            border, tip % n, AROUND, AROUND, row[0] + t * row[2], row[1] + t * row[3]
        )
    if (found[1] - found[0] + n) % n < SHORTEST:
        found[0] = (tip - 1) % n
        found[1] = (tip + 1) % n
    return (found[1] - found[0]) % n <= 2 * AROUND + 1

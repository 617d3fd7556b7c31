"""Grows one border outward to fewer lines, as far as its tolerance allows and no farther.

Rules and units
- Rectified pixels, y down; the obstacle is on the right hand of the border.
- An outline begins as the border's points, joined in their order. Two steps make it simpler, and
  both only add to the obstacle: a hollow is bridged, and a side between two corners goes where its
  neighbours, extended, meet. So the outline encloses every point of the border at any time.
- Each line keeps the stretch of points that it replaced, and two lines share the point that they
  meet at. A step is taken only where no point of the stretch is deeper behind its line than that
  point's tolerance, and no corner farther from its point. So nothing is added that is farther from
  the border than the tolerance.
- A step is taken only where what it adds is free of the rest of the outline.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from planner.scene.compile_options import LEAF

HAIR = 1e-6
"""Rounding that is no deviation, pixels: indifferent, the edge points of a drawing are up to 2e-8
px from the middles of its cracks."""
LEVELS = (0.1, 0.25, 0.5, 0.75, 1.0)
"""Shares of the tolerance that steps may use, one after the other: chosen, so that what takes
little is done first and does not stand in the way."""
MOST_ROUNDS = 100
"""Times around the border at each level: a bound on the work, indifferent. Each takes away at
least one corner, and most of them nearly all that can go."""
SHARE_OF_GAP = 0.45
"""Of the way to another object's border: indifferent, below one half, so that two never meet."""


class Ring(NamedTuple):
    """One border's points, and how far the outline may be from each: (n,) float64."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    reach: NDArray[np.float64]


class Corners(NamedTuple):
    """The outline's corners as a circular list: (n,), of which those that are linked are in use.

    ``x``, ``y`` float64; ``point`` int64: the border's point that the corner belongs to; ``before``
    and ``after`` int64: its neighbours.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    point: NDArray[np.int64]
    before: NDArray[np.int64]
    after: NDArray[np.int64]


@njit(**LEAF)
def _side(ax, ay, bx, by, x, y):
    """Twice the area of a, b, (x, y): above 0 where the point is on the line's right hand."""
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax)


@njit(**LEAF)
def _deepest(ring, corners, first, last, a, b):
    """How deep points first .. last are behind the line a, b, as a share of their reach.

    Infinite where one is in front of it.
    """
    n = len(ring.x)
    ax = corners.x[a]
    ay = corners.y[a]
    length = math.hypot(corners.x[b] - ax, corners.y[b] - ay)
    if length <= HAIR:
        return math.inf
    deepest = 0.0
    k = first
    while True:
        depth = _side(ax, ay, corners.x[b], corners.y[b], ring.x[k], ring.y[k]) / length
        if depth < -HAIR:
            return math.inf
        deepest = max(deepest, depth / ring.reach[k])
        if k == last:
            return deepest
        k = k + 1 if k + 1 < n else 0


@njit(**LEAF)
def _touches(corners, a, b, c):
    """Whether a corner besides a, b and c lies in their triangle."""
    ax, bx, cx = corners.x[a], corners.x[b], corners.x[c]
    ay, by, cy = corners.y[a], corners.y[b], corners.y[c]
    left, right = min(ax, bx, cx), max(ax, bx, cx)
    top, bottom = min(ay, by, cy), max(ay, by, cy)
    v = corners.after[c]
    while v != a:
        x = corners.x[v]
        y = corners.y[v]
        # a hollow turns left: its triangle is on the left of a, b and b, c
        if (
            left <= x <= right
            and top <= y <= bottom
            and _side(ax, ay, bx, by, x, y) <= HAIR
            and _side(bx, by, cx, cy, x, y) <= HAIR
            and _side(cx, cy, ax, ay, x, y) <= HAIR
        ):
            return True
        v = corners.after[v]
    return False


@njit(**LEAF)
def _cross(ax, ay, bx, by, cx, cy, dx, dy):
    """Whether the segments a, b and c, d meet."""
    return (
        max(ax, bx) >= min(cx, dx)
        and max(cx, dx) >= min(ax, bx)
        and max(ay, by) >= min(cy, dy)
        and max(cy, dy) >= min(ay, by)
        and _side(ax, ay, bx, by, cx, cy) * _side(ax, ay, bx, by, dx, dy) <= 0.0
        and _side(cx, cy, dx, dy, ax, ay) * _side(cx, cy, dx, dy, bx, by) <= 0.0
    )


@njit(**LEAF)
def _is_crossed(corners, b, c, qx, qy):
    """Whether the rest of the outline comes near the triangle of the side b, c and its tip q."""
    bx, by = corners.x[b], corners.y[b]
    cx, cy = corners.x[c], corners.y[c]
    u = corners.after[c]
    end = corners.before[b]
    while u != end:
        v = corners.after[u]
        ux, uy = corners.x[u], corners.y[u]
        vx, vy = corners.x[v], corners.y[v]
        if _cross(bx, by, qx, qy, ux, uy, vx, vy) or _cross(qx, qy, cx, cy, ux, uy, vx, vy):
            return True
        u = v
    return False


@njit(**LEAF)
def _turns_back(corners, a, b, c):
    """Whether the way from a to b is the way to c back again."""
    bx, by = corners.x[b], corners.y[b]
    along = (bx - corners.x[a]) * (corners.x[c] - bx) + (by - corners.y[a]) * (corners.y[c] - by)
    return along < 0.0


@njit(**LEAF)
def _bridge(ring, corners, b, level):
    """Bridge the hollow at corner b, if that is allowed: whether it was done."""
    a = corners.before[b]
    c = corners.after[b]
    turn = _side(corners.x[a], corners.y[a], corners.x[b], corners.y[b], corners.x[c], corners.y[c])
    if turn > HAIR or (turn > -HAIR and _turns_back(corners, a, b, c)):
        return False
    if _deepest(ring, corners, corners.point[a], corners.point[c], a, c) > level:
        return False
    if turn < -HAIR and _touches(corners, a, b, c):
        return False
    corners.after[a] = c
    corners.before[c] = a
    return True


@njit(**LEAF)
def _meeting(corners, a, b, c, d):
    """Where the lines a, b and d, c meet in front of b, c; the last is False where they do not."""
    ux, uy = corners.x[b] - corners.x[a], corners.y[b] - corners.y[a]
    wx, wy = corners.x[d] - corners.x[c], corners.y[d] - corners.y[c]
    sx, sy = corners.x[c] - corners.x[b], corners.y[c] - corners.y[b]
    turn = ux * wy - uy * wx
    if turn <= HAIR or ux * sy - uy * sx <= HAIR or sx * wy - sy * wx <= HAIR:
        return 0.0, 0.0, False
    along = (sx * wy - sy * wx) / turn
    return corners.x[b] + along * ux, corners.y[b] + along * uy, True


@njit(**LEAF)
def _point_of_tip(ring, corners, b, c, qx, qy, level):
    """The point of the side b, c nearest to the tip q, -1 where the lines cannot replace the side.

    Points up to it are behind the line before the side, those from it on behind the line after.
    """
    n = len(ring.x)
    a = corners.before[b]
    d = corners.after[c]
    first = corners.point[b]
    last = corners.point[c]
    # the last point that the line before can take
    upto = -1
    k = first
    while _deepest(ring, corners, k, k, a, b) <= level:
        upto = k
        if k == last:
            break
        k = k + 1 if k + 1 < n else 0
    if upto < 0:
        return -1
    best = level
    found = -1
    taken = False
    k = last
    while _deepest(ring, corners, k, k, c, d) <= level:
        taken = taken or k == upto
        away = math.hypot(ring.x[k] - qx, ring.y[k] - qy) / ring.reach[k]
        if taken and away <= best:
            best = away
            found = k
        if k == first:
            break
        k = k - 1 if k > 0 else n - 1
    return found


@njit(**LEAF)
def _extend(ring, corners, b, level):
    """Let the neighbours of the side behind corner b meet in its place: whether it was done."""
    a = corners.before[b]
    c = corners.after[b]
    d = corners.after[c]
    qx, qy, meet = _meeting(corners, a, b, c, d)
    if not meet:
        return False
    k = _point_of_tip(ring, corners, b, c, qx, qy, level)
    if k < 0 or _is_crossed(corners, b, c, qx, qy):
        return False
    corners.x[b] = qx
    corners.y[b] = qy
    corners.point[b] = k
    corners.after[b] = d
    corners.before[d] = b
    return True


@njit(**LEAF)
def _simplify(ring, corners, left, here, extending):
    """Take steps until none is allowed: corners left, and one of them."""
    for level in LEVELS:
        for _ in range(MOST_ROUNDS):
            before = left
            steps = left
            while steps > 0 and left > 3:
                steps -= 1
                after = corners.after[here]
                if _bridge(ring, corners, here, level + HAIR):
                    left -= 1
                    here = corners.before[after]
                elif extending and left > 3 and _extend(ring, corners, here, level + HAIR):
                    left -= 1
                else:
                    here = after
            if left == before:
                break
    return left, here


@njit(**LEAF)
def grow_to_lines(ring, corners):
    """Make a border's outline as simple as its tolerance allows: corners left, and one of them.

    Hollows are bridged first: a tip put up beside one would stand higher than the line over it.
    O(points times corners) at the worst, and not more than ``MOST_ROUNDS`` times that.
    """
    n = len(ring.x)
    for i in range(n):
        corners.x[i] = ring.x[i]
        corners.y[i] = ring.y[i]
        corners.point[i] = i
        corners.before[i] = i - 1 if i > 0 else n - 1
        corners.after[i] = i + 1 if i + 1 < n else 0
    left, here = _simplify(ring, corners, n, 0, False)
    return _simplify(ring, corners, left, here, True)


@njit(**LEAF)
def gaps_between(x, y, owner, order, cell_starts, columns, cell, gap):
    """Lower ``gap`` (n,) to the way from each point to the nearest one of another owner.

    Points are sorted into square cells of the size ``cell``, ``order`` (n,) row by row, and
    ``cell_starts`` (cells + 1,); ways longer than a cell are not looked for. O(points).
    """
    rows = (len(cell_starts) - 1) // columns
    for row in range(rows):
        for column in range(columns):
            here = row * columns + column
            for i in order[cell_starts[here] : cell_starts[here + 1]]:
                for r in range(max(row - 1, 0), min(row + 2, rows)):
                    left = r * columns + max(column - 1, 0)
                    right = r * columns + min(column + 1, columns - 1)
                    for j in order[cell_starts[left] : cell_starts[right + 1]]:
                        if owner[j] != owner[i]:
                            away = math.hypot(x[j] - x[i], y[j] - y[i])
                            gap[i] = min(gap[i], away)

"""Shapes of primitives: ends and lengths, directions along them, crossings and meetings.

Rules and units
- Distances of primitives are in :mod:`planner.scene.primitive_kernels`; everything else that
  depends on a primitive's kind is here. Angles are in radians.
- ``backwards`` (k,) marks arcs that run against their border.
"""

# numba infers types; docstrings state them.
# mypy: allow-untyped-defs

from __future__ import annotations

import math

from numba import njit

from planner.scene.compile_options import BORROWING, LEAF
from planner.scene.primitive_kernels import (
    ARC,
    CIRCLE,
    POINT,
    SEGMENT,
    TAU,
    circles_cross,
    distance,
    is_round,
    on_circle,
    segment_distance,
)

ROUND_LEAST, ROUND_APART = 8.0, 0.8
"""Least number of a circle's generators, and largest angle between an arc's in radians, which is as
many for a whole turn."""


@njit(**BORROWING)
def end_of(kind, data, backwards, i, last):
    """First or last point of primitive i in its border's order."""
    if kind[i] == SEGMENT:
        return (data[i, 2], data[i, 3]) if last else (data[i, 0], data[i, 1])
    if kind[i] == POINT:
        return data[i, 0], data[i, 1]
    return on_circle(data, i, data[i, 3] + (data[i, 4] if last != backwards[i] else 0.0))


@njit(**BORROWING)
def tangent_at(kind, data, backwards, i, x, y):
    """Unit direction of travel along primitive i at its point (x, y)."""
    if kind[i] == SEGMENT:
        dx, dy = data[i, 2] - data[i, 0], data[i, 3] - data[i, 1]
    else:
        dx, dy = data[i, 1] - y, x - data[i, 0]
        if backwards[i]:
            dx, dy = -dx, -dy
    d = math.sqrt(dx * dx + dy * dy)
    return dx / d, dy / d


@njit(**BORROWING)
def length_of(kind, data, i):
    """Length of primitive i; 0 for a point."""
    if kind[i] == SEGMENT:
        return math.sqrt((data[i, 2] - data[i, 0]) ** 2 + (data[i, 3] - data[i, 1]) ** 2)
    if kind[i] == CIRCLE:
        return TAU * data[i, 2]
    if kind[i] == ARC:
        return data[i, 4] * data[i, 2]
    return 0.0


@njit(**BORROWING)
def x_range(kind, data, i):
    """Range of x that contains primitive i."""
    if kind[i] == SEGMENT:
        return min(data[i, 0], data[i, 2]), max(data[i, 0], data[i, 2])
    return data[i, 0] - data[i, 2], data[i, 0] + data[i, 2]


@njit(**BORROWING)
def cross(kind, data, i, j):
    """True if two segments or arcs have a point in common."""
    if kind[j] == SEGMENT:
        i, j = j, i
    if kind[i] == SEGMENT:
        ax, ay, bx, by = data[i, 0], data[i, 1], data[i, 2], data[i, 3]
        return segment_distance(kind, data, j, ax, ay, bx, by)[0] == 0.0
    dx, dy = data[j, 0] - data[i, 0], data[j, 1] - data[i, 1]
    r, s, square = data[i, 2], data[j, 2], dx * dx + dy * dy
    if square == 0.0 or square > (r + s) ** 2 or square < (r - s) ** 2:
        return False
    return circles_cross(data, i, j)


@njit(**BORROWING)
def is_beyond(kind, data, i, ax, ay, nx, ny, around, keep):
    """True if primitive i lies beyond a line's box, or ``keep`` or more to one of its sides.

    ``around``, x_min, y_min, x_max, y_max, is the line's box, grown by ``keep``; (nx, ny) is normal
    to the line through a. If False, the distance must be computed.
    """
    x0, y0, x1, y1 = around
    ux, uy = data[i, 0], data[i, 1]
    off = nx * (ux - ax) + ny * (uy - ay)
    if kind[i] == SEGMENT:
        vx, vy = data[i, 2], data[i, 3]
        if (
            (ux >= x1 and vx >= x1)
            or (ux <= x0 and vx <= x0)
            or (uy >= y1 and vy >= y1)
            or (uy <= y0 and vy <= y0)
        ):
            return True
        far = nx * (vx - ax) + ny * (vy - ay)
        return (off >= keep and far >= keep) or (off <= -keep and far <= -keep)
    r = 0.0 if kind[i] == POINT else data[i, 2]
    if ux - r >= x1 or ux + r <= x0 or uy - r >= y1 or uy + r <= y0:
        return True
    return abs(off) - r >= keep


@njit(**BORROWING)
def place_on(kind, data, i):
    """Any point of primitive i."""
    if is_round(kind[i]):
        return on_circle(data, i, data[i, 3])
    return data[i, 0], data[i, 1]


@njit(**BORROWING)
def meet(kind, data, i, j, tolerance):
    """True if primitives i and j come within the tolerance of each other."""
    if not is_round(kind[j]):
        i, j = j, i
    if kind[i] == POINT:
        return distance(kind, data, j, data[i, 0], data[i, 1]) <= tolerance
    if kind[i] == SEGMENT:
        ax, ay, bx, by = data[i, 0], data[i, 1], data[i, 2], data[i, 3]
        return segment_distance(kind, data, j, ax, ay, bx, by)[0] <= tolerance
    x, y = place_on(kind, data, i)
    if distance(kind, data, j, x, y) <= tolerance:
        return True
    x, y = place_on(kind, data, j)
    if distance(kind, data, i, x, y) <= tolerance:
        return True
    dx, dy = data[j, 0] - data[i, 0], data[j, 1] - data[i, 1]
    r, s, square = data[i, 2], data[j, 2], dx * dx + dy * dy
    d = math.sqrt(square)
    if d == 0.0 or d > r + s + tolerance or d < abs(r - s) - tolerance:
        return False
    return circles_cross(data, i, j)


@njit(**BORROWING)
def crosses_ray(kind, data, i, x, y):
    """True if a rightward ray from (x, y) crosses primitive i an odd number of times.

    A ray through a shared end counts once because a piece holds its lower end only (half-open in
    y). Arcs are cut where their tangent is level, so that each part is monotone in y.
    """
    k = kind[i]
    if k == SEGMENT:
        y0, y1 = data[i, 1], data[i, 3]
        if (y0 <= y) == (y1 <= y):
            return False
        side = (data[i, 2] - data[i, 0]) * (y - y0) - (x - data[i, 0]) * (y1 - y0)
        return (side > 0.0) == (y1 > y0)
    if k == CIRCLE:
        return (x - data[i, 0]) ** 2 + (y - data[i, 1]) ** 2 < data[i, 2] ** 2
    return k == ARC and _arc_crossings(data, i, x, y) % 2 == 1


@njit(**BORROWING)
def _arc_crossings(data, i, x, y):
    """Number of times that a rightward ray from (x, y) crosses the arc."""
    cx, cy, r, a0 = data[i, 0], data[i, 1], data[i, 2], data[i, 3]
    a1 = a0 + data[i, 4]
    count = 0
    cut = (math.floor(a0 / math.pi - 0.5) + 1.0) * math.pi + 0.5 * math.pi
    lo = a0
    y_lo = cy + r * math.sin(a0)
    while lo < a1:
        hi = min(cut, a1)
        y_hi = cy + r * math.sin(hi)
        if (y_lo <= y) != (y_hi <= y):
            dx = math.sqrt(max(r * r - (y - cy) ** 2, 0.0))
            if math.cos(0.5 * (lo + hi)) < 0.0:
                dx = -dx
            if cx + dx > x:
                count += 1
        lo, y_lo = hi, y_hi
        cut += math.pi
    return count


@njit(**BORROWING)
def fewest_places(kind, data, i):
    """Least number of generators of primitive i, at any spacing."""
    if kind[i] == CIRCLE:
        return ROUND_LEAST
    return math.ceil(data[i, 4] / ROUND_APART) if kind[i] == ARC else 1.0


@njit(**BORROWING)
def place_at(kind, data, backwards, i, t):
    """Place at a part t of primitive i, in its border's order."""
    if kind[i] == SEGMENT:
        x, y = data[i, 0], data[i, 1]
        return x + t * (data[i, 2] - x), y + t * (data[i, 3] - y)
    sweep = TAU if kind[i] == CIRCLE else data[i, 4]
    return on_circle(data, i, data[i, 3] + sweep * (1.0 - t if backwards[i] else t))


@njit(**BORROWING)
def area_beyond_chord(kind, data, backwards, i):
    """Area between primitive i and its chord, positive if it turns from x to y."""
    if kind[i] != ARC:
        return 0.0
    part = 0.5 * data[i, 2] ** 2 * (data[i, 4] - math.sin(data[i, 4]))
    return -part if backwards[i] else part


@njit(**LEAF)
def normal_at(kind, data, i, x, y):
    """Direction square to segment or arc i at its point (x, y), of any length."""
    if kind[i] == SEGMENT:
        return data[i, 1] - data[i, 3], data[i, 2] - data[i, 0]
    return x - data[i, 0], y - data[i, 1]

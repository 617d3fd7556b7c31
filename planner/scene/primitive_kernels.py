"""Operations on primitives: feet, distances, sweeps, boxes.

Rules and units
- A primitive is a row of :class:`planner.scene.Primitives`: ``kind`` and six numbers, and three
  more that :func:`with_middles` adds.
- Distances are unsigned and in the scene's units; a border has no inside here.
"""

# numba infers types; docstrings state them.
# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import BORROWING, LEAF, OWNING
from planner.scene.primitives import ARC as ARC
from planner.scene.primitives import CIRCLE as CIRCLE
from planner.scene.primitives import POINT as POINT
from planner.scene.primitives import SEGMENT as SEGMENT

NONE = np.int64(-1)
"""No piece, link or row. It has a type: for a literal a kernel would be compiled once more."""
FIRST, LAST = np.bool_(False), np.bool_(True)
"""Which end of a primitive is asked for; typed as well."""
TAU = 2.0 * math.pi
SURE_COSINE = 1e-14
"""Cosines of unit vectors are equal within this: some 40 roundings of 2^-53."""
TURN_SLACK = (3.0 + 16.0 * 2.0**-53) * 2.0**-53
"""Error bound of a turn's determinant over its two products (Shewchuk 1997, ccwerrboundA)."""


@njit(**LEAF, forceinline=True)
def is_round(kind):
    """True if primitives of this kind are curved, with a centre and a radius."""
    return (kind == CIRCLE) | (kind == ARC)


@njit(**LEAF, forceinline=True)
def has_ends(kind):
    """True if primitives of this kind have ends: segments and arcs."""
    return (kind == SEGMENT) | (kind == ARC)


@njit(**LEAF, forceinline=True)
def on_circle(data, i, angle):
    """Point of circle or arc i at an angle in radians."""
    return data[i, 0] + data[i, 2] * math.cos(angle), data[i, 1] + data[i, 2] * math.sin(angle)


@njit(**LEAF, forceinline=True)
def on_sweep(data, i, x, y):
    """True if the direction from an arc's centre to (x, y) lies within its sweep."""
    dx, dy = x - data[i, 0], y - data[i, 1]
    along, d = dx * data[i, 6] + dy * data[i, 7], math.sqrt(dx * dx + dy * dy)
    past = along - data[i, 8] * d
    if abs(past) > SURE_COSINE * d:
        return past > 0.0
    return _on_sweep_by_angle(data, i, dx, dy, along)


@njit(**LEAF)
def _on_sweep_by_angle(data, i, dx, dy, along):
    """Decide :func:`on_sweep` where cosines are too flat: near either end, and for thin arcs."""
    if data[i, 8] < -1.0:
        return True
    across = dy * data[i, 6] - dx * data[i, 7]
    return abs(math.atan2(across, along)) <= 0.5 * data[i, 4]


@njit(**OWNING)
def with_middles(kind, data):
    """Add three numbers for arcs to the primitives' rows, so that no query needs angles.

    They are the unit vector from the centre to the arc's middle, and the cosine of half its sweep
    (-2 for the whole circle).
    """
    out = np.zeros((len(kind), 9))
    for i in range(len(kind)):
        for c in range(6):
            out[i, c] = data[i, c]
        if kind[i] == ARC:
            half = 0.5 * data[i, 4]
            out[i, 6], out[i, 7] = math.cos(data[i, 3] + half), math.sin(data[i, 3] + half)
            out[i, 8] = -2.0 if data[i, 4] >= TAU else math.cos(half)
    return out


@njit(**LEAF, forceinline=True)
def foot_on_segment(px, py, ax, ay, bx, by):
    """Point of the segment a b nearest to p, and its place (0 to 1) along it."""
    dx, dy = bx - ax, by - ay
    ahead = (px - ax) * dx + (py - ay) * dy
    # also if a and b are equal, or so near that their squares vanish
    if not ahead > 0.0:
        return ax, ay, 0.0
    dd = dx * dx + dy * dy
    if ahead >= dd:
        return bx, by, 1.0
    t = ahead / dd
    return ax + t * dx, ay + t * dy, t


@njit(**LEAF, forceinline=True)
def foot(kind, data, i, x, y):
    """Point of primitive i nearest to (x, y)."""
    k = kind[i]
    if k == POINT:
        return data[i, 0], data[i, 1]
    if k == SEGMENT:
        fx, fy, _ = foot_on_segment(x, y, data[i, 0], data[i, 1], data[i, 2], data[i, 3])
        return fx, fy
    return _round_foot(kind, data, i, x, y)


@njit(**LEAF)
def _round_foot(kind, data, i, x, y):
    """Point of a circle or an arc nearest to (x, y)."""
    cx, cy, r = data[i, 0], data[i, 1], data[i, 2]
    dx, dy = x - cx, y - cy
    d = math.sqrt(dx * dx + dy * dy)
    if kind[i] == CIRCLE or on_sweep(data, i, x, y):
        if d > 0.0:
            return cx + r * dx / d, cy + r * dy / d
        return on_circle(data, i, data[i, 3])
    x0, y0 = on_circle(data, i, data[i, 3])
    x1, y1 = on_circle(data, i, data[i, 3] + data[i, 4])
    if (x - x0) ** 2 + (y - y0) ** 2 <= (x - x1) ** 2 + (y - y1) ** 2:
        return x0, y0
    return x1, y1


@njit(**LEAF, forceinline=True)
def distance(kind, data, i, x, y):
    """Distance from (x, y) to primitive i."""
    k = kind[i]
    if k == CIRCLE or (k == ARC and on_sweep(data, i, x, y)):
        dx, dy = x - data[i, 0], y - data[i, 1]
        return abs(math.sqrt(dx * dx + dy * dy) - data[i, 2])
    fx, fy = foot(kind, data, i, x, y)
    return math.sqrt((x - fx) ** 2 + (y - fy) ** 2)


@njit(**BORROWING)
def point_to_segment(px, py, ax, ay, bx, by):
    """Distance from p to the segment a b, and its foot's place (0 to 1) along it."""
    fx, fy, t = foot_on_segment(px, py, ax, ay, bx, by)
    return math.sqrt((px - fx) ** 2 + (py - fy) ** 2), t


@njit(**LEAF, forceinline=True)
def _turn(ux, uy, vx, vy):
    """Determinant of u and v, differences to one point; 0 if its sign is doubtful."""
    left, right = ux * vy, uy * vx
    det = left - right
    if abs(det) <= TURN_SLACK * (abs(left) + abs(right)):
        return 0.0
    return det


@njit(**LEAF, forceinline=True)
def _nearer_end(px, py, turn, ax, ay, bx, by, best):
    """Squared distance from p to a segment, its place, and True if it is less than ``best``.

    ``turn`` is the segment's turn to p: if it is doubtful and p lies beside the segment, p lies on
    it, to the rounding of its length.
    """
    fx, fy, t = foot_on_segment(px, py, ax, ay, bx, by)
    d = (px - fx) ** 2 + (py - fy) ** 2
    if turn == 0.0 and 0.0 < t < 1.0:
        d = 0.0
    return d, t, d < best


@njit(**LEAF)
def _segments_distance(ax, ay, bx, by, cx, cy, dx, dy):
    """Distance between segments a b and c d, and its place along a b.

    They cross if each one's ends surely lie on both sides of the other; else an end is nearest. For
    segments on one line but for rounding no side is sure: nothing is divided by such a turn.
    """
    ux, uy, vx, vy = bx - ax, by - ay, dx - cx, dy - cy
    to_c, to_d = _turn(ux, uy, cx - ax, cy - ay), _turn(ux, uy, dx - ax, dy - ay)
    to_a, to_b = _turn(vx, vy, ax - cx, ay - cy), _turn(vx, vy, bx - cx, by - cy)
    if (to_c < 0.0 < to_d or to_d < 0.0 < to_c) and (to_a < 0.0 < to_b or to_b < 0.0 < to_a):
        return 0.0, to_a / (to_a - to_b)
    best, at, _ = _nearer_end(cx, cy, to_c, ax, ay, bx, by, np.inf)
    d, t, nearer = _nearer_end(dx, dy, to_d, ax, ay, bx, by, best)
    if nearer:
        best, at = d, t
    d, _, nearer = _nearer_end(ax, ay, to_a, cx, cy, dx, dy, best)
    if nearer:
        best, at = d, 0.0
    d, _, nearer = _nearer_end(bx, by, to_b, cx, cy, dx, dy, best)
    if nearer:
        best, at = d, 1.0
    return math.sqrt(best), at


@njit(**BORROWING)
def segment_distance(kind, data, i, ax, ay, bx, by):
    """Distance between the segment a b and primitive i, and its place along a b.

    The least distance to an arc is at an end of either, at the segment's foot of the arc's centre,
    or where the two cross.
    """
    if kind[i] == POINT:
        return point_to_segment(data[i, 0], data[i, 1], ax, ay, bx, by)
    if kind[i] == SEGMENT:
        return _segments_distance(ax, ay, bx, by, data[i, 0], data[i, 1], data[i, 2], data[i, 3])
    return _round_to_segment(kind, data, i, ax, ay, bx, by)


@njit(**BORROWING)
def _round_to_segment(kind, data, i, ax, ay, bx, by):
    """Distance as of :func:`segment_distance` to a circle or an arc."""
    cx, cy, r = data[i, 0], data[i, 1], data[i, 2]
    best, at = distance(kind, data, i, ax, ay), 0.0
    d = distance(kind, data, i, bx, by)
    if d < best:
        best, at = d, 1.0
    fx, fy, t = foot_on_segment(cx, cy, ax, ay, bx, by)
    d = distance(kind, data, i, fx, fy)
    if d < best:
        best, at = d, t
    dx, dy = bx - ax, by - ay
    dd = dx * dx + dy * dy
    if dd > 0.0:
        m = ((cx - ax) * dx + (cy - ay) * dy) / dd
        h2 = (ax + m * dx - cx) ** 2 + (ay + m * dy - cy) ** 2
        if h2 <= r * r:
            half = math.sqrt((r * r - h2) / dd)
            for t in (m - half, m + half):
                if 0.0 <= t <= 1.0 and (
                    kind[i] == CIRCLE or on_sweep(data, i, ax + t * dx, ay + t * dy)
                ):
                    return 0.0, t
    if kind[i] == ARC and data[i, 4] < TAU:
        for end in range(2):
            ex, ey = on_circle(data, i, data[i, 3] + end * data[i, 4])
            d, t = point_to_segment(ex, ey, ax, ay, bx, by)
            if d < best:
                best, at = d, t
    return best, at


@njit(**BORROWING)
def circles_cross(data, i, j):
    """True if circles or arcs i and j, whose circles meet in two points, share one of these."""
    dx, dy = data[j, 0] - data[i, 0], data[j, 1] - data[i, 1]
    r, s, square = data[i, 2], data[j, 2], dx * dx + dy * dy
    along = 0.5 * (1.0 + (r * r - s * s) / square)
    across = math.sqrt(max(r * r / square - along * along, 0.0))
    for sign in (-1.0, 1.0):
        x = data[i, 0] + along * dx - sign * across * dy
        y = data[i, 1] + along * dy + sign * across * dx
        if on_sweep(data, i, x, y) and on_sweep(data, j, x, y):
            return True
    return False


@njit(**BORROWING)
def box_of(kind, data, i, box):
    """Box of primitive i: x_min, y_min, x_max, y_max (of the whole circle for an arc)."""
    if kind[i] == SEGMENT:
        box[0], box[2] = min(data[i, 0], data[i, 2]), max(data[i, 0], data[i, 2])
        box[1], box[3] = min(data[i, 1], data[i, 3]), max(data[i, 1], data[i, 3])
        return
    r = 0.0 if kind[i] == POINT else data[i, 2]
    box[0], box[2] = data[i, 0] - r, data[i, 0] + r
    box[1], box[3] = data[i, 1] - r, data[i, 1] + r


@njit(**LEAF, forceinline=True)
def successor(i, count):
    """Place after i in a ring of ``count`` places."""
    return i + 1 if i + 1 < count else 0


@njit(**LEAF, forceinline=True)
def predecessor(i, count):
    """Place before i in a ring of ``count`` places."""
    return i - 1 if i > 0 else count - 1


@njit(**LEAF)
def root_of(parent, i):
    """Representative of i's set in a forest; halves the paths to it."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@njit(**OWNING)
def grown(array, rows):
    """Copy of an array of any shape with ``rows`` rows; new ones are undefined."""
    more = np.empty((rows,) + array.shape[1:], array.dtype)  # noqa: RUF005 (numba has no stars)
    flat, values = more.ravel(), array.ravel()
    for i in range(len(values)):
        flat[i] = values[i]
    return more


@njit(**OWNING)
def put_rows(into, first, rows):
    """Copy ``rows``, or a single row, to those of ``into`` from ``first`` on.

    Both are contiguous, and their rows of the same shape. An assignment would do the same, but cost
    the compiler more (``planner.scene.compile_options``).
    """
    flat, values = into[first:].ravel(), rows.ravel()
    for i in range(len(values)):
        flat[i] = values[i]

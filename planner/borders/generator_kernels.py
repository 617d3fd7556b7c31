"""Generators along borders: their number and places.

Rules
- Borders have generators only in the ``disc`` (x, y, radius) around the bounds: every free place is
  nearer to a wall of the bounds than to anything beyond.
- A label is the index of a generator's piece, see :mod:`planner.borders.corner_point_kernels`.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import BORROWING, LEAF, OWNING
from planner.scene.primitive_kernels import CIRCLE, POINT, SEGMENT, TAU
from planner.scene.shape_kernels import fewest_places, length_of, place_at

AROUND = 4.0
"""Distance beyond the bounds' corners that has generators, in spacings."""
MOST_STEPS = 2.0**53
"""Steps of a piece whose places differ by less than a rounding."""
LEAST_DIVISOR = 1e-300
"""Least divisor of a quotient."""


@njit(**LEAF)
def _is_shown(x, y, disc):
    """True if (x, y) lies in the disc."""
    return (x - disc[0]) ** 2 + (y - disc[1]) ** 2 <= disc[2] * disc[2]


@njit(**LEAF)
def _shown_straight(data, i, disc):
    """Part of segment i in the disc: from > to if there is none."""
    ax, ay = data[i, 0], data[i, 1]
    dx, dy = data[i, 2] - ax, data[i, 3] - ay
    dd = max(dx * dx + dy * dy, LEAST_DIVISOR)
    t = ((disc[0] - ax) * dx + (disc[1] - ay) * dy) / dd
    off2 = (ax + t * dx - disc[0]) ** 2 + (ay + t * dy - disc[1]) ** 2
    rest = disc[2] * disc[2] - off2
    if rest < 0.0:
        return 1.0, 0.0
    half = math.sqrt(rest / dd)
    return max(t - half, 0.0), min(t + half, 1.0)


@njit(**LEAF)
def _shown_round(kind, data, backwards, i, disc, lap):
    """Part of circle or arc i in the disc, which it may enter twice: ``lap`` 0 and 1."""
    dx, dy, r = disc[0] - data[i, 0], disc[1] - data[i, 1], data[i, 2]
    d, reach = math.sqrt(dx * dx + dy * dy), disc[2]
    # squared sine of a quarter of the angle that the disc covers
    sine2 = (reach * reach - (d - r) ** 2) / max(4.0 * d * r, LEAST_DIVISOR)
    if d + r <= reach or sine2 >= 1.0:
        return 0.0, 1.0 - 2.0 * lap
    if sine2 < 0.0:
        return 1.0, 0.0
    sweep = TAU if kind[i] == CIRCLE else data[i, 4]
    half = 2.0 * math.asin(math.sqrt(sine2))
    start = (math.atan2(dy, dx) - half - data[i, 3]) % TAU - lap * TAU
    first, last = max(start, 0.0) / sweep, min(start + 2.0 * half, sweep) / sweep
    return (1.0 - last, 1.0 - first) if backwards[i] else (first, last)


@njit(**BORROWING)
def _steps(kind, data, i, spacing, at_start, at_end):
    """Number of generators on all of piece i, steps before the first, step, and length.

    ``at_start`` and ``at_end`` mark ends with a corner point.
    """
    length = length_of(kind, data, i)
    lead, tail = 1.0 if at_start else 0.5, 1.0 if at_end else 0.5
    if kind[i] == CIRCLE:
        count = np.ceil(length / spacing)
    else:
        count = np.ceil(length / spacing - lead - tail) + 1.0
    count = max(fewest_places(kind, data, i), count)
    return count, lead, length / (count - 1.0 + lead + tail), length


@njit(**BORROWING)
def _shown_steps(kind, data, backwards, i, disc, lap, steps):
    count, lead, step, length = steps
    if kind[i] == SEGMENT:
        first, last = _shown_straight(data, i, disc) if lap == 0 else (1.0, 0.0)
    else:
        first, last = _shown_round(kind, data, backwards, i, disc, lap)
    if not first <= last or not count <= MOST_STEPS:
        return np.int64(0), np.int64(0)
    begin = max(np.ceil(first * length / step - lead), 0.0)
    end = min(np.floor(last * length / step - lead) + 1.0, count)
    return np.int64(begin), np.int64(max(begin, end))


@njit(**BORROWING)
def count_generators(kind, data, backwards, disc, spacing):
    """Upper bound of the number of generators, as a float: it may be astronomical.

    NaN if a place is not finite.
    """
    total = 0.0
    for i in range(len(kind)):
        total += 1.0
        if not math.isfinite(data[i, 0] + data[i, 1]):
            return np.nan
        if kind[i] == POINT:
            continue
        # corner points may shift the first and last step by one
        steps = _steps(kind, data, i, spacing, np.bool_(False), np.bool_(False))
        if not steps[0] <= MOST_STEPS:
            return np.nan if np.isnan(steps[0]) else np.inf
        for lap in range(2):
            begin, end = _shown_steps(kind, data, backwards, i, disc, lap, steps)
            total += end - begin + 2.0
    return total


@njit(**OWNING)
def place_generators(kind, data, backwards, at, before, after, disc, spacing, capacity):
    """Place generators at most ``spacing`` apart on every primitive, and on every corner point.

    Returns ``sites`` (n, 2) and ``label`` (n,): the primitive, or k + c for corner point c.
    """
    k = len(kind)
    sites = np.empty((capacity, 2), np.float64)
    label = np.empty(capacity, np.int32)
    point_at_start = np.zeros(k, np.bool_)
    point_at_end = np.zeros(k, np.bool_)
    for c in range(len(before)):
        if before[c] >= 0:
            point_at_end[before[c]] = True
        if after[c] >= 0:
            point_at_start[after[c]] = True
    n = 0
    for i in range(k):
        if kind[i] == POINT:
            if _is_shown(data[i, 0], data[i, 1], disc):
                sites[n, 0], sites[n, 1], label[n] = data[i, 0], data[i, 1], i
                n += 1
            continue
        steps = _steps(kind, data, i, spacing, point_at_start[i], point_at_end[i])
        for lap in range(2):
            begin, end = _shown_steps(kind, data, backwards, i, disc, lap, steps)
            for j in range(begin, end):
                t = (steps[1] + j) * steps[2] / steps[3]
                sites[n, 0], sites[n, 1] = place_at(kind, data, backwards, i, t)
                label[n] = i
                n += 1
    for c in range(len(before)):
        if _is_shown(at[c, 0], at[c, 1], disc):
            sites[n, 0], sites[n, 1], label[n] = at[c, 0], at[c, 1], k + c
            n += 1
    return sites[:n], label[:n]

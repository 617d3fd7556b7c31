"""Generators along borders: how many, and where.

A label is the index of a generator's piece, see :mod:`planner.borders.corner_point_kernels`.
"""

# The arrays' types are in the docstrings; numba infers them.
# mypy: allow-untyped-defs

from __future__ import annotations

import math

import numpy as np
from numba import njit

from planner.scene.compile_options import BORROWING, OWNING
from planner.scene.primitive_kernels import POINT, has_ends
from planner.scene.shape_kernels import ROUND_LEAST, fewest_places, length_of, place_at


@njit(**BORROWING)
def count_generators(kind, data, spacing):
    """An upper bound of the number of generators, as a float: it may be astronomical."""
    total = 0.0
    for i in range(len(kind)):
        total += math.ceil(length_of(kind, data, i) / spacing) + ROUND_LEAST
    return total


@njit(**OWNING)
def place_generators(kind, data, backwards, at, before, after, spacing, room):
    """Generators at most ``spacing`` apart along every primitive, and on every corner point.

    Returns ``sites`` (n, 2) and ``label`` (n,): the primitive, or k + c for corner point c.
    """
    k = len(kind)
    sites = np.empty((room, 2), np.float64)
    label = np.empty(room, np.int32)
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
            sites[n, 0], sites[n, 1], label[n] = data[i, 0], data[i, 1], i
            n += 1
            continue
        length = length_of(kind, data, i)
        lead = 1.0 if point_at_start[i] else 0.5
        tail = 1.0 if point_at_end[i] else 0.5
        least = fewest_places(kind, data, i)
        if has_ends(kind[i]):
            count = max(least, math.ceil(length / spacing - lead - tail) + 1.0)
        else:
            lead, tail = 0.5, 0.5
            count = max(least, math.ceil(length / spacing))
        step = length / (count - 1.0 + lead + tail)
        for j in range(int(count)):
            t = (lead + j) * step / length
            sites[n, 0], sites[n, 1] = place_at(kind, data, backwards, i, t)
            label[n] = i
            n += 1
    for c in range(len(before)):
        sites[n, 0], sites[n, 1], label[n] = at[c, 0], at[c, 1], k + c
        n += 1
    return sites[:n], label[:n]

"""The obstacles' rays that a way crosses, in order, on flat arrays.

Rays and their order at the same x are those of :func:`planner.search.homotopy.word`.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING
from planner.scene.primitive_kernels import grown
from planner.scene.shape_kernels import place_on


@njit(**OWNING)
def anchors(kind, data, owner, count):
    """Kernel of :func:`planner.search.homotopy.anchors`, for the first ``count`` primitives.

    The third column is the obstacle's number, as a float.
    """
    most = -1
    for i in range(count):
        most = max(most, owner[i])
    first = np.full(most + 1, -1, np.int64)
    for i in range(count - 1, -1, -1):
        if owner[i] >= 0:
            first[owner[i]] = i
    out = np.empty((most + 1, 3))
    n = 0
    for p in first:
        if p >= 0:
            out[n, 0], out[n, 1] = place_on(kind, data, p)
            out[n, 2] = n
            n += 1
    return out[np.argsort(out[:n, 0], kind="mergesort")]


@njit(**LEAF)
def _first_behind(places, x):
    low, high = 0, len(places)
    while low < high:
        middle = (low + high) // 2
        if places[middle, 0] < x:
            low = middle + 1
        else:
            high = middle
    return low


@njit(**OWNING)
def word(places, way):
    """Reduced word (l,) int32 of a way (m, 2) among ``places`` from :func:`anchors`."""
    letters = np.empty(32, np.int32)
    met = np.empty((len(places), 2))
    m = 0
    for i in range(len(way) - 1):
        ax, ay, bx, by = way[i, 0], way[i, 1], way[i + 1, 0], way[i + 1, 1]
        first, last = _first_behind(places, min(ax, bx)), _first_behind(places, max(ax, bx))
        sign = 1.0 if ax < bx else -1.0
        n = 0
        for k in range(last - first):
            # in crossing order, except for rounding and rays at the same x
            p = first + k if ax < bx else last - 1 - k
            t = (places[p, 0] - ax) / (bx - ax)
            if not ay + t * (by - ay) > places[p, 1]:
                continue
            letter = sign * places[p, 2]
            j = n
            while j > 0 and (met[j - 1, 0] > t or (met[j - 1, 0] == t and met[j - 1, 1] > letter)):
                met[j, 0], met[j, 1] = met[j - 1, 0], met[j - 1, 1]
                j -= 1
            met[j, 0], met[j, 1] = t, letter
            n += 1
        for j in range(n):
            letter = np.int32(met[j, 1] + sign)
            if m > 0 and letters[m - 1] == -letter:
                m -= 1
                continue
            if m == len(letters):
                letters = grown(letters, 2 * m)
            letters[m] = letter
            m += 1
    return letters[:m].copy()

"""Unchanged runs of chains: the same bisector between the same two places.

Rules
- A run's curve and proof depend on nothing else while nothing comes near: if its ends are equal to
  the last bit, so are the points between.
- Only proved links are taken, in either direction.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

import numpy as np
from numba import njit

from planner.scene.compile_options import LEAF, OWNING


@njit(**LEAF, forceinline=True)
def _slot(bits_x, bits_y, size):
    """First slot for a place in a table whose size is a power of two."""
    mixed = bits_x ^ (bits_x >> 17) ^ (bits_x >> 34) ^ (bits_y >> 7) ^ (bits_y >> 25)
    return (mixed ^ (bits_y >> 43)) & (size - 1)


@njit(**OWNING, error_model="numpy")
def index_runs(kept, bent):
    """Index the points of the chains that are not ``kept`` (m,) by their place.

    ``bent`` are all chains, :class:`planner.diagram.diagram_arrays.Bent`. Returns the table of a
    :class:`planner.diagram.diagram_arrays.KnownRuns`.
    """
    points, start = bent.points, bent.start
    count = 0
    chains = len(start) - 1
    is_kept = np.zeros(chains, np.bool_)
    for c in kept:
        is_kept[c] = True
    for c in range(chains):
        if not is_kept[c]:
            count += start[c + 1] - start[c]
    size = 1
    while size < 2 * count + 1:
        size *= 2
    table = np.full(size, -1, np.int32)
    bits = points.view(np.int64)
    for c in range(chains):
        if is_kept[c]:
            continue
        for p in range(start[c], start[c + 1]):
            h = _slot(bits[p, 0], bits[p, 1], size)
            while table[h] >= 0:
                h = (h + 1) & (size - 1)
            table[h] = p
    return table


@njit(**LEAF)
def find_run(known, place, place_bits, s, left, right):
    """Find the known run from place s to the next between ``left`` and ``right``.

    ``known`` is a :class:`planner.diagram.diagram_arrays.KnownRuns`; ``place`` (n, 4) comes also as
    int64. Returns the run's first point, and 1 for forwards, -1 for backwards, 0 if there is none.
    """
    points, bits, pieces, proved, table = known
    size = len(table)
    x_bits, y_bits = place_bits[s, 0], place_bits[s, 1]
    h = _slot(x_bits, y_bits, size)
    bx, by = place[s + 1, 0], place[s + 1, 1]
    while table[h] >= 0:
        p = np.int64(table[h])
        if bits[p, 0] == x_bits and bits[p, 1] == y_bits:
            for way in (1, -1):
                a, b = (left, right) if way == 1 else (right, left)
                q = p
                while True:
                    # no chain's last link is proved: no walk leaves its chain
                    link = q if way == 1 else q - 1
                    if link < 0 or not proved[link]:
                        break
                    if pieces[link, 0] != a or pieces[link, 1] != b:
                        break
                    q += way
                    if points[q, 0] == bx and points[q, 1] == by:
                        return p, way
        h = (h + 1) & (size - 1)
    return np.int64(-1), 0

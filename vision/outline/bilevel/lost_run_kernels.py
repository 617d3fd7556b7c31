"""Runs of consecutive lost cracks, and the choice of those to replace.

Rules and units
- ``cracks``: see ``vision.outline.outline_types``; ``state`` is each crack's verdict, OK, LOST
  or GRAVE (``vision.outline.bilevel.separation_kernels``).
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from numba import njit

from planner.scene.compile_options import LEAF
from planner.scene.primitive_kernels import predecessor, successor
from vision.outline.bilevel.separation_kernels import GRAVE, OK
from vision.outline.fit.edge_shape_kernels import HUGE
from vision.outline.fit.separating_fit_kernels import HALF

TIP = 5
"""Cracks around the last two pixels of a tip: derived, three of the last and two of the one
before."""


@njit(**LEAF)
def weigh_runs(cracks, state, weights):
    """Write each run's number of lost pixels at its end, negative if the run is grave.

    A lost tip is grave too: all cracks of a pixel attached by a corner, or a run of at least
    ``TIP`` around one attached by a side. Returns the pixels of all runs, and of the heaviest one
    that is not grave.
    """
    n = cracks.n
    start = 0
    while state[start] != OK:
        start += 1
    total = 0
    heaviest = 0
    pixels = 0
    here = 0
    last_x = HUGE
    last_y = HUGE
    grave = False
    around = 0
    most = 0
    for k in range(n):
        weights[k] = 0
    for t in range(1, n + 1):
        k = start + t if start + t < n else start + t - n
        if state[k] != OK:
            here += 1
            side = 1.0 if state[k] > 0 else -1.0
            x = cracks.x[k] + side * cracks.free_x[k]
            y = cracks.y[k] + side * cracks.free_y[k]
            pixels += x != last_x or y != last_y
            last_x = x
            last_y = y
            grave = grave or abs(state[k]) == GRAVE
            j = predecessor(k, n)
            apart = abs(cracks.x[k] - cracks.free_x[k] - cracks.x[j] + cracks.free_x[j]) + abs(
                cracks.y[k] - cracks.free_y[k] - cracks.y[j] + cracks.free_y[j]
            )
            around = around + 1 if apart < HALF and here > 1 else 1
            most = max(most, around)
            continue
        grave = grave or most >= 4 or (most == 3 and here >= TIP)
        most = 0
        if pixels > 0:
            weights[predecessor(k, n)] = -pixels if grave else pixels
            total += pixels
            heaviest = max(heaviest, 0 if grave else pixels)
        pixels = 0
        here = 0
        last_x = HUGE
        last_y = HUGE
        grave = False
    return total, heaviest


@njit(**LEAF)
def mark_runs(state, n, budget, total, heaviest, weights, inside):
    """Mark in ``inside`` the runs of lost cracks to replace, and one crack beyond each.

    Grave runs, then the heaviest, until ``budget`` holds.
    """
    for k in range(n):
        inside[k] = False
        total += min(weights[k], 0)
    least = heaviest + 1
    while total > budget and least > 1:
        least -= 1
        for k in range(n):
            if weights[k] == least:
                if total > budget:
                    total -= least
                else:
                    weights[k] = 0
    for k in range(n):
        if weights[k] < 0 or weights[k] >= max(least, 1):
            j = k
            while state[j] != OK:
                inside[j] = True
                j = predecessor(j, n)
            inside[j] = True
            inside[successor(k, n)] = True

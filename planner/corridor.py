"""The shortest way within a route's corridor, kept off the borders.

Rules and units
- A corridor is what a route leaves free on both sides until the borders it runs between. The
  shortest way in it that keeps ``keep`` off them is taut: straight, and around corners.
- The answer is proved against all borders, or it is not an answer.
"""

from __future__ import annotations

import math

import numpy as np

from planner import corridor_kernels, distance_kernels
from planner.bisectors import EQUAL
from planner.generators import Borders
from planner.scene import FloatArray, IntArray

TURNS_RAD = (0.2, 0.05)
"""How far a border's foot may turn from one portal to the next: tried in this order."""


def pull_taut(
    borders: Borders, points: FloatArray, pairs: IntArray, keep: float, need: float
) -> FloatArray | None:
    """The taut polyline along a route, or None where it cannot be proved to keep ``need``.

    ``pairs`` (n, 2) are the pieces left and right of each link, -1 where unknown: there the
    route itself is kept, but for its ends, where a station lies in the first or last disc.
    ``keep`` >= ``need`` is kept where there is room. Borders are kept
    off by so much more that the chord between two portals does not come nearer.
    """
    known = np.flatnonzero(pairs[:, 0] >= 0)
    if not len(known):
        return None
    lo, hi = int(known[0]), int(known[-1]) + 2
    for turn in TURNS_RAD:
        wider = keep / math.cos(0.5 * turn)
        gates = corridor_kernels.portals(
            borders.kind,
            borders.data,
            np.ascontiguousarray(points[lo:hi]),
            np.ascontiguousarray(pairs[lo:hi]),
            wider,
            math.cos(turn),
            EQUAL * borders.extent,
        )
        first, last = corridor_kernels.between(gates, *points[0], *points[-1])
        way: FloatArray = corridor_kernels.funnel(gates[first:last], *points[0], *points[-1])
        gap = distance_kernels.polyline_clearance(*borders.tree, way)[0]
        if gap >= need:
            return way
    return None

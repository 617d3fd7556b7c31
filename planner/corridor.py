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
    route itself is kept. ``keep`` >= ``need`` is kept where there is room. Borders are kept
    off by so much more that the chord between two portals does not come nearer.
    """
    for turn in TURNS_RAD:
        wider = keep / math.cos(0.5 * turn)
        gates = corridor_kernels.portals(
            borders.kind,
            borders.data,
            np.ascontiguousarray(points),
            np.ascontiguousarray(pairs),
            wider,
            math.cos(turn),
            EQUAL * borders.extent,
        )
        way: FloatArray = corridor_kernels.funnel(gates, *points[0], *points[-1])
        gap = distance_kernels.polyline_clearance(*borders.tree, way)[0]
        if gap >= need:
            return way
    return None

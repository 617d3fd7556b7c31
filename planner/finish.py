"""From a route over the chains to a polyline: taut, cut short, and proved.

Rules and units
- Every answer is proved against all borders: the exact distance of the whole polyline is at
  least what is needed, or it is no answer.
- A preference above 0 asks for more clearance than is needed, where there is room.
"""

from __future__ import annotations

import numpy as np

from planner import bisector_kernels, distance_kernels, finish_kernels
from planner.bisectors import EQUAL
from planner.chain_lines import Line
from planner.chain_search import DETOUR, ROUNDING
from planner.corridor import pull_taut
from planner.generators import Borders
from planner.scene import FloatArray, Vec

ROOM = 2.0
"""Radii of clearance kept on top of the first, where there is room, per unit of preference."""
FLATNESS = 0.02
"""How far a path may leave the bisector it follows, in radii, where there is room."""


def is_clear(borders: Borders, start: Vec, goal: Vec, need: float, preference: float) -> bool:
    """Whether the straight line is as far off the borders as the preference asks.

    The widest way (preference 1) is never cut short.
    """
    if preference >= 1.0:
        return False
    ends = np.array([start, goal])
    rho, _ = borders.distances(ends)
    return _keeps(borders, ends, float(rho.min()), need, preference)


def _keeps(
    borders: Borders, line: FloatArray, standing: float, need: float, preference: float
) -> bool:
    """Whether a line keeps ``1 + ROOM * preference`` radii, or what its ends have (standing)."""
    gap, *_ = distance_kernels.polyline_clearance(*borders.tree, line)
    wish = min(need * (1.0 + ROOM * preference), standing)
    return bool(gap >= max(need, wish) - ROUNDING * borders.extent)


def finish(borders: Borders, line: Line, need: float, preference: float) -> FloatArray | None:
    """The route as a proved polyline: taut, or as it is where that cannot be proved.

    None where even the route as it is cannot be proved.
    """
    if preference >= 1.0:
        return certain(borders, line, need)
    keep = need * (1.0 + ROOM * preference)
    way = pull_taut(borders, line.points, line.pairs, keep, need)
    return certain(borders, line, need) if way is None else way


def cut_short(borders: Borders, way: FloatArray, need: float, preference: float) -> FloatArray:
    """The way with straight lines put in, from both ends, where they keep their distance.

    It may change to another side of an obstacle. Never longer.
    """
    wish = need * (1.0 + ROOM * preference)
    rounding = ROUNDING * borders.extent
    cut: FloatArray = finish_kernels.cut_short(*borders.tree, way, need, wish, rounding)
    return cut


def judge(borders: Borders, way: FloatArray, need: float, preference: float) -> float:
    """What a way costs: its length, and more where it is narrow."""
    return float(finish_kernels.judge(*borders.tree, way, need, DETOUR * preference))


def certain(borders: Borders, line: Line, need: float) -> FloatArray | None:
    """The line's polyline, close enough to the bisectors to keep ``need``, or None."""
    points: FloatArray
    points, _ = bisector_kernels.follow(
        *borders.tree,
        np.ascontiguousarray(line.points),
        np.ascontiguousarray(line.pairs),
        need,
        FLATNESS * need,
        EQUAL * borders.extent,
    )
    gap = distance_kernels.polyline_clearance(*borders.tree, points)[0]
    return points if gap >= need - 2.0 * ROUNDING * borders.extent else None

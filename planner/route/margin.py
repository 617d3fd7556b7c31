"""Straight ways out of the margin, from stations within it to where it is kept.

Rules and units
- The radius is mandatory, the margin a wish. A station that keeps only the radius is left, or
  reached, on the shortest straight line that ends where both are kept, and is nowhere nearer to a
  border than the station; if there is none, nowhere nearer than the radius.
- The line is at most ``WAY_OUT_REACH`` radii and margins long: the margin is given up nowhere else.
  Lengths are in the scene's units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from planner.borders import box_tree_kernels, clear_kernels
from planner.borders.generators import Borders
from planner.scene import FloatArray, Vec, primitive_kernels
from planner.search.chain_search import CLEARANCE_ROUNDING
from planner.shared.figures import sized

WAY_OUT_REACH = 2.0
"""Longest way out from its station, in radii and margins: the robot's own width."""
DIRECTIONS = 64
"""Directions tried, the first straight away from the nearest border."""
DISTANCES = 32
"""Distances tried in each, from the least that can do to the farthest."""
MARGIN_HALVINGS = 30
"""Halvings of the last step to where the margin is kept."""


@dataclass(frozen=True, slots=True)
class WayOut:
    """Place where the margin is kept again, and the remark on where it is not."""

    place: Vec
    remark: str


def way_out(
    borders: Borders, name: str, place: Vec, radius: float, margin: float, units: str = ""
) -> WayOut | None:
    """Shortest straight path out of the margin, if short enough."""
    need, reach = radius + margin, WAY_OUT_REACH * (radius + margin)
    standing, which = box_tree_kernels.nearest(borders.tree, *place, np.inf)
    fx, fy = primitive_kernels.foot(borders.kind, borders.data, which, *place)
    least = max(need - standing, CLEARANCE_ROUNDING * borders.extent)
    for keep in (standing, radius):
        away = math.atan2(place[1] - fy, place[0] - fx)
        found = _shortest(borders, place, away, least, reach, need, keep)
        if found is not None:
            length = math.dist(place, found)
            gap = box_tree_kernels.polyline_clearance(borders.tree, np.array([place, found]))[0]
            return WayOut(
                found,
                f"the margin of {sized(margin, units)} is given up within {sized(length, units)} "
                f"of {name} ({place[0]:g}, {place[1]:g}): "
                f"{sized(gap, units, beside=radius)} from the nearest border, the radius is "
                f"{sized(radius, units, beside=gap)}",
            )
    return None


def _shortest(
    borders: Borders, place: Vec, away: float, least: float, reach: float, need: float, keep: float
) -> Vec | None:
    """End of the shortest line out that keeps ``keep``, preferably near direction ``away``."""
    turn = np.arange(DIRECTIONS)
    angle = away + (turn + 1) // 2 * np.where(turn % 2 == 1, 1.0, -1.0) * math.tau / DIRECTIONS
    steps = np.geomspace(least, reach, DISTANCES) if least < reach else np.array([least])
    way = np.c_[np.cos(angle), np.sin(angle)]
    places = np.array(place) + steps[:, None, None] * way
    clearances = borders.signed_distances(np.ascontiguousarray(places.reshape(-1, 2)))
    enough = (
        clearances.reshape(len(steps), DIRECTIONS)
        >= need - 0.5 * CLEARANCE_ROUNDING * borders.extent
    )
    for i, k in np.argwhere(enough).tolist():
        end = _nearest_end(
            borders, place, way[k], float(steps[max(i - 1, 0)]), float(steps[i]), need
        )
        line = np.array([place, end])
        if clear_kernels.keeps(borders.tree, line, keep - CLEARANCE_ROUNDING * borders.extent):
            return end
    return None


def _nearest_end(
    borders: Borders, place: Vec, way: FloatArray, low: float, high: float, need: float
) -> Vec:
    """Nearest place along ``way``, between two distances, that keeps ``need``."""
    for _ in range(MARGIN_HALVINGS):
        middle = 0.5 * (low + high)
        end = np.array(place) + middle * way
        if float(borders.signed_distances(end[None])[0]) >= need:
            high = middle
        else:
            low = middle
    x, y = np.array(place) + high * way
    return float(x), float(y)

"""How tightly a trajectory bends, by its own waypoints."""

from __future__ import annotations

import math
from itertools import pairwise

from planner.path import Trajectory


def bends_of(trajectory: Trajectory) -> list[float]:
    """The curvature from each waypoint to the next, where the robot drives: one over length."""
    return [
        abs(math.remainder(b.heading_rad - a.heading_rad, math.tau)) / gap
        for a, b in pairwise(trajectory.waypoints)
        if (gap := math.dist((a.x, a.y), (b.x, b.y))) > 0.0
    ]

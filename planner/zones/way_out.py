"""The shortest path out of keep-out zones, for a robot that is in one.

- The robot may drive inside the zones that it is in, and nowhere nearer to an obstacle or another
  keep-out zone than its radius, or than it is now; nor against a one-way zone.
- The shortest straight line in ``WAY_OUT_DIRECTIONS`` directions is taken; if all are blocked, the
  shortest path to one of the ``PLACES`` nearest places outside.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from planner.borders.free_rays import nearest_free
from planner.path import Path
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray, Vec

WAY_OUT_DIRECTIONS = 64
"""Directions tried, and again around the best of them: chosen, to 0.2 degrees."""
WAY_OUT_DISTANCES = 64
"""Distances tried in each: chosen, a place narrower than a fifth of its distance may be missed."""
FINER_DISTANCES = 256
"""The same around the best direction: chosen, to 0.2 % of the distance."""
WAY_OUT_HALVINGS = 20
"""Halvings of the last step out: chosen, to 1e-6 of it."""
PLACES = 8
"""Places outside to which a path is sought: chosen."""


Permits = Callable[[FloatArray], bool]
"""True if the other zones permit a polyline (n, 2)."""


def way_out(
    open_: Roadmap, closed: Roadmap, place: Vec, need: float, permits: Permits
) -> FloatArray | None:
    """Return the polyline (n, 2) from a place to where ``closed`` leaves ``need``, or None.

    ``open_`` has the obstacles and the other keep-out zones, ``closed`` these zones too.
    """
    here = np.array(place)
    keep = min(open_.radius, float(open_.clearance(here[None])[0]))
    if keep <= 0.0:
        return None
    angles = math.tau * np.arange(WAY_OUT_DIRECTIONS) / WAY_OUT_DIRECTIONS
    box = closed.borders.box
    longest = math.hypot(box[2] - box[0], box[3] - box[1])
    steps = np.geomspace(1e-3 * need, longest, WAY_OUT_DISTANCES)

    def is_free(points: FloatArray) -> NDArray[np.bool_]:
        return closed.clearance(points) >= need

    outside = nearest_free(here, angles, steps, is_free, WAY_OUT_HALVINGS)
    found = _first_free(open_, here, outside, keep, permits)
    if found is None:
        return _around(open_, here, list(outside[:PLACES]), permits)
    # the best place is often a corner of the free ground, between two of the directions
    step = math.tau / WAY_OUT_DIRECTIONS
    angle = math.atan2(*(found[1] - here)[::-1])
    finer = angle + step * np.linspace(-1.0, 1.0, WAY_OUT_DIRECTIONS + 1)
    length = math.dist(*found)
    nearer = np.linspace(0.5 * length, length, FINER_DISTANCES)
    ends = nearest_free(here, finer, nearer, is_free, WAY_OUT_HALVINGS)
    return _first_free(open_, here, np.vstack([ends, found[1:]]), keep, permits)


def _first_free(
    open_: Roadmap, here: FloatArray, ends: FloatArray, keep: float, permits: Permits
) -> FloatArray | None:
    for end in ends[np.argsort(np.hypot(*(ends - here).T), kind="stable")]:
        line = np.array([here, end])
        if open_.path_clearance(line).distance >= keep * (1.0 - 1e-9) and permits(line):
            return line
    return None


def _around(
    open_: Roadmap, here: FloatArray, ends: list[FloatArray], permits: Permits
) -> FloatArray | None:
    best: Path | None = None
    for end in ends:
        path = open_.plan(tuple(here), tuple(end), prefer="length", relaxed=True)
        if not isinstance(path, Path) or not permits(path.points):
            continue
        if best is None or path.length < best.length:
            best = path
    return None if best is None else best.points

"""Waits moved out of no-waiting zones, to the last place before them.

Where that leads to a circle of waits (:func:`planner.fleet.dependencies.is_live`), another plan is
needed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planner.fleet.fleet_plan import Dependency
from planner.scene import FloatArray
from planner.zones.rules import RADIUS_ROUNDING, Rules


def wait_before(
    tracks: Sequence[FloatArray], dependencies: Sequence[Dependency], rules: Sequence[Rules]
) -> list[Dependency]:
    """Return the dependencies with each wait at a row outside its robot's no-waiting zones.

    ``tracks`` (k, 3) are rows of t, x, y; ``rules`` are each robot's. A robot that begins inside
    waits at its first row.
    """
    inside = [_inside(track, own) for track, own in zip(tracks, rules, strict=True)]
    moved: list[Dependency] = []
    for first, passed, waiting, row in dependencies:
        before = row
        while 0 < before < len(inside[waiting]) and inside[waiting][before]:
            before -= 1
        moved.append((first, passed, waiting, before))
    return moved


def _inside(track: FloatArray, rules: Rules) -> list[bool]:
    held = np.zeros(len(track), np.bool_)
    for one in rules.of("wait"):
        points = np.ascontiguousarray(track[:, 1:])
        held |= one.distances(points) < rules.radius * (1.0 - RADIUS_ROUNDING)
    answer: list[bool] = held.tolist()
    return answer

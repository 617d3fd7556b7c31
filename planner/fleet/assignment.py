"""Assignment of tasks to robots, optimal for the sum of driving times or for the last arrival.

A pair costs the time that the robot drives alone on its own path over the roadmap, at its speed. As
many tasks as possible are assigned; a pair without a path is never chosen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from planner.fleet.on_roadmap import (
    Grounds,
    check_places,
    check_radii,
    check_speeds,
    check_zones,
)
from planner.fleet.search.matching import match_for_last, match_for_sum
from planner.path import Limits, NoPath
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray
from planner.shared.arguments import of_kind, one_of
from planner.zones.zone import Zone


@dataclass(frozen=True, slots=True)
class Assignment:
    """Task of each robot, by its place in the list, None for a robot without one.

    ``durations_s`` (robots, tasks) is the read-only cost table, infinite without a path;
    ``total_s`` is the sum of the chosen ones, ``last_s`` the longest.
    """

    tasks: tuple[int | None, ...]
    left_over: tuple[int, ...]
    total_s: float
    last_s: float
    durations_s: FloatArray


def assign_tasks(
    roadmap: Roadmap,
    robots: Sequence[Sequence[float]],
    tasks: Sequence[Sequence[float]],
    radii: float | Sequence[float] | None = None,
    limits: Limits | Sequence[Limits] | None = None,
    *,
    objective: Literal["sum", "last"] = "sum",
    zones: Sequence[Sequence[Zone]] | None = None,
) -> Assignment:
    """Give each robot at most one task and each task at most one robot, at least cost.

    ``robots`` and ``tasks`` are places (x, y) or (x, y, heading_rad) in free space. ``radii``,
    ``limits`` and ``zones`` are as in :func:`planner.plan_fleet`. ``objective`` "sum" minimises the
    sum of durations, "last" the longest one and, among equals, the sum. Paths are planned for every
    pair, then matched exactly in O(n^2 (n + m)). ``ValueError`` on senseless input.
    """
    of_kind("roadmap", roadmap, Roadmap)
    one_of("objective", objective, "sum", "last")
    begin, end = check_places("robots", robots), check_places("tasks", tasks)
    sizes = check_radii(radii, roadmap.radius, len(begin))
    speeds = check_speeds(limits, sizes)
    durations_s = np.full((len(begin), len(end)), np.inf)
    grounds, ruled = Grounds(roadmap), check_zones(zones, len(begin))
    for i, (size, speed) in enumerate(zip(sizes, speeds, strict=True)):
        for j, task in enumerate(end):
            path = grounds.path(begin[i], task, size, speed, ruled[i])
            if not isinstance(path, NoPath):
                durations_s[i, j] = path.length / speed
    chosen = (match_for_sum if objective == "sum" else match_for_last)(durations_s).tolist()
    taken = [float(durations_s[i, j]) for i, j in enumerate(chosen) if j >= 0]
    durations_s.setflags(write=False)
    return Assignment(
        tuple(j if j >= 0 else None for j in chosen),
        tuple(j for j in range(len(end)) if j not in chosen),
        sum(taken), max(taken, default=0.0), durations_s,
    )  # fmt: skip

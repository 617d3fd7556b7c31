"""Waypoints of a fleet's plan that each robot may be given now, from the progress of all.

- A robot may be given all rows of its track up to its next unmet dependency; that limit only grows
  with progress.
- Whatever the delays, no robots touch: of two near pieces, the second begins after the first has
  ended. If :func:`planner.fleet.dependencies.is_live` holds, some robot can always move until all
  have arrived.
- Nothing here reads a clock or keeps a state: a restart or a replay resumes with equal answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from planner.fleet.fleet_plan import FleetPlan


@dataclass(frozen=True, slots=True)
class Wait:
    """Limit: do not pass ``row`` of the own track until another robot has reached ``passed``."""

    row: int
    robot: int
    passed: int


@dataclass(frozen=True, slots=True)
class TrackRelease:
    """Last row of its track that a robot may be given now, and its waits there, if any."""

    row: int
    waits: tuple[Wait, ...] = ()


def releases(plan: FleetPlan, passed: Sequence[int]) -> tuple[TrackRelease, ...]:
    """Release of each robot; ``passed`` is the row that each has reached last, 0 at its start.

    ``ValueError`` if there is not one row each, or a row is not in the track. O(robots +
    dependencies).
    """
    if len(passed) != len(plan.tracks):
        raise ValueError(f"{len(passed)} rows for {len(plan.tracks)} robots: must be one each")
    for i, (row, track) in enumerate(zip(passed, plan.tracks, strict=True)):
        if not 0 <= row < len(track):
            raise ValueError(
                f"passed[{i}] = {row}: must be a row of its track, 0 to {len(track) - 1}"
            )
    limits = [len(track) - 1 for track in plan.tracks]
    unmet: list[list[Wait]] = [[] for _ in plan.tracks]
    for robot, needed, waiting, row in plan.dependencies:
        if passed[robot] < needed and row < limits[waiting]:
            limits[waiting] = row
            unmet[waiting] = []
        if passed[robot] < needed and row == limits[waiting] < len(plan.tracks[waiting]) - 1:
            unmet[waiting].append(Wait(row, robot, needed))
    return tuple(TrackRelease(row, tuple(waits)) for row, waits in zip(limits, unmet, strict=True))


def deadlocked(plan: FleetPlan) -> tuple[int, ...]:
    """Robots in a circle of waits once all have driven as far as they may; empty if none are."""
    passed = [0] * len(plan.tracks)
    while True:
        rows = [release.row for release in releases(plan, passed)]
        if rows == passed:
            return waiting_circle(plan, passed)
        passed = rows


def waiting_circle(plan: FleetPlan, passed: Sequence[int]) -> tuple[int, ...]:
    """Robots in a circle of waits, none of which can ever move; empty if none are."""
    now = releases(plan, passed)
    held = {i: r.waits for i, r in enumerate(now) if r.waits and r.row <= passed[i]}
    while True:
        free = [i for i, waits in held.items() if all(w.robot not in held for w in waits)]
        if not free:
            return tuple(sorted(held))
        for i in free:
            del held[i]

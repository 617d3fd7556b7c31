"""Which waypoints of a fleet's plan each robot may be given now, from how far all of them are.

Rules
- ``passed[i]`` is the row of robot i's track that it reached last, 0 at its start. It may be given
  all rows up to its next unmet dependency and none beyond; what it was given is never taken back,
  because what is allowed only grows with the progress of all.
- Whatever the delays, nobody touches anybody: of two pieces that come near, the second is begun
  after the first has ended. Where :func:`planner.fleet.dependencies.is_live` says so, somebody can
  always move until all are there: the waits and the order of each track form no circle, and of
  rows that are not reached yet one comes first.
- Nothing here reads a clock or keeps a state: equal progress gives equal answers, so that a restart
  or a replay resumes where it was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from planner.fleet.fleet_plan import FleetPlan


@dataclass(frozen=True, slots=True)
class Wait:
    """A robot must not go beyond ``row`` of its track until another has reached ``passed``."""

    row: int
    robot: int
    passed: int


@dataclass(frozen=True, slots=True)
class Release:
    """The last row of its track that a robot may be given now, and whom it waits for there.

    ``waits`` is empty where the row is the track's last.
    """

    row: int
    waits: tuple[Wait, ...] = ()


def releases(plan: FleetPlan, passed: Sequence[int]) -> tuple[Release, ...]:
    """What each robot may be given now; ``passed`` is the row that each has reached last.

    ``ValueError`` where there is not one row each, or a row is not in the track.
    O(robots + dependencies).
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
    return tuple(Release(row, tuple(waits)) for row, waits in zip(limits, unmet, strict=True))


def deadlocked(plan: FleetPlan) -> tuple[int, ...]:
    """Robots that wait in a circle once all have driven as far as they may; empty if none do."""
    passed = [0] * len(plan.tracks)
    while True:
        rows = [release.row for release in releases(plan, passed)]
        if rows == passed:
            return waiting_circle(plan, passed)
        passed = rows


def waiting_circle(plan: FleetPlan, passed: Sequence[int]) -> tuple[int, ...]:
    """Robots that wait for each other in a circle, none of which can ever move; empty if none do.

    Only a plan with a remark on its timing has such a circle.
    """
    now = releases(plan, passed)
    held = {i: r.waits for i, r in enumerate(now) if r.waits and r.row <= passed[i]}
    while True:
        free = [i for i, waits in held.items() if all(w.robot not in held for w in waits)]
        if not free:
            return tuple(sorted(held))
        for i in free:
            del held[i]

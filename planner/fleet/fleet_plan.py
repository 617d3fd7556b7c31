"""Answers of planning several robots, in units of the graph or scene, and seconds."""

from __future__ import annotations

from dataclasses import dataclass

from planner.scene import FloatArray

Dependency = tuple[int, int, int, int]
"""(robot, point of its track that it must have passed, waiting robot, point of its track that it
must not pass before)."""


@dataclass(frozen=True, slots=True)
class FleetPlan:
    """A track for each robot, no two of which ever come nearer than both radii.

    ``tracks`` are read-only arrays (k, 3) of t, x, y from time zero: straight and even between
    rows, at rest after the last. Robots that keep ``dependencies`` touch no other, whatever the
    delays. ``makespan_s`` is the last arrival, ``flowtime_s`` the sum of all. ``remarks`` are
    sentences on what is uncertain.
    """

    tracks: tuple[FloatArray, ...]
    dependencies: tuple[Dependency, ...]
    makespan_s: float
    flowtime_s: float
    remarks: tuple[str, ...] = ()

    @property
    def arrivals_s(self) -> tuple[float, ...]:
        """Time of each robot's final arrival at its goal."""
        return tuple(float(track[-1, 0]) for track in self.tracks)


@dataclass(frozen=True, slots=True)
class NoFleetPlan:
    """Expected refusal, which is false: no plan exists, or none was found.

    ``blocking`` are the robots responsible, by their place in the list. ``proved`` is False if a
    plan may exist.
    """

    reason: str
    blocking: tuple[int, ...] = ()
    proved: bool = True

    def __bool__(self) -> bool:
        return False

"""What planning several robots answers: their timed tracks, or why there are none.

Units are those of the graph or scene, and seconds.
"""

from __future__ import annotations

from dataclasses import dataclass

from planner.scene import FloatArray

Dependency = tuple[int, int, int, int]
"""(robot, index of the point of its track that it must have passed, waiting robot, index of the
point of its track that it must not go beyond before)."""


@dataclass(frozen=True, slots=True)
class FleetPlan:
    """A track for each robot, no two of which ever come nearer than both radii.

    ``tracks`` are read-only arrays (k, 3) of t, x, y from time zero: straight and even between
    two rows, standing after the last. ``dependencies`` keep the order in which the robots pass
    places that they share: who keeps them touches nobody, however late anybody is.
    ``makespan_s`` is the last arrival, ``flowtime_s`` the sum of all arrivals. ``remarks`` are
    plain sentences on what is not certain.
    """

    tracks: tuple[FloatArray, ...]
    dependencies: tuple[Dependency, ...]
    makespan_s: float
    flowtime_s: float
    remarks: tuple[str, ...] = ()

    @property
    def arrivals_s(self) -> tuple[float, ...]:
        """When each robot comes to its goal to stay."""
        return tuple(float(track[-1, 0]) for track in self.tracks)


@dataclass(frozen=True, slots=True)
class NoFleetPlan:
    """There is no plan, or none was found: an expected answer, which is false.

    ``blocking`` are the robots that it hangs on, by their place in the list. ``proved`` is False
    where the search ended for want of time.
    """

    reason: str
    blocking: tuple[int, ...] = ()
    proved: bool = True

    def __bool__(self) -> bool:
        return False

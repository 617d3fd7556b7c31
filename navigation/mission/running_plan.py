"""The plan being driven: its destination, the robot's progress, and its sentences.

Metres, seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from navigation.mission.cycle import PlanAnswer
from navigation.mission.targets import Target
from planner.borders.polyline import distance_to_polyline, length_of
from planner.path import NoPath, Path, Trajectory
from planner.scene import FloatArray

"""Replaces the squared length of a piece that has none."""


@dataclass(frozen=True, slots=True)
class RunningPlan:
    """A path, the targets given for it, and the part executed."""

    path: Path | None = None
    """None if nothing is driven."""
    trajectory: Trajectory | None = None
    targets: tuple[Target, ...] = ()
    speed_m_s: float = math.inf
    revision: int = 0
    """Number of the scene in which it was made."""
    visited_before: int = 0
    """Stations visited when it was made."""
    executed: int = 0
    """Targets that the robot has reached."""
    left: FloatArray = field(init=False, repr=False, compare=False)
    """Places (n, 2) of the remaining targets."""

    def __post_init__(self) -> None:
        places = [(t.x_m, t.y_m) for t in self.targets[self.executed :]]
        left = np.array(places, dtype=np.float64).reshape(-1, 2)
        left.setflags(write=False)
        object.__setattr__(self, "left", left)

    @property
    def visited(self) -> int:
        """Stations of the mission visited by the executed part."""
        passed = [t.station for t in self.targets[: self.executed] if t.station is not None]
        return self.visited_before + max(passed, default=0)

    def with_executed(self, count: int) -> RunningPlan:
        """Plan with more targets reached, at most all of them; the number never falls."""
        executed = max(self.executed, min(count, len(self.targets)))
        return self if executed == self.executed else replace(self, executed=executed)

    def left_m(self, place_m: tuple[float, float]) -> float | None:
        """Distance from a place through the remaining targets; None without any."""
        left = self.left
        if len(left) == 0:
            return None
        points = np.vstack([[place_m], left])
        return length_of(points)

    def deviation_m(self, place_m: tuple[float, float] | None) -> float | None:
        """Distance of a place from the path; None if either is missing."""
        if place_m is None or self.path is None:
            return None
        return distance_to_polyline(self.path.points, place_m)


def plan_of(
    answer: PlanAnswer, targets: tuple[Target, ...], speed_m_s: float | None, visited: int
) -> RunningPlan:
    """Plan that an answer with a path begins, at most ``speed_m_s`` fast; None: no limit."""
    assert isinstance(answer.path, Path)
    return RunningPlan(
        path=answer.path,
        trajectory=answer.trajectory,
        targets=targets,
        speed_m_s=math.inf if speed_m_s is None else speed_m_s,
        revision=answer.scene_revision,
        visited_before=visited,
    )


def driving_sentence(path: Path, stations_left: int) -> str:
    """Sentence about a plan being driven."""
    return (
        f"driving {path.length:.2f} m to {stations_left} station{'s' * (stations_left != 1)}, "
        f"clearance at least {path.min_clearance:.3f} m" + _remarked(path)
    )


def refusal_sentence(answer: NoPath) -> str:
    """Sentence about a missing plan."""
    return f"no safe plan: {answer.reason}{_remarked(answer)}"


def _remarked(answer: Path | NoPath) -> str:
    return "".join(f"; {remark}" for remark in answer.remarks)

"""The coordinator's knowledge of each robot, and the places of robots that take no part.

A seen robot keeps its body's disc. An unseen one also keeps every place along what it was given
that it can have reached before its lease ran out and its brakes stopped it. Metres, radians,
seconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from navigation.fleet.releases import Held
from navigation.fleet.request import Promise, Taken
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import State, Station
from planner.borders.polyline import distance_to_polyline, length_of
from planner.path import Limits, Path
from planner.scene import FloatArray

SEEN_S: Final = 0.3
"""A robot seen no longer ago is where it was seen."""
TOUCH_M: Final = 0.003
"""Two poses' noise: bodies that come nearer may touch."""
NEARER_M: Final = 0.004
"""A gap that shrinks by less does not shrink."""


@dataclass(frozen=True, slots=True)
class Member:
    """One robot in one cycle."""

    state: State
    pose: tuple[float, float, float] | None
    """Last pose that the camera saw; None if it never saw the robot."""
    pose_age_s: float
    stands: bool
    """True if it is at rest or, unseen, can no longer move."""
    radius_m: float
    limits: Limits
    max_deviation_m: float
    reach_m: float
    """Longest drive after it was last seen, until lease and brakes end it."""
    executed: int | None = None
    """Targets executed of its present plan, if any."""
    request: PlanRequest | None = None
    sentence: str = ""
    """Reason for the mission's state."""
    obliging: bool = False
    """It is at rest without a mission, is well, and may be asked to step aside."""
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Along both axes, and turning to the left, as last seen."""
    obeys: bool = True
    """True if it is no faster than its lease, or its brakes since the lease's end, allow."""
    is_silent: bool = False
    keep_m: float = 0.03
    """Distance from the body of a runaway."""
    at_large: bool = False
    """It may be anywhere: neither seen nor heard, and nothing of its own stops it."""

    def limits_at(self, request: PlanRequest) -> Limits:
        """Limits at no more than the requested speed."""
        if request.speed_m_s is None or request.speed_m_s >= self.limits.speed:
            return self.limits
        slow = min(self.limits.slow_speed, request.speed_m_s)
        return replace(self.limits, speed=request.speed_m_s, slow_speed=slow)

    @property
    def waits_because(self) -> str:
        """Reason given by a robot that waits for it."""
        if self.state is State.DRIVING:
            return "has to pass first"
        return f"is {self.state.value}: {self.sentence}" if self.sentence else "does not drive"


def why_nobody_moves(members: Mapping[str, Member]) -> str | None:
    """Sentence about a robot that may be anywhere; None if every place is known."""
    for name, one in members.items():
        if one.pose is None:
            return f"{name} was not seen yet: its place is unknown"
        if one.at_large:
            return f"{name} is not seen and does not answer, and nothing stops it by itself"
    return None


def places_kept(name: str, one: Member, held: Held | None) -> Iterator[Taken]:
    """Discs that hold a robot that takes no part in a plan."""
    if one.pose is None:
        return
    x, y, _ = one.pose
    yield Taken(name, x, y, one.radius_m)
    if one.pose_age_s <= SEEN_S or held is None:
        return
    for at_x, at_y in _ahead(one.pose[:2], held, one.reach_m):
        yield Taken(name, at_x, at_y, one.radius_m + one.max_deviation_m)


def _ahead(here: tuple[float, float], held: Held, reach_m: float) -> Iterator[tuple[float, float]]:
    gone_m, before = 0.0, here
    for x, y in held.promise.points[held.executed + 1 :].tolist():
        gone_m += math.dist(before, (x, y))
        before = (x, y)
        yield x, y
        if gone_m > reach_m:
            return


def line_kept(name: str, answer: PlanAnswer) -> Held:
    """Line aside in the form of a promise."""
    path = answer.path
    assert isinstance(path, Path)
    station = Station(*path.points[-1].tolist())
    promise = Promise(name, station, path.points, answer.targets, (), path, None, path.robot_radius)
    return Held(promise, sent=len(answer.targets))


def comes_too_near(way: FloatArray, name: str, members: Mapping[str, Member]) -> str | None:
    """Sentence about a path that leads into another body; None if all is clear.

    ``way`` (n >= 1, 2) begins at the robot. A body that it approaches no further is no reason to
    hold.
    """
    radius_m = members[name].radius_m
    x_m, y_m = way[0].tolist()
    length_m = length_of(way)
    for other, one in members.items():
        if other == name or one.pose is None:
            continue
        bodies_m = radius_m + one.radius_m
        now_m = math.dist((x_m, y_m), one.pose[:2]) - bodies_m
        if now_m - length_m >= TOUCH_M:
            continue
        least_m = distance_to_polyline(way, one.pose[:2]) - bodies_m
        if least_m < min(TOUCH_M, now_m - NEARER_M):
            return f"{other} is in the path: it leaves {max(least_m, 0.0):.3f} m"
    return None

"""Requests to the fleet's planner, and its answers. Metres, radians, seconds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import Station
from navigation.mission.targets import Target
from planner.path import Limits, Path, Trajectory
from planner.scene import FloatArray
from planner.zones.zone import Zone


@dataclass(frozen=True, slots=True)
class Traveller:
    """A robot that wants to move, and its next station."""

    name: str
    start: tuple[float, float, float]
    station: Station
    radius_m: float
    limits: Limits
    open_order: tuple[Station, ...] = ()
    """Its stations, if all but the last may be visited in any order; else empty."""
    zones: tuple[Zone, ...] = ()

    @property
    def as_taken(self) -> Taken:
        """The place that it keeps if it does not move."""
        return Taken(self.name, self.start[0], self.start[1], self.radius_m)


@dataclass(frozen=True, slots=True)
class Taken:
    """Round place kept by a robot that takes no part."""

    name: str
    x_m: float
    y_m: float
    radius_m: float


@dataclass(frozen=True, slots=True)
class FleetRequest:
    """Request for paths of all travellers at once, around taken places."""

    id: int
    scene_revision: int
    travellers: tuple[Traveller, ...]
    taken: tuple[Taken, ...] = ()
    driving: tuple[Driving, ...] = ()
    """Robots that drive on meanwhile; empty if all are at rest and planned together."""
    idle: tuple[Traveller, ...] = ()
    """Robots at rest without a mission, which may step aside and come back."""


@dataclass(frozen=True, slots=True)
class Gate:
    """Limit in a promise: ``before`` targets until another robot has executed ``passed``."""

    before: int
    other: str
    passed: int


@dataclass(frozen=True, slots=True)
class Promise:
    """A robot's path, the targets along it, and its gates.

    ``points`` (n + 1, 2): its place when planned, and the place of each of its n targets.
    """

    name: str
    station: Station
    points: FloatArray
    targets: tuple[Target, ...]
    gates: tuple[Gate, ...]
    path: Path
    trajectory: Trajectory | None
    radius_m: float
    margin_m: float = 0.0
    """Excess of the planned radius."""


@dataclass(frozen=True, slots=True)
class Driving:
    """A robot that drives on: its promise, and its executed and its given targets."""

    promise: Promise
    executed: int
    sent: int
    limits: Limits
    zones: tuple[Zone, ...] = ()

    @property
    def as_traveller(self) -> Traveller:
        """The same robot, from its last executed target."""
        x, y = self.promise.points[self.executed].tolist()
        promise = self.promise
        return Traveller(
            promise.name, (x, y, 0.0), promise.station, promise.radius_m, self.limits,
            zones=self.zones,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class FleetAnswer:
    """Promises, and the reason for each traveller that has none.

    ``driving`` are the promises of driving robots with their present gates; ``cannot`` is the
    reason if nothing could be added to them. An idle robot's promise asks it to step aside and come
    back.
    """

    id: int
    scene_revision: int
    promises: Mapping[str, Promise]
    refused: Mapping[str, str]
    driving: tuple[Promise, ...] = ()
    cannot: str = ""


Request: TypeAlias = PlanRequest | FleetRequest
Answer: TypeAlias = PlanAnswer | FleetAnswer

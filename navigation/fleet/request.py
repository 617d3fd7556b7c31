"""What is asked of the fleet's planner, and what it answers. Metres, radians, seconds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import Station
from navigation.mission.targets import Target
from planner.path import Limits, Path, Trajectory
from planner.scene import FloatArray


@dataclass(frozen=True, slots=True)
class Traveller:
    """A robot that wants to move: where it stands, and the station that it goes to."""

    name: str
    start: tuple[float, float, float]
    station: Station
    radius_m: float
    limits: Limits
    open_order: tuple[Station, ...] = ()
    """Its stations, where all but the last may be visited in any order; else empty."""


@dataclass(frozen=True, slots=True)
class Taken:
    """A round place that a robot which does not take part keeps."""

    name: str
    x_m: float
    y_m: float
    radius_m: float


@dataclass(frozen=True, slots=True)
class FleetRequest:
    """Ask for paths for all travellers at once, around what is taken."""

    id: int
    scene_revision: int
    travellers: tuple[Traveller, ...]
    taken: tuple[Taken, ...] = ()
    driving: tuple[Driving, ...] = ()
    """Who drives on meanwhile; empty where all stand and are planned together."""
    idle: tuple[Traveller, ...] = ()
    """Who stands without a mission, and may step aside and come back to its station."""


@dataclass(frozen=True, slots=True)
class Gate:
    """Of a promise: no more than ``before`` targets before another robot has executed ``passed``
    of its own."""

    before: int
    other: str
    passed: int


@dataclass(frozen=True, slots=True)
class Promise:
    """What one robot may drive in the end: its path, the targets along it, and its gates.

    ``points`` (n + 1, 2): where it stood, and the place of each of its n targets.
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
    """By how much larger the robot was planned."""


@dataclass(frozen=True, slots=True)
class Driving:
    """A robot that drives on: its promise, the targets of it that it has executed, and how many
    it was given."""

    promise: Promise
    executed: int
    sent: int
    limits: Limits

    @property
    def as_traveller(self) -> Traveller:
        """The same robot, from the target that it has executed last."""
        x, y = self.promise.points[self.executed].tolist()
        promise = self.promise
        return Traveller(promise.name, (x, y, 0.0), promise.station, promise.radius_m, self.limits)


@dataclass(frozen=True, slots=True)
class FleetAnswer:
    """A promise for each traveller that has one, and the reason for each that has none.

    ``driving`` are the promises of those that drive on with the gates that they have now, where any
    have changed; ``cannot`` is the reason where nothing could be added to them. A promise of an
    idle robot asks it to step aside and come back.
    """

    id: int
    scene_revision: int
    promises: Mapping[str, Promise]
    refused: Mapping[str, str]
    driving: tuple[Promise, ...] = ()
    cannot: str = ""


Request: TypeAlias = PlanRequest | FleetRequest
"""A planner's request, for one robot or for several."""
Answer: TypeAlias = PlanAnswer | FleetAnswer

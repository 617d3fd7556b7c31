"""A journal's records as text, read as strictly as a configuration.

A record names its owner: a mission is only for one robot, on one port, in one arena, of one
configuration. Metres, radians, seconds.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Final

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError

from navigation.config import Config
from navigation.config.errors import key_name
from navigation.config.several.each_camera import each_camera
from navigation.config.values import LONGEST_DWELL_S, MOST_STATIONS
from navigation.mission.mission import MissionProgress, State, Station
from navigation.mission.targets import Target
from planner.scene import Bounds, printable
from vision.camera.sources import without_password, without_user

MOST_TARGETS: Final = 1_000_000
"""Waypoints of one plan: far more than a robot takes, and still a bounded text."""
LARGEST_MISSION_ID: Final = (1 << 32) - 1
FASTEST_M_S: Final = 100.0
LARGEST_RAD: Final = 7.0
"""Headings lie in (-pi, pi]; a little more than a turn leaves room for other conventions."""


class RecordError(ValueError):
    """Error: a record cannot be used."""


@dataclass(frozen=True, slots=True)
class Owner:
    """Owner of a journal; ``camera`` is a fingerprint of its address and calibration."""

    robot: str = ""
    port: str = ""
    camera: str = ""
    configuration: str = ""
    bounds_m: tuple[float, float, float, float] = (-1e3, -1e3, 1e3, 1e3)

    def difference(self, other: Owner) -> str:
        """Differences from the other owner, in words; empty without any."""
        mine, theirs = asdict(self), asdict(other)
        names = {"bounds_m": "arena"}
        parts = [
            f"the {names.get(key, key)} {_shown(theirs[key])}, not {_shown(mine[key])}"
            for key in mine
            if mine[key] != theirs[key] and key != "camera"
        ]
        if self.camera != other.camera:
            parts.append("another camera or calibration")
        return " and ".join(parts)


def owner_of(config: Config, file: Path | None = None) -> Owner:
    """Owner for the run of a configuration from ``file``."""
    own = [one.camera for one in each_camera(config).values()] or [config.camera]
    cameras = [
        (without_user(str(one.source)), str(one.calibration), one.metres_per_pixel) for one in own
    ]
    camera = cameras if config.cameras else list(cameras[0])
    x0, y0, x1, y1 = config.arena.bounds_m
    return Owner(
        robot=f"{config.robot.marker_id} of {config.robot.dictionary}",
        port=without_password(config.serial.port),
        camera=_fingerprint(json.dumps(camera)),
        configuration="" if file is None else str(file.absolute()),
        bounds_m=(float(x0), float(y0), float(x1), float(y1)),
    )


def _fingerprint(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _shown(value: object) -> str:
    return str(list(value)) if isinstance(value, tuple | list) else str(value) or "unnamed"


@dataclass(frozen=True, slots=True)
class SentPlan:
    """A plan given to the robot: its id on the wire, and the number of stations before it."""

    mission_id: int
    visited_before: int
    targets: tuple[Target, ...]

    def visited_after(self, executed: int) -> int:
        """Number of stations visited after ``executed`` targets."""
        passed = [t.station for t in self.targets[:executed] if t.station is not None]
        return self.visited_before + max(passed, default=0)


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


_Text = Annotated[str, StringConstraints(max_length=100_000)]
_Heading = Annotated[float, Field(ge=-LARGEST_RAD, le=LARGEST_RAD)]
_Dwell = Annotated[float, Field(ge=0.0, le=LONGEST_DWELL_S)]


class _Owner(_Record):
    robot: _Text
    port: _Text
    camera: _Text
    configuration: _Text
    bounds_m: tuple[float, float, float, float]


class _Station(_Record):
    x: float
    y: float
    heading_rad: _Heading | None
    dwell_s: _Dwell


class _Mission(_Record):
    stations: Annotated[list[_Station], Field(max_length=MOST_STATIONS)]
    visited: Annotated[int, Field(ge=0)]
    any_order: bool
    state: _Text
    reason: _Text
    paused: bool
    errand: _Station | None = None


class _Target(_Record):
    x_m: float
    y_m: float
    speed_m_s: Annotated[float, Field(ge=0.0, le=FASTEST_M_S)]
    stops: bool
    heading_rad: _Heading | None
    dwell_s: _Dwell
    station: Annotated[int, Field(ge=0, le=MOST_STATIONS)] | None


class _Plan(_Record):
    mission_id: Annotated[int, Field(ge=1, le=LARGEST_MISSION_ID)]
    visited_before: Annotated[int, Field(ge=0)]
    targets: Annotated[list[_Target], Field(max_length=MOST_TARGETS)]


class _Contents(_Record):
    owner: _Owner
    mission: _Mission
    plan: _Plan | None


@dataclass(frozen=True, slots=True)
class Contents:
    """Everything in a journal."""

    owner: Owner
    mission: MissionProgress
    plan: SentPlan | None


def to_text(contents: Contents) -> str:
    """The contents as JSON; floats read back the same."""
    mission = {**asdict(contents.mission), "state": contents.mission.state.name}
    plan = None if contents.plan is None else asdict(contents.plan)
    body = {"owner": asdict(contents.owner), "mission": mission, "plan": plan}
    return json.dumps(body, allow_nan=False)


def from_text(text: str) -> Contents:
    """Contents of a text; ``RecordError`` if anything in it is impossible."""
    try:
        read = _Contents.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = key_name(tuple(first["loc"])) or "its text"
        raise RecordError(printable(f"{where}: {first['msg']}"[:300])) from None
    owner = Owner(**read.owner.model_dump())
    mission = _mission_of(read.mission, owner)
    plan = None if read.plan is None else _plan_of(read.plan, mission)
    return Contents(owner, mission, plan)


def _mission_of(read: _Mission, owner: Owner) -> MissionProgress:
    if read.state not in State.__members__:
        raise RecordError(printable(f"mission.state {read.state[:40]!r}: is no state"))
    if read.visited > len(read.stations):
        count = len(read.stations)
        raise RecordError(f"mission.visited = {read.visited}: must be <= {count}, its stations")
    stations = tuple(Station(**one.model_dump()) for one in read.stations)
    errand = None if read.errand is None else Station(**read.errand.model_dump())
    if errand is not None and read.visited < len(stations):
        raise RecordError("mission.errand: must be null until all stations are visited")
    state = State[read.state]
    if not stations and state is not State.DONE:
        raise RecordError("mission.stations: must not be empty of a mission that is not done")
    mission = MissionProgress(
        stations, read.visited, read.any_order, state, read.reason, read.paused, errand
    )
    _are_inside(mission.places, owner)
    return mission


def _plan_of(read: _Plan, mission: MissionProgress) -> SentPlan:
    targets = tuple(Target(**one.model_dump()) for one in read.targets)
    plan = SentPlan(read.mission_id, read.visited_before, targets)
    if plan.visited_after(len(targets)) > len(mission.places):
        count = len(mission.places)
        raise RecordError(f"plan: visits more stations than the mission has, {count}")
    return plan


def _are_inside(stations: Iterable[Station], owner: Owner) -> None:
    bounds = Bounds(*owner.bounds_m)
    for number, one in enumerate(stations):
        if not bounds.contains((one.x, one.y)):
            place = f"({one.x:g}, {one.y:g}) m"
            where = f"mission.stations[{number}]"
            raise RecordError(f"{where}: {place} lies outside the arena, {bounds.ranges}")

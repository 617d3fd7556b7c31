"""Facts and orders of one control cycle. Metres, radians, seconds."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from navigation.mission.mission import MissionError, Station
from navigation.mission.targets import Target
from navigation.mission.traffic import Disc, Mover, TrafficLimits
from navigation.mission.watch import SafetyLimits
from navigation.witness import NO_EVIDENCE, Evidence
from planner.path import NoPath, Path, Trajectory
from planner.scene import Bounds


@dataclass(frozen=True, slots=True)
class PilotSettings:
    """The pilot's configuration."""

    limits: SafetyLimits
    bounds_m: Bounds
    goal_tolerance_m: float
    goal_tolerance_rad: float
    settle_s: float
    """Time that a hold's cause must be gone before a new plan, and that the robot must be at
    rest before the camera judges its arrival."""
    retry_s: float
    """Wait after a failed plan."""
    robot_grace_s: float
    """Time that the robot may take to begin, or rest unfinished."""
    replan_distance_m: float
    """A changed obstacle nearer to the path than this asks for a new plan."""
    give_up_s: float
    """Time that the robot may wait without progress before the mission fails."""
    circles_s: float
    """Longest time that the robot may move without coming nearer to its next target."""
    traffic: TrafficLimits
    corrections: int
    """Most corrections of the last stretch if the camera sees the robot off its goal."""
    turns_on_spot: bool = True
    """True if the robot can prove itself by a turn on the spot."""

    def check_stations(self, stations: Iterable[Station]) -> None:
        """Raise ``MissionError`` for a station outside the arena."""
        for number, station in enumerate(stations, 1):
            if not self.bounds_m.contains((station.x, station.y)):
                raise MissionError(
                    f"station {number} at ({station.x:g}, {station.y:g}) m: outside the arena, "
                    f"{self.bounds_m.ranges}"
                )


@dataclass(frozen=True, slots=True)
class Sight:
    """The camera's report.

    Texts are sentences for people; empty or None without a cause.
    """

    frame_age_s: float = math.inf
    pose_age_s: float = math.inf
    pose: tuple[float, float, float] | None = None
    scene_revision: int = 0
    """Counts the scenes seen; 0 before the first."""
    clearance_m: float | None = None
    """From the robot's centre to the nearest border."""
    others: tuple[Mover, ...] = ()
    """Every other robot ever seen."""
    failed: str | None = None
    """A part of the program has failed and is being restarted."""
    camera_reason: str = ""
    """The camera's remark on itself."""
    doubles: tuple[str, ...] = ()
    """Markers seen twice."""
    evidence: Evidence = NO_EVIDENCE
    scene_doubt: str | None = None
    """Why the arena cannot be what the newest scene shows."""
    partner: str | None = None
    """A robot of the same fleet is in the path."""
    late: str | None = None
    """Why camera and wheels may seem to part though they do not."""
    blind: str | None = None
    """Why the last moments were not observed."""


@dataclass(frozen=True, slots=True)
class RobotReport:
    """The link's report of the robot."""

    age_s: float = math.inf
    down_reason: str | None = "not connected yet"
    estopped: bool = False
    leaving_estop: bool = False
    """True if the robot was re-armed and has not answered yet."""
    disarmed: bool = False
    mission_id: int | None = None
    executed: int = 0
    """Waypoints of it that the robot has reached."""
    no_permit: str | None = None
    """Why the robot can get no lease to drive; None if it can."""
    standing_reason: str | None = None
    """Why the robot does not run its mission; None while it does."""
    waits: bool = False
    """True if it has reached every waypoint sent and waits for more."""
    place_m: tuple[float, float] | None = None
    """The robot's own estimate of its place."""
    fault: str | None = None


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """Request for a path."""

    id: int
    start: tuple[float, float, float]
    stations: tuple[Station, ...]
    scene_revision: int
    any_order: bool = False
    """True if all stations but the last may change places."""
    avoid: tuple[Disc, ...] = ()
    """Other robots, avoided as obstacles in this plan only."""
    speed_m_s: float | None = None
    """Speed limit for late pictures; None: none."""


@dataclass(frozen=True, slots=True)
class PlanAnswer:
    """The planner's answer to a request, or its check of the running plan in a new scene."""

    id: int
    scene_revision: int
    path: Path | NoPath
    trajectory: Trajectory | None = None
    targets: tuple[Target, ...] = ()
    """Empty if there is no path."""


@dataclass(frozen=True, slots=True)
class Orders:
    """Orders after a cycle; None and False mean nothing."""

    permit: bool
    """True if the lease lets the robot move."""
    request: PlanRequest | None = None
    upload: tuple[int, tuple[Target, ...]] | None = None
    """A new mission for the robot: id and targets."""
    halt: bool = False
    """Stop under control and drop the queue."""
    estop: bool = False
    rearm: bool = False
    measure_latency: bool = False
    """Measure the camera's latency again from here on."""

"""Input and output of one control cycle: facts in, orders out.

Units: metres, radians, seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from navigation.mission.mission import Station
from navigation.mission.targets import Target
from navigation.mission.traffic import Disc, Mover, TrafficLimits
from navigation.mission.watch import SafetyLimits
from navigation.witness import NO_EVIDENCE, Evidence
from planner.path import NoPath, Path, Trajectory
from planner.scene import Bounds


@dataclass(frozen=True, slots=True)
class PilotSettings:
    """The pilot's settings, from the configuration."""

    limits: SafetyLimits
    bounds_m: Bounds
    goal_tolerance_m: float
    goal_tolerance_rad: float
    settle_s: float
    """Time that the cause of a hold must be gone before a new plan is made, and that the robot must
    be at rest before the camera judges its arrival."""
    retry_s: float
    """Time to wait before asking for a plan again where there was none."""
    robot_grace_s: float
    """Time that the robot may take to begin, or be at rest without having finished."""
    replan_distance_m: float
    """A changed obstacle that comes nearer to the path than this asks for a new plan."""
    give_up_s: float
    """Time that the robot may wait without any progress before the mission fails."""
    traffic: TrafficLimits
    corrections: int
    """Most corrections of the last stretch where the camera sees the robot off its goal."""
    turns_on_spot: bool = True
    """True if the robot can prove itself by a turn on the spot."""


@dataclass(frozen=True, slots=True)
class Sight:
    """The camera's report: the robot's pose, and the ages of picture and pose."""

    frame_age_s: float = math.inf
    pose_age_s: float = math.inf
    pose: tuple[float, float, float] | None = None
    scene_revision: int = 0
    """Counts the scenes seen; 0 before the first."""
    clearance_m: float | None = None
    """From the robot's centre to the nearest border in the newest scene."""
    others: tuple[Mover, ...] = ()
    """Every other robot that was ever seen."""
    failed: str | None = None
    """The sentence that says which part of the program has failed and is being restarted."""
    camera_reason: str = ""
    """Remark of the camera on itself; empty while all is well."""
    doubles: tuple[str, ...] = ()
    """A sentence for each marker that is seen twice."""
    evidence: Evidence = NO_EVIDENCE
    """Evidence of camera and wheels together."""
    scene_doubt: str | None = None
    """The sentence that says why the arena cannot be what the newest scene shows."""
    partner: str | None = None
    """The sentence that says which robot of the same fleet is in the path."""
    late: str | None = None
    """The sentence that says why camera and wheels may seem to part though they do not."""
    blind: str | None = None
    """The sentence that says why the last moments were not observed."""


@dataclass(frozen=True, slots=True)
class RobotReport:
    """The link's report of the robot."""

    age_s: float = math.inf
    down_reason: str | None = "not connected yet"
    estopped: bool = False
    leaving_estop: bool = False
    """True if the robot was re-armed and has not answered yet: it reports the old stop."""
    disarmed: bool = False
    mission_id: int | None = None
    """The mission that the robot holds."""
    executed: int = 0
    """Number of waypoints of that mission that the robot has reached."""
    no_permit: str | None = None
    """Why the robot cannot be given a lease to drive; None where it can."""
    standing_reason: str | None = None
    """Why the robot does not run its mission; None while it does."""
    waits: bool = False
    """True if it has reached every waypoint that it was sent, and waits for more."""
    place_m: tuple[float, float] | None = None
    """Place at which the robot believes itself to be."""
    fault: str | None = None
    """Fault felt by the robot, which made it stop itself."""


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """Request for a path from here through these stations."""

    id: int
    start: tuple[float, float, float]
    stations: tuple[Station, ...]
    scene_revision: int
    any_order: bool = False
    """True if the stations but the last may change places."""
    avoid: tuple[Disc, ...] = ()
    """Places of other robots: kept clear of as obstacles are, in this plan only."""
    speed_m_s: float | None = None
    """No faster than this, where the camera's pictures are late; None: as fast as it can."""


@dataclass(frozen=True, slots=True)
class PlanAnswer:
    """The planner's answer to a request, or its check of the running plan in a new scene."""

    id: int
    scene_revision: int
    path: Path | NoPath
    trajectory: Trajectory | None = None
    targets: tuple[Target, ...] = ()
    """Targets that the robot is given; empty if there is no path."""


@dataclass(frozen=True, slots=True)
class Orders:
    """Orders after a cycle; None and False mean nothing."""

    permit: bool
    """True if the lease lets the robot move."""
    request: PlanRequest | None = None
    upload: tuple[int, tuple[Target, ...]] | None = None
    """A new mission for the robot: its id and the targets."""
    halt: bool = False
    """Stop under control and drop the queue."""
    estop: bool = False
    rearm: bool = False
    measure_latency: bool = False
    """The camera's latency is to be measured again from here on."""

"""What the running program tells of itself after each cycle, and of the plans that it drove.

Nothing here changes any more once it is made: any thread may keep it and read it at leisure.
Units: metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from navigation.link.link_snapshot import LinkSnapshot
from navigation.mission.mission import Mission
from navigation.mission.trust import Level
from navigation.mission.watch import Verdict
from navigation.witness import NO_EVIDENCE, Evidence
from planner.path import Path, Trajectory
from planner.roadmap.roadmap import Roadmap
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose


@dataclass(frozen=True, slots=True)
class StageTimes:
    """How long each stage took last, seconds; None before its first time."""

    look_s: float | None = None
    """Vision, one frame."""
    roadmap_s: float | None = None
    """From a new scene to its roadmap, in the planner's thread."""
    plan_s: float | None = None
    """From a request for a plan to its answer."""


@dataclass(frozen=True, slots=True)
class DaemonState:
    """What is known after a cycle; for the command line, the dashboard and tests.

    Nothing in it changes any more: other threads may keep it and read it at leisure.
    """

    time_s: float
    mission: Mission
    sentence: str
    pose: RobotPose | None
    link: LinkSnapshot
    to_go_m: float | None
    clearance_m: float | None
    verdict: Verdict
    frame: Frame | None
    """The newest picture."""
    poses: Mapping[int, RobotPose]
    """By marker id: every robot in that picture."""
    roadmap: Roadmap | None
    """The newest; its ``scene`` is what it was made of."""
    path: Path | None
    """The plan that is being driven."""
    times: StageTimes
    evidence: Evidence = NO_EVIDENCE
    """What camera and wheels say together."""
    trust: Level = Level.SURE
    """How far the robot's identity can be trusted."""
    troubles: tuple[str, ...] = ()
    """What people must know although the run goes on: a journal or log that cannot be written."""


@dataclass(frozen=True, slots=True)
class DrivenPlan:
    """A plan that was driven, and from when on, in the clock's seconds."""

    path: Path
    trajectory: Trajectory | None
    since_s: float

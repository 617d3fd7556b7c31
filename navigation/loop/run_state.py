"""State of a run after a cycle, for each robot and for all; driven plans.

The objects are immutable: any thread may keep and read them. Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from navigation.link.link_snapshot import LinkSnapshot, doubt_of_stop
from navigation.mission.mission import MissionProgress, State
from navigation.mission.trust import Level
from navigation.mission.watch import Verdict
from navigation.witness import NO_EVIDENCE, Evidence
from planner.path import Path, Trajectory
from planner.roadmap.roadmap import Roadmap
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose


@dataclass(frozen=True, slots=True)
class StageTimes:
    """Seconds that each stage last took."""

    look_s: float | None = None
    """Vision, one frame."""
    roadmap_s: float | None = None
    """From a new scene to its roadmap, in the planner's thread."""
    plan_s: float | None = None
    """From a request to its answer."""
    wire_s: float | None = None
    """From capture to the order on the wire, on the slowest link."""


@dataclass(frozen=True, slots=True)
class RobotSnapshot:
    """Everything known of one robot after a cycle."""

    time_s: float
    mission: MissionProgress
    sentence: str
    pose: RobotPose | None
    link: LinkSnapshot
    to_go_m: float | None
    clearance_m: float | None
    verdict: Verdict
    frame: Frame | None
    poses: Mapping[int, RobotPose]
    """Every robot in that picture, by marker id."""
    roadmap: Roadmap | None
    path: Path | None
    """The driven plan."""
    times: StageTimes
    evidence: Evidence = NO_EVIDENCE
    """Evidence of camera and wheels together."""
    trust: Level = Level.SURE
    """Trust in the robot's identity."""
    troubles: tuple[str, ...] = ()
    """Troubles that people must know of."""


@dataclass(frozen=True, slots=True)
class RunState:
    """Robots after a cycle by name, which is empty for a lone robot."""

    time_s: float
    robots: Mapping[str, RobotSnapshot]
    waits: Mapping[str, str] = field(default_factory=dict)
    """Sentence for each waiting robot: which one it waits for, and why."""
    rounds: int = 0
    """Number of plans asked for."""
    waits_for: Mapping[str, str] = field(default_factory=dict)
    """Robot awaited, for each that waits for one other robot."""

    @property
    def only(self) -> RobotSnapshot:
        """Robot of a run of one."""
        (robot,) = self.robots.values()
        return robot

    @property
    def together(self) -> RobotSnapshot:
        """Robot of a run of one; several combined, with the link that most needs attention."""
        each = list(self.robots.values())
        if "" in self.robots:
            return self.only
        paused = all(one.mission.paused for one in each)
        return replace(
            each[0],
            mission=MissionProgress(state=self.state, reason=self.sentence, paused=paused),
            sentence=self.sentence,
            pose=None,
            link=max((one.link for one in each), key=_unknown),
            to_go_m=None,
            clearance_m=None,
            path=None,
        )

    @property
    def is_over(self) -> bool:
        """True if nothing more will happen without a new order."""
        return all(one.mission.is_over or not one.mission.places for one in self.robots.values())

    @property
    def state(self) -> State:
        """State of a robot under way, or else the worst end."""
        if "" in self.robots:
            return self.only.mission.state
        states = [one.mission.state for one in self.robots.values() if one.mission.places]
        for state in (State.DRIVING, State.PROVING, State.PLANNING, State.HOLDING):
            if state in states:
                return state
        for state in (State.STOPPED, State.FAILED):
            if state in states:
                return state
        return State.DONE if State.DONE in states else State.IDLE

    @property
    def sentence(self) -> str:
        """Sentence of a lone robot, or of each robot not at its end."""
        if "" in self.robots:
            return self.only.sentence
        sentences = {
            name: self.waits.get(name) or one.sentence
            for name, one in self.robots.items()
            if one.mission.places and one.mission.state is not State.DONE
        }
        if not sentences:
            return "all robots are at rest at their goals"
        return "; ".join(f"{name}: {sentence}" for name, sentence in sentences.items())


def _unknown(link: LinkSnapshot) -> tuple[bool, bool, float]:
    """Sort key for how little is known, above all about rest after a stop."""
    age_s = math.inf if math.isnan(link.heard_age_s) else link.heard_age_s
    return doubt_of_stop(link) is not None, link.down_reason is not None, age_s


@dataclass(frozen=True, slots=True)
class DrivenPlan:
    """Driven plan and the time it started."""

    path: Path
    trajectory: Trajectory | None
    since_s: float

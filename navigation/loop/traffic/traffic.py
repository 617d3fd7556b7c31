"""Interface between the control loop and the planning and release of its robots.

Metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from navigation.fleet.orders import TrafficOrders
from navigation.fleet.request import Answer
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.planning import Answering, SceneCheck
from navigation.loop.robot import ControlledRobot
from navigation.mission.cycle import Orders, PlanAnswer, PlanRequest, Sight
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray, Vec
from planner.zones.rules import SPEED_SLACK, Rules


@dataclass(frozen=True, slots=True)
class Decided:
    """Decision of one robot's pilot in a cycle, and its inputs."""

    orders: Orders
    sight: Sight
    snapshot: LinkSnapshot


class TrafficPlanner(Answering[Any, Any], Protocol):
    """Planner with the newest scene's roadmap."""

    @property
    def roadmap(self) -> Roadmap | None:
        """Newest roadmap, without zones; None before the first scene."""
        ...

    def clearance_m(self, position: Vec) -> float | None:
        """Exact clearance of a place in the newest scene; None before the first."""

    def rules(self, robot: str) -> Rules | None:
        """Zones for a robot in the newest scene; None before the first."""


@dataclass(frozen=True, slots=True)
class PathCheck:
    """A running path's clearance in a new scene, and the sentence on a zone's rule it breaks."""

    robot: str
    clearance_m: float | None
    breach: str | None


class Traffic(Protocol):
    """Asks for plans, hands them out, and limits how far each robot may drive."""

    @property
    def planner(self) -> TrafficPlanner:
        """The planner."""
        ...

    @property
    def rounds(self) -> int:
        """Number of plans asked for, of all robots or of some that join driving ones."""
        ...

    @property
    def waits(self) -> Mapping[str, str]:
        """Sentences by waiting robot: which one it waits for, and why."""
        ...

    @property
    def waits_for(self) -> Mapping[str, str]:
        """Robot awaited, for each that waits for one other robot."""
        ...

    def checked_points(self) -> FloatArray | None:
        """Path (n, 2) whose clearance the planner's thread measures in each scene."""

    def checked(self, checks: Sequence[SceneCheck]) -> Iterable[PathCheck]:
        """Yield the check of each driven path in new scenes and zones."""
        ...

    def take(self, answer: Answer | None) -> Mapping[str, PlanAnswer]:
        """Take the planner's answer; return the pilots' answers in this cycle."""
        ...

    def step(self, now_s: float, decided: Mapping[str, Decided], revision: int) -> TrafficOrders:
        """Act on all pilots' decisions in the scene of this revision."""
        ...

    def released(self, name: str) -> int | None:
        """Number of targets that a robot may be sent; None: all."""

    def forget(self, name: str) -> None:
        """Forget the robot's promise, so that it is planned again."""

    def preview(self, name: str, request: PlanRequest) -> PlanAnswer:
        """Return one robot's plan alone; any thread may ask."""
        ...


def breach_of(robot: ControlledRobot, rules: Rules | None, *, zones_changed: bool) -> str | None:
    """Sentence on the zone's rule that the rest of a robot's plan breaks, or None.

    A changed zone breaks the path out of a keep-out zone too: it may not be the shortest.
    """
    plan, pose = robot.pilot.plan, robot.pose
    if rules is None or not rules.grounds or plan.path is None or pose is None:
        return None
    line = np.vstack([[(pose.x, pose.y)], plan.left])
    if zones_changed:
        inside = [one for one in rules.of("keep_out") if rules.is_held_by(one, (pose.x, pose.y))]
        if inside:
            return f"begins in {inside[0].zone}"
    left = plan.targets[plan.executed :]
    for place in ((t.x_m, t.y_m) for t in left if t.station is not None):
        for one in rules.of("wait"):
            if rules.is_held_by(one, place):
                return f"has a station in {one.zone}"
    speeds = np.array([t.speed_m_s for t in left])
    return rules.breach(line) or rules.too_fast(plan.left, speeds / SPEED_SLACK)

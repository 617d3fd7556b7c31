"""What the control loop needs of whoever plans for its robots and lets them drive.

Two do it: `alone` for one robot, which may drive all that was planned for it, and `coordinated`
for several, which drive as far as their common order lets them. Metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from navigation.fleet.request import Answer, Request
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.planning import Answering, SceneCheck
from navigation.mission.cycle import Orders, PlanAnswer, PlanRequest, Sight
from navigation.mission.mission import Station
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray, Vec


@dataclass(frozen=True, slots=True)
class Decided:
    """What one robot's pilot has decided in a cycle, and what it was told."""

    orders: Orders
    sight: Sight
    snapshot: LinkSnapshot


@dataclass(frozen=True, slots=True)
class TrafficOrders:
    """What follows from a cycle for the planner, and for robots by name."""

    request: Request | None = None
    plan_again: Sequence[tuple[str, str]] = ()
    """Robots whose pilots ask for a path anew, and why."""
    answers: Mapping[str, PlanAnswer] = field(default_factory=dict)
    """For pilots, in the next cycle."""
    holds: Mapping[str, str] = field(default_factory=dict)
    """Who holds for which robot in its path, in a sentence."""
    errands: Mapping[str, Station] = field(default_factory=dict)
    """New missions of robots that step aside."""


class TrafficPlanner(Answering[Any, Any], Protocol):
    """The planner that answers what `Traffic` asks, with the newest scene's roadmap."""

    @property
    def roadmap(self) -> Roadmap | None:
        """None before the first scene."""
        ...

    def clearance_m(self, position: Vec) -> float | None:
        """The exact clearance of a place in the newest scene; None before the first."""


class Traffic(Protocol):
    """Asks for plans, hands them out, and says how far each robot may drive."""

    @property
    def planner(self) -> TrafficPlanner:
        """Who plans."""
        ...

    @property
    def rounds(self) -> int:
        """How often all were planned together."""
        ...

    @property
    def waits(self) -> Mapping[str, str]:
        """Who waits for whom and why, in a sentence each."""
        ...

    @property
    def waits_for(self) -> Mapping[str, str]:
        """Of those in `waits` that wait for one other robot: for which."""
        ...

    def checked_points(self) -> FloatArray | None:
        """The path whose clearance the planner's thread measures in each new scene, (n, 2)."""

    def checked(self, checks: Sequence[SceneCheck]) -> Iterable[tuple[str, float | None]]:
        """After new scenes: by name, what clearance the paths that are driven have in them."""
        ...

    def take(self, answer: Answer | None) -> Mapping[str, PlanAnswer]:
        """Take over the planner's answer; what pilots are told of it in this very cycle."""
        ...

    def step(self, now_s: float, decided: Mapping[str, Decided], revision: int) -> TrafficOrders:
        """What follows from all pilots' decisions in the scene of this revision."""
        ...

    def released(self, name: str) -> int | None:
        """How many targets of its plan a robot may be sent; None: all."""

    def forget(self, name: str) -> None:
        """The robot is to be planned for anew."""

    def preview(self, name: str, request: PlanRequest) -> PlanAnswer:
        """The plan of one robot as if it were alone; any thread may ask."""
        ...

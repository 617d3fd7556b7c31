"""One robot alone: its pilot's requests go to the planner, and it may drive all of its plan."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from navigation.fleet.orders import TrafficOrders
from navigation.fleet.request import Answer
from navigation.loop.planning import ArenaPlanner, SceneCheck
from navigation.loop.robot import ControlledRobot
from navigation.loop.stages import plan_settings
from navigation.loop.traffic.traffic import Decided, PathCheck, breach_of
from navigation.mission.cycle import PlanAnswer, PlanRequest
from planner.scene import FloatArray


class Alone:
    """`Traffic` of a run with one robot."""

    rounds: Final = 0
    waits: Final[Mapping[str, str]] = {}
    waits_for: Final[Mapping[str, str]] = {}

    def __init__(self, robot: ControlledRobot) -> None:
        self._robot = robot
        self.planner = ArenaPlanner(plan_settings(robot.config), robot.name)

    def checked_points(self) -> FloatArray | None:
        """The driven path."""
        path = self._robot.pilot.plan.path
        return None if path is None else path.points

    def checked(self, checks: Sequence[SceneCheck]) -> Iterable[PathCheck]:
        """Report every scene, which may have closed the route."""
        for check in checks:
            breach = breach_of(
                self._robot, self.planner.rules(""), zones_changed=check.zones_changed
            )
            yield PathCheck(self._robot.name, check.path_clearance_m, breach)

    def take(self, answer: Answer | None) -> Mapping[str, PlanAnswer]:
        """Pass the planner's answer to the pilot."""
        return {self._robot.name: answer} if isinstance(answer, PlanAnswer) else {}

    def step(self, _now_s: float, decided: Mapping[str, Decided], _revision: int) -> TrafficOrders:
        """The pilot's request, unless it has stopped."""
        orders = decided[self._robot.name].orders
        return TrafficOrders(request=None if orders.estop else orders.request)

    def released(self, _name: str) -> int | None:
        """Release all."""
        return None

    def forget(self, _name: str) -> None:
        """Do nothing: no promise exists."""

    def preview(self, _name: str, request: PlanRequest) -> PlanAnswer:
        """Return the plan; any thread may ask."""
        return self.planner.answer(request, preview=True)

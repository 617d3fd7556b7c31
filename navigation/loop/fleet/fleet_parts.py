"""What the control loop of several robots needs around it, and each robot as orders see it.

In real time and in virtual time it is the same, as for one robot (`navigation.loop.parts`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from navigation.fleet.request import FleetAnswer, FleetRequest
from navigation.loop.fleet.fleet_planner import FleetPlanner
from navigation.loop.parts import Frames, Link, PlannerPart
from navigation.loop.planning import SceneCheck
from navigation.mission.mission import Station
from vision.calibration.calibration import Calibration


class FleetSurroundings(Protocol):
    """What a run of several robots is connected to."""

    @property
    def calibration(self) -> Calibration:
        """Where pixels lie on the floor."""
        ...

    def clock(self) -> float:
        """Monotonic seconds."""
        ...

    def wait(self, seconds: float) -> None:
        """Let time pass."""

    def make_frames(self) -> Frames:
        """The camera."""
        ...

    def make_link(self, name: str) -> Link:
        """The link to one robot."""
        ...

    def make_fleet_planner(
        self,
        planner: FleetPlanner,
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[FleetAnswer], None],
    ) -> PlannerPart[FleetRequest]:
        """The planner."""
        ...

    def start(self) -> None:
        """Switch simulated robots on."""

    def stop(self) -> None:
        """Switch them off."""


class TakesOrders(Protocol):
    """The daemon of several robots, as orders reach it; ``robot`` None: all of them."""

    def give(self, stations: tuple[Station, ...], robot: str | None = None) -> None:
        """A new mission."""

    def stop(self, reason: str, robot: str | None = None) -> None:
        """Emergency stop."""

    def pause(self, robot: str | None = None) -> None:
        """Hold."""

    def resume(self, robot: str | None = None) -> None:
        """Continue."""

    def replan(self, robot: str | None = None) -> None:
        """Plan again."""

    def settle(self) -> None:
        """Wait until a cycle has acted on the orders so far."""

    def describe(self, robot: str | None = None) -> dict[str, Any]:
        """The present state."""
        ...


class OneOfFleet:
    """One robot of several, taking the orders that a robot alone takes."""

    def __init__(self, fleet: TakesOrders, name: str) -> None:
        self._fleet, self._name = fleet, name

    def give(self, stations: tuple[Station, ...]) -> None:
        """A new mission; MissionError where it cannot be."""
        self._fleet.give(stations, self._name)

    def stop(self, reason: str) -> None:
        """Emergency stop of this robot, latched."""
        self._fleet.stop(reason, self._name)

    def pause(self) -> None:
        """Hold until resumed."""
        self._fleet.pause(self._name)

    def resume(self) -> None:
        """End a pause; after a stop re-arm, and the next time go on."""
        self._fleet.resume(self._name)

    def replan(self) -> None:
        """Plan again from where it is."""
        self._fleet.replan(self._name)

    def settle(self) -> None:
        """Return when the orders given so far were acted on, soon in any case."""
        self._fleet.settle()

    def describe(self) -> Mapping[str, Any]:
        """The present state, as JSON takes it."""
        return self._fleet.describe(self._name)

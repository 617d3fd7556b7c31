"""What the control loop of several robots needs around it.

In real time and in virtual time it is the same, as for one robot (`navigation.loop.parts`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from navigation.fleet.request import FleetAnswer, FleetRequest
from navigation.loop.fleet.fleet_planner import FleetPlanner
from navigation.loop.parts import Frames, Link, PlannerPart
from navigation.loop.planning import SceneCheck
from vision.calibration.calibration import Calibration
from vision.joined.floor_plan import FloorPlan


class FleetSurroundings(Protocol):
    """What a run of several robots is connected to."""

    @property
    def calibration(self) -> Calibration:
        """Where pixels lie on the floor, of the picture that people are shown."""
        ...

    @property
    def floor_plan(self) -> FloorPlan | None:
        """The floor under several cameras; None where there is one."""
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

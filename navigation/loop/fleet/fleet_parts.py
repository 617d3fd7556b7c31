"""What the control loop of several robots needs around it.

In real time and in virtual time it is the same, as for one robot (`navigation.loop.parts`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from navigation.fleet.request import FleetAnswer, FleetRequest
from navigation.loop.fleet.fleet_planner import FleetPlanner
from navigation.loop.parts import AnySurroundings, Link, PlannerPart
from navigation.loop.planning import SceneCheck


class FleetSurroundings(AnySurroundings, Protocol):
    """What a run of several robots is connected to."""

    def make_link(self, name: str) -> Link:
        """The link to one robot."""
        ...

    def search_clock(self) -> float:
        """The seconds by which a search for plans is limited."""
        ...

    def make_fleet_planner(
        self,
        planner: FleetPlanner,
        on_scene: Callable[[SceneCheck], None],
        on_answer: Callable[[FleetAnswer], None],
    ) -> PlannerPart[FleetRequest]:
        """The planner."""
        ...

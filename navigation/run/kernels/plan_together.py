"""Kernels that only several robots need: two discs pass each other."""

from __future__ import annotations

from navigation.config import Config
from navigation.fleet.planning import plan_promises
from navigation.fleet.request import FleetRequest, Taken, Traveller
from navigation.mission.mission import Station
from planner.motion.trajectory import default_limits
from planner.roadmap.roadmap import build_roadmap
from planner.scene import Bounds, Scene

RADIUS_M = 0.1


def plan_together(config: Config) -> None:
    """Plan for two robots in an empty arena, and around a third."""
    scene = Scene("m", Bounds(0.0, 0.0, 2.0, 1.0), ())
    roadmap = build_roadmap(scene, RADIUS_M)
    limits = default_limits(RADIUS_M)
    travellers = (
        Traveller("a", (0.2, 0.3, 0.0), Station(1.8, 0.3), RADIUS_M, limits),
        Traveller("b", (1.8, 0.3, 0.0), Station(0.2, 0.3), RADIUS_M, limits),
    )
    request = FleetRequest(0, 0, travellers, (Taken("c", 1.0, 0.8, RADIUS_M),))
    plan_promises(roadmap, scene, request, config.safety.other_robots_m)

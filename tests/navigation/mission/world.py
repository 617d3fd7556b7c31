"""A pilot with a scripted world around it: planner, robot and camera answer as a test says."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from navigation.mission.cycle import (
    Orders,
    PilotSettings,
    PlanAnswer,
    PlanRequest,
    RobotReport,
    Sight,
)
from navigation.mission.mission import State, Station
from navigation.mission.pilot import Pilot
from navigation.mission.targets import Target
from navigation.mission.traffic import TrafficLimits
from navigation.mission.watch import SafetyLimits
from planner.path import NoPath, Path
from planner.scene import Bounds

SETTINGS = PilotSettings(
    limits=SafetyLimits(0.2, 0.2, 0.3, 0.05, 0.1, 0.01),
    bounds_m=Bounds(0.0, 0.0, 2.4, 1.8),
    goal_tolerance_m=0.005,
    goal_tolerance_rad=0.02,
    settle_s=0.3,
    retry_s=1.0,
    robot_grace_s=1.0,
    replan_distance_m=0.15,
    give_up_s=30.0,
    circles_s=8.0,
    traffic=TrafficLimits(radius_m=0.1, speed_m_s=0.3, acceleration_m_s2=0.5, keep_m=0.03),
    corrections=2,
)
PERIOD_S = 1 / 30
SEEN = Sight(0.03, 0.03, (0.3, 0.3, 0.0), 1, 0.3)
LINKED = RobotReport(age_s=0.02, down_reason=None, place_m=(0.3, 0.3))


class World:
    """Answers plans at once; the robot reaches one waypoint a cycle while the lease permits."""

    def __init__(self, pilot: Pilot) -> None:
        self.pilot, self.now_s = pilot, 0.0
        self.sight, self.robot = SEEN, LINKED
        self.answer: PlanAnswer | None = None
        self.no_path: NoPath | None = None
        self.targets: tuple[Target, ...] = ()
        self.uploads: list[int] = []
        self.moves = True

    def cycle(self) -> Orders:
        self.now_s += PERIOD_S
        orders = self.pilot.step(self.now_s, self.sight, self.robot, self.answer)
        self.answer = None if orders.request is None else self.plan(orders.request)
        if orders.upload is not None:
            mission_id, self.targets = orders.upload
            self.uploads.append(mission_id)
            self.robot = replace(self.robot, mission_id=mission_id, executed=0)
        elif orders.permit and self.moves and self.robot.executed < len(self.targets):
            t = self.targets[self.robot.executed]
            self.robot = replace(self.robot, executed=self.robot.executed + 1)
            self.move(t)
        return orders

    def move(self, target: Target) -> None:
        """The robot is at a target, and camera and wheels have seen it turn alike."""
        assert self.sight.pose is not None
        heading_rad = target.heading_rad or 0.0
        turned_rad = math.remainder(heading_rad - self.sight.pose[2], math.tau)
        seen = self.sight.evidence
        self.sight = replace(
            self.sight,
            pose=(target.x_m, target.y_m, heading_rad),
            evidence=replace(
                seen,
                wheels_rad=seen.wheels_rad + turned_rad,
                camera_rad=seen.camera_rad + turned_rad,
            ),
        )
        self.robot = replace(self.robot, place_m=(target.x_m, target.y_m))

    def plan(self, request: PlanRequest) -> PlanAnswer:
        if self.no_path is not None:
            return PlanAnswer(request.id, request.scene_revision, self.no_path)
        stops = [request.start[:2], *((s.x, s.y) for s in request.stations)]
        targets, points = [], []
        for leg, (a, b) in enumerate(pairwise(stops)):
            for t in np.linspace(0.0, 1.0, 5)[leg > 0 :]:
                x, y = a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])
                station = leg if t == 0 else leg + 1 if t == 1 else None
                heading = request.stations[leg].heading_rad
                targets.append(Target(x, y, 0.3, t == 1, heading, station=station))
                points.append((x, y))
        polyline = np.array(points)
        length = float(np.hypot(*np.diff(polyline, axis=0).T).sum())
        path = Path(
            polyline, np.full(len(polyline), 0.3), length, 0.3, stops[0], 0.1, (0,), (None,)
        )
        return PlanAnswer(request.id, request.scene_revision, path, targets=tuple(targets))

    def run(self, cycles: int) -> list[Orders]:
        return [self.cycle() for _ in range(cycles)]

    def run_until(self, state: State, cycles: int = 200) -> None:
        for _ in range(cycles):
            self.cycle()
            if self.pilot.mission.state is state:
                return
        pytest.fail(f"never {state}: {self.pilot.mission}")


TOUR = (Station(1.0, 0.3), Station(1.0, 1.0, heading_rad=1.0))

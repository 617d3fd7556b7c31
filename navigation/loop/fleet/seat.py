"""One robot of several in the control loop: what the coordinator knows of it, and what it releases.

Metres, radians, seconds of the world's clock.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from navigation.config import Config
from navigation.fleet.places_kept import Member
from navigation.fleet.releases import Release
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.driven_robot import DrivenRobot
from navigation.loop.fleet.fleet_planner import limits_of_robot
from navigation.loop.parts import Link
from navigation.loop.reports import robot_report
from navigation.loop.seeing.eye_settings import reach_m, stop_s
from navigation.mission.cycle import Orders, PlanAnswer, RobotReport, Sight
from navigation.mission.mission import State
from navigation.mission.targets import to_wire
from navigation.mission.traffic import STANDING_M_S
from vision.markers.markers import RobotPose

BRAKES_S: Final = 0.3
"""After a lease: the last one's way over the line, wheels that begin to brake, the camera."""
STOOD_S: Final = 0.25
"""A robot that was seen to stand for so long stands."""


class Seat(DrivenRobot):
    """One robot of several, as the coordinator sees it and lets it drive."""

    def __init__(self, name: str, config: Config, link: Link, first_mission_id: int) -> None:
        super().__init__(name, config, link, first_mission_id)
        self.answer: PlanAnswer | None = None
        """What the pilot is told in the next cycle."""
        self.partner: str | None = None
        """The sentence that says which robot of the fleet is in the path."""
        self._limits = limits_of_robot(config)
        self._moved_s = math.inf
        self._permitted_s = -math.inf
        self._sent: tuple[int, int] | None = None
        """The plan's mission on the wire, and how many of its targets may be sent."""

    # What comes in.

    def sees(self, poses: Mapping[int, RobotPose], frame_s: float) -> RobotPose | None:
        """The newest picture's poses: the robot gets its own at once, if it is among them."""
        pose = super().sees(poses, frame_s)
        if pose is not None and (
            self._moved_s == math.inf or math.hypot(pose.vx, pose.vy) > STANDING_M_S
        ):
            self._moved_s = pose.captured_s
        return pose

    def report(self, snapshot: LinkSnapshot) -> RobotReport:
        """What the pilot is told of the robot.

        One that has driven all it was given waits for another robot: it is not idle.
        """
        report = robot_report(snapshot)
        if self._sent is not None and report.mission_id == self._sent[0]:
            count = self._sent[1]
            if report.executed >= count < len(self.pilot.plan.targets):
                return replace(report, standing_reason=None)
        return report

    def member(self, now_s: float, orders: Orders, snapshot: LinkSnapshot) -> Member:
        """What the coordinator needs to know."""
        pose, robot = self.pose, self.config.robot
        age_s = now_s - self.pose_arrived_s
        return Member(
            state=self.pilot.mission.state,
            pose=None if pose is None else (pose.x, pose.y, pose.heading_rad),
            pose_age_s=age_s,
            stands=self._stands(now_s, age_s, snapshot),
            radius_m=robot.radius_m,
            limits=self._limits,
            max_deviation_m=self.config.safety.max_deviation_m,
            reach_m=reach_m(robot, self.config.safety),
            executed=self.pilot.plan.executed if self.pilot.plan.path is not None else None,
            request=orders.request,
            sentence=self.pilot.mission.reason,
            obliging=self._is_obliging(age_s, snapshot),
            velocity=(0.0, 0.0, 0.0) if pose is None else (pose.vx, pose.vy, pose.turn_rate_rad_s),
            obeys=self._obeys(now_s),
            is_silent=snapshot.down_reason is not None,
            keep_m=self.config.safety.other_robots_m,
        )

    def _is_obliging(self, age_s: float, snapshot: LinkSnapshot) -> bool:
        mission = self.pilot.mission
        at_rest = mission.state in (State.IDLE, State.DONE) and not mission.remaining
        well = snapshot.down_reason is None and not snapshot.estopped and not mission.paused
        return at_rest and well and age_s <= self.config.safety.pose_stale_s

    def _obeys(self, now_s: float) -> bool:
        """Whether it is no faster than its brakes can have left it since its lease ran out."""
        if self.pose is None:
            return True
        robot = self.config.robot
        braked_s = now_s - self._permitted_s - self.config.safety.lease_s - BRAKES_S
        fastest = robot.speed_m_s - robot.acceleration_m_s2 * max(braked_s, 0.0)
        return math.hypot(self.pose.vx, self.pose.vy) <= max(fastest, 0.0) + STANDING_M_S

    @property
    def stop_s(self) -> float:
        """How long the robot can drive at most after it was seen last: lease, and brakes."""
        return stop_s(self.config.robot, self.config.safety)

    def _stands(self, now_s: float, age_s: float, snapshot: LinkSnapshot) -> bool:
        if self.pose is None:
            return True  # nobody knows: the coordinator refuses to plan
        if age_s > self.config.safety.pose_stale_s:
            return age_s > self.stop_s
        if snapshot.down_reason is None and snapshot.moving:
            return False
        return now_s - self._moved_s > STOOD_S

    # What goes out.

    def drive(self, orders: Orders, now_s: float, sight: Sight, release: Release | None) -> None:
        """Send what the cycle has decided, of the plan no more than is released."""
        if orders.permit:
            self._permitted_s = now_s
        others = orders if orders.upload is None else replace(orders, upload=None)
        self.carry_out(others, now_s, sight.pose_age_s)
        if orders.estop:
            self._sent = None
            return
        if orders.upload is not None:
            self._upload(orders, now_s, release)
        elif self._sent is not None and self.pilot.mission.state is State.DRIVING:
            self._release_more(release)
        if not orders.permit:
            self._sent = None

    def _upload(self, orders: Orders, now_s: float, release: Release | None) -> None:
        assert orders.upload is not None
        mission_id, targets = orders.upload
        if self.pilot.plan.path is None or orders.measure_latency:  # a turn on the spot
            self.link.upload(mission_id, to_wire(targets))
            return
        count = 0 if release is None else release.targets
        self._sent = mission_id, count
        self.keep_plan(now_s)
        self.link.upload(mission_id, to_wire(targets), True, count)

    def _release_more(self, release: Release | None) -> None:
        assert self._sent is not None
        mission_id, before = self._sent
        if release is None:
            return
        count = release.targets
        if count > before:
            self._sent = mission_id, count
            self.link.release(mission_id, count)


class Witnesses:
    """All robots are seen by the same eye: it is as late as the one that has measured most."""

    def __init__(self, seats: Mapping[str, Seat]) -> None:
        self._seats = seats

    def latency_s(self) -> float:
        """How late the camera's pictures are, as far as that was measured."""
        return max(seat.witness.latency_s() for seat in self._seats.values())

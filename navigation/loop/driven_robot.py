"""One driven robot in the control loop: its pilot, its link, and what camera and wheels say of it.

Metres, radians, seconds of the world's clock.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Final

from firmware_protocol.host.events import StatusReceived
from navigation.config import Config
from navigation.journal.journal import Journal, SentPlan
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.daemon_state import DaemonState, DrivenPlan, StageTimes
from navigation.loop.parts import Link
from navigation.loop.punctuality import Punctuality
from navigation.loop.reports import camera_reason, to_go_m
from navigation.loop.robot_orders import RobotOrders
from navigation.loop.seeing.arena_view import ArenaView
from navigation.loop.stages import pilot_settings, witness_limits
from navigation.mission.cycle import Orders, Sight
from navigation.mission.pilot import Pilot
from navigation.mission.trust import Level
from navigation.shared.track import Track
from navigation.witness import NO_EVIDENCE, Witness
from planner.roadmap.roadmap import Roadmap
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose

PLANS_KEPT: Final = 200


class DrivenRobot:
    """One robot's parts, its pose, and what it was given; ``name`` is empty where it is alone.

    ``first_mission_id``: ids on the wire count up from the one after it.
    """

    def __init__(self, name: str, config: Config, link: Link, first_mission_id: int) -> None:
        self.name, self.config, self.link = name, config, link
        self.pilot = Pilot(pilot_settings(config), first_mission_id)
        self.orders = RobotOrders(link, config)
        self.witness = Witness(witness_limits(config))
        self.pose: RobotPose | None = None
        self.pose_arrived_s = -math.inf
        self.plans: deque[DrivenPlan] = deque(maxlen=PLANS_KEPT)
        self.sightings = Track()
        self.evidence = NO_EVIDENCE
        self.journal: Journal | None = None
        self.clearance_m: float | None = None

    # What comes in.

    def sees(self, poses: Mapping[int, RobotPose], frame_s: float) -> RobotPose | None:
        """The newest picture's poses: the robot gets its own at once, if it is among them."""
        pose = poses.get(self.config.robot.marker_id)
        if pose is None:
            return None
        self.link.pose_fix(pose.x, pose.y, pose.heading_rad, pose.captured_s)
        self.pose, self.pose_arrived_s = pose, frame_s
        self.witness.saw(pose, frame_s - pose.before_frame_s)
        if self.pilot.trust.level is not Level.DOUBTED:  # else something else has moved it
            self.sightings.add(pose.captured_s, pose.x, pose.y, pose.heading_rad)
        return pose

    def hears(self) -> None:
        """The wheels' side of the story: every report, for a loop that is late has several."""
        for event in self.link.events():
            if isinstance(event, StatusReceived):
                self.witness.report(event.status, event.at_s)
        self.evidence = self.witness.evidence()

    def sight(
        self,
        now_s: float,
        view: ArenaView,
        camera: CameraStatus,
        known_revision: int,
        clearance_m: Callable[[tuple[float, float]], float | None],
        *,
        failed: str | None,
        hold: str | None,
        punctuality: Punctuality,
        partner: str | None = None,
    ) -> Sight:
        """What the pilot is told of camera and arena.

        ``clearance_m`` measures in the scene of ``known_revision``; ``partner`` says which
        robot of several is in the path.
        """
        place = None if self.pose is None else self.witness.carried(self.pose, now_s)
        measurable = place is not None and view.is_measurable(known_revision)
        self.clearance_m = clearance_m(place[:2]) if measurable and place is not None else None
        double = view.glimpse.doubles.get(self.config.robot.marker_id)
        return Sight(
            frame_age_s=now_s - view.frame_s,
            pose_age_s=now_s - self.pose_arrived_s,
            pose=place,
            scene_revision=known_revision,
            clearance_m=self.clearance_m,
            failed=failed,
            camera_reason=camera_reason(camera),
            others=view.others.movers(now_s),
            doubles=() if double is None else (double,),
            evidence=self.evidence,
            scene_doubt=hold,
            partner=partner,
            late=punctuality.doubt(now_s),
            blind=punctuality.hold(now_s),
        )

    # What goes out.

    def write_journal(self, orders: Orders, now_s: float) -> str:
        """Keep mission, progress and the plan before they take effect; the trouble with it."""
        mission = self.pilot.mission
        if self.journal is None or not mission.stations:
            return ""
        sent = None
        if orders.upload is not None:
            sent = SentPlan(orders.upload[0], mission.visited, orders.upload[1])
        self.journal.keep(mission, sent, now_s)
        return self.journal.trouble

    def carry_out(self, orders: Orders, now_s: float, pose_age_s: float) -> None:
        """Send what the cycle has decided."""
        self.orders.carry_out(orders, now_s, pose_age_s)
        if orders.estop:
            return
        if orders.measure_latency:
            self.witness.measure_again()
        if orders.upload is not None:
            self.keep_plan(now_s)

    def keep_plan(self, now_s: float) -> None:
        """Remember what is driven from now on; a turn on the spot has no path."""
        plan = self.pilot.plan
        if plan.path is not None:
            self.plans.append(DrivenPlan(plan.path, plan.trajectory, now_s))

    def state(
        self,
        time_s: float,
        view: ArenaView,
        snapshot: LinkSnapshot,
        roadmap: Roadmap | None,
        times: StageTimes,
        troubles: tuple[str, ...],
        sentence: str | None = None,
    ) -> DaemonState:
        """What people are told after a cycle, ``time_s`` after the start."""
        mission = self.pilot.mission
        return DaemonState(
            time_s=time_s,
            mission=mission,
            sentence=sentence or mission.reason,
            pose=self.pose,
            link=snapshot,
            to_go_m=to_go_m(self.pose, self.pilot.plan.targets, snapshot.executed),
            clearance_m=self.clearance_m,
            verdict=self.pilot.verdict,
            frame=view.frame,
            poses=view.glimpse.poses,
            roadmap=roadmap,
            path=self.pilot.plan.path,
            times=times,
            evidence=self.evidence,
            trust=self.pilot.trust.level,
            troubles=tuple(filter(None, (*troubles, self._stop_to_leave(), snapshot.remark))),
        )

    def _stop_to_leave(self) -> str:
        """What to do about an emergency stop of the robot's own while it has no mission."""
        why = self.pilot.stands_stopped
        return "" if why is None else f"{why}; re-arm it before it is to drive (clearway resume)"

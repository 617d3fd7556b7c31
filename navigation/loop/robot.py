"""One driven robot in the control loop: pilot, link, and readings of camera and wheels.

Metres, radians, seconds of the world's clock.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from firmware_protocol.host.events import LinkChanged, RobotRebooted, StatusReceived
from firmware_protocol.host.state import LinkState
from navigation.config import Config
from navigation.journal.journal import Journal, SentPlan
from navigation.link.link_snapshot import LinkSnapshot
from navigation.link.robot_link import RobotLink
from navigation.loop.punctuality import Punctuality
from navigation.loop.reports import camera_reason, robot_report, to_go_m
from navigation.loop.robot_orders import RobotOrders
from navigation.loop.run_state import DrivenPlan, RobotSnapshot, StageTimes
from navigation.loop.seeing.arena_view import ArenaView
from navigation.loop.stages import pilot_settings, witness_limits
from navigation.mission.cycle import Orders, PlanAnswer, RobotReport, Sight
from navigation.mission.mission import State
from navigation.mission.pilot import Pilot
from navigation.mission.targets import to_wire
from navigation.mission.traffic import STANDING_M_S
from navigation.mission.trust import Level
from navigation.shared.track import Track
from navigation.witness import NO_EVIDENCE, Witness
from planner.roadmap.roadmap import Roadmap
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose

PLANS_KEPT: Final = 200


class ControlledRobot:
    """Parts, pose and answers of one robot; ``name`` is empty for a lone robot."""

    def __init__(self, name: str, config: Config, link: RobotLink, first_mission_id: int) -> None:
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
        self.answer: PlanAnswer | None = None
        """Input of the pilot's next cycle."""
        self.partner: str | None = None
        """Sentence on the robot of the fleet that is in the path."""
        self.moved_s = math.inf
        """Time when it was last seen to move."""
        self.permitted_s = -math.inf
        """Time when it was last permitted to drive."""
        self._sent: tuple[int, int] | None = None
        """A plan's mission on the wire and the targets to be sent, if not all."""

    def sees(self, poses: Mapping[int, RobotPose], frame_s: float) -> None:
        """Take the newest poses and send the robot its own at once."""
        pose = poses.get(self.config.robot.marker_id)
        if pose is None:
            return
        self.link.pose_fix(pose.x, pose.y, pose.heading_rad, pose.captured_s)
        self.pose, self.pose_arrived_s = pose, frame_s
        self.witness.saw(pose, frame_s - pose.before_frame_s)
        if self.pilot.trust.level is not Level.DOUBTED:  # else something else has moved it
            self.sightings.add(pose.captured_s, pose.x, pose.y, pose.heading_rad)
        if self.moved_s == math.inf or math.hypot(pose.vx, pose.vy) > STANDING_M_S:
            self.moved_s = pose.captured_s

    def hears(self) -> None:
        """Read every report of the wheels: a late loop has several."""
        for event in self.link.events():
            match event:
                case StatusReceived():
                    self.witness.report(event.status, event.at_s)
                case RobotRebooted():  # two robots may have been swapped on their ports
                    why = "the robot has rebooted, or another is on its port"
                    self.pilot.trust.may_be_another(why)
                case LinkChanged(new=LinkState.CLOSED):
                    why = "its port was closed: another robot may be there now"
                    self.pilot.trust.may_be_another(why)
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
    ) -> Sight:
        """The pilot's view of arena and camera; ``clearance_m`` measures in ``known_revision``."""
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
            partner=self.partner,
            late=punctuality.doubt(now_s),
            blind=punctuality.hold(now_s),
        )

    def report(self, snapshot: LinkSnapshot) -> RobotReport:
        """The pilot's view of the robot; one that has driven all it was given is not idle."""
        report = robot_report(snapshot)
        if self._sent is not None and report.mission_id == self._sent[0]:
            count = self._sent[1]
            if report.executed >= count < len(self.pilot.plan.targets):
                return replace(report, standing_reason=None)
        return report

    def write_journal(self, orders: Orders, now_s: float) -> str:
        """Save mission, progress and plan before they take effect; return any trouble."""
        mission = self.pilot.mission
        if self.journal is None or not (mission.stations or self._journal_is_stale()):
            return ""
        sent = None
        if orders.upload is not None:
            sent = SentPlan(orders.upload[0], mission.visited, orders.upload[1])
        self.journal.keep(mission, sent, now_s)
        return self.journal.trouble

    def _journal_is_stale(self) -> bool:
        kept = None if self.journal is None else self.journal.mission()
        has_more = kept is not None and bool(kept.remaining)
        return has_more and self.pilot.mission.state is State.DONE

    def drive(self, orders: Orders, now_s: float, sight: Sight, released: int | None) -> None:
        """Send the cycle's decision; ``released`` targets of a plan, None: all."""
        if orders.permit:
            self.permitted_s = now_s
        self.orders.carry_out(orders, now_s, sight.pose_age_s)
        if orders.estop:
            self._sent = None
            return
        if orders.measure_latency:
            self.witness.measure_again()
        if orders.upload is not None:
            self._upload(orders, now_s, released)
        elif self._sent is not None and self.pilot.mission.state is State.DRIVING:
            self._release_more(released)
        if not orders.permit:
            self._sent = None

    def _upload(self, orders: Orders, now_s: float, released: int | None) -> None:
        assert orders.upload is not None
        (mission_id, targets), plan = orders.upload, self.pilot.plan
        on_the_spot = plan.path is None or orders.measure_latency
        if plan.path is not None and not on_the_spot:
            self.plans.append(DrivenPlan(plan.path, plan.trajectory, now_s))
        if on_the_spot or released is None:
            self.link.upload(mission_id, to_wire(targets))
            return
        self._sent = mission_id, released
        self.link.upload(mission_id, to_wire(targets), True, released)

    def _release_more(self, released: int | None) -> None:
        assert self._sent is not None
        mission_id, before = self._sent
        if released is not None and released > before:
            self._sent = mission_id, released
            self.link.release(mission_id, released)

    def state(
        self,
        time_s: float,
        view: ArenaView,
        snapshot: LinkSnapshot,
        roadmap: Roadmap | None,
        times: StageTimes,
        troubles: tuple[str, ...],
        waits: str | None,
    ) -> RobotSnapshot:
        """State to report, ``time_s`` after the start."""
        mission = self.pilot.mission
        return RobotSnapshot(
            time_s=time_s,
            mission=mission,
            sentence=waits or mission.reason,
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
        why = self.pilot.stop_without_mission
        return "" if why is None else f"{why}; re-arm it before it is to drive (clearway resume)"


class Witnesses:
    """Latency of the shared eye: the largest that a witness measured."""

    def __init__(self, robots: Mapping[str, ControlledRobot]) -> None:
        self._robots = robots

    def latency_s(self) -> float:
        """Measured delay of the camera's pictures."""
        return max(one.witness.latency_s() for one in self._robots.values())

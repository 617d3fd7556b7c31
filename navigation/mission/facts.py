"""Facts for the safety rules in a cycle, from the reports of camera and link.

They depend on the robot's task: only a robot ordered to move can be idle, and a late camera about
to be measured again is not yet too late. Metres, seconds.
"""

from __future__ import annotations

from typing import NamedTuple

from navigation.mission.cycle import PilotSettings, RobotReport, Sight
from navigation.mission.late_pictures import LateCamera
from navigation.mission.mission import MissionProgress, State
from navigation.mission.running_plan import RunningPlan
from navigation.mission.stillness import MOTIONLESS, RobotStillness, is_to_move
from navigation.mission.targets import Target
from navigation.mission.traffic import Encounter
from navigation.mission.trust import Trust
from navigation.mission.watch import Facts


class PilotSituation(NamedTuple):
    """The pilot's mission, its plan, and their mission on the wire."""

    mission: MissionProgress
    plan: RunningPlan
    wire_id: int
    rearms: bool
    """True if the robot is about to leave its emergency stop."""
    stop_ordered: bool
    """True if it was ordered to stop: its own emergency stop is then no second reason."""


class FactFinder:
    """Times without driving or motion, and the camera's latency that counts."""

    def __init__(self, settings: PilotSettings, trust: Trust) -> None:
        self.late_camera = LateCamera()
        self.stillness = RobotStillness()
        self._settings, self._trust = settings, trust
        self._idle_since_s: float | None = None

    def facts(
        self,
        now_s: float,
        sight: Sight,
        robot: RobotReport,
        situation: PilotSituation,
        met: Encounter | None,
    ) -> Facts:
        """Facts of one cycle; ``met`` is the robot that comes near, if any."""
        mission, plan, wire_id, rearms, stop_ordered = situation
        position = None if sight.pose is None else sight.pose[:2]
        driving = mission.state is State.DRIVING
        running = driving and robot.mission_id == wire_id
        parted = None if sight.evidence.parted is None else sight.late or sight.evidence.parted
        return Facts(
            frame_age_s=sight.frame_age_s,
            pose_age_s=sight.pose_age_s,
            link_age_s=robot.age_s,
            link_down_reason=robot.down_reason,
            robot_estopped=robot.estopped and not (rearms or stop_ordered or robot.leaving_estop),
            robot_fault=robot.fault,
            robot_disarmed=robot.disarmed and running,
            robot_idle_reason=self._idle_reason(now_s, sight, robot, situation),
            position_m=position,
            inside_arena=position is None or self._settings.bounds_m.contains(position),
            clearance_m=sight.clearance_m,
            deviation_m=plan.deviation_m(position) if driving else None,
            paused=mission.paused,
            near_robot=None if met is None or met.stands else met.sentence,
            failed=sight.failed,
            camera_reason=sight.camera_reason,
            doubles=sight.doubles,
            parted=parted if mission.state is not State.PROVING else None,
            latency_s=self._latency_that_matters(now_s, sight, mission.state),
            scene_doubt=sight.scene_doubt,
            partner=sight.partner,
        )

    def _latency_that_matters(self, now_s: float, sight: Sight, state: State) -> float | None:
        late_s = sight.evidence.latency_s
        if state is State.PROVING or late_s is None:
            return None
        if not self._settings.turns_on_spot:
            return late_s
        return self.late_camera.look(now_s, late_s, self._settings.limits.latency_s, self._trust)

    def _idle_reason(
        self, now_s: float, sight: Sight, robot: RobotReport, situation: PilotSituation
    ) -> str | None:
        """Why a robot with time to begin does not drive its plan, which then makes it doubted.

        While it holds and can get no lease, that is the reason.
        """
        targets = situation.plan.targets
        ours = robot.mission_id == situation.wire_id
        runs = ours and robot.standing_reason is None
        ordered = situation.mission.state is State.DRIVING and bool(targets)
        finished = ours and robot.executed >= len(targets)
        if ordered and runs and not finished:
            self._idle_since_s = None
            return self._motionless(now_s, sight, robot, targets[robot.executed])
        self.stillness.reset()
        if situation.mission.state is State.HOLDING and robot.no_permit is not None:
            return robot.no_permit
        if not ordered or finished:
            self._idle_since_s = None
            return None
        if self._idle_since_s is None:
            self._idle_since_s = now_s
        if now_s - self._idle_since_s < self._settings.robot_grace_s:
            return None
        reason = (robot.standing_reason if ours else None) or "it has not taken the plan"
        self._trust.doubt(f"the robot stands still: {reason}")
        return reason

    def _motionless(
        self, now_s: float, sight: Sight, robot: RobotReport, target: Target
    ) -> str | None:
        if not is_to_move(robot, target, None if sight.pose is None else sight.pose[:2]):
            self.stillness.reset()
            return None
        if not self.stillness.look(now_s, sight.evidence):
            return None
        self._trust.doubt(f"the robot stands still: {MOTIONLESS}")
        return MOTIONLESS

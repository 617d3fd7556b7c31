"""The pilot: every decision of a control cycle, sans-IO.

`Pilot.step` takes what one cycle knows (`Sight`, `RobotReport`, the planner's answer, the time)
and returns what to do (`Orders`). It opens nothing, waits for nothing and reads no clock, so
the same pilot runs in the daemon, in virtual time and in replay. Units: metres, radians,
seconds.

One cycle: judge safety -> follow progress -> move the mission's state -> orders. Every order
to move is a lease that this cycle gives; a pilot that is not stepped moves nothing.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from navigation.mission.cycle import (
    Orders,
    PilotSettings,
    PlanAnswer,
    PlanRequest,
    RobotReport,
    Sight,
)
from navigation.mission.mission import Event, Mission, MissionError, State, Station
from navigation.mission.progress import Progress
from navigation.mission.slowing import WORTH_A_PLAN, speed_with
from navigation.mission.targets import Target
from navigation.mission.traffic import Encounter, discs_to_avoid, encounter
from navigation.mission.trust import NEAR_M, Level, Proof, Trust, slow_at_first
from navigation.mission.trust import Verdict as ProofVerdict
from navigation.mission.watch import Action, Facts, Verdict, judge
from planner.path import NoPath, Path, Trajectory
from planner.scene import FloatArray

NO_WAY: FloatArray = np.empty((0, 2))
MEASURE_AGAIN_S = 10.0
"""A camera that was too late is measured again so long after."""


class Pilot:
    """Keeps the mission, the running plan and the robot's progress along it."""

    def __init__(self, settings: PilotSettings, first_mission_id: int) -> None:
        self.settings = settings
        self.mission = Mission()
        self.verdict = Verdict(Action.HOLD, ("nothing was seen yet",))
        self.path: Path | None = None
        self.trajectory: Trajectory | None = None
        self.targets: tuple[Target, ...] = ()
        self.replans = 0
        self.plans = 0
        self.waypoints_sent = 0
        self.waypoints_executed = 0
        self._stop_reason: str | None = None
        self._rearm = False
        self._estopped = False
        self._mission_id = first_mission_id
        self._request_id = 0
        self._asked: PlanRequest | None = None
        self._ask_again_s = -math.inf
        self._clear_since_s: float | None = None
        self._path_start_index = 0
        self._corrections = 0
        self._executed_here = 0
        self._standing_since_s: float | None = None
        self._idle_since_s: float | None = None
        self._progress = Progress()
        self.trust = Trust()
        self._proof: Proof | None = None
        self._measure_again_s: float | None = None
        self._planned_m_s = math.inf
        self._planned_revision = 0
        self._closed_way: FloatArray = NO_WAY
        self.no_path = False
        """Whether the last plan asked for could not be made."""
        self.has_met_its_devices = False
        """Whether robot and camera have both been there; until then no mission is given up."""

    # Orders from people: taken at once, acted on in the next cycle.

    def give(self, stations: tuple[Station, ...], *, any_order: bool = False) -> None:
        """Replace the mission; ``MissionError`` where a station lies outside the arena."""
        if self.mission.state is State.STOPPED:
            raise MissionError("the robot is stopped: re-arm it first (clearway resume)")
        for number, station in enumerate(stations, 1):
            if not self.settings.bounds_m.contains((station.x, station.y)):
                raise MissionError(
                    f"station {number} at ({station.x:g}, {station.y:g}) m: outside the arena"
                )
        self.mission = self.mission.given(stations, "a mission was given", any_order=any_order)
        self._forget_plan()
        self._begin_again()

    def _begin_again(self) -> None:
        """What counts the troubles of a mission counts from here."""
        self._corrections = 0
        self._progress.begin()

    def restore(self, mission: Mission) -> None:
        """Go on with a mission that an earlier program left unfinished; planned anew."""
        given = self.mission.given(mission.stations, "going on after a restart")
        self.mission = replace(
            given, visited=mission.visited, any_order=mission.any_order, paused=mission.paused
        )
        self._forget_plan()
        self.trust.doubt("the program was started again")

    def stop(self, reason: str) -> None:
        """Emergency stop: latched until `rearm`."""
        self._stop_reason = reason

    def pause(self) -> None:
        """Hold where the robot is, until `resume`."""
        self.mission = replace(self.mission, paused=True)

    def resume(self) -> None:
        """The one order that lets a robot go again; each time one step.

        After a pause the mission goes on, planned anew from where the robot is. After an
        emergency stop the robot is re-armed and stands; resumed once more it goes on with the
        stations that are left. A failed mission is tried again.
        """
        self.mission = replace(self.mission, paused=False)
        if self.mission.state is State.STOPPED:
            self._leave_stop()
        elif self.mission.state in (State.IDLE, State.FAILED) and self.mission.remaining:
            self.mission = self.mission.after(Event.GIVEN, "going on as ordered")
            self._forget_plan()
            self._begin_again()
            self.trust.vouch()
        elif self._estopped:
            self._rearm = True  # a robot that was stopped before we came

    def _leave_stop(self) -> None:
        left = len(self.mission.remaining)
        what = f"resume goes on with {left} station{'s' * (left != 1)}, " if left else ""
        self.mission = self.mission.after(
            Event.REARM, f"re-armed by hand: {what}go gives a new mission"
        )
        self._stop_reason = None
        self._rearm = True
        self.trust.vouch()

    def replan(self) -> None:
        """Plan anew from where the robot is; without a mission under way nothing happens."""
        if self.mission.state is State.DRIVING:
            self.mission = self.mission.after(Event.REPLAN, "a new plan was asked for")
            self._forget_plan()

    # The cycle.

    def step(
        self,
        now_s: float,
        sight: Sight,
        robot: RobotReport,
        answer: PlanAnswer | None = None,
    ) -> Orders:
        """One control cycle; see the module's text for its order."""
        met = self._look_at_traffic(sight)
        self._look_at_identity(sight)
        self.verdict = judge(self._facts(now_s, sight, robot, met), self.settings.limits)
        if self._stop_reason is not None:
            self.verdict = Verdict(Action.STOP, (self._stop_reason, *self.verdict.reasons))
        rearm = self._take_rearm(robot)
        was = self.mission.state
        if self.verdict.action is Action.STOP:
            self._enter_stop(robot)
        if self.mission.state is State.STOPPED:
            return Orders(permit=False, estop=True)
        self._follow_progress(robot)
        upload = self._take_answer(now_s, sight, answer)
        self._hold_or_go_on(now_s)
        self._make_way(met)
        self._slow_down(sight)
        proof = self._prove(now_s, sight, robot)
        self._give_up(now_s, sight, robot)
        self._finish(now_s, sight, robot)
        moves = (State.DRIVING, State.PROVING)
        moving = self.mission.state in moves
        return Orders(
            permit=moving,
            request=self._ask(now_s, sight),
            upload=(proof or upload) if moving else None,
            halt=was in moves and not moving,
            rearm=rearm,
            measure_latency=proof is not None,
        )

    def _look_at_identity(self, sight: Sight) -> None:
        """Whether camera and wheels still speak of one robot."""
        lost = sight.pose is not None and sight.pose_age_s > self.settings.limits.pose_stale_s
        refuted = self.trust.look(sight.evidence, "the robot was lost from view" if lost else None)
        if refuted is not None and self._stop_reason is None:
            self._stop_reason = refuted

    def _slow_down(self, sight: Sight) -> None:
        """A slower plan where the pictures have become later than the present one allows."""
        allowed_m_s = self._allowed_m_s(sight)
        if self.mission.state is State.DRIVING and allowed_m_s < WORTH_A_PLAN * self._planned_m_s:
            late_s = sight.evidence.longest_latency_s
            self.mission = self.mission.after(
                Event.REPLAN, f"the camera's pictures are {late_s:.2f} s old: planning more slowly"
            )
            self._forget_plan()

    def _allowed_m_s(self, sight: Sight) -> float:
        robot = self.settings.traffic
        return speed_with(
            sight.evidence.longest_latency_s, robot.speed_m_s, robot.acceleration_m_s2
        )

    def _prove(
        self, now_s: float, sight: Sight, robot: RobotReport
    ) -> tuple[int, tuple[Target, ...]] | None:
        """Let a doubted robot turn on the spot, and look at what the camera makes of it."""
        if self.mission.state is State.PROVING:
            self._judge_proof(now_s, sight, robot)
            return None
        self._proof = None
        if self.mission.state is not State.PLANNING or self.trust.level is not Level.DOUBTED:
            return None
        evidence = sight.evidence
        if sight.pose is None or robot.place_m is None or not evidence.wheels_stand:
            return None
        self._stop_reason = self.trust.moved(evidence)
        if self._stop_reason is not None:
            return None
        if not self.settings.turns_on_spot:
            self.trust.proved(evidence)
            return None
        if math.dist(robot.place_m, sight.pose[:2]) > NEAR_M:
            return None
        self._measure_again_s = None
        self._mission_id = self._next_id()
        self._proof = Proof(self._mission_id, now_s, evidence)
        self.mission = self.mission.after(
            Event.PROVE, f"{self.trust.why}: the robot turns a little to prove itself"
        )
        return self._mission_id, self.trust.turn(robot.place_m, sight.pose[2])

    def _judge_proof(self, now_s: float, sight: Sight, robot: RobotReport) -> None:
        assert self._proof is not None
        done = robot.mission_id == self._proof.mission_id and robot.executed >= 1
        verdict, sentence = self._proof.judge(now_s, sight.evidence, done)
        if verdict is ProofVerdict.PROVED:
            self._stop_reason = self.trust.moved(sight.evidence)
        if verdict is ProofVerdict.PROVED and self._stop_reason is None:
            self.trust.proved(sight.evidence)
            self.mission = self.mission.after(Event.PROVED, "the robot has proved itself")
        elif verdict is ProofVerdict.REFUTED:
            self._stop_reason = sentence
        elif verdict is ProofVerdict.STILL:
            self.mission = self.mission.after(Event.HOLD, sentence)
            self._ask_again_s = now_s + self.settings.retry_s
            self._clear_since_s = None

    def _next_id(self) -> int:
        return (self._mission_id + 1) & 0xFFFFFFFF or 1

    def _look_at_traffic(self, sight: Sight) -> Encounter | None:
        """What other robots ask for; while holding for one, the way that it had closed counts."""
        if sight.pose is None:
            return None
        left = [(t.x_m, t.y_m) for t in self.targets[self._executed_here :]]
        way = np.array(left) if left else self._closed_way
        return encounter(sight.pose[:2], way, sight.others, self.settings.traffic)

    def _make_way(self, met: Encounter | None) -> None:
        """Another plan around a robot that stands in the way."""
        if self.mission.state is State.DRIVING and met is not None and met.stands:
            self.mission = self.mission.after(Event.REPLAN, f"{met.sentence}: planning around it")
            self._forget_plan()

    def _facts(
        self, now_s: float, sight: Sight, robot: RobotReport, met: Encounter | None
    ) -> Facts:
        position = None if sight.pose is None else sight.pose[:2]
        driving = self.mission.state is State.DRIVING
        running = driving and robot.mission_id == self._mission_id
        return Facts(
            frame_age_s=sight.frame_age_s,
            pose_age_s=sight.pose_age_s,
            link_age_s=robot.age_s,
            link_down_reason=robot.down_reason,
            robot_estopped=robot.estopped and not (self._rearm or robot.leaving_estop),
            robot_disarmed=robot.disarmed and running,
            robot_idle_reason=self._idle_reason(now_s, robot),
            position_m=position,
            inside_arena=position is None or self.settings.bounds_m.contains(position),
            clearance_m=sight.clearance_m,
            deviation_m=self._deviation_m(position) if driving else None,
            paused=self.mission.paused,
            near_robot=None if met is None or met.stands else met.sentence,
            failed=sight.failed,
            camera_reason=sight.camera_reason,
            doubles=sight.doubles,
            parted=sight.evidence.parted if self.mission.state is not State.PROVING else None,
            latency_s=self._latency_that_matters(now_s, sight),
            scene_doubt=sight.scene_doubt,
        )

    def _latency_that_matters(self, now_s: float, sight: Sight) -> float | None:
        """The camera's latency, but while it is being measured again, or is about to be."""
        late_s = sight.evidence.latency_s
        if self.mission.state is State.PROVING or late_s is None:
            return None
        if late_s <= self.settings.limits.latency_s or not self.settings.turns_on_spot:
            self._measure_again_s = None
            return late_s
        if self._measure_again_s is None:
            self._measure_again_s = now_s + MEASURE_AGAIN_S
            self.trust.doubt("the camera's pictures were too late")
        return late_s if now_s < self._measure_again_s else None

    def _take_rearm(self, robot: RobotReport) -> bool:
        """Whether the robot is to be told in this cycle that it may leave its stop."""
        rearm, self._rearm, self._estopped = self._rearm, False, robot.estopped
        return rearm

    def _idle_reason(self, now_s: float, robot: RobotReport) -> str | None:
        """Why the robot does not do what it was told, once it had time to begin."""
        if self.mission.state is not State.DRIVING or not self.targets:
            self._idle_since_s = None
            return None
        ours = robot.mission_id == self._mission_id
        finished = ours and robot.executed >= len(self.targets)
        if finished or (ours and robot.standing_reason is None):
            self._idle_since_s = None
            return None
        if self._idle_since_s is None:
            self._idle_since_s = now_s
        if now_s - self._idle_since_s < self.settings.robot_grace_s:
            return None
        return (robot.standing_reason if ours else None) or "it has not taken the plan"

    def _deviation_m(self, position: tuple[float, float] | None) -> float | None:
        if position is None or self.path is None:
            return None
        return distance_to_polyline(self.path.points, position)

    def _enter_stop(self, robot: RobotReport) -> None:
        idle = self.mission.state in (State.IDLE, State.DONE, State.FAILED)
        if robot.estopped and idle and self._stop_reason is None:
            return  # a robot that was stopped before we came: it is said when a mission is given
        if self.mission.state is not State.STOPPED:
            self.mission = self.mission.after(Event.STOP, self.verdict.sentence)
            self._forget_plan()

    def _follow_progress(self, robot: RobotReport) -> None:
        if not self.targets or robot.mission_id != self._mission_id:
            return
        executed = min(robot.executed, len(self.targets))
        self.waypoints_executed += max(0, executed - self._executed_here)
        self._executed_here = max(self._executed_here, executed)
        passed = [t.station for t in self.targets[:executed] if t.station is not None]
        last = len(self.mission.stations) - 1
        visited = self._path_start_index + max(passed, default=0)
        # the last station counts when the camera has seen the robot stand there
        visited = min(visited, last)
        if visited > self.mission.visited:
            self.mission = self.mission.with_visited(visited)

    def _take_answer(
        self, now_s: float, sight: Sight, answer: PlanAnswer | None
    ) -> tuple[int, tuple[Target, ...]] | None:
        if answer is None or self._asked is None or answer.id != self._asked.id:
            return None
        asked, self._asked = self._asked, None
        if self.mission.state is not State.PLANNING:
            return None
        if isinstance(answer.path, NoPath):
            self.mission = self.mission.after(Event.NO_PLAN, _why_no_plan(answer.path, asked))
            self._ask_again_s = now_s + self.settings.retry_s
            self.no_path = True
            self._clear_since_s = None
            return None
        if answer.scene_revision != sight.scene_revision:
            return None  # the world changed while planning: ask again
        self.mission = self.mission.settled(answer.path.order)
        self.replans += self.plans > 0
        self.plans += 1
        self.no_path = False
        self._mission_id = self._next_id()
        self.path, self.trajectory, self.targets = answer.path, answer.trajectory, answer.targets
        if self.trust.level is Level.PROBATION:
            self.targets = slow_at_first(asked.start[:2], answer.targets)
        self._planned_m_s = asked.speed_m_s or self.settings.traffic.speed_m_s
        self._planned_revision = answer.scene_revision
        self._path_start_index = self.mission.visited
        self._executed_here = 0
        self.waypoints_sent += len(answer.targets)
        self.mission = self.mission.after(Event.PLANNED, self._describe(answer.path))
        return self._mission_id, self.targets

    def _describe(self, path: Path) -> str:
        left = len(self.mission.remaining)
        return (
            f"driving {path.length:.2f} m to {left} station{'s' * (left != 1)}, "
            f"clearance at least {path.min_clearance:.3f} m" + _remarked(path)
        )

    def _give_up(self, now_s: float, sight: Sight, robot: RobotReport) -> None:
        state = self.mission.state
        self.has_met_its_devices |= math.isfinite(sight.frame_age_s) and math.isfinite(robot.age_s)
        self._progress.look(
            now_s,
            waits=state in (State.HOLDING, State.PLANNING, State.PROVING)
            and not self.mission.paused
            and self.has_met_its_devices,
            visited=self.mission.visited,
            left_m=self._left_m(sight) if state is State.DRIVING else None,
            revision=self._planned_revision,
        )
        if state is State.HOLDING and self._progress.waited_s > self.settings.give_up_s:
            why = self.mission.reason
            self.mission = self.mission.after(
                Event.FAIL, f"given up after {self.settings.give_up_s:g} s without progress: {why}"
            )

    def _left_m(self, sight: Sight) -> float | None:
        """How far it still is through the targets that are left."""
        left = [(t.x_m, t.y_m) for t in self.targets[self._executed_here :]]
        if sight.pose is None or not left:
            return None
        points = np.array([sight.pose[:2], *left])
        return float(np.hypot(*np.diff(points, axis=0).T).sum())

    def _hold_or_go_on(self, now_s: float) -> None:
        if self.verdict.action is Action.HOLD:
            self._clear_since_s = None
            if self.mission.state in (State.DRIVING, State.PLANNING, State.PROVING):
                self.mission = self.mission.after(Event.HOLD, self.verdict.sentence)
                left = [(t.x_m, t.y_m) for t in self.targets[self._executed_here :]]
                self._closed_way = np.array(left).reshape(-1, 2)
                self._forget_plan()
            elif self.mission.state is State.HOLDING:
                self.mission = replace(self.mission, reason=self.verdict.sentence)
            return
        if self.mission.state is not State.HOLDING:
            return
        if self._clear_since_s is None:
            self._clear_since_s = now_s
        settled = now_s - self._clear_since_s >= self.settings.settle_s
        if settled and now_s >= self._ask_again_s:
            self.mission = self.mission.after(Event.CLEARED, "planning from where the robot is")
            self._closed_way = NO_WAY

    def new_scene(self, path_clearance_m: float | None) -> None:
        """The scene changed; the running path keeps this clearance in it (None: no path runs).

        The way is planned anew where the robot does not fit any more, and where something has
        come nearer to the path than ``replan_distance_m``.
        """
        if self.mission.state is not State.DRIVING or path_clearance_m is None:
            return
        assert self.path is not None
        nearer_m = self.path.min_clearance - self.settings.limits.clearance_slack_m
        least_m = max(
            self.settings.limits.robot_radius_m, min(self.settings.replan_distance_m, nearer_m)
        )
        if path_clearance_m < least_m:
            self.mission = self.mission.after(
                Event.REPLAN,
                f"an obstacle leaves the path {path_clearance_m:.3f} m of clearance: planning anew",
            )
            self._forget_plan()

    def _finish(self, now_s: float, sight: Sight, robot: RobotReport) -> None:
        if self.mission.state is not State.DRIVING or not self.targets:
            return
        if robot.mission_id != self._mission_id:
            return
        if robot.executed < len(self.targets) or sight.pose is None:
            self._standing_since_s = None
            return
        if self._standing_since_s is None:
            self._standing_since_s = now_s
        if now_s - self._standing_since_s < self.settings.settle_s:
            return
        goal = self.mission.stations[-1]
        off_m = math.dist(sight.pose[:2], (goal.x, goal.y))
        off_rad = 0.0
        if goal.heading_rad is not None:
            off_rad = abs(math.remainder(sight.pose[2] - goal.heading_rad, math.tau))
        within = off_m <= self.settings.goal_tolerance_m
        if within and off_rad <= self.settings.goal_tolerance_rad:
            where = f"{off_m * 1e3:.1f} mm and {math.degrees(off_rad):.2f} deg from the goal"
            self.mission = self.mission.with_visited(len(self.mission.stations))
            self.mission = self.mission.after(Event.ARRIVED, f"the robot stands {where}")
            return
        if self._corrections < self.settings.corrections:
            self._corrections += 1
            self.mission = self.mission.after(Event.REPLAN, "correcting the last stretch")
            self._forget_plan()
            return
        self.mission = self.mission.after(
            Event.FAIL,
            f"the robot says that it has arrived, the camera sees it {off_m * 1e3:.1f} mm and "
            f"{math.degrees(off_rad):.2f} deg away after {self._corrections} corrections",
        )

    def _ask(self, now_s: float, sight: Sight) -> PlanRequest | None:
        if self.mission.state is not State.PLANNING or self._asked is not None:
            return None
        if sight.pose is None or sight.scene_revision == 0 or now_s < self._ask_again_s:
            return None
        if self.trust.level is Level.DOUBTED:
            return None
        self._request_id += 1
        self._asked = PlanRequest(
            self._request_id,
            sight.pose,
            self.mission.remaining,
            sight.scene_revision,
            any_order=self.mission.any_order and self.mission.visited == 0,
            avoid=discs_to_avoid(sight.pose[:2], sight.others, self.settings.traffic),
            speed_m_s=self._allowed_m_s(sight),
        )
        return self._asked

    def _forget_plan(self) -> None:
        self.path = self.trajectory = self._asked = None
        self.targets = ()
        self._executed_here = 0
        self._standing_since_s = None


def distance_to_polyline(points: FloatArray, position: tuple[float, float]) -> float:
    """The distance from a position to a polyline (n, 2), n >= 1, in the same units."""
    here = np.asarray(position, dtype=np.float64)
    if len(points) == 1:
        return float(np.hypot(*(points[0] - here)))
    a, d = points[:-1], points[1:] - points[:-1]
    squared = (d * d).sum(1)
    t = ((here - a) * d).sum(1) / np.where(squared > 0.0, squared, 1.0)
    nearest = a + np.clip(t, 0.0, 1.0)[:, None] * d
    return float(np.hypot(*(nearest - here).T).min())


def _why_no_plan(answer: NoPath, asked: PlanRequest) -> str:
    robots = sorted({disc.robot_id for disc in asked.avoid})
    around = f" around robot {' and '.join(map(str, robots))}" if robots else ""
    return f"no safe plan{around}: {answer.reason}{_remarked(answer)}"


def _remarked(answer: Path | NoPath) -> str:
    return "".join(f"; {remark}" for remark in answer.remarks)

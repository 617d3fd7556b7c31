"""The pilot: every decision of a control cycle, sans-IO.

`Pilot.step` opens nothing, waits for nothing and reads no clock, so the same pilot runs in the
daemon, in virtual time and in replay. Metres, radians, seconds.

A cycle judges safety, follows progress, changes the mission's state and gives orders. Every order
to move is a lease given by this cycle; a pilot that is not stepped moves nothing.
"""

from __future__ import annotations

import math
from dataclasses import replace

from navigation.mission.arrival import Arrival
from navigation.mission.cycle import (
    Orders,
    PilotSettings,
    PlanAnswer,
    PlanRequest,
    RobotReport,
    Sight,
)
from navigation.mission.facts import FactFinder, PilotSituation
from navigation.mission.late_pictures import speed_allowed
from navigation.mission.mission import Event, MissionError, MissionProgress, State, Station
from navigation.mission.plan_requests import PlanRequests
from navigation.mission.progress import Progress
from navigation.mission.proving import Proving
from navigation.mission.replanning import later_pictures, nearer_obstacle, robot_ahead
from navigation.mission.running_plan import RunningPlan, driving_sentence, plan_of, refusal_sentence
from navigation.mission.stillness import Circling
from navigation.mission.targets import Target
from navigation.mission.traffic import Encounter, encounter
from navigation.mission.trust import Level, Trust, slow_at_first
from navigation.mission.watch import Action, Facts, Verdict, judge
from planner.path import NoPath
from planner.shared.figures import placed

NO_PLAN = RunningPlan()
CONTINUES = "continuing as ordered"


class Pilot:
    """The mission, the running plan and the robot's progress along it."""

    def __init__(self, settings: PilotSettings, first_mission_id: int) -> None:
        self.settings = settings
        self.mission = MissionProgress()
        self.verdict = Verdict(Action.HOLD, ("nothing was seen yet",))
        self.plan = NO_PLAN
        self.replans = 0
        self.plans = 0
        self.waypoints_sent = 0
        self.waypoints_executed = 0
        self.stop_reason: str | None = None
        """Why the robot is to be stopped; None without a cause."""
        self.stopped_by = ""
        """Why the mission is stopped, even after the cause has gone."""
        self._skip: Station | None = None
        """Station to skip, until the next cycle."""
        self._rearm = False
        self._estopped = False
        self._mission_id = first_mission_id
        self._requests = PlanRequests(settings.settle_s)
        self._arrival = Arrival(settings)
        self._progress = Progress()
        self.trust = Trust()
        self._proving = Proving(self.trust, settings.turns_on_spot)
        self._circling = Circling(settings.circles_s)
        self._facts = FactFinder(settings, self.trust)
        self._closed_path = NO_PLAN.left
        self.no_path = False
        """True if the last request found no path."""
        self.has_met_its_devices = False
        """True once robot and camera have both reported; before, no mission is given up."""

    def begin_stopped(self, reason: str) -> None:
        """Begin in an earlier program's stop; missions wait behind it."""
        self.stop_reason = self.stopped_by = reason
        self.mission = self.mission.after(Event.STOP, reason)

    def appoint(self, mission: MissionProgress) -> None:
        """Put a mission, with its progress, behind a stop until re-arm and resume."""
        self.mission = self.mission.taking_over(mission)

    def give(self, stations: tuple[Station, ...], *, any_order: bool = False) -> None:
        """Replace the mission; ``MissionError`` if stopped, or for a station outside the arena."""
        if self.mission.state is State.STOPPED:
            raise MissionError("the robot is stopped: re-arm it first (clearway resume)")
        self.settings.check_stations(stations)
        self.mission = self.mission.given(stations, "a mission was given", any_order=any_order)
        self._begin_again()

    def step_aside(self, place: Station) -> None:
        """Let a robot whose mission is over make way for another and return to a place."""
        self.mission = self.mission.stepping_aside(place, "stepping aside for another robot")
        self._begin_again()

    def _begin_again(self) -> None:
        self._forget_plan()
        self._arrival.begin()
        self._progress.begin()

    def restore(self, mission: MissionProgress) -> None:
        """Continue an earlier program's unfinished mission with a new plan."""
        self.trust.doubt("the program was started again")
        if self.mission.state is State.STOPPED:
            self.appoint(mission)
            return
        given = self.mission.given(mission.stations, "continuing after a restart")
        self.mission = given.taking_over(mission)
        self._forget_plan()

    def stop(self, reason: str) -> None:
        """Emergency stop: latched until `rearm`."""
        self.stop_reason = reason

    def pause(self) -> None:
        """Hold until `resume`."""
        self.mission = replace(self.mission, paused=True)

    def resume(self) -> None:
        """Let the robot move again, one step each time.

        After a pause, or a failure, the mission continues with a new plan. After an emergency stop
        the robot is re-armed and does not move; a second resume continues with the remaining
        stations.
        """
        if self.mission.paused and self.mission.state is State.HOLDING:
            # the next cycle names any other cause
            self.mission = replace(self.mission, reason=CONTINUES)
        self.mission = replace(self.mission, paused=False)
        if self.mission.state is State.STOPPED:
            self.mission = self.mission.rearmed()
            self.stop_reason, self._rearm = None, True
            self.trust.vouch()
        elif self.mission.state in (State.IDLE, State.FAILED) and self.mission.remaining:
            self.mission = self.mission.after(Event.GIVEN, CONTINUES)
            self._begin_again()
            self.trust.vouch()
        elif self._estopped:
            self._rearm = True  # a robot stopped before we came

    def replan(self, why: str = "a new plan was asked for", *, holding: bool = False) -> None:
        """Plan again from here if driving, or holding and ``holding`` is set."""
        if self.mission.state is State.DRIVING:
            self._replan(why)
        elif holding and self.mission.state is State.HOLDING:
            self.mission = self.mission.after(Event.CLEARED, why)

    def skip(self) -> None:
        """Give up the next station; ``MissionError`` if none can be skipped.

        If it is reached before the next cycle, it counts as visited, and no other is given up.
        """
        if self.mission.cannot_skip:
            raise MissionError(self.mission.cannot_skip)
        self._skip = self.mission.remaining[0]

    def step(
        self, now_s: float, sight: Sight, robot: RobotReport, answer: PlanAnswer | None = None
    ) -> Orders:
        """Run one control cycle."""
        met = self._look_at_traffic(sight)
        self._look_at_identity(sight)
        ordered = self.stop_reason is not None or self.mission.state is State.STOPPED
        situation = PilotSituation(self.mission, self.plan, self._mission_id, self._rearm, ordered)
        facts = self._facts.facts(now_s, sight, robot, situation, met)
        self.verdict = judge(facts, self.settings.limits)
        if self.stop_reason is not None:
            self.verdict = Verdict(Action.STOP, (self.stop_reason, *self.verdict.reasons))
        rearm, self._rearm, self._estopped = self._rearm, False, robot.estopped
        was = self.mission.state
        if self.verdict.action is Action.STOP:
            self._enter_stop(robot)
        if self.mission.state is State.STOPPED:
            self._say_why_stopped()
            self._skip = None
            return Orders(permit=False, estop=True)
        self._follow_progress(robot)
        self._skip_station()
        upload = self._take_answer(now_s, sight, answer)
        self._hold_or_continue(now_s, facts)
        self._replan_while_driving(robot_ahead(met))
        late_s = sight.evidence.longest_latency_s
        allowed_m_s = speed_allowed(late_s, self.settings.traffic)
        self._replan_while_driving(later_pictures(late_s, allowed_m_s, self.plan.speed_m_s))
        proof = self._prove(now_s, sight, robot)
        self._look_for_circles(now_s, sight, robot)
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
        lost = sight.pose is not None and sight.pose_age_s > self.settings.limits.pose_stale_s
        unseen = "the robot was lost from view" if lost else sight.blind
        refuted = self.trust.look(sight.evidence, unseen, sight.late)
        if refuted is not None and self.stop_reason is None:
            self.stop_reason = refuted

    def _prove(
        self, now_s: float, sight: Sight, robot: RobotReport
    ) -> tuple[int, tuple[Target, ...]] | None:
        if self.mission.state is State.PROVING:
            step = self._proving.judge(now_s, sight, robot)
        elif self.mission.state is State.PLANNING and self.trust.level is Level.DOUBTED:
            step = self._proving.begin(now_s, self._next_id(), sight, robot)
        else:
            return None
        if step.stop is not None:
            self.stop_reason = step.stop
        if step.event is not None:
            self.mission = self.mission.after(step.event, step.sentence)
        if step.event is Event.HOLD:
            self._requests.hold(now_s + self._facts.stillness.pause_s())
        if step.targets is None:
            return None
        self._facts.late_camera.measured()
        self._mission_id = self._next_id()
        return self._mission_id, step.targets

    def _next_id(self) -> int:
        return (self._mission_id + 1) & 0xFFFFFFFF or 1

    def _look_at_traffic(self, sight: Sight) -> Encounter | None:
        """Most urgent other robot; while holding, on the path that it closed."""
        if sight.pose is None or not sight.others:
            return None
        path = self.plan.left if len(self.plan.left) else self._closed_path
        return encounter(sight.pose[:2], path, sight.others, self.settings.traffic)

    def _enter_stop(self, robot: RobotReport) -> None:
        idle = self.mission.state in (State.IDLE, State.DONE, State.FAILED)
        if robot.estopped and idle and self.stop_reason is None:
            return  # a robot stopped before we came: reported when a mission is given
        if self.mission.state is not State.STOPPED:
            self.stopped_by = self.verdict.reasons[0]
            self.mission = self.mission.after(Event.STOP, self.stopped_by)
            self._forget_plan()

    def _say_why_stopped(self) -> None:
        """Name the cause of the stop first, then what else forbids driving."""
        others = [reason for reason in self.verdict.reasons if reason != self.stopped_by]
        self.verdict = Verdict(Action.STOP, (self.stopped_by, *others))
        self.mission = replace(self.mission, reason=self.verdict.sentence)

    @property
    def stop_without_mission(self) -> str | None:
        """Reason for an emergency stop without a mission to stop; None if there is none."""
        if self.verdict.action is not Action.STOP or self.mission.state is State.STOPPED:
            return None
        return self.verdict.reasons[0]

    def _follow_progress(self, robot: RobotReport) -> None:
        if not self.plan.targets or robot.mission_id != self._mission_id:
            return
        before = self.plan.executed
        self.plan = self.plan.with_executed(robot.executed)
        self.waypoints_executed += self.plan.executed - before
        last = len(self.mission.places) - 1
        # the last station counts once the camera sees the robot at rest there
        visited = min(self.plan.visited, last)
        if visited > self.mission.visited:
            self.mission = self.mission.with_visited(visited)

    def _skip_station(self) -> None:
        skip, self._skip = self._skip, None
        if skip is not None and self.mission.remaining and self.mission.remaining[0] is skip:
            self.mission = self.mission.without_next()
            self._begin_again()

    def _take_answer(
        self, now_s: float, sight: Sight, answer: PlanAnswer | None
    ) -> tuple[int, tuple[Target, ...]] | None:
        asked = self._requests.close(answer)
        if answer is None or asked is None or self.mission.state is not State.PLANNING:
            return None
        if isinstance(answer.path, NoPath):
            self.mission = self.mission.after(Event.NO_PLAN, refusal_sentence(answer.path))
            self._requests.hold(now_s + self.settings.retry_s)
            self.no_path = True
            return None
        if answer.scene_revision != sight.scene_revision:
            return None  # the world changed while planning: ask again
        self.mission = self.mission.settled(answer.path.order)
        self.replans += self.plans > 0
        self.plans += 1
        self.no_path = False
        self._mission_id = self._next_id()
        targets = answer.targets
        if self.trust.level is Level.PROBATION:
            targets = slow_at_first(asked.start[:2], targets)
        self.plan = plan_of(answer, targets, asked.speed_m_s, self.mission.visited)
        self.waypoints_sent += len(targets)
        driven = driving_sentence(answer.path, len(self.mission.remaining))
        self.mission = self.mission.after(Event.PLANNED, driven)
        return self._mission_id, targets

    def _look_for_circles(self, now_s: float, sight: Sight, robot: RobotReport) -> None:
        drives = self.mission.state is State.DRIVING and robot.mission_id == self._mission_id
        if not self._circling.look(now_s, robot, self.plan, sight.pose if drives else None):
            return
        longest_s = self.settings.circles_s
        self._progress.circled(longest_s)
        if self._progress.waited_s > self.settings.give_up_s:
            why = f"given up: the robot comes no nearer to {placed(*self.plan.left[0])}"
            self.mission = self.mission.after(Event.FAIL, why)
        else:
            self._replan(f"the robot came no nearer for {longest_s:.0f} s: planning again")

    def _give_up(self, now_s: float, sight: Sight, robot: RobotReport) -> None:
        state = self.mission.state
        self.has_met_its_devices |= math.isfinite(sight.frame_age_s) and math.isfinite(robot.age_s)
        here = sight.pose[:2] if sight.pose is not None and state is State.DRIVING else None
        waits = state in (State.HOLDING, State.PLANNING, State.PROVING) and not self.mission.paused
        self._progress.look(
            now_s,
            waits=waits and self.has_met_its_devices,
            visited=self.mission.visited,
            left_m=None if here is None else self.plan.left_m(here),
            revision=self.plan.revision,
        )
        if state is State.HOLDING and self._progress.waited_s > self.settings.give_up_s:
            gave_up = f"given up after {self.settings.give_up_s:g} s without progress"
            self.mission = self.mission.after(Event.FAIL, f"{gave_up}: {self.mission.reason}")

    def _hold_or_continue(self, now_s: float, facts: Facts) -> None:
        if self.verdict.action is Action.HOLD:
            self._requests.hold()
            if self.mission.state in (State.DRIVING, State.PLANNING, State.PROVING):
                self.mission = self.mission.after(Event.HOLD, self.verdict.sentence)
                if facts.robot_idle_reason is not None:
                    self._requests.hold(now_s + self._facts.stillness.pause_s())
                self._closed_path = self.plan.left
                self._forget_plan()
            elif self.mission.state is State.HOLDING:
                self.mission = replace(self.mission, reason=self.verdict.sentence)
            return
        if self.mission.state is State.HOLDING and self._requests.is_settled(now_s):
            self.mission = self.mission.after(Event.CLEARED, "planning from where the robot is")
            self._closed_path = NO_PLAN.left

    def new_scene(self, path_clearance_m: float | None, breach: str | None = None) -> None:
        """Take a new scene's clearance of the running path (None: no path runs).

        ``breach`` is the sentence on a zone's rule that the path breaks.
        """
        if breach is not None:
            self._replan_while_driving(f"the path {breach}: planning again")
        if path_clearance_m is not None and self.plan.path is not None:
            planned_m = self.plan.path.min_clearance
            self._replan_while_driving(nearer_obstacle(path_clearance_m, planned_m, self.settings))

    def _finish(self, now_s: float, sight: Sight, robot: RobotReport) -> None:
        ours = robot.mission_id == self._mission_id
        if self.mission.state is not State.DRIVING or not self.plan.targets or not ours:
            return
        if robot.executed < len(self.plan.targets) or sight.pose is None:
            self._arrival.moves()
            return
        if self.plan.visited < len(self.mission.places):
            return self._replan("on to the next station")  # the plan ended at a station on the way
        end = self._arrival.stands(now_s, sight.pose, self.mission.places[-1])
        if end is None:
            return
        event, sentence = end
        if event is Event.ARRIVED:
            self.mission = self.mission.arrived(sentence)
        elif event is Event.REPLAN:
            self._replan(sentence)
        else:
            self.mission = self.mission.after(event, sentence)

    def _ask(self, now_s: float, sight: Sight) -> PlanRequest | None:
        if self.mission.state is not State.PLANNING or self.trust.level is Level.DOUBTED:
            return None
        return self._requests.make(now_s, sight, self.mission, self.settings.traffic)

    def _replan_while_driving(self, why: str | None) -> None:
        if why is not None and self.mission.state is State.DRIVING:
            self._replan(why)

    def _replan(self, why: str) -> None:
        self.mission = self.mission.after(Event.REPLAN, why)
        self._forget_plan()

    def _forget_plan(self) -> None:
        self.plan = NO_PLAN
        self._requests.drop()
        self._arrival.moves()

"""The running program: who talks to whom.

Threads: the camera's (newest frame wins), the planner's (newest scene and request win), the
link's, which alone owns the port, and this one, the control loop. A cycle of the control loop
is: newest frame -> eye -> pilot -> orders to the planner and the link. It runs once a frame, at
once when the planner has news, and at least every ``LONGEST_CYCLE_S`` without either, so that a
lost camera stops the robot too.
The lease that lets the robot move is given by this loop only: should it hang, the robot stops.

The clock is the world's: real, or virtual in a simulation that runs as fast as it can.
Units: metres, radians, seconds.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from navigation.config import Config
from navigation.journal.journal import Journal, SentPlan
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop import reports
from navigation.loop.daemon_state import DaemonState, DrivenPlan, StageTimes
from navigation.loop.parts import Surroundings, camera_part
from navigation.loop.planner_news import PlannerNews
from navigation.loop.planning import ArenaPlanner
from navigation.loop.robot_orders import RobotOrders
from navigation.loop.seeing.eye import Glimpse
from navigation.loop.seeing.other_robots import OtherRobots
from navigation.loop.seeing.scene_doubt import SceneDoubt
from navigation.loop.seeing.vision_stage import VisionStage
from navigation.loop.stages import pilot_settings, plan_settings, witness_limits
from navigation.mission.cycle import Orders, PlanAnswer, PlanRequest, Sight
from navigation.mission.mission import Mission, MissionError, Station
from navigation.mission.pilot import Pilot
from navigation.mission.trust import Level
from navigation.recording.events import PlanAsked, SceneSeen
from navigation.shared.supervisor import Part, Supervisor
from navigation.shared.track import Track
from navigation.witness import NO_EVIDENCE, Witness
from planner.path import NoPath
from planner.roadmap.roadmap import Roadmap
from planner.scene import Bounds, Scene
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder

LONGEST_CYCLE_S: Final = 0.05
PLANS_KEPT: Final = 200
SETTLE_S: Final = 0.3
"""An order's answer waits so long at most for a cycle that acts on it."""


class Daemon:
    """Runs one configuration; a context manager that opens and closes everything.

    ``first_mission_id``: ids on the wire count up from the one after it. With a ``journal``
    mission, progress and plan are kept before they take effect; a ``recorder`` is told all that
    is seen, planned and decided.
    """

    def __init__(
        self,
        config: Config,
        world: Surroundings,
        *,
        first_mission_id: int,
        journal: Journal | None = None,
        recorder: Recorder | None = None,
    ) -> None:
        self.config, self.world = config, world
        self._clock = world.clock
        self._bounds = Bounds(*config.arena.bounds_m)
        self.pilot = Pilot(pilot_settings(config), first_mission_id)
        self.link = world.make_link()
        self.camera = world.make_frames()
        self._robot = RobotOrders(self.link, config)
        self.witness = Witness(witness_limits(config))
        self._vision = VisionStage(
            config, world.calibration, self.witness, self._clock, (), world.floor_plan
        )
        planner = self._arena_planner = ArenaPlanner(plan_settings(config))
        self._news = PlannerNews[PlanAnswer](planner, self._clock, self.camera.wake, recorder)
        self._planner = world.make_planner(
            self._arena_planner, self._news.on_scene, self._news.on_answer
        )
        self._supervisor = Supervisor(
            {
                "vision": Part(self._vision.failure, self._vision.restart),
                "planner": Part(self._planner.failure, self._restart_planner),
                "serial link": Part(self.link.failure, self.link.restart),
                "camera's thread": camera_part(self.camera),
            }
        )
        self._lock = threading.Lock()
        self.scene: Scene | None = None
        self.pose: RobotPose | None = None
        self.plans: deque[DrivenPlan] = deque(maxlen=PLANS_KEPT)
        self.sightings = Track()
        self._scene_doubt = SceneDoubt(floor_markers=bool(config.arena.floor_markers))
        self.processed = 0
        self.state: DaemonState | None = None
        """What the last cycle ended with; replaced as a whole, so any thread may read it."""
        self._frame: Frame | None = None
        self._glimpse = Glimpse(-math.inf, {}, None, None)
        self._pose_arrived_s = -math.inf
        self._reopened, self._forget_latency = 0, False
        self._evidence = NO_EVIDENCE
        self.others = OtherRobots({one.marker_id: one.radius_m for one in config.other_robots})
        self.reanchor: Callable[[str | None], list[str]] | None = None
        self.newest = self._vision.newest
        self.lent: str | None = None  # why the robot holds while its camera serves something else
        self.started_s = self._clock()
        self._revision = self._measurable_revision = 0
        self._frame_s = -math.inf
        self._journal = journal
        self.troubles: dict[str, str] = {}
        """What people must know although the run goes on, by subject; set by the loop's thread."""
        self._recorder = recorder
        self._cycles = self._ended = 0
        self._further_turns: dict[str, Callable[[], int]] = {}
        self._turned = threading.Condition()

    def __enter__(self) -> Daemon:
        self.world.start()
        try:
            self.link.open()
            self.camera.start()
            self._planner.start()
        except BaseException:
            self.__exit__()
            raise
        self.started_s = self._clock()
        return self

    def __exit__(self, *_error: object) -> None:
        self.let_the_robot_stop()
        self._planner.stop()
        self.link.close()
        self.world.stop()

    def halt(self) -> None:
        """Withdraw the lease: the robot begins to brake. No `cycle` may follow."""
        self._robot.halt(self._clock())

    def let_the_robot_stop(self) -> None:
        """`halt`, and wait until the robot says that it stands, or should by now.

        The camera is closed meanwhile; no decision needs it any more.
        """
        self.halt()
        self.camera.stop()
        while self._clock() < self._robot.stands_s and self.link.snapshot().moving:
            self.world.wait(0.01)

    # Restarts after errors of the program; the supervisor says when.

    def _restart_planner(self) -> None:
        self._planner.restart()
        if self.scene is not None:
            self._planner.see(self.scene, self._revision, None)

    def look_after(self, name: str, part: Part, turns: Callable[[], int]) -> None:
        """Watch one more stage like those of the daemon: its failures, and whether it turns."""
        self._supervisor.add(name, part)
        self._further_turns[name] = turns

    # Orders from people.

    def give(self, stations: tuple[Station, ...], *, any_order: bool = False) -> None:
        """A new mission; ``MissionError`` where it cannot be."""
        if self.lent is not None:
            raise MissionError(self.lent)
        with self._lock:
            self.pilot.give(stations, any_order=any_order)

    def stop(self, reason: str) -> None:
        """Emergency stop: straight to the link, past every queue, then latched by the pilot."""
        self.link.estop()
        with self._lock:
            self.pilot.stop(reason)

    def restore(self, mission: Mission) -> None:
        """Go on with a mission from the journal."""
        with self._lock:
            self.pilot.restore(mission)

    def pause(self) -> None:
        """Hold where the robot is."""
        with self._lock:
            self.pilot.pause()

    def resume(self) -> None:
        """End a pause; after a stop re-arm the robot, and the next time go on."""
        with self._lock:
            self.pilot.resume()
            self._scene_doubt.accept()
            self._forget_latency = True

    def replan(self) -> None:
        """Plan anew from where the robot is."""
        with self._lock:
            self.pilot.replan()

    def settle(self) -> None:
        """Wait, in another thread, until a cycle has acted on the orders so far; not for long."""
        # the cycle under way may have decided already
        wanted = self._ended + 2
        self.camera.wake()
        with self._turned:
            self._turned.wait_for(lambda: self._ended >= wanted, SETTLE_S)

    def preview(self, stations: tuple[Station, ...]) -> PlanAnswer:
        """What a mission through these stations would be from where the robot is; changes nothing.

        Any thread may ask; the answer is the plan that `give` would lead to in this scene.
        """
        pose, revision = self.pose, self._news.known_revision
        if pose is None:
            return PlanAnswer(0, 0, NoPath("the robot was not seen yet"))
        request = PlanRequest(0, (pose.x, pose.y, pose.heading_rad), stations, revision)
        return self._arena_planner.answer(request, preview=True)

    def describe(self) -> dict[str, Any]:
        """The present state as JSON takes it."""
        with self._lock:
            mission, pose = self.pilot.mission, self.pose
        snapshot = self.link.snapshot()
        return reports.describe(
            mission,
            None if pose is None else (pose, self._clock() - pose.captured_s),
            reports.to_go_m(pose, self.pilot.plan.targets, snapshot.executed),
            snapshot,
            self.camera.status(),
            self._evidence.latency_s,
        )

    def turns(self) -> dict[str, int]:
        """For each stage a number that grows while it works, or waits for work as it should."""
        turns = {
            "control loop": self._cycles,
            "camera": self.camera.turns,
            "planner": self._planner.turns,
            "link": self.link.turns,
        }
        if self._recorder is not None and not self._recorder.has_ended():
            turns["recorder"] = self._recorder.turns
        return turns | {name: count() for name, count in self._further_turns.items()}

    # The cycle.

    def cycle(self) -> DaemonState:
        """Wait for a frame or the planner's news, at most ``LONGEST_CYCLE_S``, and decide."""
        self._cycles += 1
        frame = self.camera.take(LONGEST_CYCLE_S)
        if frame is not None:
            self._see(frame)
        now_s = self._clock()
        failed = self._supervisor.look(now_s)
        snapshot = self.link.snapshot()
        self._hear(snapshot, now_s)
        sight = self._sight(now_s, failed)
        checks, answer = self._news.take()
        with self._lock:
            for check in checks:
                self.pilot.new_scene(check.path_clearance_m)
            orders = self.pilot.step(now_s, sight, reports.robot_report(snapshot), answer)
        self._write_journal(orders)
        self._carry_out(orders, now_s, sight)
        self.state = self._state(now_s, sight, snapshot)
        if self._recorder is not None:
            self._recorder.state(self.state, now_s)
        with self._turned:
            self._ended += 1
            self._turned.notify_all()
        return self.state

    def _hear(self, snapshot: LinkSnapshot, now_s: float) -> None:
        """The wheels' side of the story, and whether the camera is another one than before."""
        if snapshot.status is not None:
            self.witness.report(snapshot.status, now_s - snapshot.status_age_s)
        reopened = reports.camera_openings(self.camera.status())
        if reopened != self._reopened or self._forget_latency:
            self._reopened, self._forget_latency = reopened, False
            self.witness.forget_latency()
        self._evidence = self.witness.evidence()

    def _see(self, frame: Frame) -> None:
        if self._vision.failure() is not None:
            return
        self._frame_s = min(frame.captured_s, self._clock())
        seen = self._vision.look(frame, self._tell_pose)
        if seen is None:
            return
        frame, glimpse = seen
        self.processed += 1
        held, self._frame, self._glimpse = self._glimpse.hold, frame, glimpse
        self.troubles |= glimpse.troubles
        self.others.see(glimpse.poses)
        self.troubles |= self._scene_doubt.look(glimpse)
        if glimpse.scene is not None:
            self._revision += 1
            self.scene = glimpse.scene
            points = None if self.pilot.plan.path is None else self.pilot.plan.path.points
            self._news.gets_scene()
            self._planner.see(glimpse.scene, self._revision, points)
        if held and not glimpse.hold:
            self._measurable_revision = self._revision  # the planner may not know it yet
        if self._recorder is not None:
            scene, at_s = glimpse.scene, frame.captured_s
            event = None if scene is None else SceneSeen(at_s, self._revision, scene)
            self._recorder.saw(frame, glimpse.poses, event)

    def _tell_pose(self, poses: Mapping[int, RobotPose]) -> None:
        """The newest thing that anybody knows goes to the robot at once."""
        pose = poses.get(self.config.robot.marker_id)
        if pose is not None:
            self.link.pose_fix(pose.x, pose.y, pose.heading_rad, pose.captured_s)
            self.pose, self._pose_arrived_s = pose, self._frame_s
            self.witness.saw(pose, self._frame_s - pose.before_frame_s)
            if self.pilot.trust.level is not Level.DOUBTED:  # else something else has moved it
                self.sightings.add(pose.captured_s, pose.x, pose.y, pose.heading_rad)

    def _sight(self, now_s: float, failed: str | None) -> Sight:
        pose = self.pose
        place = None if pose is None else self.witness.carried(pose, now_s)
        clearance = None  # in the unknown nothing can be measured
        measurable = self._news.known_revision >= self._measurable_revision
        if place is not None and measurable and not self._glimpse.hold:
            clearance = self._arena_planner.clearance_m(place[:2])
        return Sight(
            frame_age_s=now_s - self._frame_s,
            pose_age_s=now_s - self._pose_arrived_s,
            pose=place,
            scene_revision=self._news.known_revision,
            clearance_m=clearance,
            failed=failed,
            camera_reason=reports.camera_reason(self.camera.status()),
            others=self.others.movers(now_s),
            doubles=tuple(self._glimpse.doubles.values()),
            evidence=self._evidence,
            scene_doubt=self.lent or self._scene_doubt.hold or self._glimpse.hold,
        )

    def _write_journal(self, orders: Orders) -> None:
        """Before anything takes effect: progress, and the plan that the robot is given next."""
        mission = self.pilot.mission
        if self._journal is None or not mission.stations:
            return
        sent = None
        if orders.upload is not None:
            sent = SentPlan(orders.upload[0], mission.visited, orders.upload[1])
        self._journal.keep(mission, sent, self._clock())
        self.troubles["journal"] = self._journal.trouble

    def _carry_out(self, orders: Orders, now_s: float, sight: Sight) -> None:
        self._robot.carry_out(orders, now_s, sight.pose_age_s)
        if orders.estop:
            return
        if orders.measure_latency:
            self.witness.measure_again()
        plan = self.pilot.plan
        if orders.upload is not None and plan.path is not None:  # none for a turn on the spot
            self.plans.append(DrivenPlan(plan.path, plan.trajectory, now_s))
        if orders.request is not None:
            self._news.gets_request(now_s)
            self._planner.ask(orders.request)
            if self._recorder is not None:
                self._recorder.put(PlanAsked(now_s, orders.request))

    def _state(self, now_s: float, sight: Sight, snapshot: LinkSnapshot) -> DaemonState:
        mission = self.pilot.mission
        return DaemonState(
            time_s=now_s - self.started_s,
            mission=mission,
            sentence=mission.reason,
            pose=self.pose,
            link=snapshot,
            to_go_m=reports.to_go_m(self.pose, self.pilot.plan.targets, snapshot.executed),
            clearance_m=sight.clearance_m,
            verdict=self.pilot.verdict,
            frame=self._frame,
            poses=self._glimpse.poses,
            roadmap=self._arena_planner.roadmap,
            path=self.pilot.plan.path,
            times=StageTimes(self._vision.look_s, self._news.roadmap_s, self._news.plan_s),
            evidence=self._evidence,
            trust=self.pilot.trust.level,
            troubles=tuple(filter(None, (*self.troubles.values(), snapshot.remark))),
        )

    @property
    def roadmap(self) -> Roadmap | None:
        """The newest roadmap, for pictures."""
        return self._arena_planner.roadmap

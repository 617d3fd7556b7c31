"""The running program with one robot; with several it is `navigation.loop.fleet.fleet_daemon`.

Units: metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from navigation.config import Config
from navigation.journal.journal import Journal
from navigation.loop import reports
from navigation.loop.control_loop import ControlLoop
from navigation.loop.daemon_state import DaemonState
from navigation.loop.driven_robot import DrivenRobot
from navigation.loop.parts import Surroundings
from navigation.loop.planning import ArenaPlanner
from navigation.loop.stages import plan_settings
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import Mission, MissionError, State, Station
from navigation.recording.events import PlanAsked
from planner.path import NoPath
from planner.scene import FloatArray
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder


class Daemon(ControlLoop[DaemonState, PlanRequest, PlanAnswer]):
    """Runs one configuration; a context manager that opens and closes everything.

    ``first_mission_id``: ids on the wire count up from the one after it. With a ``journal``
    mission, progress and plan are kept before they take effect.
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
        self.world = world
        self.robot = DrivenRobot("", config, world.make_link(), first_mission_id)
        self.robot.journal = journal
        self.pilot, self.link, self.witness = self.robot.pilot, self.robot.link, self.robot.witness
        self.plans, self.sightings = self.robot.plans, self.robot.sightings
        super().__init__(config, world, {"": self.robot}, self.witness, recorder=recorder)
        self._arena_planner = ArenaPlanner(plan_settings(config))
        self._set_planner(self._arena_planner, partial(world.make_planner, self._arena_planner))
        self.reanchor: Callable[[str | None], list[str]] | None = None

    @property
    def pose(self) -> RobotPose | None:
        """Where the robot was seen last."""
        return self.robot.pose

    # Orders from people.

    def give(self, stations: tuple[Station, ...], *, any_order: bool = False) -> None:
        """A new mission; ``MissionError`` where it cannot be."""
        if self.lent is not None:
            raise MissionError(self.lent)
        with self.lock:
            self.pilot.give(stations, any_order=any_order)

    def stop(self, reason: str) -> str | None:
        """Emergency stop: straight to the link, past every queue, then latched, on disk too."""
        return self.stopping.stop([self.robot], reason)

    def restore(self, mission: Mission) -> None:
        """Go on with a mission from the journal."""
        with self.lock:
            self.pilot.restore(mission)

    def pause(self) -> None:
        """Hold where the robot is."""
        with self.lock:
            self.pilot.pause()

    def resume(self) -> None:
        """End a pause; after a stop re-arm the robot, and the next time go on."""
        self.stopping.resume([self.robot])
        self.accept_arena()

    def replan(self) -> None:
        """Plan anew from where the robot is."""
        with self.lock:
            self.pilot.replan()

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
        with self.lock:
            mission, pose = self.pilot.mission, self.pose
        snapshot = self.link.snapshot()
        return reports.describe(
            mission,
            None if pose is None else (pose, self._clock() - pose.captured_s),
            reports.to_go_m(pose, self.pilot.plan.targets, snapshot.executed),
            snapshot,
            self.camera.status(),
            self.robot.evidence.latency_s,
        )

    def _driven_points(self) -> FloatArray | None:
        path = self.pilot.plan.path
        return None if path is None else path.points

    def _decide(self, now_s: float, failed: str | None, camera: CameraStatus) -> DaemonState:
        robot, snapshot = self.robot, self.link.snapshot()
        robot.hears()
        sight = robot.sight(
            now_s,
            self.view,
            camera,
            self._news.known_revision,
            self._arena_planner.clearance_m,
            failed=failed,
            hold=self._hold,
            punctuality=self.punctuality,
        )
        checks, answer = self._news.take()
        with self.lock:
            for check in checks:
                self.pilot.new_scene(check.path_clearance_m)
            was = self.pilot.mission.state
            orders = self.pilot.step(now_s, sight, reports.robot_report(snapshot), answer)
            if self.pilot.mission.state is State.STOPPED is not was:
                self.stopping.stopped_itself(robot)
        self.troubles["journal"] = robot.write_journal(orders, now_s)
        robot.carry_out(orders, now_s, sight.pose_age_s)
        if orders.request is not None and not orders.estop:
            self._news.gets_request(now_s)
            self._planner.ask(orders.request)
            if self._recorder is not None:
                self._recorder.put(PlanAsked(now_s, orders.request))
        state = robot.state(
            now_s - self.started_s,
            self.view,
            snapshot,
            self.roadmap,
            self._times(),
            self._troubles,
        )
        if self._recorder is not None:
            self._recorder.state(state, now_s)
        return state

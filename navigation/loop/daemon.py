"""Main loop for one or several robots: newest frame, eye, decisions, orders.

Threads: the camera's (newest frame wins), the planner's (newest scene and request win), one per
link (sole owner of its port), and this one. A cycle runs once a frame, at once on the planner's
news, and at least every ``LONGEST_CYCLE_S``, so that a lost camera stops the robots too. Only this
loop grants the leases that let robots move: if it hangs, all stop.

Metres, radians, seconds of the world's clock.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from navigation.config import Config
from navigation.config.several.each_robot import robots_of
from navigation.journal.journal import Journal
from navigation.link.link_snapshot import is_at_rest
from navigation.loop.parts import Surroundings, camera_part
from navigation.loop.people import People
from navigation.loop.planner_news import PlannerNews
from navigation.loop.punctuality import Punctuality
from navigation.loop.reports import camera_openings
from navigation.loop.robot import ControlledRobot, Witnesses
from navigation.loop.run_state import RunState, StageTimes
from navigation.loop.seeing.arena_view import ArenaView
from navigation.loop.stopping import Stopping
from navigation.loop.traffic.alone import Alone
from navigation.loop.traffic.coordinated import Coordinated
from navigation.loop.traffic.traffic import Decided, Traffic, TrafficPlanner
from navigation.loop.zones_in_force import ZonesInForce
from navigation.mission.mission import MissionError, State
from navigation.shared.supervisor import SupervisedPart, Supervisor
from planner.roadmap.roadmap import Roadmap
from planner.scene import Scene
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder

LONGEST_CYCLE_S: Final = 0.05
SETTLE_S: Final = 0.3
"""Longest wait of an order's answer for a cycle that acts on it."""


class Daemon:
    """Runs a configuration; a context manager that opens and closes everything.

    Ids on the wire count up from the one after ``first_mission_id``. Journals, by robot name, store
    mission, progress and plan before they take effect.
    """

    def __init__(
        self,
        config: Config,
        world: Surroundings,
        *,
        first_mission_id: int,
        journals: Mapping[str, Journal] | None = None,
        recorder: Recorder | None = None,
    ) -> None:
        self.config, self.world = config, world
        self._clock = world.clock
        self._recorder = recorder
        configs = robots_of(config)
        self.robots = {
            name: ControlledRobot(name, one, world.make_link(name), first_mission_id)
            for name, one in configs.items()
        }
        for name, journal in (journals or {}).items():
            self.robots[name].journal = journal
        self.camera = world.make_frames()
        vision = world.make_vision(
            config, Witnesses(self.robots), [one.robot for one in configs.values()]
        )
        self.newest = vision.newest
        self.view = ArenaView(config, vision, self._clock, recorder)
        self.zones = ZonesInForce(config.zones, configs)
        self.zones.changed = self.camera.wake
        self._zones, self._zones_revision = self.zones.zones(), 0
        if recorder is not None:
            recorder.zones(self._zones, self.view.revision, self._clock())
        self.traffic: Traffic = (
            Coordinated(self.robots, world.search_clock)
            if config.robots
            else Alone(self.robots[""])
        )
        planner: TrafficPlanner = self.traffic.planner
        self._news = PlannerNews(planner, self._clock, self.camera.wake, recorder)
        self._planner = world.make_planner(planner, self._news.on_scene, self._news.on_answer)
        self._supervisor = Supervisor(
            {
                "vision": SupervisedPart(vision.failure, vision.restart),
                "camera's thread": camera_part(self.camera),
                **{
                    f"{_of(name)}serial link": SupervisedPart(one.link.failure, one.link.restart)
                    for name, one in self.robots.items()
                },
                "planner": SupervisedPart(self._planner.failure, self._restart_planner),
            }
        )
        self.lock = threading.Lock()
        """Held while pilots decide or people give them orders."""
        self.stopping = Stopping(self.lock)
        self.people = People(self)
        self.punctuality = Punctuality()
        self._cycled_s, self._looked = math.inf, 0
        self.lent: str | None = None
        """Why robots hold while the camera serves something else."""
        self.state: RunState | None = None
        """State after the last cycle, replaced as a whole: any thread may read it."""
        self.troubles: dict[str, str] = {}
        """Further troubles by subject; set by the loop's thread."""
        self.started_s = self._clock()
        self._reopened, self._forget_latency = 0, False
        self._cycles = self._ended = 0
        self._further_turns: dict[str, Callable[[], int]] = {}
        self._turned = threading.Condition()

    def __enter__(self) -> Daemon:
        self.world.start()
        try:
            for one in self.robots.values():
                one.link.open()
            self.camera.start()
            self._planner.start()
        except BaseException:
            self.__exit__()
            raise
        self.started_s = self._clock()
        return self

    def __exit__(self, *_error: object) -> None:
        self.let_the_robots_stop()
        self.zones.end()
        self._planner.stop()
        for one in self.robots.values():
            one.link.close()
        self.world.stop()

    def halt(self) -> None:
        """Withdraw all leases, so the robots brake. No `cycle` may follow."""
        for one in self.robots.values():
            one.orders.halt(self._clock())

    def let_the_robots_stop(self) -> list[str]:
        """`halt`, then wait until all robots report rest, or should be at rest.

        Return a sentence for each robot that is not known to be at rest then.
        """
        self.halt()
        self.camera.stop()
        doubts = []
        for one in self.robots.values():
            waited = False
            while self._clock() < one.orders.stands_s and not is_at_rest(one.link.snapshot()):
                self.world.wait(0.01)
                waited = True
            if waited and not is_at_rest(one.link.snapshot()):
                name = one.name or "the robot"
                doubts.append(f"{name} is not known to be at rest; its lease is over")
        return doubts

    def _restart_planner(self) -> None:
        self._planner.restart()
        if self.scene is not None:
            self._planner.see(self.scene, self.view.revision, None, self._zones)

    def look_after(self, name: str, part: SupervisedPart, turns: Callable[[], int]) -> None:
        """Watch another stage."""
        self._supervisor.add(name, part)
        self._further_turns[name] = turns

    def turns(self) -> dict[str, int]:
        """Counters of stages, which grow while they work or rightly wait for work."""
        turns = {
            "control loop": self._cycles,
            "camera": self.camera.turns,
            **self._planner.turns,
            **{f"{_of(name)}link": one.link.turns for name, one in self.robots.items()},
        }
        if self._recorder is not None and not self._recorder.has_ended():
            turns["recorder"] = self._recorder.turns
        return turns | {name: count() for name, count in self._further_turns.items()}

    def accept_arena(self) -> None:
        """Accept arena and camera as seen now."""
        self.view.doubt.accept()
        self._forget_latency = True

    def settle(self) -> None:
        """Wait briefly, in another thread, until a cycle has acted on earlier orders."""
        wanted = self._ended + 2  # the cycle under way may have decided already
        self.camera.wake()
        with self._turned:
            self._turned.wait_for(lambda: self._ended >= wanted, SETTLE_S)

    # Known facts; any thread may read them.

    @property
    def scene(self) -> Scene | None:
        """Newest scene."""
        return self.view.scene

    @property
    def frame(self) -> Frame | None:
        """Newest picture."""
        return self.view.frame

    @property
    def calibration(self) -> Calibration:
        """Map from pixels to the floor."""
        return self.world.calibration

    def camera_status(self) -> CameraStatus:
        """The camera's state, rate and counts."""
        return self.camera.status()

    @property
    def roadmap(self) -> Roadmap | None:
        """Newest roadmap; the smallest robot's of several."""
        return self.traffic.planner.roadmap

    @property
    def robot(self) -> ControlledRobot:
        """Robot of a run of one."""
        (robot,) = self.robots.values()
        return robot

    @property
    def has_met_its_devices(self) -> bool:
        """True if all robots and the camera have reported."""
        return all(one.pilot.has_met_its_devices for one in self.robots.values())

    def cycle(self) -> RunState:
        """Wait for a frame or the planner's news, at most ``LONGEST_CYCLE_S``, and decide."""
        self._cycles += 1
        self._note_lateness()
        frame = self.camera.take(LONGEST_CYCLE_S)
        seen = frame is not None and self.view.see(frame, self._tell_poses)
        if self._zones_changed() or seen:
            self._show_planner()
        now_s = self._clock()
        failed = self._supervisor.look(now_s)
        camera = self.camera.status()
        self._look_at_camera(camera)
        self.state = self._decide(now_s, failed, camera)
        with self._turned:
            self._ended += 1
            self._turned.notify_all()
        return self.state

    def _zones_changed(self) -> bool:
        if self.zones.revision == self._zones_revision or self.scene is None:
            return False
        self._zones_revision = self.zones.revision
        self._zones = self.zones.zones()
        self.view.zones_changed()
        if self._recorder is not None:
            self._recorder.zones(self._zones, self.view.revision, self._clock())
        return True

    def _show_planner(self) -> None:
        assert self.scene is not None
        self._news.gets_scene()
        points = self.traffic.checked_points()
        self._planner.see(self.scene, self.view.revision, points, self._zones)

    def _note_lateness(self) -> None:
        """Record delays, without this thread's own look at a picture."""
        now_s = self._clock()
        looked_s = (self.view.vision.look_s or 0.0) if self.view.processed != self._looked else 0.0
        self._looked = self.view.processed
        cycle_s, self._cycled_s = now_s - self._cycled_s, now_s
        note = self.punctuality.note
        note("the control loop", cycle_s - LONGEST_CYCLE_S - looked_s, now_s)
        note("a thread", self.world.late_s(), now_s)
        for name, one in self.robots.items():
            note(f"{_of(name) or 'the '}link's thread", one.link.late_s(), now_s)

    def _tell_poses(self, poses: Mapping[int, RobotPose]) -> None:
        for one in self.robots.values():
            one.sees(poses, self.view.frame_s)

    def _look_at_camera(self, camera: CameraStatus) -> None:
        reopened = camera_openings(camera)
        forget = reopened != self._reopened or self._forget_latency
        self._reopened, self._forget_latency = reopened, False
        if forget:
            for one in self.robots.values():
                one.witness.forget_latency()

    def _decide(self, now_s: float, failed: str | None, camera: CameraStatus) -> RunState:
        checks, answer = self._news.take()
        for check in self.traffic.checked(checks):
            if check.breach is not None:
                self.traffic.forget(check.robot)
            with self.lock:
                self.robots[check.robot].pilot.new_scene(check.clearance_m, check.breach)
        for name, one in self.traffic.take(answer).items():
            self.robots[name].answer = one
        decided = {
            name: self._decide_one(robot, now_s, failed, camera)
            for name, robot in self.robots.items()
        }
        self._let_drive(now_s, decided)
        state = self._state(now_s, decided)
        if self._recorder is not None:
            self._recorder.robots(state.robots, state.waits, state.waits_for, now_s)
        return state

    def _decide_one(
        self, robot: ControlledRobot, now_s: float, failed: str | None, camera: CameraStatus
    ) -> Decided:
        snapshot = robot.link.snapshot()
        robot.hears()
        sight = robot.sight(
            now_s,
            self.view,
            camera,
            self._news.known_revision,
            self.traffic.planner.clearance_m,
            failed=failed,
            hold=self._hold,
            punctuality=self.punctuality,
        )
        answer, robot.answer = robot.answer, None
        with self.lock:
            was = robot.pilot.mission.state
            orders = robot.pilot.step(now_s, sight, robot.report(snapshot), answer)
            if robot.pilot.mission.state is State.STOPPED is not was:
                self.stopping.stopped_itself(robot)
        return Decided(orders, sight, snapshot)

    def _let_drive(self, now_s: float, decided: Mapping[str, Decided]) -> None:
        ordered = self.traffic.step(now_s, decided, self._news.known_revision)
        for name, why in ordered.plan_again:
            with self.lock:
                self.robots[name].pilot.replan(why, holding=True)
        for name, station in ordered.errands.items():
            with self.lock, suppress(MissionError):  # a person may have stopped it just now
                self.robots[name].pilot.step_aside(station)
        if ordered.request is not None:
            self._news.gets_request(ordered.request, now_s)
            self._planner.ask(ordered.request)
        for name, robot in self.robots.items():
            robot.answer, robot.partner = ordered.answers.get(name), ordered.holds.get(name)
            one = decided[name]
            self.troubles[f"{_of(name)}journal"] = robot.write_journal(one.orders, now_s)
            robot.drive(one.orders, now_s, one.sight, self.traffic.released(name))
        if ordered.answers:
            self.camera.wake()  # so that the pilots take them at once

    def _state(self, now_s: float, decided: Mapping[str, Decided]) -> RunState:
        time_s, roadmap, times = now_s - self.started_s, self.roadmap, self._times()
        traffic, troubles = self.traffic, self._troubles
        robots = {
            name: robot.state(
                time_s,
                self.view,
                decided[name].snapshot,
                roadmap,
                times,
                troubles,
                traffic.waits.get(name),
            )
            for name, robot in self.robots.items()
        }
        return RunState(
            time_s, robots, dict(traffic.waits), traffic.rounds, dict(traffic.waits_for)
        )

    def _times(self) -> StageTimes:
        wires_s = [one.link.capture_to_wire_s for one in self.robots.values()]
        newest_s = max((times_s[-1] for times_s in wires_s if times_s), default=None)
        return StageTimes(
            self.view.vision.look_s, self._news.roadmap_s, self._news.plan_s, newest_s
        )

    @property
    def _hold(self) -> str | None:
        return self.lent or self.view.hold or self.punctuality.hold(self._clock())

    @property
    def _troubles(self) -> tuple[str, ...]:
        kept = {"stops": self.stopping.trouble, "zones": self.zones.trouble}
        troubles = self.view.troubles | self.troubles | kept
        return tuple(filter(None, troubles.values()))


def _of(name: str) -> str:
    return f"{name}'s " if name else ""

"""The running program with several robots: one eye sees all, each has a pilot and a link.

Threads are those of a run with one robot, and a link's for each. A cycle of the control loop is:
newest frame -> eye -> every pilot -> coordinator -> orders to the planner and the links. The
leases that let the robots move are given by this loop only: should it hang, all stop.

The clock is the world's. Units: metres, radians, seconds.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from navigation.config import Config
from navigation.config.several.each_robot import each_robot
from navigation.fleet.coordinator import Coordinator
from navigation.fleet.request import FleetAnswer
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.daemon_state import DaemonState, StageTimes
from navigation.loop.fleet.fleet_parts import FleetSurroundings
from navigation.loop.fleet.fleet_planner import FleetPlanner
from navigation.loop.fleet.fleet_state import FleetState
from navigation.loop.fleet.seat import Seat, Witnesses
from navigation.loop.parts import camera_part
from navigation.loop.planner_news import PlannerNews
from navigation.loop.reports import camera_openings, camera_reason, to_go_m
from navigation.loop.seeing.eye import Glimpse
from navigation.loop.seeing.other_robots import OtherRobots
from navigation.loop.seeing.scene_doubt import SceneDoubt
from navigation.loop.seeing.vision_stage import VisionStage
from navigation.mission.cycle import Orders, PlanAnswer, PlanRequest, Sight
from navigation.mission.mission import MissionError
from navigation.recording.events import FleetAsked, SceneSeen
from navigation.shared.supervisor import Part, Supervisor
from planner.roadmap.roadmap import Roadmap
from planner.scene import Scene
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder

LONGEST_CYCLE_S: Final = 0.05
SETTLE_S: Final = 0.3
"""An order's answer waits so long at most for a cycle that acts on it."""


class FleetDaemon:
    """Runs a configuration of several robots; a context manager that opens and closes everything.

    ``first_mission_id``: ids on the wires count up from the one after it.
    """

    def __init__(
        self,
        config: Config,
        world: FleetSurroundings,
        *,
        first_mission_id: int,
        recorder: Recorder | None = None,
    ) -> None:
        self.config, self.world = config, world
        self._clock = world.clock
        configs = each_robot(config)
        self.camera = world.make_frames()
        self.seats = {
            name: Seat(name, one, world.make_link(name), first_mission_id)
            for name, one in configs.items()
        }
        driven = [one.robot for one in configs.values()]
        self._vision = VisionStage(
            config,
            world.calibration,
            Witnesses(self.seats),
            self._clock,
            driven,
            world.floor_plan,
        )
        self.newest = self._vision.newest
        self._fleet_planner = FleetPlanner(configs)
        self._news = PlannerNews[FleetAnswer](
            self._fleet_planner, self._clock, self.camera.wake, recorder
        )
        self._planner = world.make_fleet_planner(
            self._fleet_planner, self._news.on_scene, self._news.on_answer
        )
        self.coordinator = Coordinator(self._fleet_planner.path_clearance_m)
        self._supervisor = Supervisor(
            {
                "vision": Part(self._vision.failure, self._vision.restart),
                "planner": Part(self._planner.failure, self._restart_planner),
                "camera's thread": camera_part(self.camera),
                **{
                    f"{name}'s serial link": Part(seat.link.failure, seat.link.restart)
                    for name, seat in self.seats.items()
                },
            }
        )
        self.others = OtherRobots({one.marker_id: one.radius_m for one in config.other_robots})
        self._recorder = recorder
        self.lock = threading.Lock()
        self.scene: Scene | None = None
        self._scene_doubt = SceneDoubt(floor_markers=bool(config.arena.floor_markers))
        self.processed = 0
        self.state: FleetState | None = None
        """What the last cycle ended with; replaced as a whole, so any thread may read it."""
        self.troubles: dict[str, str] = {}
        self.started_s = self._clock()
        self._revision = self._measurable_revision = 0
        self._frame_s = -float("inf")
        self._frame: Frame | None = None
        self._glimpse = Glimpse(-float("inf"), {}, None, None)
        self._reopened = 0
        self._forget_latency = False
        self.waits: Mapping[str, str] = {}
        self._waits_for: Mapping[str, str] = {}
        self._cycles = self._ended = 0
        self._further_turns: dict[str, Callable[[], int]] = {}
        self._turned = threading.Condition()

    # Life.

    def __enter__(self) -> FleetDaemon:
        self.world.start()
        try:
            for seat in self.seats.values():
                seat.link.open()
            self.camera.start()
            self._planner.start()
        except BaseException:
            self.__exit__()
            raise
        self.started_s = self._clock()
        return self

    def __exit__(self, *_error: object) -> None:
        self.let_the_robots_stop()
        self._planner.stop()
        for seat in self.seats.values():
            seat.link.close()
        self.world.stop()

    def halt(self) -> None:
        """Withdraw all leases: the robots begin to brake. No `cycle` may follow."""
        for seat in self.seats.values():
            seat.orders.halt(self._clock())

    def let_the_robots_stop(self) -> None:
        """`halt`, and wait until all robots say that they stand, or should by now."""
        self.halt()
        self.camera.stop()
        for seat in self.seats.values():
            while self._clock() < seat.orders.stands_s and seat.link.snapshot().moving:
                self.world.wait(0.01)

    def _restart_planner(self) -> None:
        self._planner.restart()
        if self.scene is not None:
            self._planner.see(self.scene, self._revision, None)

    def look_after(self, name: str, part: Part, turns: Callable[[], int]) -> None:
        """Watch one more stage like those of the daemon: its failures, and whether it turns."""
        self._supervisor.add(name, part)
        self._further_turns[name] = turns

    def accept_arena(self) -> None:
        """A person says that arena and camera are as they are seen now."""
        self._scene_doubt.accept()
        self._forget_latency = True

    def settle(self) -> None:
        """Wait, in another thread, until a cycle has acted on the orders so far; not for long."""
        wanted = self._ended + 2
        self.camera.wake()
        with self._turned:
            self._turned.wait_for(lambda: self._ended >= wanted, SETTLE_S)

    def turns(self) -> dict[str, int]:
        """For each stage a number that grows while it works, or waits for work as it should."""
        turns = {
            "control loop": self._cycles,
            "camera": self.camera.turns,
            "planner": self._planner.turns,
            **{f"{name}'s link": seat.link.turns for name, seat in self.seats.items()},
        }
        if self._recorder is not None and not self._recorder.has_ended():
            turns["recorder"] = self._recorder.turns
        return turns | {name: count() for name, count in self._further_turns.items()}

    def preview(self, robot: str, request: PlanRequest) -> PlanAnswer:
        """The plan of one robot as if it were alone; any thread may ask."""
        return self._fleet_planner.preview(robot, request)

    @property
    def has_met_its_devices(self) -> bool:
        """Whether every robot and the camera have been there."""
        return all(seat.pilot.has_met_its_devices for seat in self.seats.values())

    @property
    def frame(self) -> Frame | None:
        """The newest picture; any thread may look."""
        return self._frame

    @property
    def roadmap(self) -> Roadmap | None:
        """The newest roadmap of the smallest robot, for pictures."""
        return self._fleet_planner.roadmap

    # The cycle.

    def cycle(self) -> FleetState:
        """Wait for a frame or the planner's news, at most ``LONGEST_CYCLE_S``, and decide."""
        self._cycles += 1
        frame = self.camera.take(LONGEST_CYCLE_S)
        if frame is not None:
            self._see(frame)
        now_s = self._clock()
        failed = self._supervisor.look(now_s)
        self._look_at_camera()
        checks, answer = self._news.take()
        if checks:
            self._look_at_paths()
        decided = {name: self._decide(seat, now_s, failed) for name, seat in self.seats.items()}
        self._coordinate(now_s, decided, answer)
        self.state = self._state(now_s, decided)
        if self._recorder is not None:
            now = self.state
            self._recorder.robots(now.robots, now.waits, now.waits_for, now_s)
        with self._turned:
            self._ended += 1
            self._turned.notify_all()
        return self.state

    def _see(self, frame: Frame) -> None:
        if self._vision.failure() is not None:
            return
        self._frame_s = min(frame.captured_s, self._clock())
        seen = self._vision.look(frame, self._tell_poses)
        if seen is None:
            return
        frame, glimpse = seen
        self.processed += 1
        held, self._frame, self._glimpse = self._glimpse.hold, frame, glimpse
        self.others.see(glimpse.poses)
        self.troubles |= {**glimpse.troubles, **self._scene_doubt.look(glimpse)}
        if glimpse.scene is not None:
            self._revision += 1
            self.scene = glimpse.scene
            self._news.gets_scene()
            self._planner.see(glimpse.scene, self._revision, None)
        if held and not glimpse.hold:
            self._measurable_revision = self._revision  # the planner may not know it yet
        if self._recorder is not None:
            scene, at_s = glimpse.scene, frame.captured_s
            event = None if scene is None else SceneSeen(at_s, self._revision, scene)
            self._recorder.saw(frame, glimpse.poses, event)

    def _tell_poses(self, poses: Mapping[int, RobotPose]) -> None:
        for seat in self.seats.values():
            seat.sees(poses, self._frame_s)

    def _look_at_camera(self) -> None:
        """Whether the camera is another one than before, for which latency counts again."""
        reopened = camera_openings(self.camera.status())
        forget = reopened != self._reopened or self._forget_latency
        self._reopened, self._forget_latency = reopened, False
        if forget:
            for seat in self.seats.values():
                seat.witness.forget_latency()

    def _look_at_paths(self) -> None:
        """What a new scene leaves of the paths that are driven."""
        for seat in self.seats.values():
            path = seat.pilot.plan.path
            if path is not None:
                with self.lock:
                    seat.pilot.new_scene(self._fleet_planner.path_clearance_m(path.points))

    def _decide(
        self, seat: Seat, now_s: float, failed: str | None
    ) -> tuple[Orders, Sight, LinkSnapshot]:
        """One pilot's cycle."""
        snapshot = seat.link.snapshot()
        seat.hears(snapshot, now_s, forget_latency=False)
        sight = self._sight(seat, now_s, failed)
        answer, seat.answer = seat.answer, None
        with self.lock:
            orders = seat.pilot.step(now_s, sight, seat.report(snapshot), answer)
        return orders, sight, snapshot

    def _sight(self, seat: Seat, now_s: float, failed: str | None) -> Sight:
        place = None if seat.pose is None else seat.witness.carried(seat.pose, now_s)
        clearance = None  # in the unknown nothing can be measured
        measurable = self._news.known_revision >= self._measurable_revision
        if place is not None and measurable and not self._glimpse.hold:
            clearance = self._fleet_planner.clearance_m(place[:2])
        seat.clearance_m = clearance
        double = self._glimpse.doubles.get(seat.config.robot.marker_id)
        return Sight(
            frame_age_s=now_s - self._frame_s,
            pose_age_s=now_s - seat.pose_arrived_s,
            pose=place,
            scene_revision=self._news.known_revision,
            clearance_m=clearance,
            failed=failed,
            camera_reason=camera_reason(self.camera.status()),
            others=self.others.movers(now_s),
            doubles=() if double is None else (double,),
            evidence=seat.evidence,
            scene_doubt=self._scene_doubt.hold or self._glimpse.hold,
            partner=seat.partner,
        )

    def _coordinate(
        self,
        now_s: float,
        decided: Mapping[str, tuple[Orders, Sight, LinkSnapshot]],
        answer: FleetAnswer | None,
    ) -> None:
        """What follows for all, and everybody's orders."""
        members = {
            name: seat.member(now_s, decided[name][0], decided[name][2])
            for name, seat in self.seats.items()
        }
        fleet = self.coordinator.step(now_s, members, self._news.known_revision, answer)
        for name, why in fleet.plan_again:
            with self.lock:
                self.seats[name].pilot.replan(why, holding=True)
        for name, station in fleet.errands.items():
            with self.lock, suppress(MissionError):  # a person may have stopped it just now
                self.seats[name].pilot.give((station,))
        self.waits, self._waits_for = fleet.waits, fleet.waits_for
        if fleet.request is not None:
            self._news.gets_request(now_s)
            self._planner.ask(fleet.request)
            if self._recorder is not None:
                self._recorder.put(FleetAsked(now_s, fleet.request))
        for name, seat in self.seats.items():
            seat.answer = fleet.answers.get(name)
            seat.partner = fleet.holds.get(name)
            orders, sight, _ = decided[name]
            trouble = seat.write_journal(orders, now_s)
            self.troubles[f"{name}'s journal"] = trouble
            seat.carry_out(orders, now_s, sight, self.coordinator.release(name))
        if fleet.answers:
            self.camera.wake()  # the pilots take them at once

    def _state(
        self, now_s: float, decided: Mapping[str, tuple[Orders, Sight, LinkSnapshot]]
    ) -> FleetState:
        robots = {
            name: self._state_of(seat, now_s, decided[name][2]) for name, seat in self.seats.items()
        }
        return FleetState(
            now_s - self.started_s,
            robots,
            dict(self.waits),
            self.coordinator.rounds,
            dict(self._waits_for),
        )

    def _state_of(self, seat: Seat, now_s: float, snapshot: LinkSnapshot) -> DaemonState:
        mission = seat.pilot.mission
        return DaemonState(
            time_s=now_s - self.started_s,
            mission=mission,
            sentence=self.waits.get(seat.name) or mission.reason,
            pose=seat.pose,
            link=snapshot,
            to_go_m=to_go_m(seat.pose, seat.pilot.plan.targets, snapshot.executed),
            clearance_m=seat.clearance_m,
            verdict=seat.pilot.verdict,
            frame=self._frame,
            poses=self._glimpse.poses,
            roadmap=self._fleet_planner.roadmap,
            path=seat.pilot.plan.path,
            times=StageTimes(self._vision.look_s, self._news.roadmap_s, self._news.plan_s),
            evidence=seat.evidence,
            trust=seat.pilot.trust.level,
            troubles=tuple(filter(None, self.troubles.values())),
        )

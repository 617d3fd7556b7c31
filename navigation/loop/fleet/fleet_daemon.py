"""The running program with several robots: one eye sees all, each has a pilot and a link.

A cycle's decisions: every pilot -> coordinator -> orders to the planner and the links.
Units: metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from navigation.config import Config
from navigation.config.several.each_robot import each_robot
from navigation.fleet.coordinator import Coordinator
from navigation.fleet.request import FleetAnswer, FleetRequest
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.control_loop import ControlLoop
from navigation.loop.fleet.fleet_parts import FleetSurroundings
from navigation.loop.fleet.fleet_planner import FleetPlanner
from navigation.loop.fleet.fleet_state import FleetState
from navigation.loop.fleet.seat import Seat, Witnesses
from navigation.mission.cycle import Orders, PlanAnswer, PlanRequest, Sight
from navigation.mission.mission import MissionError, State
from navigation.recording.events import FleetAsked
from vision.camera.latest_frame import CameraStatus

if TYPE_CHECKING:
    from navigation.loop.recorder import Recorder


class FleetDaemon(ControlLoop[FleetState, FleetRequest, FleetAnswer]):
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
        self.world = world
        configs = each_robot(config)
        self.seats = {
            name: Seat(name, one, world.make_link(name), first_mission_id)
            for name, one in configs.items()
        }
        driven = [one.robot for one in configs.values()]
        super().__init__(config, world, self.seats, Witnesses(self.seats), driven, recorder)
        self._fleet_planner = FleetPlanner(configs, world.search_clock)
        self._set_planner(
            self._fleet_planner, partial(world.make_fleet_planner, self._fleet_planner)
        )
        self.coordinator = Coordinator(self._fleet_planner.path_clearance_m)
        self.waits: Mapping[str, str] = {}
        self._waits_for: Mapping[str, str] = {}

    def preview(self, robot: str, request: PlanRequest) -> PlanAnswer:
        """The plan of one robot as if it were alone; any thread may ask."""
        return self._fleet_planner.preview(robot, request)

    @property
    def has_met_its_devices(self) -> bool:
        """Whether every robot and the camera have been there."""
        return all(seat.pilot.has_met_its_devices for seat in self.seats.values())

    # The cycle.

    def _decide(self, now_s: float, failed: str | None, camera: CameraStatus) -> FleetState:
        checks, answer = self._news.take()
        if checks:
            self._look_at_paths()
        decided = {
            name: self._decide_one(seat, now_s, failed, camera) for name, seat in self.seats.items()
        }
        self._coordinate(now_s, decided, answer)
        state = self._state(now_s, decided)
        if self._recorder is not None:
            self._recorder.robots(state.robots, state.waits, state.waits_for, now_s)
        return state

    def _look_at_paths(self) -> None:
        """What a new scene leaves of the paths that are driven."""
        for seat in self.seats.values():
            path = seat.pilot.plan.path
            if path is not None:
                with self.lock:
                    seat.pilot.new_scene(self._fleet_planner.path_clearance_m(path.points))

    def _decide_one(
        self, seat: Seat, now_s: float, failed: str | None, camera: CameraStatus
    ) -> tuple[Orders, Sight, LinkSnapshot]:
        """One pilot's cycle."""
        snapshot = seat.link.snapshot()
        seat.hears()
        sight = seat.sight(
            now_s,
            self.view,
            camera,
            self._news.known_revision,
            self._fleet_planner.clearance_m,
            failed=failed,
            hold=self._hold,
            punctuality=self.punctuality,
            partner=seat.partner,
        )
        answer, seat.answer = seat.answer, None
        with self.lock:
            was = seat.pilot.mission.state
            orders = seat.pilot.step(now_s, sight, seat.report(snapshot), answer)
            if seat.pilot.mission.state is State.STOPPED is not was:
                self.stopping.stopped_itself(seat)
        return orders, sight, snapshot

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
                self.seats[name].pilot.step_aside(station)
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
            seat.drive(orders, now_s, sight, self.coordinator.release(name))
        if fleet.answers:
            self.camera.wake()  # the pilots take them at once

    def _state(
        self, now_s: float, decided: Mapping[str, tuple[Orders, Sight, LinkSnapshot]]
    ) -> FleetState:
        time_s, roadmap, times = now_s - self.started_s, self.roadmap, self._times()
        robots = {
            name: seat.state(
                time_s,
                self.view,
                decided[name][2],
                roadmap,
                times,
                self._troubles,
                self.waits.get(name),
            )
            for name, seat in self.seats.items()
        }
        return FleetState(
            time_s, robots, dict(self.waits), self.coordinator.rounds, dict(self._waits_for)
        )

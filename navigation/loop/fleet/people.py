"""Orders from people to several robots: to all of them, or to the one that is named.

Any thread may give them; the next cycle acts on them. Metres, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from navigation.loop.fleet.fleet_daemon import FleetDaemon
from navigation.loop.fleet.seat import Seat
from navigation.loop.reports import describe, to_go_m
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import STOPPING, Mission, MissionError, State, Station
from planner.path import NoPath


class People:
    """Takes the orders of a run; ``robot`` is a name, None where all robots are meant."""

    def __init__(self, daemon: FleetDaemon) -> None:
        self._daemon, self._seats = daemon, daemon.seats
        self.reanchor: Callable[[str | None], list[str]] | None = None

    def _chosen(self, robot: str | None) -> list[Seat]:
        if robot is None:
            return list(self._seats.values())
        if robot not in self._seats:
            raise MissionError(f"robot '{robot}': there are {', '.join(self._seats)}")
        return [self._seats[robot]]

    def of(self, robot: str) -> OneOfFleet:
        """One robot, taking orders; ``MissionError`` where there is none of that name."""
        (seat,) = self._chosen(robot)
        return OneOfFleet(self, seat.name)

    def give(self, stations: tuple[Station, ...], robot: str | None = None) -> None:
        """A new mission for one robot; ``MissionError`` where it cannot be."""
        if robot is None:
            names = ", ".join(self._seats)
            raise MissionError(f"there are several robots: say which one goes (--robot: {names})")
        (seat,) = self._chosen(robot)
        with self._daemon.lock:
            seat.pilot.give(stations)

    def appoint(self, stations: tuple[Station, ...], robot: str) -> None:
        """The configured mission: given, or put behind the stop of a robot that is stopped."""
        pilot = self._seats[robot].pilot
        with self._daemon.lock:
            if pilot.mission.state is State.STOPPED:
                pilot.appoint(Mission(stations))
            else:
                pilot.give(stations)

    def restore(self, robot: str, mission: Mission) -> None:
        """Go on with a robot's mission from its journal."""
        with self._daemon.lock:
            self._seats[robot].pilot.restore(mission)

    def stop(self, reason: str, robot: str | None = None) -> str | None:
        """Emergency stop of one or all: straight to the links, past every queue, then latched."""
        return self._daemon.stopping.stop(self._chosen(robot), reason)

    def pause(self, robot: str | None = None) -> None:
        """Hold where the robots are."""
        chosen = self._chosen(robot)
        with self._daemon.lock:
            for seat in chosen:
                seat.pilot.pause()

    def resume(self, robot: str | None = None) -> None:
        """End a pause; after a stop re-arm the robots, and the next time go on."""
        self._daemon.stopping.resume(self._chosen(robot))
        self._daemon.accept_arena()

    def replan(self, robot: str | None = None) -> None:
        """Plan again from where the robots are."""
        chosen = self._chosen(robot)
        with self._daemon.lock:
            for seat in chosen:
                self._daemon.coordinator.forget(seat.name)
                seat.pilot.replan()

    def preview(self, stations: tuple[Station, ...], robot: str) -> PlanAnswer:
        """What a robot would drive through these stations if it were alone; changes nothing."""
        (seat,) = self._chosen(robot)
        pose = seat.pose
        if pose is None:
            return PlanAnswer(0, 0, NoPath(f"{robot} was not seen yet"))
        start = (pose.x, pose.y, pose.heading_rad)
        return self._daemon.preview(robot, PlanRequest(0, start, stations, 0))

    def settle(self) -> None:
        """Wait, in another thread, until a cycle has acted on the orders so far; not for long."""
        self._daemon.settle()

    def describe(self, robot: str | None = None) -> dict[str, Any]:
        """The present state as JSON takes it: of one robot, or of all by name."""
        chosen = self._chosen(robot)
        told = {seat.name: self._describe_one(seat) for seat in chosen}
        if robot is not None:
            return told[robot]
        state = self._daemon.state
        if state is None:
            return {"state": "starting", "reason": "", "robots": told}
        stopping = state.state is State.STOPPED and any(
            one["state"] == STOPPING for one in told.values()
        )
        return {
            "state": STOPPING if stopping else state.state.value,
            "reason": state.sentence,
            "robots": told,
        }

    def _describe_one(self, seat: Seat) -> dict[str, Any]:
        with self._daemon.lock:
            mission, pose = seat.pilot.mission, seat.pose
        snapshot = seat.link.snapshot()
        told = describe(
            mission,
            None if pose is None else (pose, self._daemon.world.clock() - pose.captured_s),
            to_go_m(pose, seat.pilot.plan.targets, snapshot.executed),
            snapshot,
            self._daemon.camera.status(),
            seat.evidence.latency_s,
        )
        return told | {"waits": self._daemon.waits.get(seat.name)}


class OneOfFleet:
    """One robot of several, taking the orders that a robot alone takes."""

    def __init__(self, fleet: People, name: str) -> None:
        self._fleet, self._name = fleet, name

    def give(self, stations: tuple[Station, ...]) -> None:
        """A new mission; MissionError where it cannot be."""
        self._fleet.give(stations, self._name)

    def stop(self, reason: str) -> str | None:
        """Emergency stop of this robot, latched."""
        return self._fleet.stop(reason, self._name)

    def pause(self) -> None:
        """Hold until resumed."""
        self._fleet.pause(self._name)

    def resume(self) -> None:
        """End a pause; after a stop re-arm, and the next time go on."""
        self._fleet.resume(self._name)

    def replan(self) -> None:
        """Plan again from where it is."""
        self._fleet.replan(self._name)

    def settle(self) -> None:
        """Return when the orders given so far were acted on, soon in any case."""
        self._fleet.settle()

    def describe(self) -> Mapping[str, Any]:
        """The present state, as JSON takes it."""
        return self._fleet.describe(self._name)

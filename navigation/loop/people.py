"""Orders from people: to all robots of a run, or to one by name.

Any thread may give them; the next cycle acts on them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from threading import Lock
from typing import Any, Protocol

from navigation.config import Config
from navigation.config.zones import ZoneSection
from navigation.config.zones.in_words import as_written
from navigation.config.zones.zone_checks import outside_arena
from navigation.loop.parts import FrameSource, Surroundings
from navigation.loop.reports import describe, to_go_m
from navigation.loop.robot import ControlledRobot
from navigation.loop.run_state import RunState
from navigation.loop.stopping import Stopping
from navigation.loop.traffic.traffic import Traffic
from navigation.loop.zones_in_force import ZonesInForce
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import STOPPING, MissionError, MissionProgress, State, Station
from navigation.shared.outside import in_short
from planner.path import NoPath


class OrderedRun(Protocol):
    """The run that orders act on: the daemon."""

    config: Config
    robots: dict[str, ControlledRobot]
    zones: ZonesInForce
    traffic: Traffic
    stopping: Stopping
    world: Surroundings
    camera: FrameSource
    lock: Lock
    lent: str | None
    state: RunState | None

    def accept_arena(self) -> None:
        """Accept arena and camera as seen now."""

    def settle(self) -> None:
        """Wait briefly until a cycle has acted on earlier orders."""


class People:
    """Takes the orders of a run; ``robot`` is a name, None for all robots.

    ``reanchor`` finds the place of the named or only camera again and returns the lines to say.
    ``masks_in`` is the folder that the masks of ordered zones are in; None allows no mask.
    """

    def __init__(self, daemon: OrderedRun) -> None:
        self._daemon = daemon
        self.reanchor: Callable[[str | None], list[str]] = _cannot_reanchor
        self.masks_in: Path | None = None

    def _chosen(self, robot: str | None) -> list[ControlledRobot]:
        robots = self._daemon.robots
        if robot is None:
            return list(robots.values())
        if robot and robot in robots:
            return [robots[robot]]
        if "" in robots:
            name = in_short(robot)
            raise MissionError(f"robot {name}: this run has one robot, which has no name")
        raise MissionError(f"robot '{robot}': there are {', '.join(robots)}")

    def _one(self, robot: str | None) -> ControlledRobot:
        chosen = self._chosen(robot)
        if len(chosen) > 1:
            names = ", ".join(self._daemon.robots)
            raise MissionError(f"there are several robots: say which one goes (--robot: {names})")
        return chosen[0]

    def give(
        self, stations: tuple[Station, ...], robot: str | None = None, *, any_order: bool = False
    ) -> None:
        """Give one robot a mission; ``MissionError`` if it cannot, or does not fit at a station."""
        one = self._one(robot)
        if self._daemon.lent is not None:
            raise MissionError(self._daemon.lent)
        one.pilot.settings.check_stations(stations)
        limits = one.pilot.settings.limits
        rules = self._daemon.traffic.planner.rules(one.name)
        for number, station in enumerate(stations, 1):
            place = (station.x, station.y)
            breach = rules and rules.station_breach(f"station {number} at", place)
            if breach:
                raise MissionError(breach)
            clearance_m = self._daemon.traffic.planner.clearance_m(place)
            if (
                clearance_m is None
                or clearance_m >= limits.robot_radius_m - limits.clearance_slack_m
            ):
                continue
            where = f"station {number} at ({station.x:g}, {station.y:g}) m"
            if clearance_m <= 0.0:
                raise MissionError(f"{where}: lies in an obstacle")
            raise MissionError(
                f"{where}: the nearest obstacle is {clearance_m:.3f} m away, the robot's radius is"
                f" {limits.robot_radius_m:.3f} m"
            )
        with self._daemon.lock:
            one.pilot.give(stations, any_order=any_order)

    def appoint(self, mission: MissionProgress, robot: str) -> None:
        """Give the configured mission, or queue it behind a robot's stop."""
        pilot = self._daemon.robots[robot].pilot
        with self._daemon.lock:
            if pilot.mission.state is State.STOPPED:
                pilot.appoint(mission)
            else:
                pilot.give(mission.stations, any_order=mission.any_order)

    def restore(self, mission: MissionProgress, robot: str) -> None:
        """Continue a robot's mission from its journal."""
        with self._daemon.lock:
            self._daemon.robots[robot].pilot.restore(mission)

    def stop(self, reason: str, robot: str | None = None) -> str | None:
        """Stop in an emergency: straight to the links, then latched.

        A name that no robot has stops them all, since it was meant for one of them, and raises
        `MissionError` afterwards.
        """
        try:
            chosen, unknown = self._chosen(robot), ""
        except MissionError as error:
            chosen, unknown = self._chosen(None), str(error)
        trouble = self._daemon.stopping.stop(chosen, reason)
        if unknown:
            which = "all robots were" if len(chosen) > 1 else "the robot was"
            raise MissionError("; ".join(filter(None, (unknown, f"{which} stopped", trouble))))
        return trouble

    def pause(self, robot: str | None = None) -> None:
        """Hold where the robots are."""
        chosen = self._chosen(robot)
        with self._daemon.lock:
            for one in chosen:
                one.pilot.pause()

    def resume(self, robot: str | None = None) -> None:
        """End a pause; re-arm after a stop, and continue at the next call."""
        self._daemon.stopping.resume(self._chosen(robot))
        self._daemon.accept_arena()

    def replan(self, robot: str | None = None) -> None:
        """Plan again from where the robots are."""
        chosen = self._chosen(robot)
        with self._daemon.lock:
            for one in chosen:
                self._daemon.traffic.forget(one.name)
                one.pilot.replan()

    def skip(self, robot: str | None = None) -> None:
        """Give up one robot's next station; ``MissionError``."""
        one = self._one(robot)
        with self._daemon.lock:
            one.pilot.skip()
            self._daemon.traffic.forget(one.name)

    def put_zone(self, zone: ZoneSection) -> dict[str, Any]:
        """Add a zone, or replace the one of its name; ``MissionError``."""
        outside = outside_arena(zone, self._daemon.config.arena.bounds_m)
        if outside is not None:
            raise MissionError(f"zone '{zone.name}': {outside}")
        self._daemon.zones.put(zone)
        return self.zones()

    def remove_zone(self, name: str) -> dict[str, Any]:
        """Remove a zone; ``MissionError``."""
        self._daemon.zones.remove(name)
        return self.zones()

    def undo_zone(self, seen: int | None) -> dict[str, Any]:
        """Undo the last change of zones; ``MissionError``, if it is not that of ``seen``."""
        self._daemon.zones.undo(seen)
        return self.zones()

    def zones(self) -> dict[str, Any]:
        """Zones in force for JSON, and their changes against the configuration.

        ``kept`` is true if a file keeps changes for a restart; ``trouble`` says why it failed to.
        """
        zones = self._daemon.zones
        answer: dict[str, Any] = {
            "zones": [as_written(one) for one in zones.sections],
            "changes": {one.name: one.in_a_word for one in zones.changes()},
            "kept": zones.are_kept,
        }
        return answer | ({"trouble": zones.trouble} if zones.trouble else {})

    def preview(self, stations: tuple[Station, ...], robot: str | None = None) -> PlanAnswer:
        """Plan as if the robot were alone; changes nothing."""
        one = self._one(robot)
        pose = one.pose
        if pose is None:
            return PlanAnswer(0, 0, NoPath(f"{one.name or 'the robot'} was not seen yet"))
        start = (pose.x, pose.y, pose.heading_rad)
        return self._daemon.traffic.preview(one.name, PlanRequest(0, start, stations, 0))

    def settle(self) -> None:
        """Wait briefly, in another thread, until a cycle has acted on earlier orders."""
        self._daemon.settle()

    def describe(self, robot: str | None = None) -> dict[str, Any]:
        """Present state of one robot, or of several by name, for JSON."""
        chosen = self._chosen(robot)
        robots = {one.name: self._describe_one(one) for one in chosen}
        if robot is not None or "" in robots:
            return next(iter(robots.values()))
        state = self._daemon.state
        if state is None:
            return {"state": "starting", "reason": "", "robots": robots}
        stopping = state.state is State.STOPPED and any(
            one["state"] == STOPPING for one in robots.values()
        )
        return {
            "state": STOPPING if stopping else state.state.value,
            "reason": state.sentence,
            "robots": robots,
        }

    def _describe_one(self, robot: ControlledRobot) -> dict[str, Any]:
        with self._daemon.lock:
            mission, pose = robot.pilot.mission, robot.pose
        snapshot = robot.link.snapshot()
        status = describe(
            mission,
            None if pose is None else (pose, self._daemon.world.clock() - pose.captured_s),
            to_go_m(pose, robot.pilot.plan.targets, snapshot.executed),
            snapshot,
            self._daemon.camera.status(),
            robot.evidence.latency_s,
        )
        if not robot.name:  # a lone robot waits for no other
            return status
        return status | {"waits": self._daemon.traffic.waits.get(robot.name)}


def _cannot_reanchor(_camera: str | None) -> list[str]:
    raise MissionError("reanchor: this run cannot place its camera again")

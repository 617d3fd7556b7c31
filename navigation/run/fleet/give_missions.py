"""The configured missions, each to its robot; tasks once it is known where all robots are.

Tasks go to those robots that have no stations of their own so that the straight distances together
are least. After a kill every journal's unfinished mission continues; what its journal says is over
stays over as long as another robot's mission continues, so that nobody drives twice what was done
once, or what a person has stopped. Metres, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final

import networkx as nx

from navigation.config.values import Station as ConfiguredStation
from navigation.loop.fleet.fleet_daemon import FleetDaemon
from navigation.loop.fleet.people import People
from navigation.loop.fleet.seat import Seat
from navigation.loop.stages import stations_of
from navigation.mission.mission import Mission, Station
from planner.scene import Vec

ROBOT_PATIENCE_S: Final = 3.0
"""How long a restart waits for the robots to say how far they have come."""


class GiveMissions:
    """Gives missions as soon as they can be given; `cycle` before each of the daemon's."""

    def __init__(self, daemon: FleetDaemon, say: Callable[[str], None]) -> None:
        self._daemon, self._say = daemon, say
        self._people = People(daemon)
        self._until_s = daemon.world.clock() + ROBOT_PATIENCE_S
        self._left: dict[str, Mission] = {}
        self._kept: dict[str, Mission] = {}
        """Of a run that continues: what each journal holds, finished or not."""
        for name, seat in daemon.seats.items():
            mission = None if seat.journal is None else seat.journal.mission()
            if mission is not None:
                self._kept[name] = mission
            unfinished = None if seat.journal is None else seat.journal.unfinished()
            if unfinished is not None:
                self._left[name] = unfinished
        if not self._left:
            self._kept = {}
        for name, mission in self._kept.items():
            if name not in self._left:
                say(f"{name} has nothing to continue: its mission was {mission.state.value}")
        for name, seat in daemon.seats.items():
            stations = stations_of(seat.config)
            if stations and name not in self._kept:
                self._people.give(stations, name)
        self._tasks = self._open_tasks()
        self.cycle()

    def _open_tasks(self) -> tuple[ConfiguredStation, ...]:
        """Tasks that nobody has: all of a run's, and of one that continues what it had not given.

        They are given in one moment, but journals are written one after the other: a kill between
        two of them leaves fewer missions than there were to give.
        """
        tasks = self._daemon.config.tasks
        if not self._kept:
            return tasks
        free = [name for name, seat in self._daemon.seats.items() if not stations_of(seat.config)]
        served = [self._kept[name].stations for name in free if name in self._kept]
        if len(served) >= min(len(tasks), len(free)):
            return ()
        return tuple(task for task in tasks if (_station(task),) not in served)

    @property
    def are_given(self) -> bool:
        """Whether every robot has what is configured for it."""
        return not self._left and not self._tasks

    def cycle(self) -> None:
        """Give what can be given by now."""
        for name in list(self._left):
            self._continue(name)
        seats = self._daemon.seats
        free = {
            name: seat
            for name, seat in seats.items()
            if not seat.pilot.mission.stations and name not in self._kept
        }
        if self._tasks and all(seat.pose is not None for seat in free.values()):
            stations = [_station(task) for task in self._tasks]
            for name, number in best_placed(_places(free), stations).items():
                self._people.give((stations[number],), name)
                self._say(f"task {number + 1} goes to {name}")
            self._tasks = ()

    def _continue(self, name: str) -> None:
        """The journal's mission, once the robot has said how far it has come of it, or not."""
        seat, mission = self._daemon.seats[name], self._left[name]
        assert seat.journal is not None
        plan = seat.journal.plan()
        snapshot = seat.link.snapshot()
        silent = snapshot.down_reason is not None or snapshot.status is None
        if plan is not None and silent and self._daemon.world.clock() < self._until_s:
            return
        if plan is not None and not silent and snapshot.mission_id == plan.mission_id:
            visited = min(plan.visited_after(snapshot.executed), len(mission.stations) - 1)
            mission = mission.with_visited(max(mission.visited, visited))
        del self._left[name]
        self._say(
            f"{name} continues: {mission.visited} of {len(mission.stations)} stations were visited"
        )
        self._people.restore(name, mission)


def _places(seats: Mapping[str, Seat]) -> dict[str, Vec]:
    return {
        name: (seat.pose.x, seat.pose.y) for name, seat in seats.items() if seat.pose is not None
    }


def _station(task: ConfiguredStation) -> Station:
    return Station(task.x_m, task.y_m, task.heading_rad, task.dwell_s)


def best_placed(places: Mapping[str, Vec], stations: Sequence[Station]) -> dict[str, int]:
    """Which robot goes to which station so that the distances together are least.

    Exact (a matching of least weight); with fewer robots than stations some are left over.
    """
    graph: nx.Graph[str | int] = nx.Graph()
    for name, place in places.items():
        for number, station in enumerate(stations):
            graph.add_edge(name, number, weight=-math.dist(place, (station.x, station.y)))
    pairs = nx.max_weight_matching(graph, maxcardinality=True)
    found = {}
    for a, b in pairs:
        name, number = (a, b) if isinstance(a, str) else (b, a)
        found[name] = number
    return dict(sorted(found.items(), key=lambda item: item[1]))

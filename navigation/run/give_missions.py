"""Give the configured missions to their robots, and tasks once all robots have been located.

Tasks go to robots without stations before any robot moves, with the least sum of driving times of
robots alone. After a kill, every journal's unfinished mission continues. While any does, missions
recorded as over stay over: no robot repeats finished work or what a person has stopped. Metres,
seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from navigation.config import limits_of
from navigation.config.values import StationSection as ConfiguredStation
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import MissionProgress, Station
from planner.fleet.assignment import assign_tasks

ROBOT_PATIENCE_S: Final = 3.0
"""Time that a restart waits for the robots to report their progress."""


class GiveMissions:
    """Distribution of missions; call `cycle` before each of the daemon's.

    ``for_orders`` gives nothing configured.
    """

    def __init__(
        self, daemon: Daemon, say: Callable[[str], None], *, for_orders: bool = False
    ) -> None:
        self._daemon, self._say = daemon, say
        self._people = daemon.people
        self._until_s = daemon.world.clock() + ROBOT_PATIENCE_S
        self._left: dict[str, MissionProgress] = {}
        self._kept: dict[str, MissionProgress] = {}
        """Missions in the journals of a run that continues, finished or not."""
        self._given: dict[str, tuple[Station, ...]] = {}
        for name, robot in daemon.robots.items():
            mission = None if robot.journal is None else robot.journal.mission()
            if mission is not None:
                self._kept[name] = mission
            unfinished = None if robot.journal is None else robot.journal.unfinished()
            if unfinished is not None:
                self._left[name] = unfinished
        rearmed = self._rearmed()
        if not self._left and not rearmed:
            self._kept = {}
        for name, mission in self._kept.items():
            if name not in self._left and name not in rearmed:
                say(f"{_who(name)} has nothing to continue: its mission was {mission.state.value}")
        for name, robot in daemon.robots.items():
            stations = stations_of(robot.config)
            if stations and name not in self._kept and not for_orders:
                self._given[name] = stations
        self._tasks = () if for_orders else self._open_tasks()
        self.cycle()

    def _rearmed(self) -> set[str]:
        """Names of robots re-armed, which wait for the second resume."""
        found = set()
        for name, robot in self._daemon.robots.items():
            mission = None if robot.journal is None else robot.journal.rearmed()
            if mission is not None:
                self._say(
                    f"{_who(name)} was re-armed before this run began: "
                    "it waits for `clearway resume`"
                )
                with self._daemon.lock:
                    robot.pilot.appoint(mission)
                found.add(name)
        return found

    def _open_tasks(self) -> tuple[ConfiguredStation, ...]:
        """Unassigned tasks; a kill between two journals' writes leaves some without a mission."""
        tasks = self._daemon.config.tasks
        if not self._kept:
            return tasks
        free = [
            name for name, robot in self._daemon.robots.items() if not stations_of(robot.config)
        ]
        served = [self._kept[name].stations for name in free if name in self._kept]
        if len(served) >= min(len(tasks), len(free)):
            return ()
        return tuple(task for task in tasks if (_station(task),) not in served)

    @property
    def are_given(self) -> bool:
        """True if every robot has its configured missions and tasks."""
        return not self._left and not self._tasks and not self._given

    def cycle(self) -> None:
        """Give what can be given now."""
        if self._tasks:
            self._assign()
        if self._tasks:
            return
        for name in list(self._left):
            self._continue(name)
        for name, stations in self._given.items():
            any_order = self._daemon.robots[name].config.mission.order == "best"
            self._people.appoint(MissionProgress(stations, any_order=any_order), name)
        self._given = {}

    def _assign(self) -> None:
        """Assign tasks once all free robots were seen and a roadmap exists."""
        robots = self._daemon.robots
        free = {
            name: robot
            for name, robot in robots.items()
            if name not in self._given
            and name not in self._kept
            and not robot.pilot.mission.stations
        }
        roadmap = self._daemon.roadmap
        if roadmap is None or any(robot.pose is None for robot in free.values()):
            return
        names = list(free)
        chosen = assign_tasks(
            roadmap,
            [(robot.pose.x, robot.pose.y) for robot in free.values() if robot.pose is not None],
            [(task.x_m, task.y_m) for task in self._tasks],
            [robot.config.robot.radius_m for robot in free.values()],
            [limits_of(robot.config) for robot in free.values()],
        )
        for name, number in zip(names, chosen.tasks, strict=True):
            if number is not None:
                self._given[name] = (_station(self._tasks[number]),)
                self._say(f"task {number + 1} goes to {name}")
        for number in chosen.left_over:
            self._say(f"task {number + 1} goes to no robot: no free one has a path to it")
        self._tasks = ()

    def _continue(self, name: str) -> None:
        robot, mission = self._daemon.robots[name], self._left[name]
        assert robot.journal is not None
        plan = robot.journal.plan()
        snapshot = robot.link.snapshot()
        silent = snapshot.down_reason is not None or snapshot.status is None
        if plan is not None and silent and self._daemon.world.clock() < self._until_s:
            return
        if plan is not None and not silent and snapshot.mission_id == plan.mission_id:
            visited = min(plan.visited_after(snapshot.executed), len(mission.stations) - 1)
            mission = mission.with_visited(max(mission.visited, visited))
        del self._left[name]
        self._say(
            f"{_who(name)} continues: {mission.visited} of {len(mission.stations)} stations "
            "were visited"
        )
        self._people.restore(mission, name)


def _station(task: ConfiguredStation) -> Station:
    return Station(task.x_m, task.y_m, task.heading_rad, task.dwell_s)


def _who(name: str) -> str:
    return name or "the robot"

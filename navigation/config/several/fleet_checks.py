"""Checks across several driven robots."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from typing import Any

from navigation.config.marks import Location
from navigation.config.recording import ZONES_FILE
from navigation.config.sections import MissionSection
from navigation.config.several.each_robot import named_places
from navigation.config.values import SIMULATED, Place, with_own

_Found = Iterator[tuple[Location, str]]


def names_markers_and_ports_differ(robots: Any, serial: Any, other_robots: Any) -> _Found:
    """Two robots with one name, marker or line cannot be distinguished."""
    names: dict[str, int] = {}
    markers = {one.marker_id: f"other_robots[{i}]" for i, one in enumerate(other_robots)}
    ports: dict[str, str] = {}
    for index, entry in enumerate(robots):
        if entry.name in names:
            yield (
                ("robots", index, "name"),
                f"'{entry.name}' is the name of robots[{names[entry.name]}] already",
            )
        names.setdefault(entry.name, index)
        if entry.marker_id in markers:
            owner = markers[entry.marker_id]
            yield ("robots", index, "marker_id"), f"{entry.marker_id} is {owner}'s already"
        markers.setdefault(entry.marker_id, f"robots[{index}] ({entry.name})")
        port = with_own(serial, entry).port
        if port in ports:
            where: Location = ("robots", index, "port") if entry.port else ("robots", index)
            yield where, f"'{port}' is the port of {ports[port]} already: each needs its own"
        if port != SIMULATED:
            ports.setdefault(port, f"robots[{index}] ({entry.name})")


def journals_differ(robots: Any, recording: Any) -> _Found:
    """Each of several robots has a journal that ends with its name, beside the zones' file."""
    if recording.journal is None or len(robots) < 2:
        return
    for index, entry in enumerate(robots):
        if entry.name == ZONES_FILE:
            file = f"{recording.journal.name}.{ZONES_FILE}"
            yield ("robots", index, "name"), f"'{entry.name}': {file} keeps the changes of zones"


def markers_are_of_one_family(robots: Any, robot: Any) -> _Found:
    """A picture is searched for one family of markers."""
    for index, entry in enumerate(robots):
        if entry.dictionary not in (None, robot.dictionary):
            yield (
                ("robots", index, "dictionary"),
                f"must be {robot.dictionary}, as robot.dictionary, not {entry.dictionary}: a "
                "picture is searched for one family",
            )


def names_are_known(robots: Any, mission: Any, simulation: Any) -> _Found:
    """Stations and starts name existing robots, once each."""
    known = {entry.name for entry in robots}
    lists: list[tuple[Location, Sequence[Any]]] = [(("mission", "robots"), mission.robots)]
    if simulation is not None:
        lists.append((("simulation", "starts"), simulation.starts))
    for where, entries in lists:
        first: dict[str, int] = {}
        for index, one in enumerate(entries):
            if one.name not in known:
                there = ", ".join(sorted(known)) or "there are none"
                yield (*where, index, "name"), f"'{one.name}' is none of robots: {there}"
            elif one.name in first:
                before = f"{'.'.join(map(str, where))}[{first[one.name]}]"
                yield (*where, index, "name"), f"'{one.name}' is the name of {before} already"
            first.setdefault(one.name, index)


def every_robot_has_a_start(robots: Any, serial: Any, simulation: Any) -> _Found:
    """Each simulated robot needs a start."""
    if simulation is None:
        return
    if not robots:
        if simulation.start is None:
            yield ("simulation", "start"), "is required: where the robot is at the beginning"
        return
    started = {one.name for one in simulation.starts}
    missing = [
        entry.name
        for entry in robots
        if entry.name not in started
        and with_own(serial, entry).port == SIMULATED
        and not (len(robots) == 1 and simulation.start is not None)
    ]
    if missing:
        yield ("simulation", "starts"), f"needs the start of {', '.join(missing)}"


def missions_fit_the_fleet(robots: Any, mission: Any, tasks: Any) -> _Found:
    """Stations belong to one robot; several get them by name, or as tasks."""
    if len(robots) > 1 and mission.stations:
        yield (
            ("mission", "stations"),
            "are one robot's: with several use mission.robots, by name, or tasks",
        )
    if not robots and (tasks or mission.robots):
        where: Location = ("tasks",) if tasks else ("mission", "robots")
        yield where, "needs a list 'robots'"
    busy = sum(bool(one.stations) for one in mission.robots)
    if robots and len(tasks) > len(robots) - busy:
        yield (
            ("tasks",),
            f"{len(tasks)} tasks for {len(robots) - busy} robots without stations of their own: "
            "one for each at most",
        )


def goals_do_not_touch(robots: Any, robot: Any, mission: Any) -> _Found:
    """Two robots cannot end where their bodies would overlap."""
    ends = {one[0][2]: one for one in named_places(mission, None)}  # the last station of each
    yield from _none_touch(robots, robot, ends.values(), "goals")


def starts_do_not_touch(robots: Any, robot: Any, simulation: Any) -> _Found:
    """Two simulated robots cannot begin where their bodies would overlap."""
    starts = named_places(MissionSection(), simulation)
    yield from _none_touch(robots, robot, starts, "starts")


def _none_touch(
    robots: Any, robot: Any, places: Iterable[tuple[Location, str, Place]], what: str
) -> _Found:
    radii = {entry.name: with_own(robot, entry).radius_m for entry in robots}
    known = [(where, name, one) for where, name, one in places if name in radii]
    for (_, a, here), (where, b, there) in combinations(known, 2):
        off_m, least_m = (
            math.dist((here.x_m, here.y_m), (there.x_m, there.y_m)),
            radii[a] + radii[b],
        )
        if a != b and off_m < least_m:
            sentence = f"the {what} of {a} and {b} are {off_m:.3g} m apart"
            yield where, f"{sentence}: must be >= {least_m:.3g}, both radii together"

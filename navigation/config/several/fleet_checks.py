"""Checks across several driven robots."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

from navigation.config.marks import Location
from navigation.config.several.each_robot import robot_of, serial_of
from navigation.config.values import SIMULATED, Place

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
        port = serial_of(serial, entry).port
        if port in ports:
            where: Location = ("robots", index, "port") if entry.port else ("robots", index)
            yield where, f"'{port}' is the port of {ports[port]} already: each needs its own"
        if port != SIMULATED:
            ports.setdefault(port, f"robots[{index}] ({entry.name})")


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
        seen: set[str] = set()
        for index, one in enumerate(entries):
            if one.name not in known:
                there = ", ".join(sorted(known)) or "there are none"
                yield (*where, index, "name"), f"'{one.name}' is none of robots: {there}"
            elif one.name in seen:
                yield (*where, index, "name"), f"'{one.name}' was named before"
            seen.add(one.name)


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
        and serial_of(serial, entry).port == SIMULATED
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
    by_name = {entry.name: entry for entry in robots}
    ends = [
        (index, one, one.stations[-1])
        for index, one in enumerate(mission.robots)
        if one.stations and one.name in by_name
    ]
    for (_, a, at), (index, b, there) in combinations(ends, 2):
        if a.name == b.name:
            continue
        yield from _apart(
            (a.name, at, robot_of(robot, by_name[a.name]).radius_m),
            (b.name, there, robot_of(robot, by_name[b.name]).radius_m),
            ("mission", "robots", index, "stations", len(b.stations) - 1),
            "goals",
        )


def starts_do_not_touch(robots: Any, robot: Any, simulation: Any) -> _Found:
    """Two simulated robots cannot begin where their bodies would overlap."""
    by_name = {entry.name: entry for entry in robots}
    starts = [] if simulation is None else list(enumerate(simulation.starts))
    known = [(index, one) for index, one in starts if one.name in by_name]
    for (_, a), (index, b) in combinations(known, 2):
        if a.name != b.name:
            yield from _apart(
                (a.name, a, robot_of(robot, by_name[a.name]).radius_m),
                (b.name, b, robot_of(robot, by_name[b.name]).radius_m),
                ("simulation", "starts", index),
                "starts",
            )


def _apart(
    one: tuple[str, Place, float], other: tuple[str, Place, float], where: Location, what: str
) -> _Found:
    (a, here, ra), (b, there, rb) = one, other
    off_m = math.dist((here.x_m, here.y_m), (there.x_m, there.y_m))
    if off_m < ra + rb:
        yield (
            where,
            (
                f"the {what} of {a} and {b} are {off_m:.3g} m apart: must be >= {ra + rb:.3g}, "
                "both radii together"
            ),
        )

"""`clearway check`: a configuration and the files that it names."""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from navigation.config import Config, load_config
from navigation.config.errors import ConfigError, Problem, in_order, mark_of
from navigation.config.known_robots import CLEARWAY, KNOWN_ROBOTS, KnownRobot, least_wheel_m_s
from navigation.config.load import read_source
from navigation.config.marks import Location, read_document
from navigation.config.secrecy.secrets import hide
from navigation.config.several.each_camera import each_camera
from navigation.config.several.each_robot import each_robot, named_places, robots_of

if TYPE_CHECKING:
    from navigation.config.values import Place
    from navigation.simulator.arena import SimulatedArena
    from vision.calibration.calibration import Calibration


FILES: Final = (("camera", "calibration"), ("simulation", "arena"))
COARSE_M: Final = 0.01
"""Pixels of a floor plan that only says what several cameras see."""
LEAST_MARKER_PX: Final = 6
"""One for each cell of the coarsest markers, 4 x 4 and their border."""


@click.command(short_help="Check a configuration; report every error.")
@click.argument("config", type=click.Path(path_type=Path))
def command(config: Path) -> None:
    """Check the configuration CONFIG and the files that it names.

    Prints a summary and exits 0, or prints every error and exits 78.
    """
    loaded = load_checked(config)
    click.echo(f"{config}: ok")
    for name, words in summary(loaded):
        click.echo(hide(f"  {name:<11}{words}"))


def load_checked(file: Path) -> Config:
    """Load a configuration; ``ConfigError`` also if a file that it names is wrong.

    Errors of the files and of the configuration are reported together, as far as the sections are
    sound.
    """
    try:
        loaded = load_config(file)
    except ConfigError as error:
        found = _located(error.sound, error.text)
        told = {problem.where for problem in (*error.problems, *found)}
        found += [p for p in _missing_files(error.text, file.parent) if p.where not in told]
        if not found:
            raise
        problems = in_order([*error.problems, *found])
        raise ConfigError(error.file, problems, error.text, unknown=error.unknown) from None
    sections = {name: getattr(loaded, name) for name in Config.model_fields}
    text = read_source(file)
    problems = _located(sections, text)
    if problems:
        raise ConfigError(str(file), problems, text)
    return loaded


def file_problems(config: Config) -> Iterator[tuple[Location, str]]:
    """Yield problems with the files that a sound configuration names, and their contents."""
    yield from _problems({name: getattr(config, name) for name in Config.model_fields})


def _located(sections: Mapping[str, Any], text: str) -> list[Problem]:
    document = read_document(text)
    return [Problem(where, what, mark_of(document, where)) for where, what in _problems(sections)]


def _missing_files(text: str, folder: Path) -> Iterator[Problem]:
    """Yield missing files, whatever else is wrong with their sections."""
    document = read_document(text)
    for where in FILES:
        value = document.data
        for key in where:
            value = value.get(key) if isinstance(value, dict) else None
        overridden = "CLEARWAY_" + "__".join(where).upper() in os.environ
        if overridden or not isinstance(value, str) or not value:
            continue
        named = folder / value
        try:
            named.stat()
        except (OSError, ValueError) as error:
            why = error.strerror if isinstance(error, OSError) else None
            mark = mark_of(document, where)
            yield Problem(where, f"{named}: {why or error}", mark)


def _problems(sections: Mapping[str, Any]) -> Iterator[tuple[Location, str]]:
    config = Config.model_construct(**sections)
    if {"arena", "camera", "cameras", "robot", "other_robots", "simulation"} <= sections.keys():
        yield from _calibration_problems(config)
    needed = {"arena", "robot", "planning", "mission", "simulation"}
    if needed <= sections.keys() and config.simulation is not None:
        yield from _simulation_problems(config)
    if {"arena", "robot", "robots", "mission", "zones"} <= sections.keys() and config.zones:
        yield from _stations_in_zones(config)
    if "notify" in sections and config.notify.command is not None:
        program = config.notify.command[0]
        if shutil.which(program) is None:
            yield ("notify", "command"), f"{program}: there is no such program"


def _calibration_problems(config: Config) -> Iterator[tuple[Location, str]]:
    if not config.cameras:
        calibration, found = _calibration(config)
        yield from found
        if calibration is not None and calibration.size == config.camera.size_px:
            yield from _arena_is_seen(config, calibration)
        return
    calibrations = []
    for index, one in enumerate(each_camera(config).values()):
        calibration, found = _calibration(one)
        own = one.simulation is not None and one.camera.calibration is None
        where: Location = ("cameras", index) if own else ("cameras", index, "calibration")
        for place, sentence in found:
            yield (place if place[0] not in ("camera", "simulation") else where), sentence
        if calibration is not None and not found:
            calibrations.append(calibration)
    if len(calibrations) == len(config.cameras):
        yield from _cameras_see_the_arena(config, calibrations)


def _calibration(config: Config) -> tuple[Calibration | None, list[tuple[Location, str]]]:
    from navigation.simulator.picture.pinhole import pinhole_of
    from vision.calibration.calibration import Calibration, CalibrationError
    from vision.calibration.calibration_file import load_calibration

    camera = config.camera
    where: Location = ("camera", "calibration")
    calibration: Calibration | None = None
    try:
        if camera.calibration is not None:
            calibration = load_calibration(camera.calibration)
        elif camera.metres_per_pixel is not None:
            calibration = Calibration.from_scale(camera.metres_per_pixel, camera.size_px)
        elif config.simulation is not None:
            where = ("simulation", "camera")
            calibration = pinhole_of(config).calibration()
    except OSError as error:
        return None, [(where, _unreadable(camera.calibration, error))]
    except CalibrationError as error:
        return None, [(where, str(error))]
    if calibration is None:
        return None, []
    found = list(_markers_are_seen(config, calibration))
    if calibration.size != camera.size_px:
        (width, height), (w, h) = calibration.size, camera.size_px
        told = f"is for pictures of {width}x{height}, camera.size_px asks for {w}x{h}"
        found.append((where, told))
    return calibration, found


def _cameras_see_the_arena(
    config: Config, calibrations: Sequence[Calibration]
) -> Iterator[tuple[Location, str]]:
    """Check that each camera sees some of the arena, and at least one sees each station."""
    from planner.scene import Bounds
    from vision.calibration.calibration import CalibrationError
    from vision.joined.floor_plan import FloorPlan

    names = [one.name for one in config.cameras]
    try:
        plan = FloorPlan.of(calibrations, Bounds(*config.arena.bounds_m), names, COARSE_M)
    except CalibrationError as error:
        yield ("cameras",), str(error)
        return
    unknown = plan.unknown([True] * len(names))
    if unknown is None:
        return
    sent: list[tuple[Location, Sequence[Place]]] = [
        (("mission", "stations"), config.mission.stations),
        (("tasks",), config.tasks),
        *(
            (("mission", "robots", number, "stations"), one.stations)
            for number, one in enumerate(config.mission.robots)
        ),
    ]
    for where, stations in sent:
        for index, station in enumerate(stations):
            if plan.is_unknown(unknown, station.x_m, station.y_m, config.robot.radius_m):
                yield (
                    (*where, index),
                    f"({station.x_m:g}, {station.y_m:g}) m: no camera sees all of the floor there",
                )


def _markers_are_seen(config: Config, calibration: Calibration) -> Iterator[tuple[Location, str]]:
    """Check that each marker is below the camera, and large enough in the arena's middle."""
    from vision.calibration.calibration import CalibrationError

    x0, y0, x1, y1 = config.arena.bounds_m
    x, y = (x0 + x1) / 2.0, (y0 + y1) / 2.0
    marked: list[tuple[Location, Any]] = [(("robot",), config.robot)]
    marked += [(("other_robots", i), one) for i, one in enumerate(config.other_robots)]
    for where, one in marked:
        height_m, size_m = one.marker_height_m, one.marker_size_m
        if height_m > 0.0 and config.camera.metres_per_pixel is not None:
            limit = "must be 0 with metres_per_pixel, which does not say where the camera is"
            yield (*where, "marker_height_m"), f"{limit}; a calibration does"
            continue
        try:
            side = calibration.image_from_arena([(x, y), (x + size_m, y)], height_m)
        except CalibrationError as error:
            yield (*where, "marker_height_m"), str(error).removeprefix(f"height_m = {height_m}: ")
            continue
        if (seen_px := math.dist(*side)) < LEAST_MARKER_PX:
            seen = f"{size_m:g} m are {seen_px:.1f} px in the picture"
            limit = f"must be >= {LEAST_MARKER_PX} px, one for each cell"
            yield (*where, "marker_size_m"), f"{seen}: {limit}"


def _arena_is_seen(config: Config, calibration: Calibration) -> Iterator[tuple[Location, str]]:
    x0, y0, x1, y1 = config.arena.bounds_m
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    width, height = calibration.size
    for (x, y), (column, row) in zip(corners, calibration.image_from_arena(corners), strict=True):
        if math.isnan(column):
            yield (
                ("arena", "bounds_m"),
                f"the corner ({x:g}, {y:g}) is out of sight: the lens folds, or looks elsewhere",
            )
        elif not (-0.5 <= column <= width - 0.5 and -0.5 <= row <= height - 0.5):
            yield (
                ("arena", "bounds_m"),
                f"the corner ({x:g}, {y:g}) lies at pixel ({column:.0f}, {row:.0f}), "
                f"outside the camera's {width}x{height}",
            )


def _simulation_problems(config: Config) -> Iterator[tuple[Location, str]]:
    from navigation.simulator.arena import load_arena
    from navigation.simulator.happenings import object_of
    from navigation.simulator.line_faults import FaultSpec, FaultSpecError
    from planner.scene import Bounds, SceneError

    assert config.simulation is not None
    if config.simulation.arena is None and config.simulation.arena_text is None:
        return
    bounds = Bounds(*config.arena.bounds_m)
    try:
        FaultSpec.parse(config.simulation.robot.faults)
    except FaultSpecError as error:
        yield ("simulation", "robot", "faults"), str(error)
    yield from _wheels_start(config)
    place = "arena" if config.simulation.arena is not None else "arena_text"
    if bounds.width <= 0.0 or bounds.height <= 0.0:
        return  # reported by itself
    try:
        arena = load_arena(config)
    except OSError as error:
        yield ("simulation", place), _unreadable(config.simulation.arena, error)
        return
    except SceneError as error:
        yield ("simulation", place), str(error)
        return
    for index, section in enumerate(config.simulation.obstacles):
        try:
            object_of(section, arena)
        except SceneError as error:
            yield ("simulation", "obstacles", index, "record"), str(error)
    need = config.robot.radius_m + config.planning.margin_m
    for index, station in enumerate(config.mission.stations):
        clearance = float(arena.clearances([[station.x_m, station.y_m]])[0])
        # a station outside the arena is reported by itself
        if clearance < need and bounds.contains((station.x_m, station.y_m)):
            yield (
                ("mission", "stations", index),
                f"has a clearance of {clearance:.3f} m: must be >= {need:g}, "
                "robot.radius_m + planning.margin_m",
            )
    yield from _places_of_each(config, arena)


def _wheels_start(config: Config) -> Iterator[tuple[Location, str]]:
    """A simulated wheel that no pulse starts never reaches its target."""
    assert config.simulation is not None
    robot, wheels = config.robot, config.simulation.robot
    starts_m_s = wheels.dead_zone_m_s * (1.0 + wheels.stiction)
    least = least_wheel_m_s(robot.driver, robot.least_wheel_m_s)
    driver_knows = robot.least_wheel_m_s is None and least == 0.0
    if least < starts_m_s and not driver_knows:
        yield (
            ("robot", "least_wheel_m_s"),
            f"must be >= {starts_m_s:g}, at which the simulated wheels begin to turn "
            f"(simulation.robot: dead_zone_m_s and stiction), not {least:g}",
        )


def summary(config: Config) -> Iterator[tuple[str, str]]:
    """Yield the parts of a configuration, a line each."""
    x0, y0, x1, y1 = config.arena.bounds_m
    camera, robot, mission = config.camera, config.robot, config.mission
    width, height = camera.size_px
    yield "arena", f"{x1 - x0:g} x {y1 - y0:g} m"
    for name, one in each_camera(config).items():
        (w, h), hz = one.camera.size_px, one.camera.rate_hz
        yield "camera", f"{name}: {one.camera.source}, {w}x{h}, {hz:g} frames/s"
    if not config.cameras:
        yield "camera", f"{camera.source}, {width}x{height}, {camera.rate_hz:g} frames/s"
    robots = each_robot(config)
    if robots:
        yield from ((name, _in_short(one)) for name, one in robots.items())
        count = len(config.tasks)
        yield "tasks", f"{count or 'no'} task{'s' * (count != 1)}"
        yield from _zones(config)
        return
    yield (
        "robot",
        f"marker {robot.marker_id}, radius {robot.radius_m:g} m, up to {robot.speed_m_s:g} m/s",
    )
    if robot.driver != CLEARWAY:
        yield "driver", f"{robot.driver}: {_who_stops_it(KNOWN_ROBOTS[robot.driver])}"
    yield "serial", f"{config.serial.port}, {config.serial.baud} baud"
    count = len(mission.stations)
    stations = "1 station" if count == 1 else f"{count or 'no'} stations, {mission.order} order"
    yield "mission", stations if count else "none: waits for orders"
    yield from _zones(config)


def _zones(config: Config) -> Iterator[tuple[str, str]]:
    from navigation.config.zones.in_words import in_words

    yield from (("zone", in_words(one)) for one in config.zones)


def _who_stops_it(known: KnownRobot) -> str:
    if known.watchdog_s is None:
        return f"the {known.title} has no watchdog; nothing stops it when this computer dies"
    return f"the {known.title} stops by itself {known.watchdog_s:g} s after the last order"


def _in_short(config: Config) -> str:
    robot, count = config.robot, len(config.mission.stations)
    return (
        f"marker {robot.marker_id}, radius {robot.radius_m:g} m, up to {robot.speed_m_s:g} m/s, "
        f"{_line_of(config)}, {count or 'no'} station{'s' * (count != 1)}"
    )


def _line_of(config: Config) -> str:
    driver, port = config.robot.driver, config.serial.port
    return port if driver == CLEARWAY else f"{driver} on {port}"


def _places_of_each(config: Config, arena: SimulatedArena) -> Iterator[tuple[Location, str]]:
    assert config.simulation is not None
    robots = each_robot(config)
    for where, name, place in named_places(config.mission, config.simulation):
        clearance = float(arena.clearances([[place.x_m, place.y_m]])[0])
        if not arena.scene.bounds.contains((place.x_m, place.y_m)):
            continue
        if name in robots and clearance < robots[name].robot.radius_m:
            need = robots[name].robot.radius_m
            yield where, f"has a clearance of {clearance:.3f} m: must be >= {need:g} for {name}"


def _stations_in_zones(config: Config) -> Iterator[tuple[Location, str]]:
    """A mission with a station that a zone forbids is refused when it is given."""
    from planner.scene import Bounds, Scene
    from planner.zones.rules import rules_for

    scene = Scene("m", Bounds(*config.arena.bounds_m), ())
    rules = {
        name: rules_for([zone.zone() for zone in one.zones], scene, one.robot.radius_m)
        for name, one in robots_of(config).items()
    }
    of_one = enumerate(config.mission.stations)
    places = [(("mission", "stations", index), "", one) for index, one in of_one]
    for where, name, place in (*places, *named_places(config.mission, None)):
        breach = rules[name].station_breach("the station", (place.x_m, place.y_m))
        if breach is not None:
            yield where, f"{breach}: must be where the zones let a robot stop"


def _unreadable(file: Path | None, error: OSError) -> str:
    return f"{file}: {error.strerror or error}"

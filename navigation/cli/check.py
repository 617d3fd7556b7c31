"""`clearway check`: whether a configuration can be used, with every error at its place."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click

from navigation.config import Config
from navigation.config_errors import ConfigError, Problem, mark_of
from navigation.config_marks import Location, read_document


@click.command(short_help="Check a configuration; tell every error.")
@click.argument("config", type=click.Path(path_type=Path))
def command(config: Path) -> None:
    """Check the configuration CONFIG and the files that it names.

    Prints a summary and exits 0, or prints every error and exits 78.
    """
    from navigation.config import load_config

    loaded = load_config(config)
    found = list(file_problems(loaded))
    if found:
        text = config.read_text(encoding="utf-8")
        document = read_document(text)
        problems = [Problem(where, what, mark_of(document, where)) for where, what in found]
        raise ConfigError(str(config), problems, text)
    click.echo(f"{config}: ok")
    for name, words in summary(loaded):
        click.echo(f"  {name:<11}{words}")


def file_problems(config: Config) -> Iterator[tuple[Location, str]]:
    """What is wrong with the files that a sound configuration names, and with what is in them."""
    from navigation.simulator.arena import load_arena
    from navigation.simulator.line_faults import FaultSpec, FaultSpecError
    from planner.scene import SceneError
    from vision.calibration import CalibrationError
    from vision.calibration_file import load_calibration

    calibration = config.camera.calibration
    if calibration is not None:
        try:
            load_calibration(calibration)
        except OSError as error:
            yield ("camera", "calibration"), _unreadable(calibration, error)
        except CalibrationError as error:
            yield ("camera", "calibration"), str(error)
    if config.simulation is None:
        return
    try:
        FaultSpec.parse(config.simulation.robot.faults)
    except FaultSpecError as error:
        yield ("simulation", "robot", "faults"), str(error)
    place = "arena" if config.simulation.arena is not None else "arena_text"
    try:
        arena = load_arena(config)
    except OSError as error:
        yield ("simulation", place), _unreadable(config.simulation.arena, error)
    except SceneError as error:
        yield ("simulation", place), str(error)
    else:
        need = config.robot.radius_m + config.planning.margin_m
        for index, station in enumerate(config.mission.stations):
            clearance = float(arena.clearances([[station.x_m, station.y_m]])[0])
            if clearance < need:
                yield (
                    ("mission", "stations", index),
                    f"has a clearance of {clearance:.3f} m: must be >= {need:g}, "
                    "robot.radius_m + planning.margin_m",
                )


def summary(config: Config) -> Iterator[tuple[str, str]]:
    """What a configuration says, in a line for each part."""
    x0, y0, x1, y1 = config.arena.bounds_m
    camera, robot, mission = config.camera, config.robot, config.mission
    width, height = camera.size_px
    yield "arena", f"{x1 - x0:g} x {y1 - y0:g} m"
    yield "camera", f"{camera.source}, {width}x{height}, {camera.rate_hz:g} frames/s"
    yield (
        "robot",
        f"marker {robot.marker_id}, radius {robot.radius_m:g} m, up to {robot.speed_m_s:g} m/s",
    )
    yield "serial", f"{config.serial.port}, {config.serial.baud} baud"
    count = len(mission.stations)
    stations = "1 station" if count == 1 else f"{count or 'no'} stations, {mission.order} order"
    yield "mission", stations if count else "none: waits for orders"


def _unreadable(file: Path | None, error: OSError) -> str:
    return f"{file}: {error.strerror or error}"

"""`clearway init`: a commented configuration to start with."""

from __future__ import annotations

from pathlib import Path

import click

from navigation.cli.options import OutputType
from navigation.config.known_robots import CLEARWAY, KNOWN_ROBOTS

DEMO_HEADING = """A configuration of Clearway, made by `clearway init`.

It runs as it is, with nothing but this file: the camera, the arena and the robot are simulated.
    clearway run {name} --once
For real ones set camera.source, camera.calibration, robot and serial.port; what is under
`simulation` is then ignored. Environment variables override: CLEARWAY_SERIAL__PORT=/dev/ttyUSB0."""

REAL_HEADING = """Clearway with a real camera and robot, made by `clearway init --real`.

Measure your arena and robot, put their numbers here, then
    clearway calibrate --help       makes the file for camera.calibration
    clearway check {name}
    clearway run {name}"""


@click.command(short_help="Write a commented configuration.")
@click.argument("file", metavar="[FILE]", type=OutputType(), default="clearway.yaml")
@click.option("--real", is_flag=True, help="For a real camera and robot, not a simulated world.")
@click.option(
    "--robot",
    type=click.Choice([CLEARWAY, *KNOWN_ROBOTS]),
    default=CLEARWAY,
    show_default=True,
    help="Which robot: writes its dimensions, its limits, and how it is spoken to.",
)
@click.option("--force", is_flag=True, help="Overwrite an existing file.")
def command(file: Path, real: bool, robot: str, force: bool) -> None:
    """Write a commented configuration to FILE (clearway.yaml)."""
    from navigation.cli.setup.starter_values import demo_values, real_values
    from navigation.config.reference import starter_yaml

    values, heading = (
        (real_values(robot), REAL_HEADING) if real else (demo_values(robot), DEMO_HEADING)
    )
    text = starter_yaml(values, heading.format(name=file))
    try:
        with file.open("w" if force else "x", encoding="utf-8") as out:
            out.write(text)
    except FileExistsError:
        raise click.UsageError(f"{file} exists; --force overwrites it") from None
    click.echo(f"wrote {file}; next: clearway {'check' if real else 'run'} {file}")

"""`clearway init`: a commented configuration to start with, which loads as it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

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

ARENA_TEXT = """#@ clearway.scene/1
#@ units m
# a triangle, a bucket, an L and a D whose first edge is an arc; clockwise, x right, y up
L 3 (0.60,0.70) (0.72,0.34) (0.44,0.42)
C (0.50,1.22) 0.14
L 6 (1.60,1.40) (1.70,1.40) (1.70,1.00) (2.02,1.00) (2.02,0.90) (1.60,0.90)
L 4 (1.15,0.60) (1.15,0.30) (1.05,0.30) (1.05,0.60)
#@ arc 1 1.15 0.45 0.15 cw
L 4 (0.95,1.40) (1.25,1.30) (1.20,1.15) (0.90,1.25)
L 3 (1.85,0.62) (2.05,0.40) (1.75,0.38)
"""

_ROBOT = {"marker_id": 7, "marker_size_m": 0.09, "marker_height_m": 0.12, "radius_m": 0.09}
_STATIONS = [
    {"x_m": 1.40, "y_m": 0.90, "dwell_s": 0.5},
    {"x_m": 2.20, "y_m": 1.60, "heading_deg": 90},
]
_ARENA = {"bounds_m": [0.0, 0.0, 2.4, 1.8]}

DEMO: dict[str, Any] = {
    "arena": _ARENA,
    "camera": {"source": "simulated"},
    "robot": _ROBOT,
    "mission": {"stations": _STATIONS},
    "simulation": {
        "arena_text": ARENA_TEXT,
        "start": {"x_m": 0.2, "y_m": 0.2, "heading_deg": 45},
    },
}

REAL: dict[str, Any] = {
    "arena": _ARENA,
    "camera": {"source": 0, "calibration": "calibration.yaml"},
    "robot": _ROBOT,
    "serial": {"port": "/dev/ttyUSB0"},
}


@click.command(short_help="Write a commented configuration.")
@click.argument(
    "file", type=click.Path(path_type=Path, dir_okay=False), default=Path("clearway.yaml")
)
@click.option("--real", is_flag=True, help="For a real camera and robot, not a simulated world.")
@click.option("--force", is_flag=True, help="Overwrite an existing file.")
def command(file: Path, real: bool, force: bool) -> None:
    """Write a commented configuration to FILE (clearway.yaml)."""
    from navigation.config.reference import starter_yaml

    values, heading = (REAL, REAL_HEADING) if real else (DEMO, DEMO_HEADING)
    text = starter_yaml(values, heading.format(name=file))
    try:
        with file.open("w" if force else "x", encoding="utf-8") as out:
            out.write(text)
    except FileExistsError:
        raise click.UsageError(f"{file} exists; --force overwrites it") from None
    click.echo(f"wrote {file}; next: clearway {'check' if real else 'run'} {file}")

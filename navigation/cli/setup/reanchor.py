"""``clearway reanchor``: the place of a moved camera."""

from __future__ import annotations

import time
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from navigation.cli.options import INPUT

if TYPE_CHECKING:
    from navigation.config import Config
    from vision.camera.camera import Image

PICTURES: Final = 10
"""A marker counts with the median of them."""
PATIENCE_S: Final = 5.0


@click.command("reanchor")
@click.argument("config", required=False, type=INPUT)
@click.argument("source", required=False)
@click.option(
    "--socket", "path", type=click.Path(path_type=Path), help="The daemon's socket, without CONFIG."
)
@click.option("--camera", "name", help="Which of several cameras.")
def command(config: Path | None, source: str | None, path: Path | None, name: str | None) -> None:
    """Place a moved camera again, by the floor markers of arena.floor_markers.

    Without CONFIG the running daemon does it by its newest picture, and begins again with the new
    calibration. With CONFIG its camera is opened, or SOURCE: a picture, a folder, anything that
    camera.source may be; `systemctl reload` or SIGHUP makes a running daemon use the file.

    The lens is kept. The file camera.calibration is written whole, and the previous one is kept
    beside it.
    """
    if config is None:
        _ask_the_daemon(path, name)
        return
    if path is not None:
        raise click.UsageError("--socket is for the running daemon: without CONFIG")
    from navigation.cli.setup.check import load_checked
    from navigation.run.anchoring import of_camera, renew

    loaded = of_camera(load_checked(config), name)
    for line in renew(loaded, _pictures(loaded, source), datetime.now()).lines():
        click.echo(line)


def _ask_the_daemon(path: Path | None, name: str | None) -> None:
    from navigation.control import send_order

    order = {"order": "reanchor"} | ({} if name is None else {"camera": name})
    answer = send_order(path, order)
    for line in answer["anchoring"]:
        click.echo(line)


def _pictures(config: Config, source: str | None) -> list[Image]:
    from navigation.run.devices.device_settings import device_settings
    from navigation.run.world import World
    from vision.camera.camera import CameraError
    from vision.camera.sources import camera_for

    section = config.camera
    if source is None:
        camera = World(config).open_camera()
    else:
        named: str | int = int(source) if source.isascii() and source.isdecimal() else source
        camera = camera_for(
            named,
            clock=time.monotonic,
            rate_hz=section.rate_hz,
            size=section.size_px,
            device=device_settings(section),
        )
    taken: list[Image] = []
    try:
        camera.open()
        end_s = time.monotonic() + PATIENCE_S
        while len(taken) < PICTURES and time.monotonic() < end_s and camera.state != "ended":
            frame = camera.read(0.5)
            if frame is not None:
                taken.append(frame.image)
    finally:
        camera.close()
    if not taken:
        raise CameraError(f"{camera.name}: no picture within {PATIENCE_S:g} s")
    return taken

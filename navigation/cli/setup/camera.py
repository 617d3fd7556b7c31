"""``clearway camera``: a camera's abilities, pictures, and best settings."""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from navigation.cli.options import POSITIVE, OutputType, format_option
from navigation.cli.outputs import CommandError, keep_apart

if TYPE_CHECKING:
    from navigation.config import Config
    from navigation.config.sections import CameraSection
    from navigation.machine.camera_findings import CameraMeasurements
    from navigation.machine.doctor import Finding

WELL, ILL = 0, 1
MOST_SECONDS: Final = 3600.0


@click.command("camera")
@click.argument("source", required=False)
@click.option(
    "--seconds", type=POSITIVE, default=10.0, show_default=True, help="How long to watch it."
)
@click.option("--size", metavar="WxH", help="Pixels to ask for; the configuration's by default.")
@click.option("--rate", type=POSITIVE, help="Frames a second to ask for.")
@click.option(
    "--write",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="CONFIG",
    help="Put the best section into this configuration; it names the camera if SOURCE does not.",
)
@click.option(
    "--render",
    type=OutputType(".png", ".jpg", ".jpeg", ".webp"),
    help="Draw what was judged into the last picture: FILE.png.",
)
@format_option("A table and sentences, or one JSON object.")
def command(
    source: str | None,
    seconds: float,
    size: str | None,
    rate: float | None,
    write: Path | None,
    render: Path | None,
    form: str,
) -> int:
    """Watch a camera, and say what it can do and what it delivers.

    SOURCE is a configuration (its camera, arena and robot count), or anything that camera.source
    may be: a number, a device, an address, a file, a folder. Without it: the one plugged-in camera.
    Each line says ok, warn or fail, and how to fix it. Exits 1 if something fails.
    """
    if seconds > MOST_SECONDS:
        raise click.BadParameter(f"must be <= {MOST_SECONDS:g}", param_hint="--seconds")
    file = _configuration(source) or (write if source is None else None)
    keep_apart((("--render", render),), (file, write))

    from navigation.cli.progress import long_work
    from navigation.cli.setup.camera_watch import watch
    from navigation.cli.setup.check import load_checked
    from navigation.config.load import read_source
    from navigation.machine.camera_findings import camera_findings
    from navigation.machine.camera_section import best_section, write_section
    from navigation.machine.doctor import worst

    if write is not None:
        read_source(write)  # no need to watch if the result cannot be kept
    config = None if file is None else load_checked(file)
    wanted = _wanted(config, source if file is None else None, size, rate)
    with long_work(f"opening {_without_password(wanted.source)}") as tell:
        judged = watch(wanted, config, seconds, tell)
    findings = camera_findings(judged)
    section = best_section(judged, _stable(wanted.source))
    shown = {**section, "source": _without_password(section["source"])}
    if form == "json":
        click.echo(json.dumps(_as_json(judged, findings, shown), indent=1))
    else:
        _show(judged, findings, shown)
    if render is not None:
        _render(render, judged, config)
    if write is not None:
        if file is not None and section["source"] == wanted.source:
            del section["source"]  # it may come from the environment, with its password
        write_section(write, section)
        click.echo(f"wrote the section camera of {write}", err=True)
    return ILL if worst(findings) == "fail" else WELL


def _configuration(source: str | None) -> Path | None:
    if source is None or Path(source).suffix.lower() not in (".yaml", ".yml"):
        return None
    return Path(source)


def _wanted(
    config: Config | None, source: str | None, size: str | None, rate: float | None
) -> CameraSection:
    from navigation.config.sections import CameraSection

    changes: dict[str, Any] = {}
    if size is not None:
        width, cross, height = size.lower().partition("x")
        if not (cross and width.isdecimal() and height.isdecimal()):
            raise click.BadParameter(f"{size!r}: must be WxH, as in 1280x960", param_hint="--size")
        if not (16 <= int(width) <= 32768 and 16 <= int(height) <= 32768):
            raise click.BadParameter(f"{size}: sides must be 16..32768", param_hint="--size")
        changes["size_px"] = (int(width), int(height))
    if rate is not None:
        if not 0.001 <= rate <= 1000.0:
            raise click.BadParameter(f"{rate:g}: must be in 0.001..1000", param_hint="--rate")
        changes["rate_hz"] = rate
    if config is not None and config.cameras:
        names = ", ".join(f"{one.name}: {one.source}" for one in config.cameras if one.source)
        raise click.UsageError(f"CONFIG has several cameras: give the source of one ({names})")
    if config is not None:
        return config.camera.model_copy(update=changes)
    chosen: str | int = _only_camera() if source is None else source
    if isinstance(chosen, str) and chosen.isascii() and chosen.isdecimal():
        chosen = int(chosen)
    return CameraSection(source=chosen, metres_per_pixel=None, **changes)


def _only_camera() -> str:
    from navigation.cli.setup.devices import cameras_here

    paths = [device["path"] for device in cameras_here()]
    if len(paths) == 1:
        return paths[0]
    if paths:
        raise CommandError(f"several cameras are plugged in: name one of {', '.join(paths)}")
    raise CommandError(
        "no camera is plugged in: name a source (an address, a file, a folder) or a configuration"
    )


def _stable(source: str | int) -> str | int:
    """A device's name that survives replugging, if it has one."""
    from navigation.cli.setup.devices import cameras_here

    path = f"/dev/video{source}" if isinstance(source, int) else source
    if not path.startswith("/dev/video"):
        return source
    stable = {os.path.realpath(device["path"]): device["path"] for device in cameras_here()}
    return stable.get(path, source)


def _show(judged: CameraMeasurements, findings: list[Finding], section: dict[str, Any]) -> None:
    from navigation.cli.setup.doctor import show_finding
    from navigation.machine.camera_section import section_text

    for line in _table(judged):
        click.echo(line)
    for finding in findings:
        show_finding(finding)
    click.echo("\nthe section that serves best:\n")
    click.echo(section_text(section), nl=False)


def _table(judged: CameraMeasurements) -> list[str]:
    from vision.camera.v4l2.modes import rate_text

    if judged.kind != "device":
        return []
    lines = ["it offers:"]
    for mode in judged.modes:
        rates = (
            ", ".join(rate_text(rate) for rate in mode.rates_hz) or "a rate that it does not say"
        )
        lines.append(f"  {mode.fourcc}  {mode.size[0]}x{mode.size[1]:<6} {rates}")
    lines.append("its controls:" if judged.controls else "its controls: none")
    for one in judged.controls:
        menu = dict(one.menu)
        value = "unknown" if one.value is None else menu.get(one.value, str(one.value))
        span = ", ".join(menu.values()) if menu else f"{one.least} to {one.most}"
        lines.append(f"  {one.name:<32} {value:<16} ({span})")
    return [*lines, f"taken: {judged.taken}", ""]


def _without_password(source: str | int) -> str | int:
    from vision.camera.sources import without_password

    return source if isinstance(source, int) else without_password(source)


def _as_json(
    judged: CameraMeasurements, findings: list[Finding], section: dict[str, Any]
) -> dict[str, Any]:
    quality = judged.quality
    timing, flicker, focus = quality.timing, quality.flicker, quality.focus
    tiles = [
        [None if math.isnan(blur) else round(blur, 3) for blur in row]
        for row in focus.blur_px.tolist()
    ]
    measured = {
        "size_px": list(quality.size),
        "timing": None if timing is None else asdict(timing),
        "noise_grey": quality.noise_grey,
        "flicker": None if flicker is None else asdict(flicker),
        "brightness": quality.brightness,
        "white": quality.white,
        "black": quality.black,
        "focus": {"sharp": focus.sharp, "median_px": focus.median_px, "tiles_px": tiles},
        "markers": [
            {"id": m.id, "corners_px": m.corners_px.tolist(), "blur_px": m.blur_px}
            for m in quality.markers
        ],
        "damaged": judged.damaged,
        "missing": judged.missing,
    }
    return {
        "schema": "clearway.camera/1",
        "source": section["source"],
        "kind": judged.kind,
        "taken": judged.taken,
        "modes": [asdict(mode) for mode in judged.modes],
        "controls": [asdict(control) for control in judged.controls],
        "measured": measured,
        "findings": [asdict(finding) for finding in findings],
        "section": section,
    }


def _render(file: Path, judged: CameraMeasurements, config: Config | None) -> None:
    import cv2

    from navigation.cli.setup.camera_watch import arena_px
    from navigation.machine.camera_picture import draw_judged

    border = None if config is None else arena_px(config)
    if not cv2.imwrite(str(file), draw_judged(judged.quality, border)):
        raise CommandError(f"{file}: the picture cannot be written there")

"""``clearway devices``: the serial ports and the cameras."""

from __future__ import annotations

import glob
import json
import os

import click

from navigation.cli.options import format_option


@click.command("devices")
@format_option()
def command(form: str) -> None:
    """List the serial ports and cameras of this machine by names that survive replugging."""
    ports, cameras = serial_ports(), cameras_here()
    if form == "json":
        listed = {"schema": "clearway.devices/1", "serial": ports, "cameras": cameras}
        click.echo(json.dumps(listed, indent=2))
        return
    for title, found in (("serial ports", ports), ("cameras", cameras)):
        click.echo(f"{title}:" if found else f"{title}: none")
        for device in found:
            click.echo(f"  {device['path']}  {device['name']}")


def serial_ports() -> list[dict[str, str]]:
    """Each port's stable path (or its device if it has none), device and description."""
    from serial.tools import list_ports

    stable = {os.path.realpath(p): p for p in sorted(glob.glob("/dev/serial/by-id/*"))}
    return [
        {
            "path": stable.get(os.path.realpath(port.device), port.device),
            "device": port.device,
            "name": port.description or port.device,
        }
        for port in sorted(list_ports.comports())
    ]


def cameras_here() -> list[dict[str, str]]:
    """Each V4L2 device's stable path and name."""
    from vision.camera.sources import list_devices

    return [{"path": path, "name": name} for path, name in list_devices()]

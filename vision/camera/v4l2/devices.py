"""Cameras that are plugged in, by names that survive replugging."""

from __future__ import annotations

import glob
import os
from pathlib import Path
from typing import Final

from vision.camera.v4l2.identity import SYSTEM, nodes
from vision.camera.v4l2.node import gives_pictures

UDEV: Final = Path("/run/udev/data")
"""Folder of udev's findings on devices, for every user to read."""


def list_devices() -> list[tuple[str, str]]:
    """List the V4L2 capture devices of this machine: (path, name).

    A device is listed by its stable path under /dev/v4l/by-id if it has one. A camera's other
    nodes, without pictures, are left out; udev's word counts for a node that cannot be asked
    without permission.
    """
    stable = {os.path.realpath(p): p for p in sorted(glob.glob("/dev/v4l/by-id/*"))}
    found = []
    for device in nodes():
        gives = gives_pictures(device)
        if gives is False or (gives is None and _udev_denies_pictures(device)):
            continue
        label = SYSTEM / Path(device).name / "name"
        name = label.read_text(errors="replace").strip() if label.is_file() else device
        found.append((stable.get(device, device), name))
    return found


def _udev_denies_pictures(device: str) -> bool:
    """True if udev examined a node and found no pictures; False if it says nothing.

    Source: v4l_id.c of systemd, which lists a node's abilities as ``:capture:video_output:``.
    """
    try:
        number = (SYSTEM / Path(device).name / "dev").read_text().strip()
        told = (UDEV / f"c{number}").read_text(errors="replace")
    except OSError:
        return False
    lines = [line for line in told.splitlines() if line.startswith("E:ID_V4L_CAPABILITIES=")]
    return any(":capture:" not in line.partition("=")[2] for line in lines)

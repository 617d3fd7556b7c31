"""Cameras that are plugged in, by names that survive replugging."""

from __future__ import annotations

import glob
import os
from pathlib import Path
from typing import Final

from vision.camera.v4l2.identity import SYSTEM, nodes
from vision.camera.v4l2.node import gives_pictures

UDEV: Final = Path("/run/udev/data")
"""Folder of udev's findings."""


def list_devices() -> list[tuple[str, str]]:
    """List the V4L2 capture devices of this machine: (path, name).

    Paths are stable ones under /dev/v4l/by-id, if any. Nodes without pictures are left out, by
    udev's word if permission is missing.
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
    """True if udev examined a node and found no pictures.

    Source: v4l_id.c of systemd, which lists abilities as ``:capture:video_output:``.
    """
    try:
        number = (SYSTEM / Path(device).name / "dev").read_text().strip()
        text = (UDEV / f"c{number}").read_text(errors="replace")
    except OSError:
        return False
    lines = [line for line in text.splitlines() if line.startswith("E:ID_V4L_CAPABILITIES=")]
    return any(":capture:" not in line.partition("=")[2] for line in lines)

"""The cameras that are plugged in, by names that survive replugging."""

from __future__ import annotations

import glob
import os
from pathlib import Path

from vision.camera.v4l2.identity import SYSTEM, nodes
from vision.camera.v4l2.node import gives_pictures


def list_devices() -> list[tuple[str, str]]:
    """The V4L2 capture devices of this machine: (path, what it is called).

    A device is listed by its stable path under /dev/v4l/by-id where it has one. A camera's other
    nodes, which give no pictures, are left out; what cannot be asked, for want of permission, is
    listed.
    """
    stable = {os.path.realpath(p): p for p in sorted(glob.glob("/dev/v4l/by-id/*"))}
    found = []
    for device in nodes():
        if gives_pictures(device) is False:
            continue
        label = SYSTEM / Path(device).name / "name"
        name = label.read_text(errors="replace").strip() if label.is_file() else device
        found.append((stable.get(device, device), name))
    return found

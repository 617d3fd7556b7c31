"""A device node's camera, so that it is found again after a replug under another name.

Rules
- A camera is known by its maker's numbers and its serial number (USB), otherwise by its name, and
  among several alike by its port.
- If the configured node is not the same camera, that is sought among all nodes. Another camera
  under its name is refused: the calibration would be wrong.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from vision.camera.camera import CameraError
from vision.camera.v4l2.node import about

SYSTEM = Path("/sys/class/video4linux")


@dataclass(frozen=True, slots=True)
class CameraIdentity:
    """Identity of a camera; ``bus`` changes with the port, the rest does not."""

    card: str
    maker: str
    """USB's vendor, product and serial number; empty for other cameras."""
    bus: str

    def same_kind(self, other: CameraIdentity) -> bool:
        """True if both may be one camera, whatever the port."""
        return (self.card, self.maker) == (other.card, other.maker)


def identity_of(path: str) -> CameraIdentity | None:
    """Identity of a node that gives pictures; None if it gives none or cannot be asked."""
    camera = about(path)
    if camera is None or not camera.gives_pictures:
        return None
    # the node's device is the USB interface; the numbers belong to its parent
    usb = SYSTEM / Path(path).name / "device" / ".."
    numbers = [_line(usb / name) for name in ("idVendor", "idProduct", "serial")]
    return CameraIdentity(camera.card, ":".join(numbers) if any(numbers) else "", camera.bus)


def nodes() -> list[str]:
    """List every video device node."""
    return sorted(glob.glob("/dev/video*"))


class KnownCamera:
    """Memory of a camera, shared by its openings."""

    def __init__(self, list_nodes: Callable[[], list[str]] = nodes) -> None:
        self._nodes = list_nodes
        self._identity: CameraIdentity | None = None

    def find(self, path: str) -> tuple[str, str]:
        """Node to open for a configured path, and a sentence if it is another; or an error.

        ``path`` itself if no camera is remembered.
        """
        before = self._identity
        named = os.path.realpath(path)
        if before is None:
            return named, ""
        here = identity_of(named) if os.path.exists(named) else None
        if here is not None and here == before:
            return named, ""
        alike = {
            node: found
            for node in self._nodes()
            if (found := identity_of(node)) is not None and found.same_kind(before)
        }
        same_port = [node for node, found in alike.items() if found.bus == before.bus]
        if here is not None and here.same_kind(before) and len(alike) <= 1:
            return named, ""
        chosen = same_port or list(alike)
        if len(chosen) > 1:
            raise CameraError(
                f"{path}: {' and '.join(chosen)} are alike, and neither is where the camera was; "
                "unplug one, or name one by its port (/dev/v4l/by-path/...)"
            )
        if chosen:
            return chosen[0], f"found again as {chosen[0]}"
        if here is not None:
            raise CameraError(
                f"{path} is another camera ({here.card}) than before ({before.card}); plug that in "
                "again, or calibrate this one"
            )
        return named, ""

    def remember(self, path: str) -> None:
        """Remember the camera at a path."""
        self._identity = identity_of(os.path.realpath(path)) or self._identity


def _line(path: Path) -> str:
    try:
        return path.read_text(errors="replace").strip()
    except OSError:
        return ""

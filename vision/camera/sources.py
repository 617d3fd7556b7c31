"""From the name of a source to its camera.

- A number or ``/dev/...`` is a V4L2 device (a stable path such as ``/dev/v4l/by-id/...`` survives
  replugging), ``rtsp://`` and ``http(s)://`` are streams, anything else is a file or a folder.
- Rates are frames a second; sizes (width, height) in pixels.
"""

from __future__ import annotations

import sys
import threading
from pathlib import Path

from vision.camera.camera import Camera, CameraError, Clock
from vision.camera.capture import StreamCamera, without_password, without_user
from vision.camera.folder import FolderCamera, PictureCamera
from vision.camera.picture_files import PICTURE_SUFFIXES, Pace, VideoCamera, Wait, read_picture
from vision.camera.v4l2.device import DeviceCamera, DeviceSettings, driver_time_s
from vision.camera.v4l2.devices import list_devices
from vision.camera.v4l2.identity import KnownCamera

__all__ = [
    "PICTURE_SUFFIXES",
    "DeviceSettings",
    "KnownCamera",
    "camera_for",
    "driver_time_s",
    "list_devices",
    "read_picture",
    "without_password",
    "without_user",
]

_STREAMS = ("rtsp://", "rtsps://", "http://", "https://", "udp://", "tcp://")


def camera_for(
    source: str | int,
    *,
    clock: Clock,
    rate_hz: float | None = None,
    size: tuple[int, int] | None = None,
    loop: bool = False,
    paced: bool = True,
    wait: Wait | None = None,
    device: DeviceSettings | None = None,
    known: KnownCamera | None = None,
) -> Camera:
    """Return the camera that a source names, closed.

    ``rate_hz`` and ``size`` are requested of a device; the rate paces a file (default: the video's
    own, 10 Hz for pictures). ``loop`` repeats a file; ``paced=False`` gives its frames as fast as
    they are read. ``wait`` pauses for seconds. ``device`` sets a device's format and controls, and
    ``known``, one for all cameras of a run, finds it after a replug. Raises ``CameraError`` if the
    source cannot be opened.
    """
    text = str(source).strip()
    shown = without_password(text)
    if rate_hz is not None and not 0.0 < rate_hz <= 1000.0:
        raise CameraError(f"camera {shown}: rate_hz = {rate_hz}: must be in (0, 1000]")
    if size is not None and not (0 < size[0] <= 32768 and 0 < size[1] <= 32768):
        raise CameraError(f"camera {shown}: size = {size}: must be in 1..32768 pixels")
    if (text.isascii() and text.isdecimal()) or text.startswith("/dev/"):
        if sys.platform != "linux":
            raise CameraError(
                f"camera {shown}: needs Linux, which a file, a folder or an address does not"
            )
        return DeviceCamera(text, clock, rate_hz, size, device, known)
    if text.lower().startswith(_STREAMS):
        return StreamCamera(text, clock)
    if not text:
        raise CameraError(
            "the camera's source is empty: must be a number, a device, an address, a file or a "
            "folder"
        )
    if "://" in text:
        kinds = ", ".join(_STREAMS)
        raise CameraError(f"{shown}: must begin with one of {kinds}")
    path = Path(text)
    pause = wait or threading.Event().wait
    pace = Pace(clock, pause, paced)
    if path.is_dir():
        return FolderCamera(path, pace, rate_hz, loop)
    if not path.exists():
        raise CameraError(f"{text}: no such file, folder or camera")
    if path.suffix.lower() in PICTURE_SUFFIXES:
        return PictureCamera(path, pace, rate_hz)
    return VideoCamera(path, pace, rate_hz, loop)

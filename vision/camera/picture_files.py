"""Files as cameras: a picture's pixels, the pace of files, and videos.

With ``paced``, files run at their rate: a late reader gets no burst of missed frames. Times are
seconds on the clock passed in.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from vision.camera.camera import CameraError, Clock, Frame, Image
from vision.camera.capture import Capture
from vision.camera.picture_size import oversize

PICTURE_SUFFIXES = frozenset(
    (
        *(".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"),
        *(".webp", ".avif", ".jp2"),
        *(".pbm", ".pgm", ".ppm", ".pnm", ".pam", ".ras"),
    )
)
"""Suffixes of pictures; any other file, a GIF too, is tried as a video."""

MOST_BYTES = 1 << 30
"""Most bytes of a picture file: a device or a sparse file may have no end."""

Wait = Callable[[float], object]


def read_picture(path: Path) -> Image:
    """Read a picture file as uint8, grey (h, w) or BGR (h, w, 3), or raise ``CameraError``.

    Pixels are the sensor's, as stored: an EXIF orientation is ignored
    (``vision.camera.picture_turn`` says why), except a TIFF's, which its decoder applies. libpng
    and libjpeg may write to stderr, which other threads share.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise CameraError(f"{path}: cannot be read: {error.strerror}") from error
    if not data:
        raise CameraError(f"{path}: an empty file, not a picture")
    if len(data) > MOST_BYTES:
        raise CameraError(f"{path}: more than {MOST_BYTES} bytes: no picture is as large")
    large = oversize(data)
    if large:
        raise CameraError(f"{path}: {large}")
    try:
        how = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION
        image = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), how)
    except cv2.error as error:
        raise CameraError(f"{path}: not a picture that OpenCV can decode") from error
    if image is None:
        raise CameraError(f"{path}: not a picture that OpenCV can decode")
    return image.astype(np.uint8, copy=False)


class Pace:
    """Timing of a file's frames."""

    def __init__(self, clock: Clock, wait: Wait, paced: bool) -> None:
        self.clock = clock
        self._wait = wait
        self._paced = paced
        self._due_s: float | None = None

    def restart(self) -> None:
        """Make the next frame due at once."""
        self._due_s = None

    def pause(self, pause_s: float) -> None:
        """Wait, paced or not, for a missing file."""
        self._wait(pause_s)

    def wait_for_turn(self, rate_hz: float, timeout_s: float) -> float | None:
        """Wait for the next frame and return the time; None if it is due after the timeout."""
        now_s = self.clock()
        if not self._paced:
            return now_s
        if self._due_s is None:
            self._due_s = now_s
        if self._due_s - now_s > timeout_s:
            self._wait(timeout_s)
            return None
        if self._due_s > now_s:
            self._wait(self._due_s - now_s)
            now_s = self.clock()
        self._due_s = max(self._due_s + 1.0 / rate_hz, now_s)
        return now_s


class VideoCamera(Capture):
    """Video file, at its own rate or the requested one."""

    may_repeat = True

    def __init__(self, path: Path, pace: Pace, rate_hz: float | None, loop: bool) -> None:
        super().__init__(str(path), pace.clock)
        self._path = path
        self._pace = pace
        self._rate_wanted_hz = rate_hz
        self._loop = loop
        self._file_rate_hz = 30.0
        self._first = True

    def open(self) -> None:
        """Open the file; ``CameraError`` if it is not a video."""
        capture = self._start(str(self._path), cv2.CAP_ANY, [])
        rate_hz = capture.get(cv2.CAP_PROP_FPS)
        self._file_rate_hz = rate_hz if 0.0 < rate_hz <= 1000.0 else 30.0
        self._pace.restart()
        self._first = True

    def read(self, timeout_s: float) -> Frame | None:
        """Return the next frame when due; None before that, and after the last (``ended``)."""
        if self.state == "ended":
            return None
        due = self._pace.wait_for_turn(self._rate_wanted_hz or self._file_rate_hz, timeout_s)
        if due is None:
            return None
        grabbed = self._grab()
        if grabbed is None:
            return self._at_end(timeout_s)
        self._first = False
        return self._frame(*grabbed)

    def _at_end(self, timeout_s: float) -> Frame | None:
        if self._first:
            raise CameraError(f"{self.name}: a video without a picture")
        if self._loop:
            self.open()
            return self.read(timeout_s)
        self.state, self.reason = "ended", f"{self.name}: the video has ended"
        return None

    def _refused(self) -> CameraError:
        return CameraError(f"{self.name}: neither a picture nor a video that OpenCV can decode")

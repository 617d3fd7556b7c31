"""Pictures as cameras: a folder shown one by one, or a single picture shown for ever.

Rules
- A folder's pictures come in the order of their names; at its end, new pictures named after the
  last are read too.
- An unreadable picture may be incomplete: it is tried for ``PATIENCE_S``, then left out and named
  in ``reason``. A folder without a readable picture is an error.
- A single picture is decoded again if its file has changed. While it is unreadable or gone, the
  last good one is shown, and ``reason`` says so.
"""

from __future__ import annotations

from pathlib import Path

from vision.camera.camera import CameraError, Frame, Image, RateMeter, SourceState
from vision.camera.picture_files import PICTURE_SUFFIXES, Pace, read_picture

PATIENCE_S = 0.5
"""Less than the silence that counts as a stall."""
_BETWEEN_TRIES_S = 0.1
_PICTURES_HZ = 10.0


class FolderCamera:
    """Pictures of a folder in the order of their names."""

    may_repeat = True

    def __init__(self, path: Path, pace: Pace, rate_hz: float | None, loop: bool) -> None:
        self.name = str(path)
        self.state: SourceState = "closed"
        self.reason = ""
        self._path = path
        self._pace = pace
        self._rate_wanted_hz = rate_hz or _PICTURES_HZ
        self._loop = loop
        self._rate = RateMeter()
        self._files: list[Path] = []
        self._next = 0
        self._read_any = False
        self._failing_since_s: float | None = None
        self._sequence = 0

    @property
    def rate_hz(self) -> float:
        """Measured frames a second."""
        return self._rate.rate_hz

    def open(self) -> None:
        """List the pictures; ``CameraError`` if there are none."""
        self._files = self._list()
        self._next = 0
        self._read_any = False
        self._failing_since_s = None
        self._rate = RateMeter()
        self._pace.restart()
        self.state, self.reason = "running", ""

    def read(self, timeout_s: float) -> Frame | None:
        """Return the next picture when due; None before that, and after the last (``ended``)."""
        if self.state == "closed":
            raise CameraError(f"{self.name}: read while closed")
        if self.state == "ended" or (self._next >= len(self._files) and not self._find_more()):
            return None
        now_s = self._pace.wait_for_turn(self._rate_wanted_hz, timeout_s)
        if now_s is None:
            return None
        try:
            image = self._picture(self._files[self._next])
        except CameraError as error:
            self._try_again(error, now_s, timeout_s)
            return None
        self._next += 1
        self._read_any = True
        self._failing_since_s = None
        self._rate.add(now_s)
        frame = Frame(image, now_s, self._sequence, self.name)
        self._sequence += 1
        return frame

    def close(self) -> None:
        """Forget the list; harmless when closed."""
        self._files = []
        self.state = "closed"

    def _list(self) -> list[Path]:
        try:
            entries = sorted(self._path.iterdir())
        except OSError as error:
            raise CameraError(f"{self.name}: cannot be read: {error.strerror}") from error
        files = [p for p in entries if p.suffix.lower() in PICTURE_SUFFIXES and p.is_file()]
        if not files:
            raise CameraError(f"{self.name}: a folder without pictures")
        return files

    def _find_more(self) -> bool:
        listed = self._list()
        later = [path for path in listed if path > self._files[-1]]
        if later:
            self._files += later
            return True
        if not self._read_any:
            raise CameraError(f"{self.name}: none of its pictures can be read; {self.reason}")
        if self._loop:
            self._files, self._next, self._read_any = listed, 0, False
            return True
        self.state, self.reason = "ended", f"{self.name}: no more pictures"
        return False

    def _picture(self, path: Path) -> Image:
        return read_picture(path)

    def _try_again(self, error: CameraError, now_s: float, timeout_s: float) -> None:
        if self._failing_since_s is None:
            self._failing_since_s = now_s
        if now_s - self._failing_since_s < PATIENCE_S:
            self._pace.pause(min(timeout_s, _BETWEEN_TRIES_S))
            return
        self.reason = f"{error}: left out"
        self._next += 1
        self._failing_since_s = None


class PictureCamera(FolderCamera):
    """One picture, shown for ever."""

    def __init__(self, path: Path, pace: Pace, rate_hz: float | None) -> None:
        super().__init__(path, pace, rate_hz, loop=True)
        self._image: Image | None = None
        self._version: tuple[int, ...] = ()

    def _list(self) -> list[Path]:
        if self._image is None:
            self._version = _version(self._path)
            self._image = read_picture(self._path)
        return [self._path]

    def _picture(self, path: Path) -> Image:
        try:
            version = _version(path)
            if self._image is None or version != self._version:
                self._image = read_picture(path)
                self._version = version
            self.reason = ""
        except CameraError as error:
            if self._image is None:
                raise
            self.reason = f"{error}: the picture before it is shown"
        return self._image


def _version(path: Path) -> tuple[int, ...]:
    """Values that change with a file's content; ``CameraError`` without a file."""
    try:
        status = path.stat()
    except OSError as error:
        raise CameraError(f"{path}: cannot be read: {error.strerror}") from error
    return status.st_mtime_ns, status.st_size, status.st_ino

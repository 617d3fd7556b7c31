"""Pose of a simulated robot for another process's simulated camera, through a small file.

One process writes it often, any may read; a reading during a writing is repeated. Metres and
radians.

Either process may end, be killed and return, and the file may be cut, replaced or deleted. So it is
never mapped (cutting a mapped file kills its reader), no writer empties it, each access looks the
path up again, and a pose carries a checksum: other content is not a pose yet.
"""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path
from typing import Final

_POSE: Final = struct.Struct("<ddd")
_SUM: Final = struct.Struct("<I")
_SIZE: Final = _POSE.size + _SUM.size
_TRIES: Final = 100


class PoseFileError(ValueError):
    """Unusable file; the message says which and why."""


class PoseWriter:
    """Writer of the pose; after a restart it continues in the same file.

    ``PoseFileError`` if the file cannot be made or written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = -1
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._open()
        except OSError as error:
            raise self._refused(error) from None

    def write(self, x_m: float, y_m: float, heading_rad: float) -> None:
        """Write the robot's present pose."""
        pose = _POSE.pack(x_m, y_m, heading_rad)
        try:
            if not self._is_there():
                self._open()
            os.pwrite(self._file, pose + _SUM.pack(zlib.crc32(pose)), 0)
        except OSError as error:
            raise self._refused(error) from None

    def close(self) -> None:
        """Close the file; it stays, with the last pose."""
        file, self._file = self._file, -1
        if file >= 0:
            os.close(file)

    def _open(self) -> None:
        self.close()
        self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)

    def _is_there(self) -> bool:
        """True if the open file is still the one of that name."""
        try:
            return os.path.samestat(os.stat(self.path), os.fstat(self._file))
        except FileNotFoundError:
            return False

    def _refused(self, error: OSError) -> PoseFileError:
        return PoseFileError(f"pose file {self.path}: {error.strerror or error}")


class PoseReader:
    """Reader of the pose from the file that has the name at the time.

    A file must exist at the start, or a wrong name would be waited for: ``PoseFileError``.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.stat()
        except OSError as error:
            raise self._without_pose(error.strerror or str(error)) from None

    def read(self) -> tuple[float, float, float]:
        """Last written pose; PoseFileError if there is none."""
        why = "no pose has been written into it"
        for _ in range(_TRIES):
            try:
                row = self._row()
            except OSError as error:
                why = error.strerror or str(error)
                break
            pose = row[: _POSE.size]
            if len(row) == _SIZE and _SUM.unpack(row[_POSE.size :])[0] == zlib.crc32(pose):
                x, y, heading = _POSE.unpack(pose)
                return x, y, heading
        raise self._without_pose(why)

    def _without_pose(self, why: str) -> PoseFileError:
        return PoseFileError(f"pose file {self.path}: {why}; does `clearway robot` run?")

    def _row(self) -> bytes:
        # Without O_NONBLOCK opening a pipe of that name would wait for ever.
        file = os.open(self.path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            return os.pread(file, _SIZE, 0)
        finally:
            os.close(file)

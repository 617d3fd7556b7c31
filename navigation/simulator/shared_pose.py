"""Where a simulated robot in another process is, through a small file that both have mapped.

The simulated camera of one process sees the robot of another that way. Written many times a
second by one process, read by any; a reading in the middle of a writing is made again. Metres
and radians.
"""

from __future__ import annotations

import mmap
import struct
from pathlib import Path
from typing import Final

_ROW: Final = struct.Struct("<QdddQ")
_TRIES: Final = 1000


class PoseFileError(ValueError):
    """The file cannot be used; the message says which and why."""


class SharedPose:
    """One pose in a file; ``write=True`` makes it, otherwise it must be there.

    A writer that is started again goes on in the same file: who reads it need not know.
    """

    def __init__(self, path: Path, *, write: bool) -> None:
        self.path = path
        self._count = 0
        try:
            if write:
                path.parent.mkdir(parents=True, exist_ok=True)
                # One of the right size stays: a reader that has it mapped would fall with it.
                if not path.is_file() or path.stat().st_size != _ROW.size:
                    path.write_bytes(bytes(_ROW.size))
            with path.open("r+b" if write else "rb") as file:
                access = mmap.ACCESS_WRITE if write else mmap.ACCESS_READ
                self._map = mmap.mmap(file.fileno(), _ROW.size, access=access)
        except (OSError, ValueError) as error:
            raise PoseFileError(f"pose file {path}: {error}; does `clearway robot` run?") from None

    def write(self, x_m: float, y_m: float, heading_rad: float) -> None:
        """Tell where the robot is now."""
        self._count += 1
        self._map[:] = _ROW.pack(self._count, x_m, y_m, heading_rad, self._count)

    def read(self) -> tuple[float, float, float]:
        """Where the robot is, as told last; PoseFileError before the first time."""
        for _ in range(_TRIES):
            before, x, y, heading, after = _ROW.unpack(self._map[:])
            if before == after != 0:
                return x, y, heading
        raise PoseFileError(f"pose file {self.path}: nobody has written a pose into it")

    def close(self) -> None:
        """Let go of the file."""
        self._map.close()

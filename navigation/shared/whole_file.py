"""Files that are complete or not there at all."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path


class UnwrittenFileError(ValueError):
    """Error: a file cannot be written."""


def write_whole(
    path: Path, data: str | bytes, *, private: bool = False, durable: bool = False
) -> None:
    """Write a file under another name, then rename it; ``UnwrittenFileError``.

    ``private``: only its owner may read it. ``durable``: the file and its name are on the disk when
    this returns. Anything but an ordinary file, such as /dev/stdout, is written to directly.
    """
    content = data.encode() if isinstance(data, str) else data
    fresh = path.with_name(f".{path.name}.new")
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(content)
            return
        try:
            flags = os.O_CREAT | os.O_TRUNC | os.O_WRONLY
            with open(os.open(fresh, flags, 0o600 if private else 0o666), "wb") as file:
                file.write(content)
                if durable:
                    file.flush()
                    os.fsync(file.fileno())
            fresh.replace(path)
            if durable:
                sync_folder(path.parent)
        except OSError:
            with contextlib.suppress(OSError):  # report the first error
                fresh.unlink(missing_ok=True)
            raise
    except OSError as error:
        reason = error.strerror or error
        raise UnwrittenFileError(f"{path}: cannot be written: {reason}") from None


def sync_folder(folder: Path) -> None:
    """Sync a folder's names to the disk; ``OSError``."""
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)

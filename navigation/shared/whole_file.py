"""Files that are complete or not there at all."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from pathlib import Path


class UnwrittenFileError(ValueError):
    """Error: a file cannot be written."""


def write_whole(
    path: Path, data: str | bytes, *, private: bool = False, durable: bool = False
) -> None:
    """Write a file under another name, then rename it; ``UnwrittenFileError``.

    A link to a file stays one, a file keeps its mode, and one that may not be written is left as it
    is. ``private``: only its owner may read it. ``durable``: the file and its name are on the disk
    when this returns. Anything but an ordinary file, such as /dev/stdout, is written to directly.
    """
    content = data.encode() if isinstance(data, str) else data
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(content)
            return
        _replace(Path(os.path.realpath(path)), content, private, durable)
    except OSError as error:
        reason = error.strerror or error
        raise UnwrittenFileError(f"{path}: cannot be written: {reason}") from None


def _replace(file: Path, content: bytes, private: bool, durable: bool) -> None:
    mode = 0o600 if private else _mode_of(file)
    fresh = file.with_name(f".{file.name}.new")
    try:
        flags = os.O_CREAT | os.O_TRUNC | os.O_WRONLY
        with open(os.open(fresh, flags, 0o666 if mode is None else mode), "wb") as opened:
            if mode is not None:
                fresh.chmod(mode)  # whatever the umask, or a file that a kill has left
            opened.write(content)
            if durable:
                opened.flush()
                os.fsync(opened.fileno())
        fresh.replace(file)
        if durable:
            sync_folder(file.parent)
    except OSError:
        with contextlib.suppress(OSError):  # report the first error
            fresh.unlink(missing_ok=True)
        raise


def _mode_of(file: Path) -> int | None:
    """Mode of a file, None without one; ``PermissionError`` if it may not be written."""
    try:
        mode = stat.S_IMODE(file.stat().st_mode)
    except FileNotFoundError:
        return None
    if not os.access(file, os.W_OK, effective_ids=os.access in os.supports_effective_ids):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return mode


def sync_folder(folder: Path) -> None:
    """Sync a folder's names to the disk; ``OSError``."""
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)

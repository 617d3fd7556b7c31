"""A journal's lock: a file beside it, never replaced, that one program holds."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path
from typing import Final

OPEN_WITHIN_S: Final = 5.0
"""Time for which a run that begins waits for a program that is about to end."""
LOOK_AGAIN_S: Final = 0.05
_NO_ROOM: Final = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO})


class JournalError(ValueError):
    """Error: the journal cannot be used."""


class JournalWriteError(JournalError):
    """Error: it cannot be written now: no space, a disk error, a lost file."""


class JournalLock:
    """The held lock of a journal, a context manager; `JournalError` if another program has it."""

    def __init__(self, journal: Path, patience_s: float = OPEN_WITHIN_S) -> None:
        file = Path(os.path.realpath(journal))
        self.file = file.with_name(f".{file.name}.lock")
        self._handle: int | None = None
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            self._take(journal, patience_s)
        except OSError as error:
            raise error_of(journal, error) from None

    def _take(self, journal: Path, patience_s: float) -> None:
        import fcntl  # only Unix has it

        until_s = time.monotonic() + patience_s
        while self._handle is None:
            handle = os.open(self.file, os.O_CREAT | os.O_RDWR, 0o600)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if identity(self.file) == identity(handle):
                    self._handle = handle  # else it was deleted before it was locked
            except BlockingIOError:
                if time.monotonic() >= until_s:
                    raise JournalError(
                        f"journal {journal}: is in use by another program, a running clearway "
                        "most likely: give each its own recording.journal"
                    ) from None
                time.sleep(LOOK_AGAIN_S)  # a file's lock cannot be awaited with a time limit
            finally:
                if self._handle != handle:
                    os.close(handle)

    def __enter__(self) -> JournalLock:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()

    def close(self) -> None:
        """Release the lock."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None


def identity(file: Path | int) -> tuple[int, int] | None:
    """Device and inode of a file, None without one."""
    try:
        status = os.stat(file)
    except OSError:
        return None
    return status.st_dev, status.st_ino


def error_of(journal: Path, error: OSError) -> JournalError:
    """A system's error as the journal's."""
    kind = JournalWriteError if error.errno in _NO_ROOM else JournalError
    return kind(f"journal {journal}: {error.strerror or error}")

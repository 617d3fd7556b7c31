"""The sockets that a daemon listens at: its file, and one without a file.

Rules
- If the file or its folder was removed, it is made again; until that succeeds, one in the temporary
  folder replaces it.
- The socket without a file is always there.
- Two daemons never share a file: one that answers is left alone, a leftover is replaced.

Seconds.
"""

from __future__ import annotations

import contextlib
import os
import queue
import socket
import stat
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from navigation.control.abstract import listen_without_a_file
from navigation.machine.descriptors import NONE_LEFT
from navigation.orders.errors import ControlError

BACKLOG: Final = 512
BEGIN_S: Final = 3.0
"""Time within which a program that begins to listen has done so; it waits `PROBE_S` for a
leftover."""
AGAIN_S: Final = 0.01
"""Time between two looks at whether it has."""
PROBE_S: Final = 2.0
LOOK_EVERY_S: Final = 0.25
"""A removed socket is noticed within this time and one turn of the server."""


@dataclass(frozen=True, slots=True)
class _Bound:
    path: Path
    socket: socket.socket
    file: tuple[int, int]

    @property
    def is_there(self) -> bool:
        try:
            found = self.path.lstat()
        except OSError:
            return False
        return (found.st_dev, found.st_ino) == self.file


class OrderSocket:
    """Listens at ``path`` and without a file, from `open` on.

    ``watch`` gets each socket that `look` makes, ``unwatch`` one before it is closed; ``release``
    gives back a descriptor if none is left, and is True if it could.
    """

    def __init__(
        self,
        path: Path,
        watch: Callable[[socket.socket], None],
        unwatch: Callable[[socket.socket], None],
        release: Callable[[], bool],
    ) -> None:
        self._path = path
        self._watch, self._unwatch, self._release = watch, unwatch, release
        self._bound: _Bound | None = None
        self._abstract: socket.socket | None = None
        self._look_at_s = 0.0
        self.trouble = ""
        """Why orders cannot come to the path, and where they can; empty if they can."""
        self.news: queue.SimpleQueue[str] = queue.SimpleQueue()
        """Sentences for people."""

    def open(self) -> None:
        """Begin to listen; ``ControlError`` if that fails."""
        _make_private(self._path.parent)
        with _alone_in(self._path):
            self._bound = _bind(self._path)
        try:
            self._abstract = listen_without_a_file(self._path, BACKLOG)
        except OSError as error:
            self._leave()
            raise ControlError(f"control socket without a file: {error.strerror}") from None

    @property
    def sockets(self) -> list[socket.socket]:
        """Sockets that listen now."""
        bound = None if self._bound is None else self._bound.socket
        return [one for one in (bound, self._abstract) if one is not None]

    def look(self, now_s: float) -> None:
        """Make a missing file again; call it a few times a second."""
        if now_s < self._look_at_s:
            return
        self._look_at_s = now_s + LOOK_EVERY_S
        if self._is_at(self._path):
            return
        try:
            self._move_to(self._path)
        except (ControlError, OSError) as error:
            self._stand_in(in_its_place(self._path), _reason(error))
            return
        again = "can be made again" if self.trouble else "was removed and is made again"
        self.news.put(f"control socket {self._path}: {again}: orders work there")
        self.trouble = ""

    def close(self) -> None:
        """Stop listening and remove the file, if still this daemon's."""
        self._leave()
        if self._abstract is not None:
            self._abstract.close()

    def _stand_in(self, other: Path, reason: str) -> None:
        where = f"orders work at {other}"
        if not self._is_at(other):
            try:
                self._move_to(other)
            except (ControlError, OSError):
                self._leave()
        if self._bound is None:
            where = "orders work without --socket only"
        self.trouble = f"control socket {self._path} is gone and cannot be made: {reason}; {where}"

    def _is_at(self, path: Path) -> bool:
        return self._bound is not None and self._bound.path == path and self._bound.is_there

    def _move_to(self, path: Path) -> None:
        try:
            bound = _bind(path)
        except ControlError as error:
            cause = error.__cause__
            no_room = isinstance(cause, OSError) and cause.errno in NONE_LEFT
            if not no_room or not self._release():
                raise
            bound = _bind(path)
        self._leave()
        self._bound = bound
        self._watch(bound.socket)

    def _leave(self) -> None:
        if self._bound is None:
            return
        with contextlib.suppress(KeyError):  # it was never watched
            self._unwatch(self._bound.socket)
        self._bound.socket.close()
        if self._bound.is_there:
            with contextlib.suppress(OSError):
                self._bound.path.unlink()
        self._bound = None


def in_its_place(path: Path) -> Path:
    """File in the temporary folder that replaces ``path``."""
    folder = Path(tempfile.gettempdir()) / f"clearway-{os.getuid()}"
    return folder / f"{path.name[:40]}.{os.getpid()}"


def _reason(error: Exception) -> str:
    if isinstance(error, OSError):
        return error.strerror or str(error)
    return str(error).removeprefix("control socket ")


def _bind(path: Path) -> _Bound:
    _make_private(path.parent)
    _remove_leftover(path)
    one = _listen(path)
    try:
        found = path.lstat()
    except OSError:
        one.close()
        raise
    return _Bound(path, one, (found.st_dev, found.st_ino))


@contextlib.contextmanager
def _alone_in(path: Path) -> Iterator[None]:
    """Lock the folder: another program that begins may be about to replace the same leftover.

    ``ControlError`` if another one still begins to listen there after ``BEGIN_S``.
    """
    import fcntl  # only Unix has it

    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        until_s = time.monotonic() + BEGIN_S
        while True:
            try:
                fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if time.monotonic() > until_s:
                    sentence = f"another daemon begins to listen in {path.parent}"
                    raise ControlError(f"control socket {path}: {sentence}") from None
                time.sleep(AGAIN_S)
        yield
    finally:
        os.close(folder)


def _listen(path: Path) -> socket.socket:
    try:
        one = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    except OSError as error:
        raise ControlError(f"control socket {path}: {error.strerror or error}") from error
    mask = os.umask(0o177)
    try:
        one.bind(str(path))
        one.listen(BACKLOG)
        one.setblocking(False)
    except OSError as error:
        one.close()
        raise ControlError(f"control socket {path}: {error.strerror or error}") from error
    finally:
        os.umask(mask)
    return one


def _make_private(folder: Path) -> None:
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    info = folder.lstat()
    # systemd links to the folder of an account that it made up; a stranger's link may change
    if stat.S_ISLNK(info.st_mode) and info.st_uid in (0, os.getuid()):
        info = folder.stat()
    if not stat.S_ISDIR(info.st_mode) or info.st_uid != os.getuid() or info.st_mode & 0o022:
        raise ControlError(f"control socket folder {folder}: must be yours alone (mode 0700)")


def _remove_leftover(path: Path) -> None:
    if not path.exists():
        return
    if not path.is_socket():
        raise ControlError(f"control socket {path}: is a file that is no socket")
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        probe.settimeout(PROBE_S)
        try:
            probe.connect(str(path))
        except BlockingIOError:  # its queue is full: it listens
            pass
        except OSError:
            path.unlink()
            return
    raise ControlError(
        f"control socket {path}: another daemon listens there already; for a second one give"
        " `clearway run --socket FILE`, and the same --socket to its orders"
    )

"""The stops of a run on disk: stored before they are answered, lifted by a re-arm only.

After the start, one thread alone touches the disk, and a stop waits for it at most ``ANSWER_S``: a
disk that hangs delays no stop, and the answer says so. What a disk refused is tried again every
``RETRY_S``.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from datetime import datetime
from pathlib import Path
from typing import Final

from navigation.journal.stop_latch import (
    Kept,
    Latch,
    held_by,
    read_latches,
    remove_latch,
    write_latch,
)
from navigation.shared.whole_file import UnwrittenFileError

ANSWER_S: Final = 0.15
"""A stop is answered within 0.3 s in any case."""
RETRY_S: Final = 1.0
"""Pause before a write that failed is tried again, as a journal's."""
END_S: Final = 2.0
"""For what is left to write when a run ends."""


class KeptStops:
    """Stops on disk, a context manager; ``ports`` has each robot's, under "" for a lone robot.

    ``held``: why robots wait at the beginning, by name.
    """

    def __init__(
        self,
        folder: Path,
        socket: Path,
        configuration: Path | None,
        ports: Mapping[str, tuple[str, ...]],
        now: Callable[[], datetime] = datetime.now,
    ) -> None:
        self._folder, self._socket = folder, str(socket.absolute())
        self._configuration = "" if configuration is None else str(configuration.resolve())
        self._ports, self._now = ports, now
        self.trouble = ""
        self._files: dict[Path, set[str]] = {}
        self._wanted: dict[str, Latch | None] = {}
        self._own: dict[str, Path] = {}
        self._asked = self._done = 0
        self._ends = False
        self._news = threading.Condition()
        self.held: dict[str, str] = {}
        for kept in read_latches(folder):
            self._take(kept)
        self._thread = threading.Thread(target=self._run, name="stops", daemon=True)
        self._thread.start()

    def _take(self, kept: Kept) -> None:
        names = held_by(kept, self._socket, self._configuration, self._ports)
        if names:
            self._files[kept.file] = names
        for name in names:
            self.held.setdefault(name, kept.sentence)

    def __enter__(self) -> KeptStops:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()

    def close(self) -> None:
        """Write what is left, for at most ``END_S``."""
        self._wait(END_S)
        with self._news:
            self._ends = True
            self._news.notify_all()

    def stop(self, names: Iterable[str], reason: str) -> None:
        """Store a stop of these robots soon; `settled` waits for it."""
        when = self._now().isoformat(timespec="seconds")
        with self._news:
            for name in names:
                ports = self._ports.get(name, ())
                if self._wanted.get(name) is None:
                    self._wanted[name] = Latch(
                        name, reason, when, self._socket, self._configuration, ports
                    )
            self._asked += 1
            self._news.notify_all()

    def lift(self, names: Iterable[str]) -> None:
        """Lift the stops of re-armed robots; a later stop is kept."""
        with self._news:
            for name in names:
                self._wanted[name] = None
                self.held.pop(name, None)
            self._asked += 1
            self._news.notify_all()

    def is_kept(self, name: str) -> bool:
        """True if a stop of this robot came after its last re-arm."""
        with self._news:
            return self._wanted.get(name) is not None

    def settled(self) -> str:
        """Wait for the disk; return its trouble, or an empty string."""
        with self._news:
            if not self._wait(ANSWER_S):  # in force until the disk answers
                self.trouble = f"{self._folder}: not on the disk after {ANSWER_S:g} s"
            return self.trouble

    def _wait(self, seconds: float) -> bool:
        with self._news:
            asked = self._asked
            return self._news.wait_for(lambda: self._done >= asked, seconds)

    # The thread.

    def _run(self) -> None:
        trouble = ""
        while True:
            with self._news:
                pause_s = RETRY_S if trouble else None
                is_news = self._news.wait_for(
                    lambda: self._ends or self._done < self._asked, pause_s
                )
                if is_news and self._done >= self._asked:
                    return
                asked, wanted = self._asked, dict(self._wanted)
            trouble = ""
            for name, latch in wanted.items():
                try:
                    self._keep(name, latch)
                except (OSError, UnwrittenFileError) as error:
                    trouble = str(error)
            with self._news:
                self.trouble, self._done = trouble, asked
                self._news.notify_all()

    def _keep(self, name: str, latch: Latch | None) -> None:
        if latch is not None:
            if name not in self._own or not self._own[name].exists():
                self._own[name] = write_latch(self._folder, latch)
            return
        for file, names in list(self._files.items()):
            names.discard(name)
            if not names:
                if file != self._folder:  # an unreadable folder is no stop's file
                    remove_latch(file)
                del self._files[file]
        if name in self._own:
            remove_latch(self._own[name])
            del self._own[name]

"""Writer of the file of changed zones, in a thread: a disk that hangs delays no order.

Rules
- The newest changes win. They are encoded once, in the thread, and written again every ``RETRY_S``
  while the disk refuses them; too many of them are refused at once, and not tried again.
- A file has one writer in a program. A run that begins again takes it over, so that a write that
  hung in the run before comes before its own.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Final

from navigation.journal.kept_zones import KeptZones, KeptZonesError, ZoneChange

ANSWER_S: Final = 2.0
"""Longest wait for the disk: chosen, a slow card's sync takes less."""
RETRY_S: Final = 1.0
"""Pause before a write that failed is tried again, as a journal's."""
UNKNOWN: Final = "a restart would not know of this change"

Changes = Callable[[], Sequence[ZoneChange]]


class ZonesWriter:
    """Writer of a file; ``trouble`` says why the newest changes are not on the disk."""

    def __init__(self, kept: KeptZones) -> None:
        self.kept, self.trouble = kept, ""
        self._changes: Changes = tuple
        self._disk = threading.Condition()
        self._asked = self._done = 0
        """Changes that are to be written, and those of which it is known how that ended."""
        self._works = self._ended = False

    def take_over(self, changes: Changes) -> None:
        """Write what ``changes`` returns from now on: a run begins."""
        with self._disk:
            self._changes, self._ended = changes, False

    def write(self) -> None:
        """Write the changes as they are now; return once that has ended or after ``ANSWER_S``."""
        with self._disk:
            self._asked += 1
            asked = self._asked
            self._disk.notify_all()
            if not self._works:
                self._works = True
                threading.Thread(target=self._work, name="zones", daemon=True).start()
            if not self._disk.wait_for(lambda: self._done >= asked, ANSWER_S):
                self.trouble = f"{UNKNOWN}: {self.kept.path}: not on the disk after {ANSWER_S:g} s"

    def end(self) -> None:
        """Try no failed write again; return once all is written or after ``ANSWER_S``."""
        with self._disk:
            self._ended = True
            self._disk.notify_all()
            self._disk.wait_for(lambda: not self._works, ANSWER_S)

    def _work(self) -> None:
        """Write until the newest changes are on the disk, or cannot be."""
        encoded, data = 0, b""
        while True:
            with self._disk:
                asked, changes = self._asked, self._changes
            trouble, again = "", False
            try:
                if encoded != asked:
                    data, encoded = self.kept.encoded(changes()), asked
                again = True
                self.kept.write(data)
            except KeptZonesError as error:
                trouble = f"{UNKNOWN}: {error}"
            with self._disk:
                self.trouble, self._done = trouble, asked
                self._disk.notify_all()
                if trouble and again:
                    self._disk.wait_for(lambda: self._ended or self._asked > self._done, RETRY_S)
                again = again and bool(trouble) and not self._ended
                self._works = again or self._asked > asked
                if not self._works:
                    self._disk.notify_all()
                    return

"""Read the configuration again during a run; a broken file changes nothing.

SIGHUP asks for it. A thread reads, so the control loop continues. A changed calibration counts too.

Concurrent requests merge, and the stricter one wins: a person who changes settings on the page has
ordered no drive, whatever other requests come.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

from navigation.config import Config
from navigation.config.errors import ConfigError
from navigation.machine.logs import Level


class Reloader:
    """Reader of ``file`` on request; ``good`` gets a new, different, valid configuration.

    ``load`` reads and checks, raising ``ConfigError``. ``say`` and ``good`` are called in the
    reloader's thread.
    """

    def __init__(
        self,
        file: Path,
        present: Config,
        *,
        load: Callable[[Path], Config],
        say: Callable[[Level, str], None],
        good: Callable[[Config], None],
    ) -> None:
        self._file, self._present = file, present
        self._load, self._say, self._good = load, say, good
        self._calibration = _calibration_in(present)
        self._asked = threading.Event()
        self._hands_over = False
        self._waiting_asked = self._waiting_answered = 0
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()

    @property
    def waits(self) -> bool:
        """True if the restarted run must wait for orders."""
        return self._waiting_asked > self._waiting_answered

    def ask(self, *, waits: bool = False) -> None:
        """Request a reading without waiting, as a signal handler must.

        ``waits``: the restarted run waits for orders, whatever others ask.
        """
        self._waiting_asked += waits
        self._asked.set()
        if self._lock.acquire(blocking=False):
            self._thread = threading.Thread(target=self._run, name="reload", daemon=True)
            self._thread.start()

    def join(self, timeout_s: float) -> None:
        """Wait for the reading in progress."""
        if self._thread is not None:
            self._thread.join(timeout_s)

    def _run(self) -> None:
        try:
            while self._asked.is_set():
                self._asked.clear()
                self._read_once()
        finally:
            self._lock.release()
        if self._asked.is_set():  # asked for between the last check and the release
            self.ask()

    def _read_once(self) -> None:
        asked = self._waiting_asked  # taken before the file is read: a later request reads it again
        try:
            config = self._load(self._file)
        except ConfigError as error:
            self._say("error", f"the run continues with the last good configuration:\n{error}")
            return
        calibration = _calibration_in(config)
        if config == self._present and calibration == self._calibration:
            self._say("info", f"{self._file} was read again: nothing has changed")
            if not self._hands_over:
                self._waiting_answered = asked
            return
        names = [
            name
            for name in Config.model_fields
            if getattr(config, name) != getattr(self._present, name)
        ]
        if calibration != self._calibration and "camera" not in names:
            names.append("the calibration")
        self._present, self._calibration = config, calibration
        self._say("info", f"{self._file} was read again: {', '.join(names)} changed")
        self._hands_over = True
        self._good(config)


def _calibration_in(config: Config) -> bytes:
    """Content of the calibration file; empty if missing or unreadable."""
    file = config.camera.calibration
    try:
        return b"" if file is None else file.read_bytes()
    except OSError:
        return b""

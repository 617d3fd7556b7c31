"""The driver's process from outside: started, watched, started again when it was killed.

Its port is a link in a folder of its own that stays the same over restarts; the daemon's serial
link opens it as it would open a cable. A driver that is started again stops its robot first.
"""

from __future__ import annotations

import multiprocessing
import shutil
import tempfile
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Final

from firmware_protocol.wire.drive_settings import DriveSettings
from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.serve import FAREWELL_S, DriverOrder, serve
from navigation.link.drivers.word_of_robot import Word
from navigation.link.serial_port import PortNotReadyError

START_S: Final = 30.0
"""A machine that is busy takes its time to start a process."""
AGAIN_S: Final = 0.1
_SPAWN: Final = multiprocessing.get_context("spawn")


class DriverProcess:
    """A driver and its watcher's thread; ``port`` is what the daemon opens.

    ``name`` is one of `KNOWN_ROBOTS`, ``robot_port`` where the robot is; ``model`` as in
    `DriverOrder`.
    """

    def __init__(
        self,
        name: str,
        robot_port: str,
        baud: int,
        settings: DriveSettings,
        model: str | None = None,
    ) -> None:
        self._title = KNOWN_ROBOTS[name].title
        self._folder = Path(tempfile.mkdtemp(prefix="clearway-driver-"))
        self.port = str(self._folder / "robot")
        self._order = DriverOrder(name, robot_port, baud, settings, self._folder / "robot", model)
        self._word = Word(silence=f"the driver of the {self._title} is being started")
        self._process: SpawnProcess | None = None
        self._words: Connection | None = None
        self._ending = threading.Event()
        self._watcher: threading.Thread | None = None
        self.restarts = 0
        self.start_again = True
        """Whether a driver that was killed is started again."""

    def start(self) -> None:
        """Start it, and wait until its port is there; PortNotReadyError where it never is."""
        self._start_process()
        self._watcher = threading.Thread(target=self._watch, name="robot's driver", daemon=True)
        self._watcher.start()
        until_s = time.monotonic() + START_S
        while not self._order.link.exists():
            if time.monotonic() > until_s:
                self.stop()
                raise PortNotReadyError(f"the driver of the {self._title} has not started")
            time.sleep(0.01)  # the pace at which it is looked for

    def stop(self) -> None:
        """End it: it stops the robot and closes its port."""
        self._ending.set()
        process = self._process
        if process is not None and process.is_alive():
            process.terminate()
            process.join(FAREWELL_S + START_S)
        if self._watcher is not None:
            self._watcher.join()
            self._watcher = None
        shutil.rmtree(self._folder, ignore_errors=True)

    @property
    def pid(self) -> int | None:
        """The number of the process that drives now."""
        return None if self._process is None else self._process.pid

    def word(self) -> Word:
        """What the driver says of its robot, the newest."""
        return self._word

    def _start_process(self) -> None:
        ours, theirs = _SPAWN.Pipe(duplex=False)
        work: Callable[..., None] = serve
        self._process = _SPAWN.Process(target=work, args=(self._order, theirs), daemon=True)
        self._process.start()
        theirs.close()
        self._words = ours

    def _watch(self) -> None:
        while not self._ending.is_set():
            process, words = self._process, self._words
            assert process is not None
            assert words is not None
            ready = wait([words, process.sentinel], timeout=0.5)
            if words in ready:
                try:
                    self._word = words.recv()
                    continue
                except (EOFError, OSError):
                    pass  # it has ended; its sentinel says so too
            if process.is_alive() or self._ending.is_set():
                self._ending.wait(0.01 if words in ready else 0.0)
                continue
            process.join()
            self.restarts += 1
            self._word = Word(
                silence=f"the driver of the {self._title} has ended (code {process.exitcode}) "
                "and is started again"
            )
            words.close()
            self._ending.wait(AGAIN_S)
            if not self.start_again:
                return
            if not self._ending.is_set():
                self._start_process()

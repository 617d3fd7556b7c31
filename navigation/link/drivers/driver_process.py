"""The driver's process from outside: a thread that watches it, and stops the robot without it.

The wire's port is a link in its own folder that stays the same over restarts; the daemon's serial
link opens it like a cable. The robot's own port is opened here and lent to the process. The thread
does nothing else.
"""

from __future__ import annotations

import ctypes
import math
import multiprocessing
import shutil
import socket
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
from navigation.link.drivers.driver_watch import START_S, DriverWatch
from navigation.link.drivers.drivers import new_driver
from navigation.link.drivers.lent_port import PortLost, lend
from navigation.link.drivers.robot_halt import RobotHalt
from navigation.link.drivers.robot_port import RobotPort
from navigation.link.drivers.serve import DriverOrder, Work, serve
from navigation.link.drivers.word_of_robot import Word
from navigation.link.serial_port import PortNotReadyError
from navigation.shared.supervisor import in_words

LOOK_S: Final = 0.02
"""While the process drives."""
STOP_S: Final = 0.005
"""While the daemon itself stops the robot."""
_SPAWN: Final = multiprocessing.get_context("spawn")


class DriverProcess:
    """A driver and its watcher's thread; the daemon opens ``port``.

    ``name`` is one of `KNOWN_ROBOTS`; ``model`` as in `DriverOrder`; ``work`` is the process's
    work.
    """

    def __init__(
        self,
        name: str,
        robot_port: str,
        baud: int,
        settings: DriveSettings,
        model: str | None = None,
        work: Work = serve,
    ) -> None:
        self._title = KNOWN_ROBOTS[name].title
        self._folder = Path(tempfile.mkdtemp(prefix="clearway-driver-"))
        link = self._folder / "robot"
        self.port = str(link)
        self._link = link
        order = DriverOrder(name, robot_port, baud, settings, link, model)
        self._process = _Process(order, work)
        self._robot_port = RobotPort(robot_port, baud)
        halt = RobotHalt(new_driver(name, model), robot_port)
        self._watch = DriverWatch(self._process, self._robot_port, halt, self._title)
        self._word = self._watch.word(time.monotonic())
        self._ending = threading.Event()
        self._watcher: threading.Thread | None = None

    def begin(self) -> None:
        """Begin to start it; `start` waits for it."""
        self._watcher = threading.Thread(target=self._run, name="robot's driver", daemon=True)
        self._watcher.start()

    def start(self) -> None:
        """Start it and wait for its port; PortNotReadyError if it never comes."""
        if self._watcher is None:
            self.begin()
        until_s = time.monotonic() + START_S
        while not self._link.exists():
            if time.monotonic() > until_s or self._watcher is None or not self._watcher.is_alive():
                self.stop()
                raise PortNotReadyError(f"the driver of the {self._title} has not started")
            time.sleep(0.01)  # a name that another process makes gives no sign

    def end(self) -> None:
        """Begin to end it; `stop` waits for it."""
        self._ending.set()

    def stop(self) -> str | None:
        """End it and see that the robot is at rest; return the doubt about that, or None."""
        self._ending.set()
        if self._watcher is not None:
            self._watcher.join()
            self._watcher = None
        shutil.rmtree(self._folder, ignore_errors=True)
        return self._watch.doubt(time.monotonic())

    @property
    def pid(self) -> int | None:
        """Number of the process that drives now."""
        return self._process.pid

    @property
    def beat_s(self) -> float:
        """Last beat of the process that drives, or that last drove; monotonic."""
        return self._process.beat_s

    @property
    def restarts(self) -> int:
        """Number of restarts."""
        return self._watch.restarts

    def word(self) -> Word:
        """Newest sentences about the robot."""
        return self._word

    def _run(self) -> None:
        watch, process, ends = self._watch, self._process, False
        try:
            while not watch.is_over(time.monotonic()):
                if self._ending.is_set() and not ends:
                    ends = True
                    watch.end(time.monotonic())
                for word in process.words():
                    if isinstance(word, PortLost):
                        watch.loses_port(word.reason, time.monotonic())
                    else:
                        watch.hears(word)
                watch.turn(time.monotonic())
                self._word = watch.word(time.monotonic())
                wait(process.news(), STOP_S if watch.has_port else LOOK_S)
        finally:
            process.close()
            self._robot_port.close()


class _Process:
    """See `Drives`."""

    def __init__(self, order: DriverOrder, work: Work) -> None:
        self._order, self._work = order, work
        self._beat = _SPAWN.RawValue(ctypes.c_double, -math.inf)
        self._process: SpawnProcess | None = None
        self._words: Connection | None = None
        self._lender: socket.socket | None = None

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    @property
    def beat_s(self) -> float:
        return float(self._beat.value)

    def start(self) -> str | None:
        self._beat.value = -math.inf
        self._forget_ends()
        # the last process's port: its number may be another terminal's by now
        self._order.link.unlink(missing_ok=True)
        try:
            ours, theirs = _SPAWN.Pipe(duplex=False)
            lender, borrower = socket.socketpair()
            with theirs, borrower:
                arguments = (self._order, theirs, borrower, self._beat)
                work: Callable[..., None] = self._work
                process = _SPAWN.Process(target=work, args=arguments, daemon=True)
                process.start()
        except OSError as error:
            return in_words(error)
        self._words, self._lender, self._process = ours, lender, process
        return None

    def runs(self) -> bool:
        return self._process is not None and self._process.is_alive()

    def how_it_ended(self) -> str:
        assert self._process is not None
        return f"has ended (code {self._process.exitcode})"

    def ask_to_end(self) -> None:
        if self._process is not None:
            self._process.terminate()

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()
        self._order.link.unlink(missing_ok=True)

    def close(self) -> None:
        self.kill()
        self._forget_ends()

    def lend(self, descriptor: int) -> bool:
        assert self._lender is not None
        try:
            lend(self._lender, descriptor)
        except OSError:
            return False  # it has just ended
        return True

    def words(self) -> list[Word | PortLost]:
        words: list[Word | PortLost] = []
        try:
            while self._words is not None and self._words.poll():
                words.append(self._words.recv())
        except (EOFError, OSError):
            self._forget_ends()
        return words

    def news(self) -> list[int | Connection]:
        """Objects for `wait`: its words, and its end."""
        alive = self.runs() and self._process is not None
        ends: list[int | Connection] = [self._process.sentinel] if alive and self._process else []
        return ends if self._words is None else [*ends, self._words]

    def _forget_ends(self) -> None:
        for end in (self._words, self._lender):
            if end is not None:
                end.close()
        self._words = None

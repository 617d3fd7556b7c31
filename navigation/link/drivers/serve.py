"""The driver's process from inside: one loop around `DrivenRobot`, with its two ports.

It makes a pseudo-terminal for our wire and a link with a lasting name to it; the robot's own port
is lent to it. Each turn that did its whole work is a heartbeat. It ends when asked, or when the
program that started it has ended in any manner: the robot is stopped first. The link's folder is
removed here only if that has ended. Ctrl-C and Ctrl-Z in a terminal do not reach it; if the daemon
hangs, its lease runs out.
"""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import os
import random
import select
import shutil
import signal
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Final, TypeAlias

from firmware_protocol.robot.connection import Identity
from firmware_protocol.wire.drive_settings import DriveSettings
from navigation.link.drivers.driven_robot import DrivenRobot
from navigation.link.drivers.drivers import new_driver
from navigation.link.drivers.lent_port import LentPort, PortLost
from navigation.link.drivers.word_of_robot import Word

LONGEST_WAIT_S: Final = 0.005
WORD_S: Final = 0.1
FAREWELL_S: Final = 0.4
"""Time for which the robot is ordered to stop before its port is closed: a lost order is
repeated."""
READ_BYTES: Final = 4096


@dataclass(frozen=True, slots=True)
class DriverOrder:
    """Order to a driver's process: the robot, its port, and its settings."""

    name: str
    port: str
    baud: int
    settings: DriveSettings
    link: Path
    """Place of the link to our wire's pseudo-terminal."""
    model: str | None = None
    """The maker's robot, where the driver has to know."""


Work: TypeAlias = "Callable[[DriverOrder, Connection, socket.socket, ctypes.c_double], None]"


def serve(
    order: DriverOrder, words: Connection, lender: socket.socket, beat: ctypes.c_double
) -> None:
    """Run the process's work until it must end.

    ``words`` takes each new `Word`, ``lender`` brings the robot's port, and ``beat`` shows the
    loop's last beat.
    """
    ended = _hear_the_end()
    parent = multiprocessing.parent_process()
    assert parent is not None
    robot = DrivenRobot(
        new_driver(order.name, order.model),
        order.settings,
        Identity(random.SystemRandom().randrange(1, 1 << 32)),
        order.port,
        order.baud,
    )
    loop = _Loop(robot, LentPort(order.port, lender), order.link, words, beat)
    try:
        while not ended and not loop.has_ended(parent.sentinel):
            loop.turn()
        loop.say_farewell()
    finally:
        loop.close()
        if not parent.is_alive():
            shutil.rmtree(order.link.parent, ignore_errors=True)


def _hear_the_end() -> list[int]:
    """Signals that asked for the end; the terminal's are ignored."""
    came: list[int] = []
    with contextlib.suppress(PermissionError):
        os.setsid()
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, _frame: came.append(number))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return came


class _Loop:
    """The robot, its port, the wire's pseudo-terminal, and the words for people."""

    def __init__(
        self,
        robot: DrivenRobot,
        port: LentPort,
        link: Path,
        words: Connection,
        beat: ctypes.c_double,
    ) -> None:
        self._robot, self._port, self._words, self._beat = robot, port, words, beat
        import tty  # only Unix has it

        self._wire, self._other_end = os.openpty()
        tty.setraw(self._other_end)
        os.set_blocking(self._wire, False)
        self._link = link
        self._unsent = b""
        self._word: Word | None = None
        self._word_s = 0.0
        new = link.with_name(f"{link.name}.new")
        new.unlink(missing_ok=True)
        new.symlink_to(os.ttyname(self._other_end))
        new.replace(link)  # at once: a reader opens the old one or the new one

    def has_ended(self, sentinel: int) -> bool:
        """Wait briefly for news; True if the program that started this one has ended."""
        watched = [self._wire, sentinel, *self._port.descriptors()]
        try:
            return sentinel in select.select(watched, [], [], LONGEST_WAIT_S)[0]
        except OSError:
            return False  # the robot's port has just gone: the next turn closes it

    def turn(self) -> None:
        """Read everything, decide once, send everything due."""
        now_s = time.monotonic()
        if self._port.take():
            self._robot.port_opened(now_s)
            self._port_is_lost = False
        data = self._port.read()
        if data:
            self._robot.receive_from_robot(data, now_s)
        if self._port.fault is not None:
            self._lose_port(self._port.fault)
        with contextlib.suppress(OSError):
            self._robot.receive_from_host(os.read(self._wire, READ_BYTES), now_s)
        self._robot.tick(now_s)
        self._port.write(self._robot.bytes_to_robot(now_s) if self._port.is_free else b"")
        self._send_to_host(now_s)
        self._tell(now_s)
        self._beat.value = time.monotonic()

    _port_is_lost = True

    def _lose_port(self, fault: str) -> None:
        self._robot.port_closed(fault)
        if not self._port_is_lost:
            self._port_is_lost = True
            self._say(PortLost(fault))

    def say_farewell(self) -> None:
        """Stop the robot, and see that the order has gone out."""
        self._robot.leave()
        until_s = time.monotonic() + FAREWELL_S
        while time.monotonic() < until_s:
            self.turn()
            time.sleep(LONGEST_WAIT_S)  # a port has no event for "all sent"

    def close(self) -> None:
        """Close both ports; remove the link if it is still ours."""
        self._port.close()
        with contextlib.suppress(OSError):
            if str(self._link.readlink()) == os.ttyname(self._other_end):
                self._link.unlink()
        os.close(self._wire)
        os.close(self._other_end)

    def _send_to_host(self, now_s: float) -> None:
        self._unsent = (self._unsent + self._robot.bytes_to_host(now_s))[-READ_BYTES:]
        if self._unsent:
            try:
                self._unsent = self._unsent[os.write(self._wire, self._unsent) :]
            except OSError:
                self._unsent = b""  # no reader: a UART does not wait either

    def _tell(self, now_s: float) -> None:
        if now_s - self._word_s < WORD_S:
            return
        self._word_s = now_s
        word = self._robot.word(now_s)
        if word != self._word:
            self._word = word
            self._say(word)

    def _say(self, news: Word | PortLost) -> None:
        with contextlib.suppress(OSError):
            self._words.send(news)

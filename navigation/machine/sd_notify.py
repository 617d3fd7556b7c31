"""Reports to systemd: ready, stopping, and that every stage of the program still works.

Rules
- A message is one datagram, sent without waiting: a full socket loses it, never stops a robot's
  loop.
- WATCHDOG=1 is sent only if every stage has turned since the last one. STATUS names a hanging
  stage, and systemd restarts the program after its time.
- An assignment is always one line: outside text can set no other.

The protocol: sd_notify(3). Units: seconds.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Callable, Mapping
from typing import Final

from navigation.config.secrecy.secrets import hide
from navigation.shared.outside import printable

KEEPALIVES_A_PERIOD: Final = 4
"""systemd advises at least two; four leave room for one stage that is slow once."""
MOST_CHARACTERS: Final = 2000
SAID_AFTER: Final = 0.5
"""Part of the period after which a stage that has not turned is named."""


class Notifier:
    """Sender of sd_notify messages to ``address``; None sends nothing."""

    def __init__(self, address: str | None) -> None:
        self.lost = 0
        self._socket: socket.socket | None = None
        if not address:
            return
        # an @ is the zero byte of a name in the abstract namespace
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
        self._socket.setblocking(False)

    @classmethod
    def from_environment(cls, environment: Mapping[str, str]) -> Notifier:
        """Make the notifier for systemd's NOTIFY_SOCKET."""
        return cls(environment.get("NOTIFY_SOCKET"))

    def send(self, *assignments: str) -> bool:
        """Send assignments such as ``READY=1``; False if the message was lost."""
        if self._socket is None:
            return True
        try:
            lines = (printable(one, MOST_CHARACTERS) for one in assignments)
            self._socket.sendto(hide("\n".join(lines)).encode(), self._address)
        except OSError:
            self.lost += 1
            return False
        return True

    def close(self) -> None:
        """Close the socket."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class Watchdog:
    """Sender of systemd's watchdog messages while every stage turns.

    ``turns`` gives a number for each stage, which grows while the stage works. ``period_s``:
    systemd's WatchdogSec; None sends nothing.
    """

    def __init__(
        self, notifier: Notifier, period_s: float | None, turns: Callable[[], Mapping[str, int]]
    ) -> None:
        self._notifier = notifier
        self._period_s = period_s
        self._turns = turns
        self._last = dict(turns())
        self._sent_s: float | None = None
        self.hanging: tuple[str, ...] = ()
        """The stages that have not turned for more than half the period."""

    def tick(self, now_s: float) -> None:
        """Send if it is time and every stage has turned; call often."""
        if self._period_s is None:
            return
        if self._sent_s is None:
            self._sent_s = now_s
        if now_s < self._sent_s + self._period_s / KEEPALIVES_A_PERIOD:
            return
        turns = dict(self._turns())
        hanging = tuple(name for name, count in turns.items() if count == self._last.get(name))
        if not hanging:
            self.hanging = ()
            self._last, self._sent_s = turns, now_s
            self._notifier.send("WATCHDOG=1")
        elif now_s > self._sent_s + self._period_s * SAID_AFTER and hanging != self.hanging:
            self.hanging = hanging
            self._notifier.send(f"STATUS=does not get on: {', '.join(hanging)}")


def watchdog_period_s(environment: Mapping[str, str], own_pid: int | None = None) -> float | None:
    """Return systemd's WatchdogSec for this process; None if it watches none or another."""
    pid = environment.get("WATCHDOG_PID")
    if pid and pid != str(os.getpid() if own_pid is None else own_pid):
        return None
    try:
        period_us = int(environment.get("WATCHDOG_USEC", ""))
    except ValueError:
        return None
    return period_us / 1e6 if period_us > 0 else None

"""The robot's port in the driver's process: a descriptor that the daemon lends, and shares.

The daemon opens the port and keeps its own descriptor of it: a driver that hangs or dies takes
nothing away that is needed to stop the robot. A port that breaks is given back by saying so.
"""

from __future__ import annotations

import contextlib
import os
import select
import socket
from dataclasses import dataclass
from typing import Final

READ_BYTES: Final = 4096


@dataclass(frozen=True, slots=True)
class PortLost:
    """A message of the driver's process to the daemon: the lent port has broken, and why."""

    reason: str


def lend(to: socket.socket, descriptor: int) -> None:
    """Give the process at the other end a descriptor of the same port; OSError where it cannot."""
    socket.send_fds(to, [b"!"], [descriptor])


class LentPort:
    """``fault`` is why there is none, None while there is. ``lender``: where it comes from."""

    def __init__(self, path: str, lender: socket.socket) -> None:
        self._path, self._lender = path, lender
        lender.setblocking(False)
        self._descriptor: int | None = None
        self._unsent = b""
        self.fault: str | None = "the robot's port is not open yet"

    def take(self) -> bool:
        """Take it where it is lent; whether it has just been."""
        try:
            _data, descriptors, _flags, _from = socket.recv_fds(self._lender, 16, 4)
        except OSError:
            return False  # nothing came, or the daemon has gone, which its sentinel says
        if not descriptors:
            return False
        self.close()
        self._descriptor, *others = descriptors
        for one in others:
            os.close(one)
        self.fault, self._unsent = None, b""
        return True

    def close(self) -> None:
        """Let go of it; the daemon's descriptor stays."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            with contextlib.suppress(OSError):
                os.close(descriptor)

    def descriptors(self) -> list[int]:
        """The descriptor that `select` waits for."""
        return [self._lender.fileno(), *([] if self._descriptor is None else [self._descriptor])]

    def read(self) -> bytes:
        """Read what has come; a port that breaks is closed."""
        if self._descriptor is None or not select.select([self._descriptor], [], [], 0)[0]:
            return b""
        try:
            data = os.read(self._descriptor, READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError as error:
            return self._break(error.strerror or str(error))
        return data or self._break("it was hung up")

    @property
    def is_free(self) -> bool:
        """True if the line has taken everything that was written."""
        return not self._unsent

    def write(self, data: bytes) -> None:
        """Write what the line takes now, and keep the rest; a port that breaks is closed."""
        self._unsent += data
        if self._descriptor is None or not self._unsent:
            return
        try:
            self._unsent = self._unsent[os.write(self._descriptor, self._unsent) :]
        except BlockingIOError:
            return  # the line takes nothing now
        except OSError as error:
            self._break(error.strerror or str(error))

    def _break(self, reason: str) -> bytes:
        self.close()
        self._unsent = b""
        self.fault = f"serial port {self._path} broke: {reason}; is the cable plugged in?"
        return b""

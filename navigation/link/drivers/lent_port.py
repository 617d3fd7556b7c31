"""The robot's port in the driver's process: a descriptor that the daemon lends and shares.

The daemon keeps its own descriptor: a driver that hangs or dies takes away nothing needed to stop
the robot.
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
    """Message from the process to the daemon: the lent port broke, and why."""

    reason: str


def lend(to: socket.socket, descriptor: int) -> None:
    """Give the other process a descriptor of the same port; OSError if that fails."""
    socket.send_fds(to, [b"!"], [descriptor])


class LentPort:
    """Port from ``lender``; ``fault`` is why there is none, else None."""

    def __init__(self, path: str, lender: socket.socket) -> None:
        self._path, self._lender = path, lender
        lender.setblocking(False)
        self._descriptor: int | None = None
        self._unsent = b""
        self.fault: str | None = "the robot's port is not open yet"

    def take(self) -> bool:
        """Take the port if it is lent; True if it just was."""
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
        """Close it; the daemon's descriptor stays."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            with contextlib.suppress(OSError):
                os.close(descriptor)

    def descriptors(self) -> list[int]:
        """The descriptor that `select` waits for."""
        return [self._lender.fileno(), *([] if self._descriptor is None else [self._descriptor])]

    def read(self) -> bytes:
        """Read what has come; a broken port is closed."""
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
        """True if the line has taken everything written."""
        return not self._unsent

    def write(self, data: bytes) -> None:
        """Write what the line takes now, and keep the rest; a broken port is closed."""
        self._unsent += data
        if self._descriptor is None or not self._unsent:
            return
        try:
            self._unsent = self._unsent[os.write(self._descriptor, self._unsent) :]
        except BlockingIOError:
            return
        except OSError as error:
            self._break(error.strerror or str(error))

    def _break(self, reason: str) -> bytes:
        self.close()
        self._unsent = b""
        self.fault = f"serial port {self._path} broke: {reason}; is the cable plugged in?"
        return b""

"""The robot's own port on the daemon's side: opened, read, written, and opened again.

A device, or an address for pyserial's ``serial_for_url`` such as ``socket://host:port``. Nothing
here waits, except for an address that is slow to reach.
"""

from __future__ import annotations

import contextlib
import select
from typing import Final

import serial

from navigation.link.port_faults import PORT_FAULTS
from navigation.link.serial_port import PortError, open_port

REOPEN_FIRST_S: Final = 0.1
REOPEN_LAST_S: Final = 1.0
READ_BYTES: Final = 4096


class RobotPort:
    """Robot's port; ``fault`` is why it is closed, None while it is open."""

    def __init__(self, path: str, baud: int) -> None:
        self._path, self._baud = path, baud
        self._port: serial.Serial | None = None
        self._unsent = b""
        self._again_s = 0.0
        self._pause_s = REOPEN_FIRST_S
        self.fault: str | None = "the robot's port is not open yet"

    def open(self, now_s: float) -> bool:
        """Try to open it when due; True if it was just opened."""
        if self._port is not None or now_s < self._again_s:
            return False
        try:
            self._port = open_port(self._path, self._baud)
        except PortError as error:
            return self._wait_after(str(error), now_s)
        if self.fileno() is None:
            self.close()
            return self._wait_after(
                f"serial port {self._path}: is an address without a descriptor, which two "
                "processes cannot share: use a device or socket://host:port",
                now_s,
            )
        self.fault, self._pause_s, self._unsent = None, REOPEN_FIRST_S, b""
        return True

    def _wait_after(self, fault: str, now_s: float) -> bool:
        self.fault = fault
        self._again_s = now_s + self._pause_s
        self._pause_s = min(REOPEN_LAST_S, 2.0 * self._pause_s)
        return False

    def close(self) -> None:
        """Close it."""
        port, self._port = self._port, None
        if port is not None:
            # a port that has hung up may fail to close
            with contextlib.suppress(*PORT_FAULTS):
                port.close()

    def fileno(self) -> int | None:
        """Descriptor for `select`; None if there is none."""
        if self._port is None:
            return None
        try:
            number: int = self._port.fileno()
        except (AttributeError, OSError):
            return None
        return number

    def read(self, now_s: float) -> bytes:
        """Bytes that have come; a broken port is closed."""
        if self._port is None:
            return b""
        try:
            return bytes(self._port.read(READ_BYTES))
        except PORT_FAULTS as error:
            self._break(error, now_s)
            return b""

    @property
    def is_free(self) -> bool:
        """True if everything written was taken."""
        return not self._unsent

    def write(self, data: bytes, now_s: float) -> None:
        """Write what the line takes now, and keep the rest; a broken port is closed."""
        self._unsent += data
        if self._port is None or not self._unsent:
            return
        number = self.fileno()
        if number is not None and not select.select([], [number], [], 0)[1]:
            return
        try:
            self._unsent = self._unsent[self._port.write(self._unsent) or 0 :]
        except PORT_FAULTS as error:
            self._break(error, now_s)

    def drop_unsent(self, now_s: float) -> None:
        """Drop unsent bytes, in the computer's queue too: old orders to drive."""
        self._unsent = b""
        try:
            if self._port is not None:
                self._port.reset_output_buffer()
        except PORT_FAULTS as error:
            self._break(error, now_s)

    def lose(self, fault: str, now_s: float) -> None:
        """Close a port that its user found broken; it is opened again soon."""
        self.close()
        self._unsent = b""
        self.fault = fault
        self._again_s = now_s + self._pause_s

    def _break(self, error: BaseException, now_s: float) -> None:
        self.lose(f"serial port {self._path} broke: {error}; is the cable plugged in?", now_s)

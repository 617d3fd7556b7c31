"""Opening a serial port, or saying in one sentence why it cannot be opened."""

from __future__ import annotations

import errno
import os
import stat
import termios

import serial


class PortError(ValueError):
    """A serial port cannot be used; the message says which and why."""


def open_port(path: str, baud: int) -> serial.Serial:
    """Open ``path`` for this process alone, without waiting in reads and writes.

    Raises PortError where the port is missing, busy, forbidden or no serial port.
    """
    look_for_port(path)
    try:
        return serial.Serial(path, baud, timeout=0, write_timeout=0, exclusive=True)
    except (serial.SerialException, OSError, ValueError, termios.error) as error:
        raise PortError(f"serial port {path}: {_reason(error)}") from error


def look_for_port(path: str) -> None:
    """PortError where there is no such device; opens nothing, for opening resets some robots."""
    try:
        mode = os.stat(path).st_mode
    except OSError as error:
        raise PortError(f"serial port {path}: {_reason(error)}") from error
    if not stat.S_ISCHR(mode):
        raise PortError(f"serial port {path}: is no serial port")


def _reason(error: BaseException) -> str:
    number = getattr(error, "errno", None)
    if number is None and error.args and isinstance(error.args[0], int):
        number = error.args[0]
    if number is None and error.__context__ is not None:
        return _reason(error.__context__)  # pyserial wraps termios.error without its number
    match number:
        case errno.ENOENT | errno.ENXIO | errno.ENODEV:
            return "there is no such device; is the cable plugged in?"
        case errno.EAGAIN | errno.EBUSY:
            return "is in use by another program"
        case errno.EACCES | errno.EPERM:
            return "no permission; on Debian the user has to be in the group dialout"
        case errno.ENOTTY | errno.EINVAL:
            return "is no serial port"
        case int():
            return os.strerror(number)
    return str(error)

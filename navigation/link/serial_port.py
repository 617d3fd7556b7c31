"""Opening of a serial port, or one sentence on why it fails.

A missing, busy or forbidden port may be usable later; a file that is no serial port never will be.
"""

from __future__ import annotations

import errno
import os
import stat
from typing import Final

import serial

from navigation.link.port_faults import PORT_FAULTS


class PortError(ValueError):
    """Unusable serial port; the message says which and why."""


class PortNotReadyError(PortError):
    """Serial port that cannot be used now, but is worth waiting for."""


NEVER: Final = frozenset(
    (errno.ENOTTY, errno.EINVAL, errno.ENOTDIR, errno.ELOOP, errno.ENAMETOOLONG)
)
"""Errors that only another configuration helps against; everything else may pass."""


def open_port(path: str, baud: int) -> serial.Serial:
    """Open ``path`` for this process alone, with non-blocking reads and writes.

    ``path`` may also be a pyserial address such as ``socket://host:port``. Raises PortNotReadyError
    if the port is missing, busy or forbidden, and PortError if it is no serial port.
    """
    look_for_port(path)
    try:
        return serial.serial_for_url(path, baud, timeout=0, write_timeout=0, exclusive=True)
    except (*PORT_FAULTS, ValueError) as error:
        raise _refusal(path, error) from error


def is_address(path: str) -> bool:
    """True if ``path`` is a pyserial address, not a device."""
    return "://" in path


def look_for_port(path: str) -> None:
    """Raise errors as `open_port` does, as far as they show without opening, which resets some
    robots.
    """
    if is_address(path):
        return  # only opening it shows if anything listens
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError as error:
        if os.sep not in path:
            raise PortError(
                f"serial port {path}: must be 'simulated' or a path such as /dev/{path}"
            ) from error
        raise _refusal(path, error) from error
    except OSError as error:
        raise _refusal(path, error) from error
    if not stat.S_ISCHR(mode):
        raise PortError(f"serial port {path}: is no serial port")


def _refusal(path: str, error: BaseException) -> PortError:
    number = _errno(error)
    reason = f"serial port {path}: {_reason(number) or error}"
    if number is None or number in NEVER:
        return PortError(reason)
    return PortNotReadyError(reason)


def _errno(error: BaseException) -> int | None:
    number = getattr(error, "errno", None)
    if number is None and error.args and isinstance(error.args[0], int):
        number = error.args[0]
    if number is None and error.__context__ is not None:
        return _errno(error.__context__)  # pyserial wraps termios.error without its number
    return number


def _reason(number: int | None) -> str | None:
    match number:
        case errno.ENOENT | errno.ENXIO | errno.ENODEV:
            return "there is no such device; is the cable plugged in?"
        case errno.EAGAIN | errno.EBUSY:
            return "is in use by another program"
        case errno.EACCES | errno.EPERM:
            return "no permission; on Debian the user has to be in the group dialout"
        case errno.ECONNREFUSED | errno.EHOSTUNREACH | errno.ENETUNREACH | errno.ETIMEDOUT:
            return f"{os.strerror(number)}; is the robot switched on and in this network?"
        case errno.EIO:
            return "does not answer (input/output error); is there a device behind it?"
        case errno.ENOTTY | errno.EINVAL:
            return "is no serial port"
        case int():
            return os.strerror(number)
    return None

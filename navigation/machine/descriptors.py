"""File descriptors: as many as the system allows, and a few in reserve."""

from __future__ import annotations

import errno
import os
from typing import Final

WANTED: Final = 1024
"""Descriptors below this fit ``select``, which pyserial and the link's thread wait with. The page's
and the socket's connections take less than half of them."""
NONE_LEFT: Final = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})
"""Errors of `accept` where the process or the system has no room for another connection."""


def set_descriptor_limit(wanted: int = WANTED) -> int:
    """Set this process's soft limit to ``wanted``, at most the hard limit.

    A higher limit is lowered: a serial port with a descriptor beyond it could not be waited for.
    """
    import resource  # only Unix has it

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY:
        wanted = min(wanted, hard)
    if soft == wanted:
        return wanted
    resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    return wanted


def descriptor_limit() -> int:
    """Number of descriptors that this process may open; `WANTED` if there is no limit."""
    import resource

    soft, _hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    return WANTED if soft == resource.RLIM_INFINITY else soft


class SpareDescriptors:
    """Reserve of open descriptors, released when none is left."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._held: list[int] = []
        self.refill()

    def release(self) -> bool:
        """Close one, so that the next opening succeeds; False if none is left."""
        if not self._held:
            return False
        os.close(self._held.pop())
        return True

    def refill(self) -> None:
        """Restore the reserve as far as the system allows."""
        while len(self._held) < self._count:
            try:
                self._held.append(os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC))
            except OSError as error:
                if error.errno not in NONE_LEFT:
                    raise
                return

    def close(self) -> None:
        """Close all."""
        while self.release():
            pass

"""The process at the other end of a local socket, named by the kernel, and what it may.

An abstract socket has no file and so no permissions: anyone in the same network namespace may
bind its name or connect to it. What the kernel says of the other end cannot be made up.
"""

from __future__ import annotations

import os
import socket
import struct
from dataclasses import dataclass
from typing import Final

ROOT: Final = 0
_CREDENTIALS: Final = struct.Struct("3i")


@dataclass(frozen=True, slots=True)
class Peer:
    """A process and its user; ``pid`` is 0 where it is in a namespace that is not seen here."""

    pid: int
    uid: int

    @property
    def has_ended(self) -> bool:
        """True if no such process runs any more: what is bound in its name is a leftover."""
        if self.pid <= 0:
            return False
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return True
        except PermissionError:
            pass
        return False


def peer_of(connected: socket.socket) -> Peer:
    """The process that connected, or the one that listens at what was connected to."""
    data = connected.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    pid, uid, _gid = _CREDENTIALS.unpack(data)
    return Peer(pid, uid)


def may_order(peer: Peer) -> bool:
    """True if a daemon of this user takes orders of that process: its own user's, and root's."""
    return peer.uid in (ROOT, os.geteuid())


def may_answer(peer: Peer) -> bool:
    """True if that process may be this user's daemon: its own or root's; for root anybody's."""
    return peer.uid in (ROOT, os.geteuid()) or os.geteuid() == ROOT

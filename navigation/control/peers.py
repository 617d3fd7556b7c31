"""The process at the other end of a local socket, named by the kernel, and its rights.

An abstract socket has no permissions: anyone in the same network namespace may bind its name or
connect to it. The kernel's word on the other end cannot be forged.
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
    """A process and its user; ``pid`` is 0 if its namespace is not seen here."""

    pid: int
    uid: int

    @property
    def has_ended(self) -> bool:
        """True if no such process runs: its socket is a leftover."""
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
    """Process that connected, or that listens at the other end."""
    data = connected.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    pid, uid, _gid = _CREDENTIALS.unpack(data)
    return Peer(pid, uid)


def may_order(peer: Peer) -> bool:
    """True if a daemon of this user takes its orders: its own user's and root's."""
    return peer.uid in (ROOT, os.geteuid())


def may_answer(peer: Peer) -> bool:
    """True if it may be this user's daemon: its own or root's; for root anyone's."""
    return peer.uid in (ROOT, os.geteuid()) or os.geteuid() == ROOT

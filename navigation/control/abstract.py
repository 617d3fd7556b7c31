"""The socket without a file: its name, and the names of all daemons that listen on this computer.

The second path to a daemon, for when its file is gone: an abstract socket lives as long as its
process, and nobody can remove it. Its name has the user, a digest of the path that the daemon was
given, and random digits, so that nobody can take it beforehand. Names are per network namespace:
from inside a container without the host's network a daemon outside is not seen, nor the other way
round.
"""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import socket
from dataclasses import dataclass
from pathlib import Path
from typing import Final

LISTS_SOCKETS: Final = Path("/proc/net/unix")
LISTENS: Final = 0x10000
"""Among the flags of `LISTS_SOCKETS` (the kernel's ``__SO_ACCEPTCON``)."""
_NAME: Final = re.compile(rb"@(clearway-(\d{1,10})-([0-9a-f]{16})-[0-9a-f]{16})")


@dataclass(frozen=True, slots=True)
class Abstract:
    """A listening socket without a file; who listens is only known once it is connected to."""

    name: str
    uid: int
    digest: str

    @property
    def address(self) -> str:
        """The address that `connect` and `bind` take."""
        return f"\0{self.name}"


def digest_of(path: Path) -> str:
    """A digest of a path for a socket's name: the same however the path is spelt."""
    return hashlib.sha256(os.fsencode(os.path.realpath(path))).hexdigest()[:16]


def listen_without_a_file(path: Path, backlog: int) -> socket.socket:
    """Listen under a new name for the daemon that was given ``path``."""
    one = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        one.bind(f"\0clearway-{os.geteuid()}-{digest_of(path)}-{secrets.token_hex(8)}")
        one.listen(backlog)
        one.setblocking(False)
    except OSError:
        one.close()
        raise
    return one


def all_listening() -> list[Abstract]:
    """Every socket of such a name that listens, of any user; OSError where none can be listed."""
    found = []
    for line in LISTS_SOCKETS.read_bytes().splitlines():
        fields = line.split(None, 7)  # address, count, protocol, flags, type, state, inode, name
        if len(fields) < 8 or not _listens(fields[3]):
            continue
        if (match := _NAME.fullmatch(fields[7])) is not None:
            name, uid, digest = (part.decode() for part in match.groups())
            found.append(Abstract(name, int(uid), digest))
    return found


def _listens(flags: bytes) -> bool:
    try:
        return bool(int(flags, 16) & LISTENS)
    except ValueError:  # a name with a line's end in it looks like a line of its own
        return False

"""The socket without a file: its name, and the names of all daemons listening on this computer.

It reaches a daemon whose file is gone: an abstract socket lives while its process does, and cannot
be removed. Random digits in its name keep it from being taken beforehand. Names are per network
namespace: a container without the host's network and the host do not see each other's daemons.
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
"""The kernel's ``__SO_ACCEPTCON``."""
_NAME: Final = re.compile(rb"@(clearway-(\d{1,10})-([0-9a-f]{16})-[0-9a-f]{16})")


@dataclass(frozen=True, slots=True)
class Abstract:
    """Listening socket without a file; its owner shows only on connecting."""

    name: str
    uid: int
    digest: str

    @property
    def address(self) -> str:
        """Address for `connect` and `bind`."""
        return f"\0{self.name}"


def digest_of(path: Path) -> str:
    """Digest of a path, equal for every spelling of it."""
    return hashlib.sha256(os.fsencode(os.path.realpath(path))).hexdigest()[:16]


def listen_without_a_file(path: Path, backlog: int) -> socket.socket:
    """Listen under a new name for ``path``."""
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
    """Every such listening socket, of any user; OSError if they cannot be listed."""
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
    except ValueError:  # a name with a line end in it looks like a line of its own
        return False

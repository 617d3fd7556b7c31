"""A V4L2 device node: opened, asked, and its own description.

A camera may have several nodes, for pictures and their metadata: all report the whole camera's
abilities, and each its own. Asking disturbs no program that streams.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import Structure, c_int32
from dataclasses import dataclass
from typing import TypeVar

from vision.camera.v4l2 import structs

Kind = TypeVar("Kind", bound=Structure | c_int32)

_NOT_SUPPORTED = (errno.ENOTTY, errno.EINVAL, errno.ENODATA)
"""An unknown request, or the end of a list."""


@dataclass(frozen=True, slots=True)
class About:
    """Description of a node by itself; ``bus`` is its port."""

    driver: str
    card: str
    bus: str
    can: int
    """Abilities of this node, as V4L2's bits."""

    @property
    def gives_pictures(self) -> bool:
        """True if pictures come from it."""
        return bool(self.can & (structs.CAN_CAPTURE | structs.CAN_CAPTURE_PLANES))


class Node:
    """Open device node. Raises ``OSError`` as the kernel does."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.fd = os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)

    def close(self) -> None:
        """Close it; harmless when closed."""
        fd, self.fd = self.fd, -1
        if fd >= 0:
            os.close(fd)

    def ask(self, request: int, about: Kind) -> Kind:
        """Carry out a request on a structure, which the driver changes in place."""
        import fcntl  # only Unix has it

        fcntl.ioctl(self.fd, request, about, True)
        return about

    def try_ask(self, request: int, about: Kind) -> Kind | None:
        """Ask; None if the driver does not know the request or a list has ended."""
        try:
            return self.ask(request, about)
        except OSError as error:
            if error.errno in _NOT_SUPPORTED:
                return None
            raise

    def about(self) -> About:
        """Ask for the node's description."""
        reply = self.ask(structs.QUERYCAP, structs.Capability())
        whole = int(reply.capabilities)
        can = int(reply.device_caps) if whole & structs.HAS_NODE_CAPABILITIES else whole
        return About(_text(reply.driver), _text(reply.card), _text(reply.bus_info), can)


@contextmanager
def opened(path: str) -> Iterator[Node]:
    """Open a node for the length of a context."""
    node = Node(path)
    try:
        yield node
    finally:
        node.close()


def about(path: str) -> About | None:
    """Description of a device node; None without permission or driver."""
    try:
        with opened(path) as node:
            return node.about()
    except OSError:
        return None


def gives_pictures(path: str) -> bool | None:
    """True if a device node gives pictures; None if it cannot be asked.

    A camera in use answers too.
    """
    try:
        with opened(path) as node:
            return node.about().gives_pictures
    except OSError as error:
        return False if error.errno in (errno.ENOTTY, errno.EINVAL) else None


def _text(raw: bytes) -> str:
    return raw.decode("utf-8", "replace").strip()

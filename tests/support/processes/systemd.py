"""Messages that a service sent to systemd."""

from __future__ import annotations

import select
import socket


def messages_to(end: socket.socket) -> list[str]:
    """Everything that was sent so far."""
    lines = []
    while select.select([end], [], [], 0.0)[0]:
        lines += end.recv(4096).decode().splitlines()
    return lines

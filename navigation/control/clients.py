"""Clients of the control socket: bytes so far, deadlines, and the order of leaving.

Rules
- A whole request has ``REQUEST_WITHIN_S``, however its bytes drip in.
- If ``MOST_CLIENTS`` are connected, a new one replaces the one that has held back its request
  longest; clients waiting for the answer to a stop leave last.

Seconds.
"""

from __future__ import annotations

import contextlib
import json
import math
import socket
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from navigation.config.secrecy.secrets import hide_in
from navigation.control.order_thread import Job

MOST_BYTES: Final = 65_536
MOST_CLIENTS: Final = 64
REQUEST_WITHIN_S: Final = 2.0
ANSWER_WITHIN_S: Final = 5.0


class TooLongError(ValueError):
    """Error: a request of more than ``MOST_BYTES``."""


@dataclass(slots=True, eq=False)
class Client:
    """One connection; ``job`` is set once its request was read whole."""

    socket: socket.socket
    came_s: float
    job: Job | None = None
    data: bytearray = field(default_factory=bytearray)

    def read(self) -> bytes | None:
        """Return a whole line or all to the end; None while more is needed.

        ``TooLongError`` if it is too long; OSError if the client is gone.
        """
        while True:
            try:
                part = self.socket.recv(MOST_BYTES)
            except (BlockingIOError, InterruptedError):
                return None
            self.data += part
            if len(self.data) > MOST_BYTES:
                raise TooLongError(f"the request is longer than {MOST_BYTES} bytes")
            if not part or b"\n" in part:
                return bytes(self.data)

    def answer(self, answer: Mapping[str, Any]) -> None:
        """Send as much of the answer as the client takes at once, and hang up."""
        line = json.dumps(hide_in(_without_infinities(answer)), allow_nan=False).encode() + b"\n"
        with contextlib.suppress(OSError):  # it did not wait for its answer
            self.socket.send(line)
        self.socket.close()

    def late(self, now_s: float) -> str | None:
        """Reason to give it up, if any."""
        if self.job is None and now_s - self.came_s > REQUEST_WITHIN_S:
            return f"no request came within {REQUEST_WITHIN_S:g} s"
        if self.job is not None and now_s - self.job.came_s > ANSWER_WITHIN_S:
            return f"the control loop has not answered within {ANSWER_WITHIN_S:g} s"
        return None


def who_makes_room(clients: list[Client]) -> Client:
    """Client that is dropped for a new one."""
    return min(
        clients,
        key=lambda one: (one.job is not None, one.job is not None and one.job.is_stop, one.came_s),
    )


def _without_infinities(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _without_infinities(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_without_infinities(one) for one in value]
    return value

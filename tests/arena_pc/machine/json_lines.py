"""JSON, a line each, over a Unix socket whose other end may not be there yet."""

from __future__ import annotations

import contextlib
import json
import queue
import socket
import threading
import time
from pathlib import Path
from typing import Any

LOOK_EVERY_S = 0.05


class GoneError(RuntimeError):
    """The other end has closed the socket, or never opened it."""


class JsonLines:
    """Objects sent and received; a thread reads, so that nothing waits in the socket."""

    def __init__(self, path: Path, within_s: float) -> None:
        self._socket = connected(path, within_s)
        self._received: queue.Queue[dict[str, Any] | None] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def send(self, what: dict[str, Any]) -> None:
        """Send an object."""
        try:
            self._socket.sendall(json.dumps(what).encode() + b"\n")
        except OSError as error:
            raise GoneError(str(error)) from error

    def receive(self, within_s: float) -> dict[str, Any]:
        """The next object; ``TimeoutError`` where none comes in time."""
        try:
            got = self._received.get(timeout=within_s)
        except queue.Empty:
            raise TimeoutError(f"no answer within {within_s:g} s") from None
        if got is None:
            self._received.put(None)
            raise GoneError("the other end has closed the line")
        return got

    def close(self) -> None:
        """End the connection, and the thread."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _read(self) -> None:
        with contextlib.suppress(OSError), self._socket.makefile("rb") as lines:
            for line in lines:
                self._received.put(json.loads(line))
        self._received.put(None)


def connected(path: Path, within_s: float) -> socket.socket:
    """A connection to a Unix socket, as soon as somebody listens there."""
    end_s = time.monotonic() + within_s
    while True:
        line = socket.socket(socket.AF_UNIX)
        try:
            line.connect(str(path))
        except OSError as error:
            line.close()
            if time.monotonic() > end_s:
                raise GoneError(f"{path}: {error}") from error
            time.sleep(LOOK_EVERY_S)  # the socket is not made yet
        else:
            return line

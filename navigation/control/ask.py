"""The asking end of the control socket: where it is, and one order with its answer.

Rules
- The whole of an order, answer included, has ``PATIENCE_S``.
- A stop and a status may be asked for twice, so a daemon that is crowded is asked again; any
  other order is sent once.

Units: seconds.
"""

from __future__ import annotations

import json
import os
import socket
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from navigation.control.orders import ControlError, NoDaemonError
from navigation.shared.outside import OutsideError, printable, read_object

PATIENCE_S: Final = 2.0
AGAIN_AFTER_S: Final = 0.01
MOST_ANSWER_BYTES: Final = 1_000_000
REPEATABLE: Final = frozenset({"stop", "status"})


class _CrowdedError(OSError):
    """The daemon had no place for us just now."""


def default_socket() -> Path:
    """Where the daemon listens: the user's runtime folder, else a private temporary one."""
    runtime = os.environ.get("RUNTIME_DIRECTORY") or os.environ.get("XDG_RUNTIME_DIR")
    if runtime and os.access(runtime.split(":")[0], os.W_OK):
        return Path(runtime.split(":")[0]) / "clearway" / "control.sock"
    return Path(tempfile.gettempdir()) / f"clearway-{os.getuid()}" / "control.sock"


def send_order(path: Path, request: Mapping[str, Any]) -> dict[str, Any]:
    """Give an order to the daemon that listens at ``path``; its answer.

    ``NoDaemonError`` where no daemon runs there; ``ControlError`` where it does not answer, or
    refuses.
    """
    until_s = time.monotonic() + PATIENCE_S
    line = json.dumps(request).encode() + b"\n"
    while True:
        try:
            answer = read_object(_exchange(path, line, until_s))
            if answer.get("again") is True:
                raise ConnectionResetError("it is crowded")
            break
        except (FileNotFoundError, ConnectionRefusedError):
            raise NoDaemonError(
                f"no daemon listens at {path}: start one with 'clearway run CONFIG'"
            ) from None
        except (_CrowdedError, ConnectionError) as error:
            again = isinstance(error, _CrowdedError) or request.get("order") in REPEATABLE
            if not again or time.monotonic() + AGAIN_AFTER_S > until_s:
                raise ControlError(f"the daemon at {path} does not answer: {error}") from None
            time.sleep(AGAIN_AFTER_S)  # a crowded daemon has room by then; nothing tells us
        except (OSError, OutsideError) as error:
            raise ControlError(f"the daemon at {path} does not answer: {error}") from None
    if not answer.get("ok"):
        reason = answer.get("error")
        words = printable(reason, 1000) if isinstance(reason, str) else "no reason given"
        raise ControlError(f"the daemon refuses: {words}")
    return answer


def _exchange(path: Path, line: bytes, until_s: float) -> bytes:
    """One request and its answer; `_CrowdedError` where nothing was sent yet, or dropped unread."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client:
        client.settimeout(_left_s(until_s))
        try:
            client.connect(str(path))
        except BlockingIOError:  # its queue is full at this moment
            raise _CrowdedError("too many wait for it") from None
        client.sendall(line)
        answer = bytearray()
        while not answer.endswith(b"\n"):
            client.settimeout(_left_s(until_s))
            part = client.recv(4096)
            if not part:
                break
            answer += part
            if len(answer) > MOST_ANSWER_BYTES:
                raise OutsideError(f"its answer is longer than {MOST_ANSWER_BYTES} bytes")
    if not answer:
        raise ConnectionResetError("it hung up")
    return bytes(answer)


def _left_s(until_s: float) -> float:
    left_s = until_s - time.monotonic()
    if left_s <= 0.0:
        raise TimeoutError("timed out")
    return left_s

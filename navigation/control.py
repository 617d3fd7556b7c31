"""Orders to a running daemon over a local socket: go, stop, pause, resume, replan, status.

Rules
- A Unix socket that only its owner can use (mode 0600, in a folder of mode 0700). One request
  and one answer a connection, each one line of JSON; `ControlServer` takes them in a thread.
- A request is ``{"order": NAME, ...}``; an answer is ``{"ok": true, ...}`` or
  ``{"ok": false, "error": SENTENCE}``. What is malformed or too long is refused and counted.
- Two daemons never share a socket: one that answers is left alone, one that does not is a
  leftover and is replaced.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import socket
import stat
import tempfile
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, Protocol

from navigation.config.values import LONGEST_DWELL_S, MOST_STATIONS
from navigation.mission import MissionError, Station

MOST_BYTES: Final = 65_536
PATIENCE_S: Final = 2.0


class ControlError(ValueError):
    """An order that cannot be given or taken; the message says why."""


class Commanded(Protocol):
    """What orders are given to: the daemon."""

    def give(self, stations: tuple[Station, ...]) -> None:
        """A new mission; MissionError where it cannot be."""

    def stop(self, reason: str) -> None:
        """Emergency stop, latched."""

    def pause(self) -> None:
        """Hold until resumed."""

    def resume(self) -> None:
        """End a pause; after a stop re-arm, and the next time go on."""

    def replan(self) -> None:
        """Plan anew from where the robot is."""

    def settle(self) -> None:
        """Return when the orders given so far were acted on, soon in any case."""

    def describe(self) -> Mapping[str, Any]:
        """The present state, as JSON takes it."""
        ...


def default_socket() -> Path:
    """Where the daemon listens: the user's runtime folder, else a private temporary one."""
    runtime = os.environ.get("RUNTIME_DIRECTORY") or os.environ.get("XDG_RUNTIME_DIR")
    if runtime and os.access(runtime.split(":")[0], os.W_OK):
        return Path(runtime.split(":")[0]) / "clearway" / "control.sock"
    return Path(tempfile.gettempdir()) / f"clearway-{os.getuid()}" / "control.sock"


def carry_out(request: Mapping[str, Any], daemon: Commanded) -> dict[str, Any]:
    """Do what a request asks for; the answer, never an exception for a bad request."""
    try:
        match request.get("order"):
            case "go":
                daemon.give(read_stations(request.get("stations")))
            case "stop":
                daemon.stop(_reason(request))
            case "pause":
                daemon.pause()
            case "resume":
                daemon.resume()
            case "replan":
                daemon.replan()
            case "status":
                pass
            case other:
                raise ControlError(
                    f"order {other!r}: must be go, stop, pause, resume, replan or status"
                )
    except (ControlError, MissionError) as error:
        return {"ok": False, "error": str(error)}
    return {"ok": True, **daemon.describe()}


def _reason(request: Mapping[str, Any]) -> str:
    reason = request.get("reason", "stopped by order")
    if not isinstance(reason, str) or len(reason) > 500:
        raise ControlError("reason: must be a text of at most 500 characters")
    return reason


def read_stations(value: Any) -> tuple[Station, ...]:
    """Stations from JSON; ControlError where they are none."""
    if not isinstance(value, list) or not 1 <= len(value) <= MOST_STATIONS:
        raise ControlError(f"stations: must be a list of 1 to {MOST_STATIONS} stations")
    return tuple(_station(number, item) for number, item in enumerate(value, 1))


def _station(number: int, item: Any) -> Station:
    if not isinstance(item, dict) or not set(item) <= {"x_m", "y_m", "heading_rad", "dwell_s"}:
        raise ControlError(
            f"station {number}: must be an object of x_m, y_m, heading_rad and dwell_s"
        )
    x, y = (_number(number, item, key) for key in ("x_m", "y_m"))
    heading_rad = None
    if item.get("heading_rad") is not None:
        heading_rad = math.remainder(_number(number, item, "heading_rad"), math.tau)
    dwell_s = _number(number, item, "dwell_s") if "dwell_s" in item else 0.0
    if dwell_s < 0.0:
        raise ControlError(f"station {number}: dwell_s = {dwell_s:g}: must be >= 0")
    if dwell_s > LONGEST_DWELL_S:
        limit = f"must be <= {LONGEST_DWELL_S:g}"
        raise ControlError(f"station {number}: dwell_s = {dwell_s:g}: {limit}")
    return Station(x, y, heading_rad, dwell_s)


def _number(number: int, item: Mapping[str, Any], key: str) -> float:
    value = item.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ControlError(f"station {number}: {key} = {value!r}: must be a finite number")
    return float(value)


class ControlServer:
    """Listens on a socket in a thread of its own; a context manager."""

    def __init__(self, path: Path, daemon: Commanded) -> None:
        self.path = path
        self.refused = 0
        """How many requests were malformed."""
        self._daemon = daemon
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="control", daemon=True)

    def __enter__(self) -> ControlServer:
        _make_private(self.path.parent)
        _remove_leftover(self.path)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        mask = os.umask(0o177)
        try:
            self._socket.bind(str(self.path))
        except OSError as error:
            self._socket.close()
            raise ControlError(f"control socket {self.path}: {error.strerror or error}") from None
        finally:
            os.umask(mask)
        self._socket.listen(8)
        self._socket.settimeout(0.2)
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._stopping.set()
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as waker:
            waker.setblocking(False)
            with contextlib.suppress(OSError):  # then the wait for a client ends by itself
                waker.connect(str(self.path))
        self._thread.join()
        self._socket.close()
        with contextlib.suppress(FileNotFoundError):
            self.path.unlink()

    def _serve(self) -> None:
        while not self._stopping.is_set():
            try:
                connection, _ = self._socket.accept()
            except TimeoutError:
                continue
            with connection:
                if self._stopping.is_set():
                    return
                connection.settimeout(PATIENCE_S)
                # a client that hangs up in the middle has its order dropped, nothing more
                with contextlib.suppress(OSError):
                    self._answer(connection)

    def _answer(self, connection: socket.socket) -> None:
        try:
            request = json.loads(_read_line(connection))
            if not isinstance(request, dict):
                raise ControlError("a request must be one JSON object")
        except (ControlError, ValueError) as error:
            self.refused += 1
            sentence = str(error) if isinstance(error, ControlError) else "the request is no JSON"
            answer: dict[str, Any] = {"ok": False, "error": sentence}
        else:
            answer = carry_out(request, self._daemon)
            if answer["ok"] and request.get("order") != "status":
                # what the order led to, not what was before it
                self._daemon.settle()
                answer.update(self._daemon.describe())
            self.refused += not answer["ok"]
        connection.sendall(json.dumps(answer).encode() + b"\n")


def send_order(path: Path, request: Mapping[str, Any]) -> dict[str, Any]:
    """Give an order to the daemon that listens at ``path``; its answer.

    ``ControlError`` where no daemon runs there, or it does not answer or refuses.
    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client:
        client.settimeout(PATIENCE_S)
        try:
            client.connect(str(path))
            client.sendall(json.dumps(request).encode() + b"\n")
            answer = json.loads(_read_line(client))
        except (FileNotFoundError, ConnectionRefusedError):
            raise ControlError(
                f"no daemon listens at {path}: start one with 'clearway run CONFIG'"
            ) from None
        except (OSError, ValueError) as error:
            raise ControlError(f"the daemon at {path} does not answer: {error}") from None
    if not isinstance(answer, dict) or not answer.get("ok"):
        reason = answer.get("error") if isinstance(answer, dict) else None
        raise ControlError(f"the daemon refuses: {reason or 'no reason given'}")
    return answer


def _read_line(connection: socket.socket) -> bytes:
    data = b""
    while not data.endswith(b"\n"):
        chunk = connection.recv(4096)
        if not chunk:
            break
        data += chunk
        if len(data) > MOST_BYTES:
            raise ControlError(f"the request is longer than {MOST_BYTES} bytes")
    return data


def _make_private(folder: Path) -> None:
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    info = folder.lstat()
    if not stat.S_ISDIR(info.st_mode) or info.st_uid != os.getuid() or info.st_mode & 0o022:
        raise ControlError(f"control socket folder {folder}: must be yours alone (mode 0700)")


def _remove_leftover(path: Path) -> None:
    if not path.exists():
        return
    if not path.is_socket():
        raise ControlError(f"control socket {path}: is a file that is no socket")
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        probe.settimeout(PATIENCE_S)
        try:
            probe.connect(str(path))
        except OSError:
            path.unlink()
            return
    raise ControlError(f"control socket {path}: another daemon listens there already")

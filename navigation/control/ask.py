"""The asking end of the control sockets: their places, and one order with its answer.

Rules
- The file is asked first. If none listens there, the daemon is found by its socket without a file:
  the one of that path or, without a path, any daemon of this user. A stop is sent to all of them at
  once; any other order is refused if there are several.
- ``NoDaemonError`` means that certainly no daemon listens. Another user's process that has taken a
  name or a file is no daemon.
- A whole order, answer included, has ``PATIENCE_S``.
- Only orders that may be repeated are sent again to a crowded daemon.

Seconds.
"""

from __future__ import annotations

import json
import os
import tempfile
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Final

from navigation.control.abstract import LISTS_SOCKETS, Abstract, all_listening, digest_of
from navigation.control.exchange import CrowdedError, NobodyError, exchange
from navigation.control.peers import ROOT
from navigation.orders.carry_out import SCHEMA
from navigation.orders.errors import ControlError, NoDaemonError
from navigation.orders.table import ORDERS
from navigation.shared.outside import OutsideError, printable, read_object

PATIENCE_S: Final = 2.0
AGAIN_AFTER_S: Final = 0.01
REPEATABLE: Final = frozenset(name for name, order in ORDERS.items() if order.may_repeat)
MOST_AT_ONCE: Final = 32


def default_socket() -> Path:
    """Socket of the daemon: in the user's runtime folder, or a private one."""
    runtime = os.environ.get("RUNTIME_DIRECTORY") or os.environ.get("XDG_RUNTIME_DIR")
    if runtime and os.access(runtime.split(":")[0], os.W_OK):
        return Path(runtime.split(":")[0]) / "clearway" / "control.sock"
    return Path(tempfile.gettempdir()) / f"clearway-{os.getuid()}" / "control.sock"


def send_order(path: Path | None, request: Mapping[str, Any]) -> dict[str, Any]:
    """Give an order to the daemon of ``path``, None: of this user; return its answer.

    Answers of several stopped daemons are in ``daemons``. ``NoDaemonError`` if no daemon runs;
    ``ControlError`` if one does not answer, or refuses.
    """
    until_s = time.monotonic() + PATIENCE_S
    file = path or default_socket()
    try:
        return _ask(str(file), f"the daemon at {file}", request, until_s)
    except NobodyError:
        forbidden = None
    except PermissionError as error:
        # our own daemon never listens where we may not look: a default path is somebody else's
        forbidden = None if path is None else error
    answers = _ask_all(_found(file, any_path=path is None), request, until_s)
    if answers:
        return answers[0] if len(answers) == 1 else _together(answers)
    if forbidden is not None:
        raise ControlError(f"the daemon at {file} cannot be asked: {forbidden.strerror}")
    raise NoDaemonError(f"no daemon listens at {file}: start one with 'clearway run CONFIG'")


def _ask(address: str, who: str, request: Mapping[str, Any], until_s: float) -> dict[str, Any]:
    line = json.dumps(request).encode() + b"\n"
    while True:
        try:
            answer = read_object(exchange(address, line, until_s))
            if answer.get("again") is True:
                raise ConnectionResetError("it is crowded")
            break
        except (NobodyError, PermissionError):
            raise
        except (CrowdedError, ConnectionError) as error:
            again = isinstance(error, CrowdedError) or request.get("order") in REPEATABLE
            if not again or time.monotonic() + AGAIN_AFTER_S > until_s:
                raise ControlError(f"{who} does not answer: {error}") from None
            time.sleep(AGAIN_AFTER_S)  # a crowded daemon has places by then; no message says so
        except (OSError, OutsideError) as error:
            raise ControlError(f"{who} does not answer: {error}") from None
    if not answer.get("ok"):
        reason = answer.get("error")
        words = printable(reason, 1000) if isinstance(reason, str) else "no reason given"
        raise ControlError(f"the daemon refuses: {words}")
    return answer


def _found(file: Path, *, any_path: bool) -> list[Abstract]:
    """Sockets without a file that may be daemons of this user; of any user for root."""
    try:
        everybody = all_listening()
    except OSError as error:
        raise ControlError(
            f"no program listens at {file}, and it is unknown if a daemon runs: "
            f"{LISTS_SOCKETS}: {error.strerror or error}"
        ) from None
    me = os.geteuid()
    ours = [one for one in everybody if me in (ROOT, one.uid)]
    return [one for one in ours if any_path or one.digest == digest_of(file)]


def _ask_all(
    found: Sequence[Abstract], request: Mapping[str, Any], until_s: float
) -> list[dict[str, Any]]:
    if request.get("order") != "stop" and len(found) > 1:
        statuses = [one for one in _at_once(found, {"order": "status"}, until_s) if one is not None]
        if len(statuses) > 1:
            places = ", ".join(sorted(str(one.get("socket")) for one in statuses))
            raise ControlError(f"{len(statuses)} daemons run: name one by --socket: {places}")
    return [one for one in _at_once(found, request, until_s) if one is not None]


def _at_once(
    found: Sequence[Abstract], request: Mapping[str, Any], until_s: float
) -> list[dict[str, Any] | None]:
    """Answers of all, None where there is no daemon; none waits for another."""
    if not found:
        return []

    def ask(one: Abstract) -> dict[str, Any] | ControlError | None:
        try:
            return _ask(one.address, f"the daemon @{one.name}", request, until_s)
        except (NobodyError, PermissionError):
            return None
        except ControlError as error:
            return error

    with ThreadPoolExecutor(min(len(found), MOST_AT_ONCE)) as threads:
        answers = list(threads.map(ask, found))
    errors = [str(one) for one in answers if isinstance(one, ControlError)]
    if errors:
        done = [_in_words(one) for one in answers if isinstance(one, dict)]
        raise ControlError("; ".join(errors + done))
    return [one for one in answers if not isinstance(one, ControlError)]


def _together(answers: Sequence[dict[str, Any]]) -> dict[str, Any]:
    states = {str(one.get("state")) for one in answers}
    return {
        "schema": SCHEMA,
        "ok": True,
        "state": states.pop() if len(states) == 1 else "stopping",
        "reason": "; ".join(map(_in_words, answers)),
        "daemons": list(answers),
    }


def _in_words(answer: Mapping[str, Any]) -> str:
    return f"the daemon of {answer.get('socket')}: {answer.get('state')}"

"""Calls of other programs and web servers, in a thread: asking for one never waits.

Rules
- A call is a process of its own. One that is not over in its time is killed with all that it has
  started: neither a program that hangs nor a server that drips keeps the thread.
- The process begins as Python's own and becomes the command there: a command on a disk that does
  not answer would otherwise hold this process, with the interpreter's lock, until it is loaded.
- At most ``MOST_WAITING`` calls wait; further ones are left out.
- A failure is a sentence in `news`; nothing is raised.

Seconds.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

from navigation.machine import post
from navigation.shared.outside import printable

MOST_WAITING: Final = 64
"""Chosen: three for each robot of the largest fleet."""
MOST_NEWS: Final = 64
REAPED_WITHIN_S: Final = 1.0
"""A killed process is gone at once, unless a disk holds it."""
NO_PROGRAM: Final = 127
"""Exit code of a command that could not be loaded; as of a shell."""
MOST_REASON: Final = 200

_PYTHON: Final = (sys.executable, "-I", "-S")
"""Python without the environment's settings and the packages around it: it starts in
milliseconds."""
_BECOME: Final = f"""\
import os, signal, sys
signal.signal(signal.SIGPIPE, signal.SIG_DFL)
signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
try:
    os.execvp(sys.argv[1], sys.argv[1:])
except OSError as error:
    os._exit({NO_PROGRAM})
"""
"""Python ignores these two signals, which a program would inherit."""


@dataclass(frozen=True, slots=True)
class OutsideCall:
    """A command's arguments, or a URL with the JSON that it gets."""

    command: tuple[str, ...] = ()
    url: str = ""
    body: str = ""

    @property
    def name(self) -> str:
        """The program or the host; the rest of an address may be a key."""
        return self.command[0] if self.command else urlsplit(self.url).netloc


class OutsideCalls:
    """Caller of one call after another, each for ``within_s``; a context manager.

    At its end the calls that wait have ``within_s`` together; the rest is left out.
    """

    def __init__(self, within_s: float) -> None:
        self._within_s = within_s
        self._waiting: queue.Queue[OutsideCall | None] = queue.Queue(MOST_WAITING)
        self._news: deque[str] = deque(maxlen=MOST_NEWS)
        self._ends_s = math.inf
        """End of the last call; infinite until the end."""
        self._thread = threading.Thread(target=self._run, name="outside calls", daemon=True)

    def __enter__(self) -> OutsideCalls:
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._ends_s = time.monotonic() + self._within_s
        with contextlib.suppress(queue.Full):  # then it wakes without being asked to
            self._waiting.put_nowait(None)
        self._thread.join(self._within_s + 2.0 * REAPED_WITHIN_S)

    def put(self, call: OutsideCall) -> None:
        """Ask for a call; return at once."""
        try:
            self._waiting.put_nowait(call)
        except queue.Full:
            self._news.append(f"{call.name}: {MOST_WAITING} calls wait already; one is left out")

    def news(self) -> list[str]:
        """Sentences on the calls that have failed since the last time."""
        said = []
        while self._news:
            said.append(self._news.popleft())
        return said

    def _run(self) -> None:
        while True:
            call = self._waiting.get()
            if call is not None:
                try:
                    reason = self._call(call)
                except Exception as error:  # noqa: BLE001 - said; the next one may work
                    reason = f"{type(error).__name__}: {error}"
                if reason:
                    self._news.append(f"{call.name}: {printable(reason, MOST_REASON)}")
            if self._ends_s < math.inf and self._waiting.empty():
                return

    def _call(self, call: OutsideCall) -> str:
        within_s = min(self._within_s, self._ends_s - time.monotonic())
        if within_s <= 0.0:
            return "left out: the run is over"
        if call.command:
            arguments = (*_PYTHON, "-c", _BECOME, *call.command)
            asked = None
        else:
            arguments = (*_PYTHON, str(Path(post.__file__)))
            asked = json.dumps({"url": call.url, "body": call.body}).encode()
        ours = subprocess.DEVNULL if asked is None else subprocess.PIPE  # ours says little
        process = subprocess.Popen(
            arguments, stdin=ours, stdout=subprocess.DEVNULL, stderr=ours, start_new_session=True
        )
        try:
            _, said = process.communicate(asked, within_s)
        except subprocess.TimeoutExpired:
            _kill(process)
            return f"not over within {within_s:.3g} s, and ended"
        if process.returncode == 0:
            return ""
        return (said or b"").decode("utf-8", "replace").strip() or _ending(process.returncode)


def _kill(process: subprocess.Popen[bytes]) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(REAPED_WITHIN_S)
    for pipe in (process.stdin, process.stderr):
        if pipe is not None:
            with contextlib.suppress(OSError):
                pipe.close()


def _ending(code: int) -> str:
    if code == NO_PROGRAM:
        return f"exited with {code}: there is no such program, or it may not be run"
    return f"was ended by signal {-code}" if code < 0 else f"exited with {code}"

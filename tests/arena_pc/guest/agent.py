"""Runs shell commands that the host sends over a virtio serial port: one line of JSON each way.

An order is ``{"id": 1, "run": "uname -r", "within_s": 60}``; its answer is
``{"id": 1, "code": 0, "output": "..."}``, with 124 as the code of a command that took too long.
Orders run side by side. The agent says ``{"ready": true}`` once.
"""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from typing import Any

TOO_LONG = 124
NOBODY_LISTENS_S = 0.05
"""The host opens its end at any time, and a read returns at once until then."""


class Agent:
    """The guest's end of the line."""

    def __init__(self, port: str) -> None:
        self._line = os.open(port, os.O_RDWR)
        self._one_writes = threading.Lock()

    def serve(self) -> None:
        """Answer orders for ever."""
        self._send({"ready": True})
        unfinished = b""
        while True:
            got = os.read(self._line, 65536)
            if not got:
                time.sleep(NOBODY_LISTENS_S)
                continue
            *lines, unfinished = (unfinished + got).split(b"\n")
            for line in lines:
                threading.Thread(target=self._obey, args=(json.loads(line),), daemon=True).start()

    def _obey(self, order: dict[str, Any]) -> None:
        code, output = run(order["run"], order["within_s"])
        self._send({"id": order["id"], "code": code, "output": output})

    def _send(self, what: dict[str, Any]) -> None:
        rest = json.dumps(what).encode() + b"\n"
        with self._one_writes:
            while rest:
                rest = rest[os.write(self._line, rest) :]


def run(command: str, within_s: float) -> tuple[int, str]:
    """A command's exit code and what it printed; its whole group of processes is ended in time."""
    child = subprocess.Popen(
        ["bash", "-c", command],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        output, _ = child.communicate(timeout=within_s)
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, signal.SIGKILL)
        output, _ = child.communicate()
        return TOO_LONG, output
    return child.returncode, output


if __name__ == "__main__":
    Agent(sys.argv[1]).serve()

"""Programs that run on in the guest while a test plugs and pulls, and what they say meanwhile."""

from __future__ import annotations

import itertools
import re
import time
from pathlib import Path

from tests.arena_pc.machine.pc import ArenaPC

LOOK_EVERY_S = 1.0
PATIENCE_S = 240.0
"""By the host's clock; an emulated machine beside other work is slow."""
SCRIPTS = Path(__file__).parents[1] / "scripts"
_NUMBERS = itertools.count(1)


def wait_for(pc: ArenaPC, command: str, pattern: str, within_s: float = PATIENCE_S) -> str:
    """What a command prints, as soon as the pattern is in it."""
    end_s = time.monotonic() + within_s
    while True:
        output = pc.run(command).output
        if re.search(pattern, output, re.MULTILINE):
            return output
        assert time.monotonic() < end_s, f"{command}: no {pattern!r} in:\n{output}"
        time.sleep(LOOK_EVERY_S)  # nobody tells when it would answer otherwise


def wait_for_files(pc: ArenaPC, *files: str) -> None:
    """Wait until what was plugged in has its names."""
    wait_for(pc, f"ls {' '.join(files)} && echo all are there", "all are there")


class Program:
    """A command in the background."""

    def __init__(self, pc: ArenaPC, command: str) -> None:
        self._pc = pc
        self._log = f"/run/program-{next(_NUMBERS)}.log"
        started = pc.check(f"setsid {command} >{self._log} 2>&1 </dev/null & echo $!")
        self._process = int(started)

    def said(self) -> str:
        """All that it has printed."""
        return self._pc.check(f"cat {self._log}")

    def says(self, pattern: str, within_s: float = PATIENCE_S, after: int = 0) -> str:
        """Wait until it has printed that, ``after`` so many characters; all that it printed."""
        show = f"tail -c +{after + 1} {self._log}"
        return wait_for(self._pc, show, pattern, within_s)

    def end(self) -> None:
        """Kill it."""
        self._pc.run(f"kill -KILL -- -{self._process}")


def watch_camera(pc: ArenaPC, device: str, rate_hz: float) -> Program:
    """The program's own reader on a camera; it prints what it has to say on it."""
    pc.write("/opt/watch_camera.py", (SCRIPTS / "watch_camera.py").read_text())
    return Program(pc, f"/opt/clearway/bin/python -u /opt/watch_camera.py {device} {rate_hz}")

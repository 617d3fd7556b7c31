"""`clearway run` under a flood of connections: a stop is taken, over the socket and over the page.

The program may open 1,024 descriptors, as on most machines, whatever this one allows.
"""

from __future__ import annotations

import http.client
import json
import re
import resource
import shutil
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from navigation.control import send_order
from tests.support.processes.floods import flood
from tests.support.waiting import wait_until

pytestmark = pytest.mark.timed  # says how long a stop takes

CONFIGS = Path(__file__).parents[2] / "configs"
DESCRIPTORS = 1024
HALF_OPEN, DRIPPING = 1100, 200
TRIES = 9
ANSWERED_WITHIN_S = 0.3
"""Half of the stops: another program may have the processor for longer at times."""
STOPPED = ("stopped", "stopping")
"""The second until the robot is known to stand."""
LINK = re.compile(r"dashboard at http://(127\.0\.0\.1:\d+)/#token=(\S+)")


@dataclass(frozen=True, slots=True)
class Program:
    """A run that drives: its process, its socket, its page."""

    process: subprocess.Popen[str]
    socket: Path
    page: str
    token: str

    def state(self) -> str:
        return str(send_order(self.socket, {"order": "status"})["state"])

    def is_free_again(self) -> bool:
        """Whether a stop has been left; asked for again until it has."""
        if self.state() in STOPPED:
            send_order(self.socket, {"order": "resume"})
        return self.state() not in STOPPED


@pytest.fixture
def program(tmp_path: Path) -> Iterator[Program]:
    """The shipped simulation, driving."""
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)
    with (tmp_path / "simulation.yaml").open("a") as config:
        config.write("\ndashboard: {port: 0}\n")
    socket = tmp_path / "run" / "c.sock"

    def lower() -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (DESCRIPTORS, DESCRIPTORS))

    with subprocess.Popen(
        [
            Path(sys.executable).with_name("clearway"),
            "run",
            "simulation.yaml",
            "--socket",
            str(socket),
        ],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=lower,
    ) as process:
        try:
            assert process.stdout is not None
            said = ""
            while not re.search(r"driving +at ", said):
                line = process.stdout.readline()
                assert line, f"it never drove: {said}"
                said += line
            found = LINK.search(said)
            assert found, said
            yield Program(process, socket, found[1], found[2])
        finally:
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=30)


def seconds_of(stop: Callable[[], None], program: Program) -> list[float]:
    """How long each of so many stops took to be answered; each is left again."""
    took_s = []
    for _ in range(TRIES):
        assert wait_until(program.is_free_again)
        began_s = time.monotonic()
        stop()
        took_s.append(time.monotonic() - began_s)
        assert wait_until(lambda: program.state() == "stopped")
    return took_s


def test_a_stop_is_answered_under_floods_of_socket_and_page(program: Program) -> None:
    def by_socket() -> None:
        assert send_order(program.socket, {"order": "stop"})["state"] in STOPPED

    def by_page() -> None:
        line = http.client.HTTPConnection(program.page, timeout=10.0)
        line.request("POST", "/api/stop", headers={"Authorization": f"Bearer {program.token}"})
        with line.getresponse() as answer:
            assert json.loads(answer.read())["ok"]
        line.close()

    with flood("tcp", program.page, HALF_OPEN), flood("unix", str(program.socket), DRIPPING):
        descriptors = len(list(Path(f"/proc/{program.process.pid}/fd").iterdir()))
        assert descriptors < DESCRIPTORS / 2
        for way in (by_socket, by_page):
            took_s = seconds_of(way, program)
            median_s = statistics.median(took_s)
            print(f"{way.__name__}: median {median_s:.3f} s, longest {max(took_s):.3f} s")
            assert median_s < ANSWERED_WITHIN_S
    assert program.process.poll() is None

"""`clearway run` on a robot and a camera that are not there yet, and that go and come back.

The robot is another process at the end of a link, as a name under /dev/serial/by-id is one; the
simulated camera sees it through a file that the robot writes, so until then it is lost too.
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from navigation.simulator.shared_pose import PoseReader
from tests.support.pictures import call
from tests.support.processes import forked
from tests.support.runs.light_camera import with_light_camera
from tests.support.waiting import wait_until

CONFIGS = Path(__file__).parents[2] / "configs"
CONFIG = "configs/hardware_in_the_loop.yaml"
START = "0.2,0.2,90"
PATIENCE_S = 60.0
GIVE_UP_S = 10.0
"""Of the mission: enough for a robot that is exchanged on a loaded machine."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a short mission for a robot behind ``runs/robot``, which is not there."""
    shutil.copytree(CONFIGS, tmp_path / "configs")
    file = tmp_path / CONFIG
    text = re.sub(
        r"^  stations:\n(?:    .*\n)+",
        "  stations:\n    - {x_m: 0.20, y_m: 0.80}\n",
        with_light_camera(file.read_text()),
        flags=re.MULTILINE,
    )
    text = text.replace("  journal: runs/robot.journal", "  # no journal:")
    file.write_text(text + f"\nsafety:\n  give_up_s: {GIVE_UP_S}\n")
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "robot.pose").touch()
    return tmp_path


class Program:
    """A running ``clearway`` and what it has said so far."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self._out = folder / f"{arguments[0]}-{time.monotonic_ns()}.out"
        with self._out.open("w") as out:
            self.process = forked.Program(
                arguments, cwd=folder, stdout=out, stderr=subprocess.STDOUT
            )

    @property
    def said(self) -> str:
        return self._out.read_text()

    def says(self, pattern: str, seconds: float = PATIENCE_S) -> None:
        """Wait until it has said that, or has ended."""
        over = self.process.poll
        wait_until(lambda: bool(re.search(pattern, self.said)) or over() is not None, seconds)
        assert re.search(pattern, self.said), self.said

    def end(self, number: int = signal.SIGTERM) -> int:
        """Send it a signal and wait for its end; the exit code."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.process.wait(timeout=30)


@pytest.fixture
def start(folder: Path) -> Iterator[Callable[..., Program]]:
    """Starts programs in the folder, and ends them with the test."""
    with contextlib.ExitStack() as until:

        def start(*arguments: str) -> Program:
            program = Program(folder, *arguments)
            until.callback(program.end, signal.SIGKILL)
            return program

        yield start


def run(start: Callable[..., Program], *options: str) -> Program:
    return start("run", CONFIG, "--no-dashboard", "--socket", "c.sock", *options)


def robot(start: Callable[..., Program], at: str = START) -> Program:
    arguments = ("--link", "runs/robot", "--poses", "runs/robot.pose", "--start", at)
    return start("robot", *arguments)


def port_of(robot: Program) -> str:
    """The pseudo-terminal that it says it answers on."""
    robot.says(r"/dev/pts/\d+")
    found = re.search(r"/dev/pts/\d+", robot.said)
    assert found is not None
    return found.group()


@contextlib.contextmanager
def taken(port: str) -> Iterator[None]:
    """Holds pseudo-terminals until that one is in use, so that the next to open gets another."""
    with contextlib.ExitStack() as held:
        while not Path(port).exists():
            for end in os.openpty():
                held.callback(os.close, end)
        yield


WAITS = r"waiting for the robot: serial port runs/robot: there is no such device; .*plugged in"


@pytest.mark.timed  # a robot in another process drives in real time
def test_a_robot_that_is_plugged_in_later_is_waited_for_and_driven(
    folder: Path, start: Callable[..., Program]
) -> None:
    """Later than the mission's patience; then it is pulled out, and another one plugged in."""
    program = run(start)
    program.says(WAITS)
    program.says(r"waiting for the camera: ")
    program.says(rf"(?m)^ +{GIVE_UP_S + 2:.0f}\.\d s +holding ")
    first = robot(start)
    program.says(r"driving +at ")
    assert program.said.count("waiting for the robot") == 1, program.said
    assert program.said.count("waiting for the camera") == 1, program.said
    assert "the robot's serial port is open" in program.said
    assert "the camera gives pictures" in program.said

    first.end()
    program.says(r"(?s)waiting for the robot.*waiting for the robot")
    x_m, y_m, heading_rad = PoseReader(folder / "runs" / "robot.pose").read()
    with taken(port_of(first)):
        second = robot(start, f"{x_m},{y_m},{math.degrees(heading_rad)}")
        program.says(r" done ")
        assert port_of(second) != port_of(first)
    assert program.end() == 0, program.said


def test_a_stop_pressed_before_the_robot_is_there_stops_it_when_it_comes(
    folder: Path, start: Callable[..., Program]
) -> None:
    program = run(start)
    program.says(WAITS)
    order = call("stop", "--socket", folder / "c.sock")
    assert order.code == 0, order
    there = robot(start)
    there.says("ESTOP")
    program.says("stopped ")
    assert program.end() == 0, program.said
    assert "driving" not in program.said


def test_with_once_a_port_that_is_not_there_is_refused_at_once(
    start: Callable[..., Program],
) -> None:
    program = run(start, "--once")
    assert program.process.wait(PATIENCE_S) == 2
    assert "given up" not in program.said


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_run_that_waits_ends_in_order_when_asked_to(
    start: Callable[..., Program], number: int
) -> None:
    program = run(start)
    program.says(WAITS)
    assert program.end(number) == 0, program.said
    assert "Traceback" not in program.said


@pytest.mark.parametrize(
    ("port", "words"),
    [
        ("runs", "is no serial port"),
        (CONFIG, "is no serial port"),
        (f"{CONFIG}/ttyUSB0", "Not a directory"),
        ("ttyUSB0", "must be 'simulated' or a path such as /dev/ttyUSB0"),
        ("/dev/null", "is no serial port"),
    ],
)
def test_what_can_never_be_a_serial_port_is_an_error_at_once(
    folder: Path, monkeypatch: pytest.MonkeyPatch, port: str, words: str
) -> None:
    monkeypatch.chdir(folder)
    file = folder / CONFIG
    file.write_text(file.read_text().replace("port: runs/robot", f"port: {port}"))
    told = call("run", CONFIG, "--no-dashboard", "--socket", "c.sock")
    assert told.code == 2, told
    assert told.err.startswith(f"clearway: error: serial port {port}: ")
    assert words in told.err

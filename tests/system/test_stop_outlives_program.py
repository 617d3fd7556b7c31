"""A stopped robot in another process stands while `clearway run` is killed, ended or reloaded."""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from subprocess import DEVNULL

import pytest

from navigation.control import ControlError, send_order
from navigation.simulator.shared_pose import PoseFileError, PoseReader
from tests.support.pictures import Told, call
from tests.support.processes.forked import Program
from tests.support.waiting import wait_until
from tests.system.test_kill_9 import folder

__all__ = ["folder"]

pytestmark = pytest.mark.slow

CONFIG = "configs/hardware_in_the_loop.yaml"
WITHIN_S = 200.0
LOOK_S = 0.02
RESTS_S = 0.7
"""Longer than a simulated robot that gets no processor keeps its pose: `own_time.BEHIND_MAX_S`."""
STOOD_M = 1e-3
"""Less than a robot drives in a tenth of a second; one that stands does not move at all."""


class Bench:
    """The robot's true pose, and the program that is to drive it."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.socket = folder, folder / "c.sock"
        self.reader = PoseReader(folder / "runs" / "robot.pose")
        self.program: Program | None = None

    def pose(self) -> tuple[float, float, float]:
        while True:
            try:
                return self.reader.read()
            except PoseFileError:
                time.sleep(LOOK_S)  # it is being written

    def begin(self) -> None:
        """`clearway run`, until it takes orders."""
        arguments = ("run", CONFIG, "--no-dashboard", "--socket", self.socket)
        self.program = Program(arguments, cwd=self.folder, stdout=DEVNULL)
        assert wait_until(lambda: self.state() is not None, WITHIN_S)

    def end(self, number: signal.Signals) -> None:
        assert self.program is not None
        self.program.send_signal(number)
        self.program.wait(WITHIN_S)

    def state(self) -> str | None:
        try:
            return str(send_order(self.socket, {"order": "status"})["state"])
        except ControlError:
            return None

    def order(self, name: str) -> Told:
        """Give an order as a person does."""
        return call(name, "--socket", self.socket)

    def drives(self) -> bool:
        was = self.pose()
        return wait_until(lambda: math.dist(self.pose()[:2], was[:2]) > 0.03, WITHIN_S)

    def resting_place(self) -> tuple[float, float, float]:
        """Pose of the robot at rest; on a busy computer its time falls behind the wall's."""
        assert wait_until(lambda: self.stands(RESTS_S), WITHIN_S)
        return self.pose()

    def stands(self, seconds: float) -> bool:
        """True if the robot moves by nothing that counts for so long."""
        was, end_s = self.pose(), time.monotonic() + seconds
        while time.monotonic() < end_s:
            if math.dist(self.pose(), was) > STOOD_M:
                return False
            time.sleep(LOOK_S)  # the pace of looking
        return True


@pytest.fixture
def bench(folder: Path) -> Iterator[Bench]:
    """The program drives the robot."""
    bench = Bench(folder)
    try:
        bench.begin()
        assert bench.drives()
        yield bench
    finally:
        if bench.program is not None and bench.program.poll() is None:
            bench.program.kill()
            bench.program.wait()


def killed(bench: Bench) -> None:
    bench.end(signal.SIGKILL)
    bench.begin()


def ended(bench: Bench) -> None:
    bench.end(signal.SIGTERM)
    bench.begin()


def reloaded(bench: Bench) -> None:
    """With another margin."""
    file = bench.folder / CONFIG
    text = file.read_text()
    assert "margin_m: 0.015" in text
    file.write_text(text.replace("margin_m: 0.015", "margin_m: 0.02"))
    assert bench.program is not None
    bench.program.send_signal(signal.SIGHUP)
    assert wait_until(lambda: "stopped before this run began" in sentence(bench), WITHIN_S)


def sentence(bench: Bench) -> str:
    try:
        return str(send_order(bench.socket, {"order": "status"})["reason"])
    except ControlError:
        return ""


@pytest.mark.parametrize("again", [killed, ended, reloaded])
def test_a_stopped_robot_stands_until_it_is_rearmed_and_told_to_go_on(
    bench: Bench, again: Callable[[Bench], None]
) -> None:
    assert bench.order("stop").code == 0
    assert wait_until(lambda: bench.state() == "stopped", WITHIN_S)
    was = bench.resting_place()
    again(bench)
    assert bench.stands(3.0)
    assert "stopped before this run began" in sentence(bench)
    assert bench.order("resume").code == 0
    assert bench.stands(1.5)
    assert math.dist(bench.pose(), was) <= STOOD_M
    assert bench.order("resume").code == 0
    assert bench.drives()


def test_a_stop_without_a_program_holds_the_next_one_and_only_a_program_lifts_it(
    bench: Bench,
) -> None:
    bench.end(signal.SIGTERM)
    told = bench.order("stop")
    assert told.code == 0
    assert f"latched in {os.environ['XDG_STATE_HOME']}/clearway/stops" in told.out
    assert f"with the socket {bench.socket} waits" in told.out
    refused = bench.order("resume")
    assert refused.code == 2
    was = bench.resting_place()
    bench.begin()
    assert bench.stands(3.0)
    assert math.dist(bench.pose(), was) <= STOOD_M
    assert wait_until(lambda: bench.state() == "stopped", WITHIN_S)


def test_a_zone_that_no_file_keeps_holds_after_a_reload(bench: Bench) -> None:
    assert bench.order("stop").code == 0
    corner = {"name": "corner", "kind": "keep_out", "circle": [2.2, 0.2, 0.05]}
    assert send_order(bench.socket, {"order": "zone_put", "zone": corner})["kept"]
    (bench.folder / "runs" / "robot.journal.zones").unlink()
    reloaded(bench)
    assert "'corner'" in call("zone", "list", "--socket", bench.socket).out

"""A simulated robot that falls behind the clock: where it is at a time stays true."""

from __future__ import annotations

import os
import select
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navigation.simulator import own_time
from navigation.simulator.drive_model import DriveModel
from navigation.simulator.own_time import BEHIND_MAX_S, OwnTime
from navigation.simulator.robot import SimulatedRobot
from tests.support.robots.emulated_processor import EmulatedProcessor, Motors
from tests.support.robots.emulated_twin import EmulatedTwin

PROMPT = """
import struct, sys
read, write = sys.stdin.buffer.read, sys.stdout.buffer.write
asked = cycles = bytes_in = 0
while head := read(11):
    us, left, right, flags, count = struct.unpack("<IhhBH", head)
    bytes_in += len(read(count))
    asked += 1
    cycles += 16 * us
    answer = struct.pack("<IB", asked, bytes_in) if count else b""
    write(struct.pack("<BBBIIH", 51, 51, 1, 0, cycles % 2**32, len(answer)) + answer)
    sys.stdout.buffer.flush()
"""
"""An emulator that drives straight on; it answers bytes with the number of the step in which they
came."""
SPEED_M_S = 51 / 255 * 0.8
STEP_S = 0.002
STALLED_AT, STALL_S = (150, 300), 0.2
"""Steps whose answers take so long: twice in the first second."""


class Clock:
    """Time that passes when a test says so, and in the answers that stall."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self._lock = threading.Lock()

    def __call__(self) -> float:
        return self.now_s

    def pass_by(self, seconds: float) -> None:
        with self._lock:
            self.now_s += seconds


class StallingProcessor(EmulatedProcessor):
    """One for whose answer the robot waits ``STALL_S`` twice."""

    def __init__(self, program: Path, stall: Callable[[], None]) -> None:
        super().__init__([sys.executable, program])
        self._asked, self._stall = 0, stall

    def run(self, *arguments: Any) -> tuple[Motors, bytes]:
        answer = super().run(*arguments)
        self._asked += 1
        if self._asked in STALLED_AT:
            self._stall()
        return answer


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot is waited for, and makes up, as long as a busy machine takes."""
    monkeypatch.setattr(own_time, "BEHIND_MAX_S", 60.0)


def stalling_robot(folder: Path, clock: Clock, stall: Callable[[], None]) -> SimulatedRobot:
    program = folder / "prompt.py"
    program.write_text(PROMPT)
    model = DriveModel(lag_s=1e-4, slip=0.0)
    twin = EmulatedTwin([sys.executable, program], model=model)
    twin._processor.close()
    twin._processor = StallingProcessor(program, stall)
    return SimulatedRobot(twin=twin, rng=np.random.default_rng(1), model=model, clock=clock)


@pytest.mark.usefixtures("patient")
def test_a_pose_is_that_of_the_moment_it_is_asked_for_though_the_emulator_stalls(
    tmp_path: Path,
) -> None:
    clock = Clock()
    robot = stalling_robot(tmp_path, clock, lambda: clock.pass_by(STALL_S))
    robot.start()
    behind_m = []
    while (asked_s := clock()) < 1.0:
        behind_m.append(asked_s * SPEED_M_S - robot.pose().x_m)
        clock.pass_by(0.01)  # a camera's period
    robot.stop()
    robot.twin.close()
    assert max(behind_m) / SPEED_M_S < 0.02, "a frame of that time would show it where it was"
    assert len(behind_m) > 10


@pytest.mark.usefixtures("patient")
def test_bytes_do_not_reach_a_stalled_emulator_before_their_time(tmp_path: Path) -> None:
    clock = Clock()
    sent_s: list[float] = []

    def stall() -> None:
        clock.pass_by(STALL_S / 2)
        if not sent_s:
            os.write(host, b"?")
            sent_s.append(clock())
        clock.pass_by(STALL_S / 2)

    robot = stalling_robot(tmp_path, clock, stall)
    host = os.open(robot.port, os.O_RDWR | os.O_NOCTTY)
    robot.start()
    while not select.select([host], [], [], 0.0)[0]:
        robot.pose()  # so far it has come then
        clock.pass_by(0.01)
    step = int.from_bytes(os.read(host, 4), "little")
    robot.stop()
    robot.twin.close()
    os.close(host)
    assert step * STEP_S > sent_s[0] - 0.01


@pytest.mark.timed  # the robot's thread stalls in real time
def test_a_simulated_robot_whose_thread_is_held_up_is_waited_for() -> None:
    """Its thread is kept from going on; a pose that is asked for meanwhile comes afterwards."""
    held = threading.Lock()
    began_s = time.monotonic()

    def clock() -> float:
        if threading.current_thread().name == "simulated robot":
            with held:
                return time.monotonic()
        return time.monotonic()

    robot = SimulatedRobot(rng=np.random.default_rng(1), clock=clock)
    with robot:
        time.sleep(0.05)  # it runs
        held.acquire()
        time.sleep(0.1)  # and now it falls behind
        threading.Timer(0.1, held.release).start()
        asked_s = time.monotonic()
        robot.pose()
        newest_s = robot.track()[-1, 0]
    assert newest_s > asked_s - 0.03, f"asked at {asked_s - began_s:.3f} s"


def test_what_lies_too_far_behind_is_let_go_and_counted() -> None:
    own = OwnTime(STEP_S)
    own.begin(10.0)
    own.limit(10.0 + BEHIND_MAX_S)
    assert own.lost_s == 0.0
    own.limit(11.0 + BEHIND_MAX_S)
    assert abs(own.lost_s - 1.0) < 1e-9
    assert own.next_step_s(11.0) is None
    end_s = own.next_step_s(11.0 + STEP_S)
    assert end_s is not None
    own.done(end_s)
    assert own.due_in_s(11.0 + STEP_S) > 0.0


def test_nobody_waits_for_a_step_that_is_not_due_however_its_end_is_rounded() -> None:
    own, now_s = OwnTime(STEP_S), 0.0
    own.begin(now_s)
    began_s = time.perf_counter()
    for _ in range(100):
        now_s += 0.01  # five steps, but for the last bit
        while (end_s := own.next_step_s(now_s)) is not None:
            own.done(end_s)
        own.wait_for(now_s)
    assert time.perf_counter() - began_s < BEHIND_MAX_S


def test_a_robot_that_is_off_is_not_waited_for() -> None:
    own = OwnTime(STEP_S)
    own.begin(0.0)
    own.end()
    took_s = []
    for _ in range(3):
        before_s = time.perf_counter()
        own.wait_for(100.0)
        took_s.append(time.perf_counter() - before_s)
    assert min(took_s) < BEHIND_MAX_S, "the machine may have held up one of them"

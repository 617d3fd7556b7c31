"""The watcher in virtual time: a process of words, a port of bytes, a real Create 2's twin."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import cast

import pytest

from navigation.link.drivers.create2 import Create2Driver
from navigation.link.drivers.driver_watch import (
    BEAT_MISSED_S,
    LAST_WORDS_S,
    LEAVE_S,
    START_S,
    DriverWatch,
)
from navigation.link.drivers.robot_halt import RobotHalt
from navigation.link.drivers.robot_port import RobotPort
from navigation.link.drivers.word_of_robot import Word
from navigation.simulator.twins.create2 import Create2Twin

STEP_S = 0.005
DRIVES = Word(None, identity="iRobot Create 2")
DRIVE_ON = bytes([145, 1, 44, 1, 44])
"""Both wheels at 300 mm/s."""


@dataclass
class Process:
    """A process that the test is."""

    beat_s: float = -math.inf
    lives: bool = False
    dies_slowly: bool = False
    did: list[str] = field(default_factory=list)

    def start(self) -> str | None:
        self.did.append("start")
        self.lives, self.beat_s = True, -math.inf
        return None

    def runs(self) -> bool:
        return self.lives

    def how_it_ended(self) -> str:
        return "has ended (code -9)"

    def ask_to_end(self) -> None:
        self.did.append("ask to end")

    def kill(self) -> None:
        self.did.append("kill")
        self.lives = self.dies_slowly

    def lend(self, descriptor: int) -> bool:
        self.did.append(f"lend {descriptor}")
        return True


class Line:
    """`RobotPort` with a Create 2's twin at its other end."""

    def __init__(self) -> None:
        self.fault: str | None = "not open yet"
        self.twin, self.twin_hears, self.queued = Create2Twin(), True, b""
        self.moved_ticks = 0.0
        self.is_there = True

    def open(self, _now_s: float) -> bool:
        opened = self.fault is not None and self.is_there
        if opened:
            self.fault = None
        return opened

    def fileno(self) -> int | None:
        return None if self.fault else 7

    def read(self, now_s: float) -> bytes:
        wheels = self.twin.step(now_s, *[round(self.moved_ticks)] * 2)
        self.moved_ticks += wheels.left_m_s * STEP_S * 2_000 if wheels.powered else 0.0
        if not self.twin_hears:
            return b""
        return self.twin.bytes_to_send(now_s)

    @property
    def is_free(self) -> bool:
        return True

    def write(self, data: bytes, now_s: float) -> None:
        self.queued += data
        if self.twin_hears:
            self.twin.receive(self.queued, now_s)
            self.queued = b""

    def drop_unsent(self, _now_s: float) -> None:
        self.queued = b""

    def lose(self, fault: str, _now_s: float) -> None:
        self.fault = fault


class Bench:
    """A watch, and the time."""

    def __init__(self) -> None:
        self.now_s, self.process, self.line = 10.0, Process(), Line()
        halt = RobotHalt(Create2Driver(), "/dev/ttyUSB0")
        port = cast(RobotPort, self.line)
        self.watch = DriverWatch(self.process, port, halt, "iRobot Create 2")

    def run(self, seconds: float, *, beats: bool = False) -> None:
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            self.now_s += STEP_S
            if beats:
                self.process.beat_s = self.now_s
            self.watch.turn(self.now_s)

    def drive(self) -> None:
        """The process has the port, and the robot drives."""
        self.run(0.5)
        self.run(0.2, beats=True)
        self.watch.hears(DRIVES)
        self.line.write(DRIVE_ON, self.now_s)
        assert self.moves

    @property
    def moves(self) -> bool:
        return self.line.twin.step(self.now_s, *[round(self.line.moved_ticks)] * 2).left_m_s != 0.0

    @property
    def silence(self) -> str:
        return str(self.watch.word(self.now_s).silence)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_the_daemon_greets_the_robot_and_lends_the_port_at_the_first_beat(bench: Bench) -> None:
    bench.run(0.5)
    assert bench.process.did == ["start"]
    assert bench.watch.word(bench.now_s).stands
    bench.run(0.1, beats=True)
    assert bench.process.did == ["start", "lend 7"]
    assert not bench.watch.has_port
    bench.watch.hears(DRIVES)
    assert bench.watch.word(bench.now_s) == DRIVES


def test_a_beat_that_is_missed_ends_the_process_and_stops_the_robot_in_the_same_turn(
    bench: Bench,
) -> None:
    bench.drive()
    bench.run(BEAT_MISSED_S - STEP_S)
    assert bench.moves
    assert "kill" not in bench.process.did
    bench.run(3 * STEP_S)
    assert bench.process.did[-1] == "kill"
    assert not bench.moves
    assert bench.silence == (
        "the driver of the iRobot Create 2 did nothing for 0.2 s and was ended; "
        "the iRobot Create 2 on /dev/ttyUSB0 is being stopped"
    )


def test_what_a_dead_process_has_queued_is_not_driven(bench: Bench) -> None:
    bench.drive()
    bench.line.queued = DRIVE_ON * 3 + DRIVE_ON[:3]
    bench.process.lives = False
    bench.run(STEP_S)
    assert not bench.moves
    assert "the driver of the iRobot Create 2 has ended (code -9)" in bench.silence


def test_an_order_that_was_cut_off_takes_no_stop_with_it(bench: Bench) -> None:
    for length in range(1, len(DRIVE_ON)):
        one = Bench()
        one.drive()
        one.line.write(DRIVE_ON[:length], one.now_s)
        one.process.lives = False
        one.run(STEP_S)
        assert not one.moves, length


def test_a_new_process_waits_for_the_robot_to_be_heard_to_stand(bench: Bench) -> None:
    bench.drive()
    bench.line.twin_hears, bench.process.lives = False, False
    bench.run(60.0)
    assert bench.process.did.count("start") == 1
    assert bench.silence.endswith(
        "the iRobot Create 2 on /dev/ttyUSB0 was ordered to stand and has not been heard to: "
        "press CLEAN to wake it, and look at the cable"
    )
    bench.line.twin_hears = True
    bench.run(1.5)
    assert not bench.moves
    assert bench.process.did.count("start") == 2
    assert bench.watch.restarts == 1
    bench.run(0.1, beats=True)
    assert bench.process.did[-1] == "lend 7"


def test_a_process_that_is_killed_but_not_gone_yet_has_no_successor(bench: Bench) -> None:
    """One that waits for a disk dies when the disk answers."""
    bench.drive()
    bench.process.dies_slowly = True
    bench.run(2.0)
    assert not bench.moves
    assert bench.process.did.count("start") == 1
    bench.process.lives = False
    bench.run(0.2)
    assert bench.process.did.count("start") == 2


def test_a_port_that_breaks_is_opened_again_and_lent_again(bench: Bench) -> None:
    bench.drive()
    bench.line.is_there = False
    bench.watch.loses_port("serial port /dev/ttyUSB0 broke", bench.now_s)
    bench.run(0.5, beats=True)
    assert bench.silence == "serial port /dev/ttyUSB0 broke"
    bench.line.is_there = True
    bench.run(0.1, beats=True)
    assert bench.process.did.count("lend 7") == 2
    assert not bench.moves, "the daemon stops it before anybody else has it"


def test_a_process_that_never_begins_is_ended(bench: Bench) -> None:
    bench.run(START_S + 1.0)
    assert bench.process.did[:3] == ["start", "kill", "start"]


def test_the_end_waits_for_a_farewell_and_then_for_the_robot(bench: Bench) -> None:
    bench.drive()
    bench.watch.end(bench.now_s)
    bench.run(LEAVE_S - 0.1, beats=True)
    assert "kill" not in bench.process.did
    bench.run(0.2, beats=True)
    assert bench.process.did[-2:] == ["ask to end", "kill"]
    assert not bench.watch.is_over(bench.now_s)
    bench.run(0.4)
    assert bench.watch.is_over(bench.now_s)
    assert bench.watch.doubt(bench.now_s) is None
    assert not bench.moves


def test_the_end_does_not_wait_for_a_robot_that_is_not_heard(bench: Bench) -> None:
    bench.drive()
    bench.line.twin_hears = bench.process.lives = False
    bench.watch.end(bench.now_s)
    bench.run(LAST_WORDS_S + 2 * STEP_S)
    assert bench.watch.is_over(bench.now_s)
    assert "has not been heard to" in str(bench.watch.doubt(bench.now_s))

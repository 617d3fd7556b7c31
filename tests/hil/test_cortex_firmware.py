"""The binary for a bare Cortex-M3 on an emulated board, in real time.

Real time on a shared machine: bounds are those of the robot plus what a late process costs.
"""

from __future__ import annotations

import contextlib
import re
import socket
import struct
from collections.abc import Iterator
from pathlib import Path

import pytest

from firmware_protocol.host.events import MissionDone, RobotRebooted
from firmware_protocol.wire.messages import ResetCause, RobotState, Waypoint
from firmware_protocol.wire.mission import Mission
from tests.support.robots.avr_bench import AvrBench
from tests.support.robots.cortex_robot import CortexBoard, CortexBuild, missing_tools

pytestmark = pytest.mark.skipif(missing_tools() is not None, reason=f"needs {missing_tools()}")
keeps_up = pytest.mark.timed
"""The emulated processor has to keep up with the clock: this emulator has no time of its own."""
LATE_S = 0.1
"""What this machine may be late by, and a processor that is well may be silent for."""
STARTS = 10
"""A robot whose lease a busy machine has let lapse refuses its mission: it is given it again."""


@pytest.fixture(scope="module")
def build() -> Iterator[CortexBuild]:
    with CortexBuild() as build:
        yield build


@pytest.fixture
def bench(build: CortexBuild) -> Iterator[AvrBench]:
    processor = CortexBoard(build)
    bench = AvrBench(processor)
    bench.until(lambda: bench.host.state.is_up and bench.host.status is not None, 10.0)
    yield bench
    processor.close()


def drive(bench: AvrBench, count: int) -> Mission:
    mission = Mission(5, [Waypoint(0.02 * i, 0.0, 0.4) for i in range(count)])
    for _ in range(STARTS):
        bench.host.upload(mission, bench.now_s)
        with contextlib.suppress(TimeoutError):
            bench.until(lambda: bench.motors.left_m_s > 0.1, 1.0)
            break
    bench.until(lambda: bench.state() is RobotState.RUN, 1.0)
    return mission


def measure_lateness(bench: AvrBench) -> None:
    bench.silence_s = board_of(bench).late_s = 0.0


def late_s(bench: AvrBench) -> float:
    """The time that the machine may have kept from the emulated processor, and from the test.

    A processor that gets no time is silent; a test that is late sees everything later by that.
    """
    return max(LATE_S, bench.silence_s) + board_of(bench).late_s


def board_of(bench: AvrBench) -> CortexBoard:
    assert isinstance(bench.avr, CortexBoard)
    return bench.avr


def test_it_fits_into_a_small_microcontroller(build: CortexBuild) -> None:
    assert build.flash_bytes < 16_384
    assert build.ram_bytes < 2_048


def test_a_board_that_is_closed_leaves_no_folder(
    build: CortexBuild, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    CortexBoard(build).close()
    assert list(tmp_path.iterdir()) == []


@keeps_up
def test_a_mission_is_driven_to_its_end(bench: AvrBench) -> None:
    mission = drive(bench, 25)
    bench.until(lambda: MissionDone(5) in bench.events, 10.0)
    status = bench.host.status
    assert status is not None
    assert status.exec_crc == mission.prefix_crc(25)
    assert abs(status.x_m - 0.48) < 0.005
    assert status.counters.overruns == 0


@keeps_up
def test_the_emergency_stop_takes_the_power_away_and_stays(bench: AvrBench) -> None:
    drive(bench, 50)
    assert bench.motors.powered
    asked_s = bench.motors.now_s
    measure_lateness(bench)
    bench.host.estop()
    bench.until(lambda: not bench.motors.powered, 3.0)
    assert 0.0 <= bench.motors.off_s - asked_s < 0.015 + late_s(bench)
    bench.until(lambda: bench.state() is RobotState.ESTOP, 3.0)
    bench.run(0.5)
    assert not bench.motors.powered


@keeps_up
def test_the_dead_man_stops_the_motors(bench: AvrBench) -> None:
    drive(bench, 50)
    bench.lease = False
    measure_lateness(bench)
    bench.until(lambda: bench.state() is RobotState.HOLD, 3.0)
    held_s = bench.now_s - bench.leased_s
    assert 0.5 - board_of(bench).late_s <= held_s < 0.525 + late_s(bench)
    bench.until(lambda: bench.motors.left_m_s == 0.0 and bench.motors.right_m_s == 0.0, 1.5)


@keeps_up
def test_a_reset_forgets_the_mission_and_is_noticed(bench: AvrBench) -> None:
    drive(bench, 50)
    assert bench.host.status is not None
    boot_id = bench.host.status.boot_id
    bench.tick(reset=True)
    bench.until(lambda: any(isinstance(event, RobotRebooted) for event in bench.events), 3.0)
    (reboot,) = (event for event in bench.events if isinstance(event, RobotRebooted))
    assert reboot.cause is ResetCause.EXTERNAL
    bench.until(lambda: bench.host.state.is_up and bench.host.status.boot_id != boot_id, 3.0)
    assert bench.state() is RobotState.IDLE
    assert not bench.motors.powered


def hang(debugger: Path) -> None:
    """Put an endless loop where the processor is, as a debugger does."""
    with socket.socket(socket.AF_UNIX) as line:
        line.settimeout(5.0)
        line.connect(str(debugger))
        registers = ask(line, "g")
        (pc,) = struct.unpack("<I", bytes.fromhex(registers[15 * 8 : 16 * 8]))
        assert ask(line, f"M{pc:x},2:fee7") == "OK"
        line.sendall(packet("D"))


def packet(text: str) -> bytes:
    return f"${text}#{sum(text.encode()) % 256:02x}".encode()


def ask(line: socket.socket, text: str) -> str:
    """The answer to one question of GDB's remote protocol; reports of stops are passed over."""
    line.sendall(packet(text))
    got = b""
    while not (answer := re.search(rb"\$([^T#][^#]*)#..", got)):
        got += line.recv(4096)
    line.sendall(b"+")
    return answer[1].decode()


@keeps_up
def test_a_program_that_hangs_is_stopped_and_reset_by_the_watchdog(
    build: CortexBuild, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CORTEX_DEBUGGER", str(tmp_path / "debugger"))
    processor = CortexBoard(build)
    bench = AvrBench(processor)
    bench.until(lambda: bench.host.state.is_up and bench.host.status is not None, 10.0)
    drive(bench, 50)
    hung_s = bench.now_s
    processor.late_s = 0.0
    hang(tmp_path / "debugger")
    bench.until(lambda: not bench.motors.powered, 3.0)
    assert bench.now_s - hung_s < 0.125 + LATE_S + processor.late_s
    bench.until(lambda: any(isinstance(event, RobotRebooted) for event in bench.events), 3.0)
    (reboot,) = (event for event in bench.events if isinstance(event, RobotRebooted))
    assert reboot.cause is ResetCause.WATCHDOG
    bench.run(0.3)
    assert bench.state() is RobotState.IDLE
    assert not bench.motors.powered
    processor.close()


def test_two_boards_never_begin_with_one_boot_id(build: CortexBuild) -> None:
    seen = set()
    for _ in range(2):
        processor = CortexBoard(build)
        bench = AvrBench(processor)
        bench.until(lambda bench=bench: bench.host.status is not None, 10.0)  # type: ignore[misc]
        assert bench.host.status is not None
        seen.add(bench.host.status.boot_id)
        processor.close()
    assert len(seen) == 2

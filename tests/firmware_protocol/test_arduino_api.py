"""The firmware's port on Arduino's API, on a header that stands in for that API on Linux.

The program is the library as it is installed, with its example ``AnyBoard``; its clock goes as the
test lets it go, so bounds are the robot's own.
"""

from __future__ import annotations

import contextlib
import json
import random
import shutil
import socket
import subprocess
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import Event, MissionDone
from firmware_protocol.wire.messages import RobotState, StopReason, Waypoint
from firmware_protocol.wire.mission import Mission
from tests.support.robots.c_robot import FIRMWARE

STAND_IN = Path(__file__).parent / "arduino_api"
CORE = Path("/usr/share/arduino/hardware/arduino/avr/cores/arduino")
STRICT = ["-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"]
SANE = ["-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
TICK_S = 0.001
LEASE_EVERY = 50
"""Ticks from one lease to the next."""

pytestmark = [
    pytest.mark.skipif(
        not (shutil.which("g++") and shutil.which("make")), reason="needs g++ and make"
    ),
]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Arduino library, laid out as the IDE installs it."""
    folder = tmp_path_factory.mktemp("arduino")
    target = folder / "Clearway" / "library.properties"
    command = ["make", "-s", "-C", str(FIRMWARE), f"BUILD={folder}", str(target)]
    subprocess.run(command, check=True, timeout=60)
    return target.parent


@pytest.fixture(scope="module")
def program(library: Path) -> Path:
    """The example AnyBoard with a stop button on pin 10, as a Linux program."""
    build = library.parent
    sketch = (library / "examples" / "AnyBoard" / "AnyBoard.ino").read_text()
    assert "CW_NO_PIN};" in sketch
    (build / "sketch.h").write_text(sketch.replace("CW_NO_PIN};", "10};"))
    source, objects = library / "src", []
    ours = source / "clearway"
    for file in (*ours.glob("*.c"), ours / "port_arduino.cpp", STAND_IN / "board.cpp"):
        language = ["gcc", "-std=c99"] if file.suffix == ".c" else ["g++", "-std=c++11"]
        objects.append(build / f"{file.stem}.o")
        include = [f"-I{STAND_IN}", f"-I{source}", f"-I{build}"]
        compiling = [*language, *STRICT, *SANE, *include, "-c", str(file), "-o", str(objects[-1])]
        subprocess.run(compiling, check=True, timeout=120)
    linking = ["g++", *SANE, *map(str, objects), "-o", str(build / "robot")]
    subprocess.run(linking, check=True, timeout=120)
    return build / "robot"


class Bench:
    """The running program and a host on its line, in lockstep; :meth:`tick` is one millisecond."""

    def __init__(self, program: Path) -> None:
        self.line, theirs = socket.socketpair()
        self.line.setblocking(False)
        with theirs:
            self.process = subprocess.Popen(
                [program, str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
        self.host = HostConnection(random.Random(1))
        self.events: list[Event] = []
        self.lease = True
        self.now_s, self.ticks = 0.0, 0
        self.host.open(0.0)
        self.until(lambda: self.host.state.is_up and self.host.status is not None, 10.0)

    def tick(self) -> None:
        self.does(f"run {round(TICK_S * 1e6)}")
        self.ticks += 1
        self.now_s = self.ticks * TICK_S
        if self.lease and self.ticks % LEASE_EVERY == 0:
            self.host.lease(self.now_s, 0.5, True, odometry=True)
        with contextlib.suppress(BlockingIOError):
            self.host.receive_bytes(self.line.recv(4096), self.now_s)
        self.host.tick(self.now_s)
        self.line.sendall(self.host.bytes_to_send(self.now_s))
        while (event := self.host.next_event()) is not None:
            self.events.append(event)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def until(self, holds: Callable[[], bool], seconds: float) -> None:
        end_s = self.now_s + seconds
        while not holds():
            if self.now_s > end_s:
                raise TimeoutError(f"not after {seconds} s: {self.host.status}")
            self.tick()

    def state(self) -> RobotState | None:
        return None if self.host.status is None else self.host.status.state

    def drive(self, count: int) -> Mission:
        mission = Mission(5, [Waypoint(0.02 * i, 0.0, 0.4) for i in range(count)])
        self.host.upload(mission, self.now_s)
        self.until(lambda: self.status_x_m() > 0.02, 5.0)
        return mission

    def status_x_m(self) -> float:
        return 0.0 if self.host.status is None else self.host.status.x_m

    def does(self, what: str) -> list[int]:
        """Let time pass, press or release the button; the PWM behind it."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(f"{what}\n")
        self.process.stdin.flush()
        return [int(word) for word in self.process.stdout.readline().split()]

    def close(self) -> None:
        self.process.communicate(timeout=10)
        self.line.close()
        assert self.process.returncode == 0, "the sanitizers found nothing"


@pytest.fixture
def bench(program: Path) -> Iterator[Bench]:
    bench = Bench(program)
    yield bench
    bench.close()


def test_a_mission_is_driven_to_its_end(bench: Bench) -> None:
    mission = bench.drive(25)
    bench.until(lambda: MissionDone(5) in bench.events, 10.0)
    status = bench.host.status
    assert status is not None
    assert status.exec_crc == mission.prefix_crc(25)
    assert abs(status.x_m - 0.48) < 0.01


def test_the_emergency_stop_stops_and_stays(bench: Bench) -> None:
    bench.drive(50)
    bench.host.estop()
    bench.until(lambda: bench.state() is RobotState.ESTOP, 0.1)
    stopped_m = bench.status_x_m()
    bench.run(0.5)
    assert bench.state() is RobotState.ESTOP
    assert bench.status_x_m() - stopped_m < 0.05, "the wheels roll out"


def test_the_button_takes_the_power_away_at_once(bench: Bench) -> None:
    bench.drive(50)
    assert all(bench.does("run 1000"))
    assert bench.does("press") == [0, 0]
    bench.until(lambda: bench.state() is RobotState.ESTOP, 0.1)
    assert bench.host.status is not None
    assert bench.host.status.reason is StopReason.ESTOP_HOST
    bench.does("release")
    bench.run(0.3)
    assert bench.state() is RobotState.ESTOP, "releasing the button does not re-arm"


def test_the_dead_man_stops_the_motors(bench: Bench) -> None:
    bench.drive(50)
    bench.lease = False
    silent_s = bench.now_s
    bench.until(lambda: bench.state() is RobotState.HOLD, 2.0)
    since_last_s = (LEASE_EVERY - 1) * TICK_S
    assert 0.5 - since_last_s <= bench.now_s - silent_s <= 0.5 + 0.1


def test_two_boots_have_different_ids(program: Path) -> None:
    seen = set()
    for _ in range(2):
        bench = Bench(program)
        assert bench.host.status is not None
        seen.add(bench.host.status.boot_id)
        bench.close()
    assert len(seen) == 2


def test_the_library_is_complete(library: Path) -> None:
    properties = dict(
        line.split("=", 1) for line in (library / "library.properties").read_text().splitlines()
    )
    required = "name version author maintainer sentence paragraph category url architectures"
    assert set(required.split()) <= set(properties)
    assert properties["architectures"] == "*"
    assert (library / "src" / properties["includes"]).exists()


def test_only_its_own_header_is_on_the_include_path(library: Path) -> None:
    """Where file names ignore case, another header there would be taken for Arduino's Wire.h."""
    assert [file.name for file in (library / "src").iterdir() if file.is_file()] == ["Clearway.h"]
    assert (library / "src" / "clearway" / "wire.h").exists()


def test_the_library_has_what_library_managers_ask_for(library: Path) -> None:
    project = tomllib.loads((FIRMWARE.parents[1] / "pyproject.toml").read_text())["project"]
    properties = dict(
        line.split("=", 1) for line in (library / "library.properties").read_text().splitlines()
    )
    manifest = json.loads((library / "library.json").read_text())
    for field in ("name", "version"):
        assert manifest[field] == properties[field]
    assert manifest["description"] == properties["sentence"]
    assert manifest["headers"] == properties["includes"]
    assert manifest["version"] == project["version"]
    for name in ("LICENSE", "README.md", "keywords.txt"):
        assert (library / name).stat().st_size > 100
    headers = "".join(file.read_text() for file in library.glob("src/**/*.h"))
    for line in (library / "keywords.txt").read_text().splitlines():
        word, kind = line.split("\t")
        assert word in headers
        assert kind in ("KEYWORD1", "KEYWORD2", "LITERAL1")


@pytest.mark.parametrize("without", [False, True])
def test_the_port_compiles_on_a_core_without_available_for_write(
    library: Path, tmp_path: Path, without: bool
) -> None:
    header = (STAND_IN / "Arduino.h").read_text()
    assert header.count("availableForWrite") == 2
    if without:
        header = header.replace("availableForWrite", "room")
    (tmp_path / "Arduino.h").write_text(header)
    port = library / "src" / "clearway" / "port_arduino.cpp"
    command = [
        "g++",
        "-std=c++11",
        *STRICT,
        f"-I{tmp_path}",
        f"-I{library / 'src'}",
        "-c",
        str(port),
    ]
    subprocess.run([*command, "-o", str(tmp_path / "port.o")], check=True, timeout=120)


@pytest.mark.skipif(not CORE.exists(), reason="needs arduino-core-avr")
def test_the_example_for_any_board_builds_with_arduinos_own_core(tmp_path: Path) -> None:
    command = ["make", "-s", "-C", str(FIRMWARE), "arduino-core", f"BUILD={tmp_path}"]
    done = subprocess.run(command, timeout=180, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    text, data, bss = (int(n) for n in done.stdout.splitlines()[-1].split()[:3])
    assert text + data < 32_000
    assert data + bss < 2_500

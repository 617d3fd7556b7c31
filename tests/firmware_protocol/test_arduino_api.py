"""The firmware's port on Arduino's API, on a header that stands in for that API on Linux.

The program is the library as it is installed, with its example ``AnyBoard``; time is real, so
bounds are the robot's plus what a busy machine may be late by.
"""

from __future__ import annotations

import json
import random
import shutil
import subprocess
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import serial

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import Event, MissionDone
from firmware_protocol.wire.messages import RobotState, StopReason, Waypoint
from firmware_protocol.wire.mission import Mission
from tests.support.robots.c_robot import FIRMWARE

STAND_IN = Path(__file__).parent / "arduino_api"
CORE = Path("/usr/share/arduino/hardware/arduino/avr/cores/arduino")
STRICT = ["-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"]
SANE = ["-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
LATE_S = 0.2
"""What this machine may be late by."""

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
    """The running program and a host on its line."""

    def __init__(self, program: Path) -> None:
        self.process = subprocess.Popen(
            [program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.port = serial.Serial(self.process.stdout.readline().strip(), timeout=0)
        self.host = HostConnection(random.Random(1))
        self.events: list[Event] = []
        self.lease = True
        self._leased_s = 0.0
        self.host.open(time.monotonic())
        self.until(lambda: self.host.state.is_up and self.host.status is not None, 10.0)

    def until(self, holds: Callable[[], bool], seconds: float) -> None:
        end_s = time.monotonic() + seconds
        while not holds():
            now_s = time.monotonic()
            if now_s > end_s:
                raise TimeoutError(f"not after {seconds} s: {self.host.status}")
            if self.lease and now_s - self._leased_s >= 0.05:
                self._leased_s = now_s
                self.host.lease(now_s, 0.5, True, odometry=True)
            self.host.receive_bytes(self.port.read(4096), now_s)
            self.host.tick(now_s)
            self.port.write(self.host.bytes_to_send(now_s))
            while (event := self.host.next_event()) is not None:
                self.events.append(event)
            time.sleep(0.001)

    def state(self) -> RobotState | None:
        return None if self.host.status is None else self.host.status.state

    def drive(self, count: int) -> Mission:
        mission = Mission(5, [Waypoint(0.02 * i, 0.0, 0.4) for i in range(count)])
        self.host.upload(mission, time.monotonic())
        self.until(lambda: self.status_x_m() > 0.02, 5.0)
        return mission

    def status_x_m(self) -> float:
        return 0.0 if self.host.status is None else self.host.status.x_m

    def hand(self, does: str) -> list[int]:
        """Press or release the button; the PWM behind it."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(f"{does}\n")
        self.process.stdin.flush()
        return [int(word) for word in self.process.stdout.readline().split()]

    def close(self) -> None:
        self.port.close()
        self.process.communicate(timeout=10)
        assert self.process.returncode == 0, "the sanitizers found nothing"


@pytest.fixture
def bench(program: Path) -> Iterator[Bench]:
    bench = Bench(program)
    yield bench
    bench.close()


@pytest.mark.timed  # the program goes by the wall's clock
def test_a_mission_is_driven_to_its_end(bench: Bench) -> None:
    mission = bench.drive(25)
    bench.until(lambda: MissionDone(5) in bench.events, 10.0)
    status = bench.host.status
    assert status is not None
    assert status.exec_crc == mission.prefix_crc(25)
    assert abs(status.x_m - 0.48) < 0.01


@pytest.mark.timed  # the program goes by the wall's clock
def test_the_emergency_stop_stops_and_stays(bench: Bench) -> None:
    bench.drive(50)
    bench.host.estop()
    bench.until(lambda: bench.state() is RobotState.ESTOP, 0.1 + LATE_S)
    stopped_m = bench.status_x_m()
    waited_s = time.monotonic() + 0.5
    bench.until(lambda: time.monotonic() > waited_s, 1.0)
    assert bench.state() is RobotState.ESTOP
    assert bench.status_x_m() - stopped_m < 0.05, "the wheels roll out"


@pytest.mark.timed  # the program goes by the wall's clock
def test_the_button_takes_the_power_away_at_once(bench: Bench) -> None:
    bench.drive(50)
    assert bench.hand("press") == [0, 0]
    bench.until(lambda: bench.state() is RobotState.ESTOP, 0.1 + LATE_S)
    assert bench.host.status is not None
    assert bench.host.status.reason is StopReason.ESTOP_HOST
    bench.hand("release")
    waited_s = time.monotonic() + 0.3
    bench.until(lambda: time.monotonic() > waited_s, 1.0)
    assert bench.state() is RobotState.ESTOP, "releasing the button does not re-arm"


@pytest.mark.timed  # the program goes by the wall's clock
def test_the_dead_man_stops_the_motors(bench: Bench) -> None:
    bench.drive(50)
    bench.lease = False
    silent_s = time.monotonic()
    bench.until(lambda: bench.state() is RobotState.HOLD, 2.0)
    assert time.monotonic() - silent_s < 0.6 + LATE_S


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

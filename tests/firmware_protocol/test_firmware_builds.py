"""What the firmware can be built as: for a robot of one's own, and as an Arduino library."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from firmware_protocol.wire.drive_settings import DriveSettings
from navigation.config import load_config
from navigation.loop.firmware_settings import header_of
from tests.support.robots.c_robot import FIRMWARE

CONFIG = Path(__file__).parents[2] / "configs" / "simulation.yaml"
needs_avr = pytest.mark.skipif(shutil.which("avr-gcc") is None, reason="needs avr-gcc")


def make(*arguments: str) -> str:
    """What ``make`` in the firmware's folder prints; fails where it fails."""
    command = ["make", "-s", "-C", str(FIRMWARE), *arguments]
    done = subprocess.run(command, timeout=180, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


def test_the_default_settings_are_those_of_the_python_robot() -> None:
    text = (FIRMWARE / "settings.h").read_text()
    (values,) = re.findall(r"#define CW_SETTINGS \{(.*)\}", text)
    assert [int(value.rstrip("ul")) for value in values.split(", ")] == list(
        DriveSettings().whole_numbers()
    )


def test_the_firmware_keeps_to_the_ranges_it_can_compute_with() -> None:
    greedy = DriveSettings(3.0, *[99.0] * 9).whole_numbers()
    assert greedy == (1_000_000, 2000, 8000, 8000, 4000, 15_000, 1000, 500, 2000, 200)


@needs_avr
def test_a_configuration_reaches_the_board(tmp_path: Path) -> None:
    config = load_config(CONFIG)
    header = tmp_path / "my_robot.h"
    header.write_text(header_of(config, 300, 900))
    assert f"#define CW_BAUD {config.serial.baud}ul" in header.read_text()
    assert f"{{{round(config.robot.track_m * 1e6)}ul, {round(config.robot.speed_m_s * 1e3)}u" in (
        header.read_text()
    )
    make("avr", f"SETTINGS={header}", f"BUILD={tmp_path / 'mine'}")
    make("avr", f"BUILD={tmp_path / 'plain'}")
    images = [(tmp_path / name / "robot.elf").read_bytes() for name in ("mine", "plain")]
    assert images[0] != images[1]


@needs_avr
def test_a_baud_rate_that_the_clock_cannot_make_is_refused(tmp_path: Path) -> None:
    header = tmp_path / "my_robot.h"
    header.write_text("#define CW_BAUD 921600ul\n")
    command = ["make", "-s", "-C", str(FIRMWARE), "avr", f"SETTINGS={header}", f"BUILD={tmp_path}"]
    done = subprocess.run(command, timeout=180, capture_output=True, text=True)
    assert done.returncode != 0
    assert "cannot make this baud rate" in done.stderr


@needs_avr
def test_the_watchdog_can_be_left_out(tmp_path: Path) -> None:
    stores = []
    for chosen in ("1", "0"):
        build = tmp_path / chosen
        make("avr", f"WATCHDOG={chosen}", f"BUILD={build}")
        command = ["avr-objdump", "-d", str(build / "robot.elf")]
        done = subprocess.run(command, check=True, timeout=60, capture_output=True, text=True)
        # its control register: switched off at the start, two stores; switched on, two more
        stores.append(len(re.findall(r"sts\t0x0060, ", done.stdout)))
    assert stores == [4, 2]


@needs_avr
def test_a_sketch_can_leave_the_watchdog_out(tmp_path: Path) -> None:
    make("arduino", f"BUILD={tmp_path}")
    assert "watchdog" not in (tmp_path / "sketch.cpp").read_text()
    library = tmp_path / "Clearway" / "src"
    sketch = tmp_path / "other.cpp"
    sketch.write_text(
        "#include <Clearway.h>\n"
        "const cw_settings cw_robot_settings = CW_SETTINGS;\n"
        "bool cw_board_has_watchdog(void) { return false; }\n"
        "int main() { cw_port_begin(0, nullptr); cw_program_begin(); }\n"
    )
    flags = ["-mmcu=atmega328p", "-DF_CPU=16000000UL", "-Os", f"-I{library}"]
    sources = [str(file) for file in (library / "clearway").glob("*.c")]
    objects = []
    for file in sources:
        objects.append(str(tmp_path / f"{Path(file).stem}.other.o"))
        compiling = ["avr-gcc", *flags, "-std=gnu11", "-c", file, "-o", objects[-1]]
        subprocess.run(compiling, check=True, timeout=120)
    out = tmp_path / "other.elf"
    linking = ["avr-g++", *flags, "-std=gnu++11", str(sketch), *objects, "-o", str(out)]
    subprocess.run(linking, check=True, timeout=120)
    listing = subprocess.run(
        ["avr-objdump", "-d", str(out)], check=True, timeout=60, capture_output=True, text=True
    ).stdout
    (body,) = re.findall(r"<cw_board_has_watchdog>:\n((?:.+\n)+)", listing)
    assert "ldi\tr24, 0x00" in body, "the sketch's, not the port's"


@needs_avr
def test_the_arduino_library_compiles_without_a_warning(tmp_path: Path) -> None:
    told = make("arduino", f"BUILD={tmp_path}")
    assert "warning" not in told
    assert (tmp_path / "Clearway" / "library.properties").exists()
    assert (tmp_path / "Clearway" / "examples" / "ClearwayRobot" / "ClearwayRobot.ino").exists()

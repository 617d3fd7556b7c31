"""The AVR binary on an emulated ATmega328P, in lockstep with virtual time.

Needs gcc, avr-gcc, avr-libc and simavr with its headers; :func:`missing_tools` names what is
not there. On Debian: gcc-avr avr-libc binutils-avr simavr libsimavr-dev libelf-dev.
"""

from __future__ import annotations

import shutil
import struct
import subprocess
import tempfile
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from tests.support.c_robot import FIRMWARE

BRIDGE = Path(__file__).parents[1] / "hil" / "avr_bridge.c"
CLOCK_HZ = 16_000_000
FULL_SPEED_M_S = 0.8
TICK_M = 250e-6


def missing_tools() -> str | None:
    """What is missing to build and run, None where nothing is."""
    tools = [tool for tool in ("gcc", "make", "avr-gcc") if shutil.which(tool) is None]
    if not Path("/usr/include/simavr/sim_avr.h").exists():
        tools.append("libsimavr-dev")
    return " and ".join(tools) or None


class Motors(NamedTuple):
    """What the board's outputs do."""

    left_m_s: float
    right_m_s: float
    powered: bool
    off_s: float
    """When the power was last taken from the motors, in the emulated processor's time."""
    now_s: float


class AvrRobot:
    """A running firmware; a context manager."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="clearway_avr_")
        folder = Path(self._folder.name)
        make = ["make", "-s", "-C", str(FIRMWARE), "avr", f"BUILD={folder}"]
        sizes = subprocess.run(make, check=True, timeout=120, capture_output=True, text=True)
        text, data, bss = (int(n) for n in sizes.stdout.splitlines()[-1].split()[:3])
        self.flash_bytes, self.ram_bytes = text + data, data + bss
        bridge = folder / "avr_bridge"
        gcc = ["gcc", "-O2", "-o", str(bridge), str(BRIDGE), "-lsimavr", "-lelf"]
        subprocess.run(gcc, check=True, timeout=120)
        self._process = subprocess.Popen(
            [bridge, folder / "robot.elf"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._rest = [0.0, 0.0]

    def __enter__(self) -> AvrRobot:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.kill()
        self._process.communicate()
        self._folder.cleanup()

    def run(
        self,
        seconds: float,
        data: bytes = b"",
        wheels_m: tuple[float, float] = (0.0, 0.0),
        reset: bool = False,
    ) -> tuple[Motors, bytes]:
        """Let time pass while bytes arrive and the wheels turn by so much."""
        steps = []
        for side, travel in enumerate(wheels_m):
            self._rest[side] += travel / TICK_M
            whole = round(self._rest[side])
            self._rest[side] -= whole
            steps.append(whole)
        head = struct.pack("<IhhBH", round(seconds * 1e6), *steps, int(reset), len(data))
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(head + data)
        self._process.stdin.flush()
        answer = self._process.stdout.read(13)
        left, right, state, off, now, count = struct.unpack("<BBBIIH", answer)
        speeds = [
            pwm / 255.0 * FULL_SPEED_M_S * (-1.0 if state & backwards else 1.0)
            for pwm, backwards in ((left, 2), (right, 4))
        ]
        powered = bool(state & 1)
        motors = Motors(
            speeds[0] if powered else 0.0,
            speeds[1] if powered else 0.0,
            powered,
            off / CLOCK_HZ,
            now / CLOCK_HZ,
        )
        return motors, self._process.stdout.read(count)

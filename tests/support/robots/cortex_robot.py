"""The Cortex-M binary on a board that QEMU emulates, in real time.

Needs arm-none-eabi-gcc with newlib and qemu-system-arm; :func:`missing_tools` names what is not
there. On Debian: gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import TracebackType

from tests.support.robots.c_robot import FIRMWARE
from tests.support.robots.emulated_processor import EmulatedProcessor, Motors

ROOT = Path(__file__).parents[3]


def missing_tools() -> str | None:
    """What is missing to build and run, None where nothing is."""
    tools = ("make", "arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm")
    return " and ".join(tool for tool in tools if shutil.which(tool) is None) or None


class CortexBuild:
    """The built firmware; ``command`` runs a board with it, as ``EmulatedProcessor`` wants it."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="clearway_cortex_")
        make = ["make", "-s", "-C", str(FIRMWARE), "cortex-m", f"BUILD={self._folder.name}"]
        sizes = subprocess.run(make, check=True, timeout=120, capture_output=True, text=True)
        text, data, bss = (int(n) for n in sizes.stdout.splitlines()[-1].split()[:3])
        self.flash_bytes, self.ram_bytes = text + data, data + bss
        bridge = (str(ROOT / "tests" / "hil" / "cortex_bridge.py"),)
        self.command = (sys.executable, *bridge, f"{self._folder.name}/robot_cortex_m.elf")

    def __enter__(self) -> CortexBuild:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._folder.cleanup()


class CortexBoard(EmulatedProcessor):
    """A board that is asked no faster than its real time goes."""

    def __init__(self, build: CortexBuild) -> None:
        super().__init__(build.command)
        super().run(0.0)  # it has started when this is answered
        self._due_s = time.monotonic()
        self.late_s = 0.0
        """The longest time by which the asker was late, since a test set it to 0."""

    def run(
        self,
        seconds: float,
        data: bytes = b"",
        wheels_m: tuple[float, float] = (0.0, 0.0),
        reset: bool = False,
    ) -> tuple[Motors, bytes]:
        """As that of an ``EmulatedProcessor``; waits until the time has passed."""
        self._due_s += seconds
        self.late_s = max(self.late_s, time.monotonic() - self._due_s)
        time.sleep(max(0.0, self._due_s - time.monotonic()))
        return super().run(seconds, data, wheels_m, reset)

"""The AVR binary on an emulated ATmega328P, in lockstep with virtual time.

Needs gcc, avr-gcc, avr-libc and simavr with its headers; :func:`missing_tools` names what is
not there. On Debian: gcc-avr avr-libc binutils-avr simavr libsimavr-dev libelf-dev.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path
from types import TracebackType

from tests.support.robots.c_robot import FIRMWARE
from tests.support.robots.emulated_processor import EmulatedProcessor

BRIDGE = Path(__file__).parents[2] / "hil" / "avr_bridge.c"


def missing_tools() -> str | None:
    """What is missing to build and run, None where nothing is."""
    tools = [tool for tool in ("gcc", "make", "avr-gcc") if shutil.which(tool) is None]
    if not Path("/usr/include/simavr/sim_avr.h").exists():
        tools.append("libsimavr-dev")
    return " and ".join(tools) or None


class AvrRobot:
    """A running firmware and, as ``command``, how to run another; a context manager.

    ``run`` is that of ``EmulatedProcessor``.
    """

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
        self.command = (str(bridge), str(folder / "robot.elf"))
        self._processor = EmulatedProcessor(self.command)
        self.run = self._processor.run

    def __enter__(self) -> AvrRobot:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._processor.close()
        self._folder.cleanup()

"""Where the real MicroPython is: on a 32-bit machine, as every board that it is made for."""

from __future__ import annotations

import shutil
from pathlib import Path

UNPACKED = Path(__file__).parents[3] / "build" / "micropython" / "micropython"


def interpreter() -> str | None:
    """The one that ``.ci/micropython`` has unpacked, or one on the path, or None."""
    return str(UNPACKED) if UNPACKED.exists() else shutil.which("micropython")

"""The operating system that the running program needs."""

from __future__ import annotations

import sys
from typing import Final

NEEDED: Final = "linux"


class NeedsLinuxError(RuntimeError):
    """Error: a part is used that needs Linux."""

    exit_code: Final = 2


def require_linux(part: str) -> None:
    """Raise NeedsLinuxError, naming ``part``, unless this is Linux."""
    if sys.platform != NEEDED:
        raise NeedsLinuxError(
            f"{part}: needs Linux, and this is {sys.platform}; "
            "commands on pictures and maps, and sweep, run here too"
        )

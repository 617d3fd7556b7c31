"""Clock for searches with a time limit: it stops while kernels are compiled.

The first search on a machine compiles its kernels, which may take longer than its limit.
"""

# mypy: allow-untyped-calls

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypeAlias

from numba.core import event  # documented: numba's manual for developers, "Event API"

COMPILING = "numba:compile"
Clock: TypeAlias = Callable[[], float]
"""Gives seconds."""


class _Compiling(event.Listener):
    def __init__(self) -> None:
        self.total_s = 0.0
        self.began_s = 0.0
        self.depth = 0

    def on_start(self, event: Any) -> None:
        if self.depth == 0:
            self.began_s = time.monotonic()
        self.depth += 1

    def on_end(self, event: Any) -> None:
        self.depth -= 1
        if self.depth == 0:
            self.total_s += time.monotonic() - self.began_s


_COMPILING = _Compiling()
event.register(COMPILING, _COMPILING)


def search_clock_s() -> float:
    """Seconds since some past time, without those spent compiling kernels."""
    now_s = _COMPILING.began_s if _COMPILING.depth else time.monotonic()
    return now_s - _COMPILING.total_s

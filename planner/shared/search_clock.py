"""A clock for searches with a limit of time: it is stopped while kernels are compiled.

The first search on a machine compiles what it calls. Without this its time would be over before it
had begun, and it would say that it found no plan.
"""

# mypy: allow-untyped-calls

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypeAlias

from numba.core import event

COMPILING = "numba:compile"
Clock: TypeAlias = Callable[[], float]
"""Gives seconds; a search may be given another one than this process's."""


class _Compiling(event.Listener):
    """How long this process has compiled; compilations within others count once."""

    def __init__(self) -> None:
        self.total_s = 0.0
        self.began_s = 0.0
        self.depth = 0

    def on_start(self, event: Any) -> None:
        """A kernel is being compiled."""
        if self.depth == 0:
            self.began_s = time.monotonic()
        self.depth += 1

    def on_end(self, event: Any) -> None:
        """It is compiled, or refused."""
        self.depth -= 1
        if self.depth == 0:
            self.total_s += time.monotonic() - self.began_s


_COMPILING = _Compiling()
event.register(COMPILING, _COMPILING)


def search_clock_s() -> float:
    """Seconds since some time in the past, without those in which kernels were compiled."""
    now_s = _COMPILING.began_s if _COMPILING.depth else time.monotonic()
    return now_s - _COMPILING.total_s

"""Delay in waking this program's threads, measured by a thread that does nothing else.

A thread that waits for a device cannot distinguish a late device from a late computer. The time for
which the computer slept counts, which no monotonic clock shows. Seconds.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import Final

EVERY_S: Final = 0.02


def asleep_s() -> float:
    """Time for which this computer has slept since it was started."""
    if not hasattr(time, "CLOCK_BOOTTIME"):  # only Linux has it
        return 0.0
    return time.clock_gettime(time.CLOCK_BOOTTIME) - time.monotonic()


class Wakeups:
    """A thread that wakes up every ``EVERY_S`` of ``clock``; ``asleep`` is `asleep_s`."""

    def __init__(self, clock: Callable[[], float], asleep: Callable[[], float] = asleep_s) -> None:
        self._clock, self._asleep = clock, asleep
        self._worst_s = 0.0
        self._woken_s = math.inf
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Begin to measure."""
        self._stop.clear()
        self._thread = threading.Thread(target=self._run, name="wakeups", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop measuring."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def late_since_s(self) -> float:
        """Time of the next wake-up; infinity while it is off."""
        return self._woken_s + EVERY_S

    def worst_s(self) -> float:
        """Worst delay since the last call."""
        worst_s, self._worst_s = self._worst_s, 0.0
        return worst_s

    def _run(self) -> None:
        self._woken_s, asleep_s = self._clock(), self._asleep()
        while not self._stop.wait(EVERY_S):
            now_s, slept_s = self._clock(), self._asleep() - asleep_s
            self._worst_s = max(self._worst_s, now_s - self._woken_s - EVERY_S + slept_s)
            self._woken_s, asleep_s = now_s, asleep_s + slept_s
        self._woken_s = math.inf

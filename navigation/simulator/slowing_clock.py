"""Clock of a simulated world in real time: it follows the wall and waits for late parts.

On one busy computer, camera, robots and program fall behind differently: late reports and pictures
make the program conclude that a robot was carried. So each part states since when it has had
unfinished work; the clock passes that by at most the part's slack. On a slow computer the whole
world slows evenly.

A part without progress for ``PATIENCE_S`` while others read the clock hangs, and is not waited for:
robots notice a hanging program as in the real world, by a lapsed lease. A computer that sleeps, or
a program that is stopped and continued, loses nothing.

Two processes may share a clock, each reading its own over the same memory. Seconds.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, MutableSequence
from typing import Final

PATIENCE_S: Final = 3.0
"""A thread that got no processor for this time, while others did, hangs."""
READS_SLACK_S: Final = 0.1
"""Longest pause of a thread between reads: the control loop reads the clock twice in this time."""
LONGEST_GAP_S: Final = 0.1
"""The clock is read more often than this unless the whole program is suspended."""
SHARED_VALUES: Final = 3
"""Values shared by two processes: the seconds lost, and until when each one's parts let time
pass."""


class SlowingClock:
    """Monotonic seconds of the simulated world; call it, from any thread.

    ``shared`` is memory for ``SHARED_VALUES`` numbers, at first zeros, common to two processes;
    ``side`` is 0 in one and 1 in the other. ``wall`` gives monotonic seconds.
    """

    def __init__(
        self,
        shared: MutableSequence[float] | None = None,
        side: int = 0,
        wall: Callable[[], float] = time.monotonic,
    ) -> None:
        self._shared = [0.0] * SHARED_VALUES if shared is None else shared
        self._side, self._wall = side, wall
        if side == 0:
            self._shared[1] = self._shared[2] = math.inf
        self._parts: dict[str, _Part] = {}
        self._other = _Part(lambda: self._shared[2 - side], 0.0)
        self._reader: int | None = None
        self._lock = threading.Lock()
        self._now_s = -math.inf
        self._wall_s, self._awake_s = wall(), 0.0

    def __call__(self) -> float:
        """Now."""
        with self._lock:
            wall_s = self._wall()
            self._awake_s += min(wall_s - self._wall_s, LONGEST_GAP_S)
            self._wall_s = wall_s
            lost_s = self._shared[0]
            until_s = self._until_s()
            if wall_s - lost_s > until_s:
                lost_s = wall_s - max(until_s, self._now_s)
                # of two processes' concurrent writes none is lost: the next reading repeats it
                self._shared[0] = max(self._shared[0], lost_s)
            self._now_s = max(self._now_s, wall_s - lost_s)
            if threading.get_ident() == self._reader:
                self._read_s = self._now_s
            return self._now_s

    def wait(self, seconds: float) -> None:
        """Wait ``seconds`` of the simulated world's time."""
        end_s = self() + seconds
        while (left_s := end_s - self()) > 0.0:
            time.sleep(left_s)  # the wall needs at least that long

    @property
    def lost_s(self) -> float:
        """Delay of the simulated world behind the wall so far."""
        return self._shared[0]

    def waits_for(self, name: str, since_s: Callable[[], float], slack_s: float) -> None:
        """Let a part be late by at most ``slack_s``; it replaces one of the same name.

        ``since_s`` gives the time since which it has had unfinished work, or infinity.
        """
        with self._lock:
            self._parts[name] = _Part(since_s, slack_s)

    def waits_for_this_thread(self) -> None:
        """Wait for the calling thread, which must read the clock again and again."""
        self._read_s = self()
        self._reader = threading.get_ident()
        self.waits_for("control loop", lambda: self._read_s, READS_SLACK_S)

    def _until_s(self) -> float:
        own = [part.until_s(self._awake_s) for part in self._parts.values()]
        self._shared[1 + self._side] = until_s = min(own, default=math.inf)
        return min(until_s, self._other.until_s(self._awake_s))


class _Part:
    """A part of the world and its progress."""

    def __init__(self, since_s: Callable[[], float], slack_s: float) -> None:
        self._since_s, self._slack_s = since_s, slack_s
        self._last_s, self._moved_s = math.nan, -math.inf

    def until_s(self, awake_s: float) -> float:
        """Time up to which it lets the clock run; ``awake_s`` grows while the clock is read."""
        since_s = self._since_s()
        if since_s != self._last_s:
            self._last_s, self._moved_s = since_s, awake_s
        if awake_s - self._moved_s > PATIENCE_S:
            return math.inf
        return since_s + self._slack_s

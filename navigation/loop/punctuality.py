"""Punctuality of the program's own threads.

A computer that is too busy dates pictures and reports late, so camera and wheels disagree though
nothing is wrong with the robot. The robots hold until the threads have been on time for a while.
Seconds of the world's clock.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from typing import Final

LATE_S: Final = 0.35
"""Robots hold if a thread is this late: the motion of the wheels is unknown without reports for
this time, and a robot's lease is nearly over."""
DOUBTFUL_S: Final = 0.05
"""With a thread this late, camera and wheels may seem to differ: in this time a robot at 0.4 m/s
drives as far as the two may differ."""
STOPPED_S: Final = 5.0
"""A delay that load alone hardly explains: the program was stopped, or the computer slept."""
CALM_S: Final = 1.0
"""Time for which all threads must be on time before robots drive again."""


class Punctuality:
    """Judgement of delays; ``load`` is for the sentence."""

    def __init__(self, load: Callable[[], tuple[float, float, float]] | None = None) -> None:
        self._load = load
        self._late: dict[float, tuple[float, str]] = {}

    def note(self, thread: str, late_s: float, now_s: float) -> None:
        """Note a delay; usual ones are ignored."""
        for limit_s in (DOUBTFUL_S, LATE_S):
            if late_s >= limit_s:
                self._late[limit_s] = (now_s, self._sentence(thread, late_s))

    def hold(self, now_s: float) -> str | None:
        """Reason why robots hold, if any."""
        return self._since(LATE_S, now_s)

    def doubt(self, now_s: float) -> str | None:
        """Reason why camera and wheels may seem to differ, if any."""
        return self._since(DOUBTFUL_S, now_s)

    def _since(self, limit_s: float, now_s: float) -> str | None:
        when_s, sentence = self._late.get(limit_s, (-math.inf, ""))
        return sentence if now_s - when_s < CALM_S else None

    def _sentence(self, thread: str, late_s: float) -> str:
        load, cores = (self._load or os.getloadavg)()[0], os.cpu_count() or 1
        if late_s >= STOPPED_S:
            return (
                f"this program did not run for {late_s:.0f} s: it was stopped, or this computer "
                f"slept or is too busy (load {load:.1f} on {cores} processors)"
            )
        return (
            f"this computer is too busy: {thread} was late by {late_s:.1f} s "
            f"(load {load:.1f} on {cores} processors)"
        )

"""Times of the host's questions for the robot's clock.

Eight quick ones, then one a second, and one at once if a report does not fit. An answer counts
once, however late. Seconds of the host's monotonic clock.
"""

from __future__ import annotations

import math
from typing import Final

from firmware_protocol.host.line.clock_sync import WRAP_US
from firmware_protocol.wire.messages import TimeSync

FAST_S: Final = 0.1
SLOW_S: Final = 1.0
FAST_COUNT: Final = 8
_KEPT: Final = 32
"""Most questions that await an answer."""


class SyncSchedule:
    """Questions of one connection."""

    def __init__(self) -> None:
        self._asked_s = -math.inf
        self._sent: dict[int, float] = {}
        self._count = 0
        self._doubted = False

    def next_question(self, now_s: float) -> TimeSync | None:
        """Question that is due, which then counts as sent, or None."""
        fast = self._count < FAST_COUNT or self._doubted
        if now_s - self._asked_s < (FAST_S if fast else SLOW_S):
            return None
        self._asked_s = now_s
        self._count += 1
        self._doubted = False
        sent_us = int(now_s * 1e6) % WRAP_US
        self._sent[sent_us] = now_s
        if len(self._sent) > _KEPT:
            del self._sent[next(iter(self._sent))]
        return TimeSync(sent_us)

    def sent_s(self, sent_us: int) -> float | None:
        """Time of the answered question, once only; None if it is not ours."""
        return self._sent.pop(sent_us, None)

    def doubt(self) -> None:
        """Ask soon: a report does not fit the estimate."""
        self._doubted = True

    def begin_again(self) -> None:
        """Ask quickly, and ignore earlier answers: the clock may be another."""
        self._count = 0
        self._asked_s = -math.inf
        self._sent = {}

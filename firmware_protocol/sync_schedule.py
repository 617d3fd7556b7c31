"""When the host asks for the robot's clock, and when it asked what.

Eight times quickly, then once a second; only the answer to the last question counts. Seconds of
the host's monotonic clock.
"""

from __future__ import annotations

import math
from typing import Final

from firmware_protocol.clock_sync import WRAP_US
from firmware_protocol.messages import TimeSync

FAST_S: Final = 0.1
SLOW_S: Final = 1.0
FAST_COUNT: Final = 8


class SyncSchedule:
    """The questions of one connection."""

    def __init__(self) -> None:
        self._asked_s = -math.inf
        self._sent: dict[int, float] = {}
        self._count = 0

    def next_question(self, now_s: float) -> TimeSync | None:
        """The question that is due, None where none is; it counts as sent."""
        interval_s = FAST_S if self._count < FAST_COUNT else SLOW_S
        if now_s - self._asked_s < interval_s:
            return None
        self._asked_s = now_s
        self._count += 1
        sent_us = int(now_s * 1e6) % WRAP_US
        self._sent = {sent_us: now_s}
        return TimeSync(sent_us)

    def sent_s(self, sent_us: int) -> float | None:
        """When the answered question was sent, None where it is not the last; once only."""
        return self._sent.pop(sent_us, None)

    def hurry(self) -> None:
        """The robot's clock is another one: ask quickly again."""
        self._count = 0

    def forget(self) -> None:
        """Answers of before do not count any more."""
        self._sent = {}

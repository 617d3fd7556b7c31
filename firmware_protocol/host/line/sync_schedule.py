"""When the host asks for the robot's clock, and when it asked what.

Eight times quickly, then once a second, and at once where a report does not fit what is known. An
answer counts once, however late it comes: its round trip says what it is worth. Seconds of the
host's monotonic clock.
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
"""Questions whose answers are waited for, the newest."""


class SyncSchedule:
    """The questions of one connection."""

    def __init__(self) -> None:
        self._asked_s = -math.inf
        self._sent: dict[int, float] = {}
        self._count = 0
        self._doubted = False

    def next_question(self, now_s: float) -> TimeSync | None:
        """The question that is due, None where none is; it counts as sent."""
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
        """When the answered question was sent, None where it was none of ours; once only."""
        return self._sent.pop(sent_us, None)

    def doubt(self) -> None:
        """A report does not fit what is known: ask soon."""
        self._doubted = True

    def begin_again(self) -> None:
        """The clock may be another one: ask quickly; answers of before do not count."""
        self._count = 0
        self._asked_s = -math.inf
        self._sent = {}

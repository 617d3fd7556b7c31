"""The robot's clock over one connection: the questions for it, and their answers.

Eight quick questions, then one a second, and one at once if a report does not fit. An answer counts
once, however late; ``clock_sync`` makes the ``estimate``. Seconds of the host's monotonic clock.
"""

from __future__ import annotations

import math
from typing import Final

from firmware_protocol.host.freshest import ERROR_MAX_S
from firmware_protocol.host.line.clock_sync import WRAP_US, ClockEstimate
from firmware_protocol.host.line.pace import LinePace
from firmware_protocol.wire.framing import wire_bytes
from firmware_protocol.wire.messages import Status, TimeSync, TimeSyncReply

FAST_S: Final = 0.1
SLOW_S: Final = 1.0
FAST_COUNT: Final = 8
_KEPT: Final = 32
"""Most questions that await an answer."""


class RobotClock:
    """Clock of one robot, over one line."""

    def __init__(self, pace: LinePace) -> None:
        self.estimate = ClockEstimate()
        self.jumps = 0
        """Jumps of either clock."""
        self._asking_s = pace.wire_s(wire_bytes(TimeSync.LAYOUT.size))
        self._answering_s = pace.wire_s(wire_bytes(TimeSyncReply.LAYOUT.size))
        self._doubted = False
        self.new_session()

    def new_session(self) -> None:
        """Void the answers on their way, and ask again quickly: the clock may be another."""
        self._count = 0
        self._asked_s = -math.inf
        self._sent: dict[int, float] = {}

    def new_boot(self) -> None:
        """Restart: a rebooted robot has a new clock."""
        self.estimate = ClockEstimate()
        self.new_session()

    @property
    def _interval_s(self) -> float:
        return FAST_S if self._count < FAST_COUNT or self._doubted else SLOW_S

    @property
    def question_s(self) -> float:
        """Time of the next question."""
        return self._asked_s + self._interval_s

    def next_question(self, now_s: float) -> TimeSync | None:
        """Question that is due, which then counts as sent, or None."""
        if now_s - self._asked_s < self._interval_s:
            return None
        self._asked_s = now_s
        self._count += 1
        self._doubted = False
        sent_us = int(now_s * 1e6) % WRAP_US
        self._sent[sent_us] = now_s
        if len(self._sent) > _KEPT:
            del self._sent[next(iter(self._sent))]
        return TimeSync(sent_us)

    def take(self, answer: TimeSyncReply, now_s: float) -> None:
        """Take an answer; ignore one to no question of ours."""
        sent_s = self._sent.pop(answer.host_sent_us, None)
        if sent_s is None:
            return
        before = self.estimate.jumps
        wire_s = (self._asking_s, self._answering_s)
        self.estimate.add(sent_s, answer.robot_received_us, answer.robot_sent_us, now_s, wire_s)
        self.jumps += self.estimate.jumps - before

    def compare(self, status: Status, now_s: float) -> None:
        """Compare a report just received; ask soon if its time does not fit."""
        self._doubted = self._doubted or self.estimate.is_in_doubt(status.time_us, now_s)

    def why_unknown(self, now_s: float) -> str | None:
        """Reason why no lease can be dated; None if one can."""
        error_s = self.estimate.error_s(now_s)
        if error_s <= ERROR_MAX_S:
            return None
        if not self.estimate.ready:
            return "its clock is not known yet"
        return (
            f"its clock is known to {error_s * 1e3:.0f} ms only, {ERROR_MAX_S * 1e3:.0f} ms are "
            "needed: the line is too slow"
        )

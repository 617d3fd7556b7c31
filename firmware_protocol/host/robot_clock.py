"""The robot's clock over one connection.

``clock_sync`` makes the ``estimate``, ``sync_schedule`` times the questions. Seconds of the host's
monotonic clock.
"""

from __future__ import annotations

from firmware_protocol.host.freshest import ERROR_MAX_S
from firmware_protocol.host.line.clock_sync import ClockEstimate
from firmware_protocol.host.line.pace import LinePace
from firmware_protocol.host.line.sync_schedule import SyncSchedule
from firmware_protocol.wire.framing import wire_bytes
from firmware_protocol.wire.messages import Status, TimeSync, TimeSyncReply


class RobotClock:
    """Clock of one robot, over one line."""

    def __init__(self, pace: LinePace) -> None:
        self.estimate = ClockEstimate()
        self.jumps = 0
        """Jumps of either clock."""
        self._asking_s = pace.wire_s(wire_bytes(TimeSync.LAYOUT.size))
        self._answering_s = pace.wire_s(wire_bytes(TimeSyncReply.LAYOUT.size))
        self._schedule = SyncSchedule()

    def next_question(self, now_s: float) -> TimeSync | None:
        """Question that is due, which then counts as sent, or None."""
        return self._schedule.next_question(now_s)

    def take(self, answer: TimeSyncReply, now_s: float) -> None:
        """Take an answer; ignore one to no question of ours."""
        sent_s = self._schedule.sent_s(answer.host_sent_us)
        if sent_s is None:
            return
        before = self.estimate.jumps
        wire_s = (self._asking_s, self._answering_s)
        self.estimate.add(sent_s, answer.robot_received_us, answer.robot_sent_us, now_s, wire_s)
        self.jumps += self.estimate.jumps - before

    def compare(self, status: Status, now_s: float) -> None:
        """Compare a report just received; ask soon if its time does not fit."""
        if self.estimate.is_in_doubt(status.time_us, now_s):
            self._schedule.doubt()

    def new_session(self) -> None:
        """Void the answers on their way; ask again quickly."""
        self._schedule.begin_again()

    def new_boot(self) -> None:
        """Restart: a rebooted robot has a new clock."""
        self.estimate = ClockEstimate()
        self._schedule.begin_again()

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

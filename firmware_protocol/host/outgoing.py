"""Output of the host's end: at most one frame at a time, the most urgent first.

An emergency stop passes every queue and the line's pace. Otherwise HELLO, while no robot answers;
its challenge returned, until verified; else lease, pose and the clock's question; then commands and
waypoints. Seconds of the host's monotonic clock.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from firmware_protocol.host.commands import Commands
from firmware_protocol.host.counters import HostCounters
from firmware_protocol.host.freshest import Freshest
from firmware_protocol.host.line.pace import LinePace
from firmware_protocol.host.line.send_window import SendWindow
from firmware_protocol.host.robot_clock import RobotClock
from firmware_protocol.host.sessions import HostSessions
from firmware_protocol.host.state import LinkState
from firmware_protocol.host.upload import Upload
from firmware_protocol.wire.framing import Sender, WireFrame, encode_frame
from firmware_protocol.wire.messages import (
    ESTOP_FRAME,
    SCHEMA_HASH,
    Confirm,
    Hello,
    Lease,
    PoseFix,
    Status,
    TimeSync,
)

ESTOP_REPEAT_S: Final = 0.02


class Outgoing:
    """Everything to send, and the line's pace at ``baud``; None does not pace."""

    def __init__(self, sessions: HostSessions, counters: HostCounters, baud: int | None) -> None:
        self.pace = LinePace(baud)
        self.clock = RobotClock(self.pace)
        self.freshest = Freshest()
        self.window = SendWindow(0)
        self.commands = Commands()
        self.nonce: int | None = None
        """The robot's unanswered challenge."""
        self.estop_wanted = False
        """True if an emergency stop awaits confirmation."""
        self._sessions, self._counters = sessions, counters
        self._estop_s = -math.inf

    def want_estop(self) -> None:
        """Stop at once, until confirmed; wishes that would move the robot are void."""
        self.estop_wanted = True
        self._estop_s = -math.inf
        self.commands.reset_wanted = False
        self.commands.want_no_start()

    def drop_session(self) -> None:
        """Drop everything in flight."""
        self._counters.timeouts += self.window.timeouts
        self.window = SendWindow(0)
        self.freshest.forget()
        self.clock.new_session()

    def next_bytes(
        self, state: LinkState, status: Status | None, upload: Upload | None, now_s: float
    ) -> bytes:
        """At most one frame; empty if none is due or the line is busy."""
        if self.estop_wanted and now_s - self._estop_s >= ESTOP_REPEAT_S:
            self._estop_s = now_s
            return self._account(ESTOP_FRAME, now_s)
        if now_s < self.pace.ready_s:
            return b""
        frame = self._next_frame(state, status, upload, now_s)
        return b"" if frame is None else self._account(encode_frame(frame, Sender.HOST), now_s)

    def due_times_s(self, state: LinkState, now_s: float) -> Iterator[float]:
        """Times at which a frame may be due; one that is past waits for bytes or an order."""
        if self.estop_wanted:
            yield self._estop_s + ESTOP_REPEAT_S
        if now_s < self.pace.ready_s:
            yield self.pace.ready_s
        elif state.is_asking or state is LinkState.VERIFY:
            yield self._sessions.next_hello_s(state is LinkState.LINK_LOST)
        else:
            yield self.clock.question_s
            yield from self.commands.due_times_s()

    def _next_frame(
        self, state: LinkState, status: Status | None, upload: Upload | None, now_s: float
    ) -> WireFrame | None:
        if state.is_asking:
            return self._next_hello(state, now_s)
        if state is LinkState.VERIFY:
            return self._next_confirm(state, now_s)
        clock = self.clock.estimate
        urgent = self.freshest.take(now_s, clock) or self.clock.next_question(now_s)
        self._counters.stale = self.freshest.stale
        if urgent is not None:
            return self._frame(urgent)
        if status is not None and state is not LinkState.REBOOTED:
            self._fill_window(status, upload, now_s)
        pending = self.window.next_frame(now_s)
        if pending is not None:
            self._counters.retransmits += pending.sent_again
            return WireFrame(
                kind=pending.kind,
                session=self._sessions.present,
                payload=pending.payload,
                sequence=pending.sequence,
                reliable=True,
            )
        return None

    def _fill_window(self, status: Status, upload: Upload | None, now_s: float) -> None:
        command = self.commands.next(status, upload, self.window.idle, now_s)
        if command is not None:
            self.window.add(command.TYPE, command.pack())
        if upload is None or self.window.has_unsent():
            return
        batch = upload.next_batch()
        if batch is None:
            return
        payload = batch.pack()
        if self.window.room_for(len(payload)):
            self.window.add(batch.TYPE, payload)
            upload.sent(batch)

    def _next_hello(self, state: LinkState, now_s: float) -> WireFrame | None:
        if state is LinkState.LINK_LOST and self._sessions.foreigner_speaks(now_s):
            return None
        return self._frame(Hello(SCHEMA_HASH)) if self._sessions.hello_due(now_s) else None

    def _next_confirm(self, state: LinkState, now_s: float) -> WireFrame | None:
        """Return the challenge; HELLO again if it, or the robot's report, was lost."""
        if self.nonce is None:
            return self._next_hello(state, now_s)
        nonce, self.nonce = self.nonce, None
        return self._frame(Confirm(nonce))

    def _frame(self, message: Hello | Confirm | Lease | PoseFix | TimeSync) -> WireFrame:
        return WireFrame(kind=message.TYPE, session=self._sessions.present, payload=message.pack())

    def _account(self, data: bytes, now_s: float) -> bytes:
        self._counters.frames_sent += 1
        self._counters.bytes_sent += len(data)
        self.pace.sent(len(data), now_s)
        return data

"""The send window with go-back-N, and the round-trip times behind its timeout.

- Reliable frames carry sequence numbers modulo 256; the robot takes them in order and acknowledges
  with the next number expected.
- At most ``window`` bytes of the wire may be unacknowledged; a NAK or a timeout sends all again
  from the oldest on.
- Sequence numbers start at 0 in every session. Seconds.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

from firmware_protocol.wire.framing import wire_bytes

SEQUENCE_MODULUS: Final = 256
RTO_MIN_S: Final = 0.025
RTO_MAX_S: Final = 1.0


class RttEstimate:
    """Smoothed round-trip time and timeout, by Jacobson (1988) and RFC 6298."""

    def __init__(self) -> None:
        self.smoothed_s = 0.0
        self.variation_s = 0.0
        self.samples = 0
        self._backoff = 1.0

    def add(self, rtt_s: float) -> None:
        """Take a round trip of a frame sent only once (Karn's rule)."""
        if self.samples == 0:
            self.smoothed_s, self.variation_s = rtt_s, rtt_s / 2.0
        else:
            self.variation_s += (abs(rtt_s - self.smoothed_s) - self.variation_s) / 4.0
            self.smoothed_s += (rtt_s - self.smoothed_s) / 8.0
        self.samples += 1
        self._backoff = 1.0

    def back_off(self) -> None:
        """After a timeout, double the next one."""
        self._backoff = min(64.0, self._backoff * 2.0)

    @property
    def timeout_s(self) -> float:
        """Timeout of an acknowledgement, in [25 ms, 1 s]; 100 ms before any sample."""
        base = 0.1 if self.samples == 0 else self.smoothed_s + 4.0 * self.variation_s
        return min(RTO_MAX_S, max(RTO_MIN_S, base) * self._backoff)


@dataclass(slots=True)
class PendingFrame:
    """A reliable frame not yet acknowledged."""

    sequence: int
    kind: int
    payload: bytes
    sent_s: float | None = None
    sent_again: bool = False

    @property
    def wire_bytes(self) -> int:
        """Its size on the wire."""
        return wire_bytes(len(self.payload))


class SendWindow:
    """Reliable frames in flight and those to send next."""

    def __init__(self, window_bytes: int) -> None:
        self.window_bytes = window_bytes
        self.rtt = RttEstimate()
        self.timeouts = 0
        self.next_sequence = 0
        """Number that the receiver expects once it has everything."""
        self._pending: deque[PendingFrame] = deque()
        self._sent = 0
        """Number of ``_pending``, from the left, in flight."""
        self._timer_s = 0.0
        self._quiet_until_s = 0.0

    @property
    def bytes_pending(self) -> int:
        """Bytes of all unacknowledged frames, sent or not."""
        return sum(frame.wire_bytes for frame in self._pending)

    @property
    def idle(self) -> bool:
        """True if everything is acknowledged."""
        return not self._pending

    def room_for(self, payload_bytes: int) -> bool:
        """True if one more frame fits into the window (one frame always does)."""
        if not self._pending:
            return True
        return self.bytes_pending + wire_bytes(payload_bytes) <= self.window_bytes

    def add(self, kind: int, payload: bytes) -> None:
        """Number a frame and queue it last."""
        self._pending.append(PendingFrame(self.next_sequence, kind, payload))
        self.next_sequence = (self.next_sequence + 1) % SEQUENCE_MODULUS

    def next_frame(self, now_s: float) -> PendingFrame | None:
        """The next frame to put on the wire; it counts as sent."""
        if self._sent >= len(self._pending):
            return None
        frame = self._pending[self._sent]
        if frame.sent_s is not None:
            frame.sent_again = True
        frame.sent_s = now_s
        if self._sent == 0:
            self._timer_s = now_s
        self._sent += 1
        return frame

    def has_unsent(self) -> bool:
        """True if :meth:`next_frame` has one."""
        return self._sent < len(self._pending)

    def acknowledge(self, expected: int, now_s: float) -> int:
        """Take the receiver's next number; return the number of frames acknowledged.

        A number of no frame in flight changes nothing.
        """
        in_flight = [frame.sequence for frame in self._pending if frame.sent_s is not None]
        ends = [(sequence + 1) % SEQUENCE_MODULUS for sequence in in_flight]
        if expected not in ends:
            return 0
        count = ends.index(expected) + 1
        for _ in range(count):
            frame = self._pending.popleft()
            if not frame.sent_again and frame.sent_s is not None:
                self.rtt.add(now_s - frame.sent_s)
        self._sent = max(0, self._sent - count)
        self._timer_s = now_s
        return count

    def complained(self, now_s: float) -> None:
        """Send all again, once a round trip: the receiver misses its next frame."""
        if self._sent == 0 or now_s < self._quiet_until_s:
            return
        self._go_back(now_s)

    def tick(self, now_s: float) -> None:
        """Send all again if the oldest acknowledgement is overdue."""
        if self._sent and now_s - self._timer_s >= self.rtt.timeout_s:
            self.timeouts += 1
            self.rtt.back_off()
            self._go_back(now_s)

    def deadline_s(self) -> float:
        """Time of the timeout; infinity while nothing is in flight."""
        return self._timer_s + self.rtt.timeout_s if self._sent else math.inf

    def _go_back(self, now_s: float) -> None:
        self._sent = 0
        self._timer_s = now_s
        # complaints about frames in flight arrive within about one round trip
        self._quiet_until_s = now_s + max(0.005, self.rtt.smoothed_s)

"""The host's sessions: their numbers, the times of HELLO, and other hosts on the line.

- A session's number is random, never one of the last sixteen, which distinguishes our late frames
  from a stranger's.
- HELLO is repeated at intervals that grow by half, until the robot reports in the session; to a
  robot of another schema every few seconds.
- The robot answers a stranger's HELLO and stays with ours. Only its messages in an open session
  show that another host has returned the challenge.
- That host has the robot while the count of frames in STATUS grows. This host is silent meanwhile,
  then takes the robot back.
- Seconds of the host's monotonic clock.
"""

from __future__ import annotations

import math
import random
from collections import deque
from typing import Final

from firmware_protocol.wire.errors import RemoteError
from firmware_protocol.wire.framing import WireFrame
from firmware_protocol.wire.messages import MessageType, Status

HELLO_FIRST_S: Final = 0.05
HELLO_LAST_S: Final = 0.5
HELLO_REFUSED_S: Final = 3.0
"""Interval of HELLO to a robot of another schema."""
FOREIGN_S: Final = 2.5
"""Silence of another host, which sends TIMESYNC once a second, before the robot is free."""
STRAY_TOLD_S: Final = 1.0
"""Least interval of reports on stray HELLOs."""
_REMEMBERED: Final = 16
_OPENING: Final = (MessageType.HELLO_ACK, MessageType.CHALLENGE)
"""Messages of the robot in a session that is not open."""


class HostSessions:
    """The present session, and our knowledge of others."""

    def __init__(self, rng: random.Random) -> None:
        self.present = 0
        self.stray_hellos = 0
        """Answers of the robot to HELLOs that were none of ours."""
        self._rng = rng
        self._own: deque[int] = deque(maxlen=_REMEMBERED)
        self._told_hellos = 0
        self._told_s = -math.inf
        self._foreign_s = -math.inf
        self._foreign: int | None = None
        self._frames: int | None = None
        """Frames that the robot had taken at its last report in that session."""
        self._hello_s = 0.0
        self._wait_s = HELLO_FIRST_S

    def renew(self, now_s: float) -> None:
        """Begin another session; its first HELLO is due at once."""
        self._own.append(self.present)
        while self.present in self._own:
            self.present = self._rng.randrange(1, 1 << 16)
        self._hello_s = now_s
        self._wait_s = HELLO_FIRST_S

    def is_late(self, frame: WireFrame, now_s: float) -> bool:
        """True if a frame of another session is one of ours; a stranger's is examined."""
        if frame.session in self._own:
            return True
        if frame.kind == MessageType.HELLO_ACK:
            self.stray_hellos += 1
        if frame.kind not in _OPENING:
            self._look_at(frame, now_s)
        return False

    def _look_at(self, frame: WireFrame, now_s: float) -> None:
        if frame.session != self._foreign:
            self._foreign, self._frames, self._foreign_s = frame.session, None, now_s
        if frame.kind != MessageType.STATUS:
            return
        try:
            frames = Status.unpack(frame.payload).counters.frames
        except RemoteError:
            return  # another schema's: its count is unknown
        if self._frames not in (None, frames):
            self._foreign_s = now_s
        self._frames = frames

    def stray_is_news(self, now_s: float) -> bool:
        """True, once, if a stray HELLO is news to the user."""
        more = self.stray_hellos != self._told_hellos
        self._told_hellos = self.stray_hellos
        if not more or now_s - self._told_s < STRAY_TOLD_S:
            return False
        self._told_s = now_s
        return True

    def foreigner_speaks(self, now_s: float) -> bool:
        """True if the robot just heard another host in an open session."""
        return now_s - self._foreign_s < FOREIGN_S

    def hello_due(self, now_s: float) -> bool:
        """True if HELLO is due now; lengthens the interval by half."""
        if now_s < self._hello_s:
            return False
        self._hello_s = now_s + self._wait_s
        self._wait_s = min(HELLO_LAST_S, 1.5 * self._wait_s)
        self._frames = None  # the robot counts this HELLO too
        return True

    def next_hello_s(self, lost: bool) -> float:
        """Time of the next HELLO; a lost link's waits until another host is silent."""
        return max(self._hello_s, self._foreign_s + FOREIGN_S) if lost else self._hello_s

    def wait_long(self, now_s: float) -> None:
        """Ask an unusable robot again, but seldom."""
        self._hello_s = now_s + HELLO_REFUSED_S

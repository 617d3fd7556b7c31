"""The host's sessions: their numbers, when HELLO goes out, and who else is on the line.

- A session's number is drawn at random and never one of the last sixteen: late frames of an own
  session are told from those of another host.
- HELLO is repeated, each time a half later, until a robot answers. While another host speaks, a
  host that lost its robot keeps still.
- Seconds of the host's monotonic clock.
"""

from __future__ import annotations

import math
import random
from collections import deque
from typing import Final

from firmware_protocol.framing import Frame

HELLO_FIRST_S: Final = 0.05
HELLO_LAST_S: Final = 0.5
FOREIGN_S: Final = 1.0
_REMEMBERED: Final = 16


class HostSessions:
    """The present session, and what is known of the others."""

    def __init__(self, rng: random.Random) -> None:
        self.present = 0
        self._rng = rng
        self._own: deque[int] = deque(maxlen=_REMEMBERED)
        self._foreign_s = -math.inf
        self._hello_s = 0.0
        self._wait_s = HELLO_FIRST_S

    def renew(self, now_s: float) -> None:
        """Another session; its first HELLO is due at once."""
        self._own.append(self.present)
        while self.present in self._own:
            self.present = self._rng.randrange(1, 1 << 16)
        self._hello_s = now_s
        self._wait_s = HELLO_FIRST_S

    def is_late(self, frame: Frame, now_s: float) -> bool:
        """Whether a frame of another session is one of ours; a stranger's is remembered."""
        if frame.session in self._own:
            return True
        self._foreign_s = now_s
        return False

    def foreigner_speaks(self, now_s: float) -> bool:
        """Whether another host's session was heard just now."""
        return now_s - self._foreign_s < FOREIGN_S

    def hello_due(self, now_s: float) -> bool:
        """Whether to say HELLO now; the next is due a half later than this one was."""
        if now_s < self._hello_s:
            return False
        self._hello_s = now_s + self._wait_s
        self._wait_s = min(HELLO_LAST_S, 1.5 * self._wait_s)
        return True

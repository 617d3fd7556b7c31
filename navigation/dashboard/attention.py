"""One viewer's attention: its news, and whether it could take a picture.

Pictures are sent on credit: at most `CREDITS` are on their way, and each one drawn by the page
brings its credit back.
"""

from __future__ import annotations

import asyncio
import math
from collections import deque
from typing import Final

from navigation.dashboard.admission.access import Role

CREDITS: Final = 2
NOTICES: Final = 8
EARLY: Final = 0.75
"""Pictures come unevenly: one that is early by less than a quarter of the pause is sent."""


class Attention:
    """A viewer as the hub sees it; ``number`` counts viewers up, ``key`` is empty until it joins.

    ``displaced`` is set when it has to leave for another.
    """

    def __init__(self, role: Role = Role.OPERATOR, number: int = 0) -> None:
        self.role, self.number = role, number
        self.displaced = asyncio.Event()
        self.key = ""
        self.is_watching = False
        self.kind = "picture"
        """``picture``, from above, or ``camera``, as it was taken."""
        self.width_px = 0
        self.wants_heat = False
        self.news = asyncio.Event()
        self.notices: deque[str] = deque(maxlen=NOTICES)
        self._credits = CREDITS
        self._shown_s = -math.inf

    @property
    def sees(self) -> tuple[str, int]:
        """Kind and width of its pictures."""
        return self.kind, self.width_px

    def wants_picture(self, now_s: float, pause_s: float) -> bool:
        """True if a new picture could be sent now, ``pause_s`` after the last one."""
        due = now_s - self._shown_s >= EARLY * pause_s
        return self.is_watching and self._credits > 0 and due

    def shown(self, now_s: float) -> None:
        """Note that a picture was sent."""
        self._credits -= 1
        self._shown_s = now_s

    def drawn(self) -> None:
        """Note that the page has drawn a picture."""
        self._credits = min(CREDITS, self._credits + 1)

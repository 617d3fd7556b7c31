"""How long bytes take on the line, and when it is free again: so that one frame waits, not ten.

What lies in the operating system cannot be taken back, and an emergency stop would wait behind
it. Seconds; 10 bits a byte.
"""

from __future__ import annotations

import math
from typing import Final

PREFETCH_S: Final = 0.001
"""The next frame may be handed out so long before the line is free."""


class LinePace:
    """A line at ``baud``; None takes no time."""

    def __init__(self, baud: int | None) -> None:
        self.baud = baud
        self._free_s = -math.inf

    def reset(self) -> None:
        """A line on which nothing is under way."""
        self._free_s = -math.inf

    def wire_s(self, count: int) -> float:
        """How long so many bytes take."""
        return 0.0 if self.baud is None else 10.0 * count / self.baud

    def sent(self, count: int, now_s: float) -> None:
        """So many bytes were handed out, behind what is still under way."""
        self._free_s = max(now_s, self._free_s) + self.wire_s(count)

    @property
    def ready_s(self) -> float:
        """When the next frame may be handed out."""
        return self._free_s - PREFETCH_S

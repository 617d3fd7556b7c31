"""Transmission time of bytes, so that at most one frame waits for the line.

Bytes in the operating system cannot be taken back; an emergency stop would wait behind them.
Seconds; 10 bits a byte.
"""

from __future__ import annotations

import math
from typing import Final

PREFETCH_S: Final = 0.001
"""Time before the line is free at which the next frame may be handed out."""


class LinePace:
    """A line at ``baud``; None takes no time."""

    def __init__(self, baud: int | None) -> None:
        self.baud = baud
        self._free_s = -math.inf

    def reset(self) -> None:
        """Nothing is under way on the line."""
        self._free_s = -math.inf

    def wire_s(self, count: int) -> float:
        """Time for ``count`` bytes."""
        return 0.0 if self.baud is None else 10.0 * count / self.baud

    def sent(self, count: int, now_s: float) -> None:
        """Note ``count`` bytes handed out, behind those under way."""
        self._free_s = max(now_s, self._free_s) + self.wire_s(count)

    @property
    def ready_s(self) -> float:
        """Time at which the next frame may be handed out."""
        return self._free_s - PREFETCH_S

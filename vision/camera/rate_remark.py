"""Remark on a rate other than the requested one, without a new sentence for each picture.

Rules
- A rate is wrong if it is off by more than a tenth, and right again within a twentieth.
- While it is wrong, the sentence keeps its number for a minute.
"""

from __future__ import annotations

from typing import Final

OFF: Final = 0.10
RIGHT: Final = 0.05
EVERY_S: Final = 60.0


class RateRemark:
    """Remark on a measured rate; empty if it is as requested, or nothing was requested."""

    def __init__(self, wanted_hz: float | None) -> None:
        self._wanted_hz = wanted_hz
        self._said = ""
        self._said_s = 0.0

    def of(self, rate_hz: float, now_s: float) -> str:
        """Return the remark at ``now_s`` for a measured rate (0.0: not yet known)."""
        wanted_hz = self._wanted_hz
        if wanted_hz is None or rate_hz <= 0.0:
            return self._said
        off = abs(rate_hz - wanted_hz) / wanted_hz
        if off <= (RIGHT if self._said else OFF):
            self._said = ""
        elif not self._said or now_s - self._said_s >= EVERY_S:
            self._said = f"asked for {wanted_hz:g} frames/s, gets {rate_hz:.1f}"
            self._said_s = now_s
        return self._said

"""What to say of a rate that is not the one asked for, without a new sentence a picture.

Rules
- Too slow, or too fast, is a rate that is off by more than a tenth; it is as asked again when it is
  off by less than a twentieth.
- While it is off, the sentence keeps its number for a minute, unless the rate becomes right.
"""

from __future__ import annotations

from typing import Final

OFF: Final = 0.10
RIGHT: Final = 0.05
EVERY_S: Final = 60.0


class RateRemark:
    """The sentence on a measured rate; empty while it is as asked, or nothing was asked."""

    def __init__(self, wanted_hz: float | None) -> None:
        self._wanted_hz = wanted_hz
        self._said = ""
        self._said_s = 0.0

    def of(self, rate_hz: float, now_s: float) -> str:
        """The sentence at ``now_s``, for the rate measured lately (0.0: not yet known)."""
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

"""Another device's clock converted to ours, from the arrivals of its messages.

The least difference between arrival and stamp is the clocks' offset plus the shortest delay. It is
relaxed slowly, as clocks drift. Seconds. Source: the minimum filter of one-way delays (Moon,
Skelly, Towsley 1999).
"""

from __future__ import annotations

import math
from typing import Final

DRIFT: Final = 2e-3
"""Largest share of the time by which two clocks part: a ceramic resonator's 1e-3, twice."""


class ArrivalClock:
    """Conversion of a sender's stamps into times of our clock, never later than the arrival."""

    def __init__(self) -> None:
        self._offset_s = math.inf
        self._stamp_s = -math.inf

    def time_of(self, stamp_s: float, arrived_s: float) -> float:
        """Return when the message stamped ``stamp_s`` was sent, up to the shortest delay."""
        passed_s = max(0.0, stamp_s - self._stamp_s) if math.isfinite(self._stamp_s) else 0.0
        self._stamp_s = max(stamp_s, self._stamp_s)
        self._offset_s = min(self._offset_s + DRIFT * passed_s, arrived_s - stamp_s)
        return min(stamp_s + self._offset_s, arrived_s)  # rounding may exceed the arrival

    @property
    def offset_s(self) -> float:
        """Our clock minus the sender's, plus the shortest delay; infinite before a message."""
        return self._offset_s

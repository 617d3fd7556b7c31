"""Speed limit for late pictures.

Between an event and rest the robot drives on for the picture's latency, the loop's reaction and
braking. This distance stays what it is at full speed with a camera no later than
``FREE_LATENCY_S``. Metres, seconds.
"""

from __future__ import annotations

import math
from typing import Final

from navigation.mission.trust import Trust
from navigation.witness.evidence import FREE_LATENCY_S

REACTION_S: Final = 0.07
"""A control cycle of 50 ms at most, and the order's way over the line."""
MEASURE_AGAIN_S: Final = 10.0
"""Time after which a camera that was too late is measured again."""
WORTH_A_PLAN: Final = 0.85
"""A robot that should drive at less than this share of its plan's speed gets a slower plan."""


def speed_with(latency_s: float, full_m_s: float, braking_m_s2: float) -> float:
    """Highest speed at which the stopping distance is no longer than usual."""
    if latency_s <= FREE_LATENCY_S:
        return full_m_s
    usual_m = full_m_s * (REACTION_S + FREE_LATENCY_S) + full_m_s**2 / (2.0 * braking_m_s2)
    late = braking_m_s2 * (REACTION_S + latency_s)
    return math.sqrt(late * late + 2.0 * braking_m_s2 * usual_m) - late


class LateCamera:
    """Measures a late camera again now and then, with a turn of the robot."""

    def __init__(self) -> None:
        self._again_s: float | None = None

    def measured(self) -> None:
        """Forget the last measurement, as the robot begins to turn."""
        self._again_s = None

    def look(self, now_s: float, late_s: float, limit_s: float, trust: Trust) -> float | None:
        """Latency that counts; None if it is about to be measured again.

        A late camera makes its robot doubted, so that it turns.
        """
        if late_s <= limit_s:
            self._again_s = None
            return late_s
        if self._again_s is None:
            self._again_s = now_s + MEASURE_AGAIN_S
            trust.doubt("the camera's pictures were too late")
        return late_s if now_s < self._again_s else None

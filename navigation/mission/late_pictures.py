"""Speed limit for late pictures.

From an event to rest the robot drives for the picture's latency, the loop's reaction and the
braking. The limit keeps this distance at that of full speed with latency ``FREE_LATENCY_S``.
Metres, seconds.
"""

from __future__ import annotations

import math
from typing import Final

from navigation.mission.traffic import TrafficLimits
from navigation.mission.trust import Trust
from navigation.witness.evidence import FREE_LATENCY_S

REACTION_S: Final = 0.07
"""A control cycle of 50 ms at most, and the order's time on the line."""
MEASURE_AGAIN_S: Final = 10.0
"""Time after which a late camera is measured again."""
WORTH_A_PLAN: Final = 0.85
"""A robot that should drive slower than this share of its plan's speed gets a new plan."""


def speed_with(latency_s: float, full_m_s: float, braking_m_s2: float) -> float:
    """Highest speed at which the stopping distance is no longer than usual."""
    if latency_s <= FREE_LATENCY_S:
        return full_m_s
    usual_m = full_m_s * (REACTION_S + FREE_LATENCY_S) + full_m_s**2 / (2.0 * braking_m_s2)
    late = braking_m_s2 * (REACTION_S + latency_s)
    return math.sqrt(late * late + 2.0 * braking_m_s2 * usual_m) - late


def speed_allowed(latency_s: float, limits: TrafficLimits) -> float:
    """Speed of a robot with these limits, in m/s."""
    return speed_with(latency_s, limits.speed_m_s, limits.acceleration_m_s2)


class LateCamera:
    """Time at which a late camera is measured again, with a turn of the robot."""

    def __init__(self) -> None:
        self._again_s: float | None = None

    def measured(self) -> None:
        """Note that a measurement begins."""
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

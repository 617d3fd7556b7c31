"""How fast the robot may drive with pictures that are late.

From the moment that something happens until the robot stands, it covers the way of the picture's
latency, of the loop's reaction and of the brakes. That way stays what it is at full speed with a
camera that is no later than ``FREE_LATENCY_S``. Metres, seconds.
"""

from __future__ import annotations

import math
from typing import Final

from navigation.witness.evidence import FREE_LATENCY_S

REACTION_S: Final = 0.07
"""A control cycle of 50 ms at most, and the order's way over the line."""
WORTH_A_PLAN: Final = 0.85
"""A robot that should drive at less than this share of its plan's speed gets a slower plan."""


def speed_with(latency_s: float, full_m_s: float, braking_m_s2: float) -> float:
    """The highest speed at which the stopping way is no longer than the usual one."""
    if latency_s <= FREE_LATENCY_S:
        return full_m_s
    usual_m = full_m_s * (REACTION_S + FREE_LATENCY_S) + full_m_s**2 / (2.0 * braking_m_s2)
    late = braking_m_s2 * (REACTION_S + latency_s)
    return math.sqrt(late * late + 2.0 * braking_m_s2 * usual_m) - late

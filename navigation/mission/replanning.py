"""Reasons for a new plan while a robot drives; None if the present plan may stay.

Metres, seconds.
"""

from __future__ import annotations

from navigation.mission.cycle import PilotSettings
from navigation.mission.late_pictures import WORTH_A_PLAN
from navigation.mission.traffic import Encounter


def nearer_obstacle(clearance_m: float, planned_m: float, settings: PilotSettings) -> str | None:
    """Reason if a new scene leaves the path ``clearance_m`` instead of ``planned_m``.

    The robot no longer fits, or something is nearer than ``replan_distance_m`` and, beyond the
    measurement's slack, nearer than planned.
    """
    limits = settings.limits
    nearer_m = planned_m - limits.clearance_slack_m
    least_m = max(limits.robot_radius_m, min(settings.replan_distance_m, nearer_m))
    if clearance_m >= least_m:
        return None
    return f"an obstacle leaves the path {clearance_m:.3f} m of clearance: planning again"


def later_pictures(latency_s: float, allowed_m_s: float, planned_m_s: float) -> str | None:
    """Reason if pictures allow much less speed than the present plan has."""
    if allowed_m_s >= WORTH_A_PLAN * planned_m_s:
        return None
    return f"the camera's pictures are {latency_s:.2f} s old: planning more slowly"


def robot_ahead(met: Encounter | None) -> str | None:
    """Reason if another robot is at rest in the path."""
    if met is None or not met.stands:
        return None
    return f"{met.sentence}: planning around it"

"""Requests to the planner: one at a time, and none while the robot has to hold.

Metres, seconds.
"""

from __future__ import annotations

import math

from navigation.mission.cycle import PlanAnswer, PlanRequest, Sight
from navigation.mission.late_pictures import speed_allowed
from navigation.mission.mission import MissionProgress
from navigation.mission.traffic import TrafficLimits, discs_to_avoid


class PlanRequests:
    """The open request, and the time before which no other is made.

    ``settle_s``: time that the cause of a hold must be gone before the next plan.
    """

    def __init__(self, settle_s: float) -> None:
        self._settle_s = settle_s
        self._number = 0
        self._open: PlanRequest | None = None
        self._not_before_s = -math.inf
        self._clear_since_s: float | None = None

    def hold(self, until_s: float | None = None) -> None:
        """Note a cause to hold, and with ``until_s`` a pause however soon the cause is gone."""
        self._clear_since_s = None
        if until_s is not None:
            self._not_before_s = until_s

    def is_settled(self, now_s: float) -> bool:
        """Note that no cause to hold is left; True if that has lasted and no pause is left."""
        if self._clear_since_s is None:
            self._clear_since_s = now_s
        settled = now_s - self._clear_since_s >= self._settle_s
        return settled and now_s >= self._not_before_s

    def make(
        self, now_s: float, sight: Sight, mission: MissionProgress, limits: TrafficLimits
    ) -> PlanRequest | None:
        """Ask for a path of the remaining mission; None if a request is open or it is too early."""
        if self._open is not None or now_s < self._not_before_s:
            return None
        if sight.pose is None or sight.scene_revision == 0:
            return None
        self._number += 1
        self._open = PlanRequest(
            self._number,
            sight.pose,
            mission.remaining,
            sight.scene_revision,
            any_order=mission.any_order and mission.visited == 0,
            avoid=discs_to_avoid(sight.pose[:2], sight.others, limits),
            speed_m_s=speed_allowed(sight.evidence.longest_latency_s, limits),
        )
        return self._open

    def close(self, answer: PlanAnswer | None) -> PlanRequest | None:
        """Close and return the open request if this is its answer."""
        if answer is None or self._open is None or answer.id != self._open.id:
            return None
        asked, self._open = self._open, None
        return asked

    def drop(self) -> None:
        """Forget the open request; its answer will be ignored."""
        self._open = None

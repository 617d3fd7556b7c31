"""Robots that move without permission, and their possible places in the next seconds.

A robot runs away if it is faster than its brakes allow since its permit ended, or strays from what
it was sent by more than its path allows. A silent robot that moves may run away: its lease has yet
to show if it obeys. Speed and bend are assumed constant. Metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from navigation.fleet.members import Member
from navigation.fleet.releases import Held
from navigation.mission.mission import State
from navigation.mission.traffic import LOST_S, STANDING_M_S
from planner.borders.polyline import distance_to_polyline
from planner.scene import FloatArray


@dataclass(frozen=True, slots=True)
class Runaway:
    """Present place, motion and body of a runaway."""

    name: str
    x_m: float
    y_m: float
    vx_m_s: float
    vy_m_s: float
    turn_rate_rad_s: float
    radius_m: float
    certain: bool = True
    """True if it does run away."""

    def places(self, times_s: FloatArray) -> FloatArray:
        """Its centre at these times from now, (n, 2)."""
        half = 0.5 * self.turn_rate_rad_s * times_s
        chords = (self.vx_m_s + 1j * self.vy_m_s) * times_s * np.sinc(half / np.pi)
        moved = chords * np.exp(1j * half)
        return np.column_stack([self.x_m + moved.real, self.y_m + moved.imag])


def runaways_of(members: Mapping[str, Member], held: Mapping[str, Held]) -> list[Runaway]:
    """Seen robots that run away, or may."""
    found = []
    for name, one in members.items():
        vx, vy, turn = one.velocity
        if one.pose is None or one.pose_age_s > LOST_S or math.hypot(vx, vy) < STANDING_M_S:
            continue
        certain = not one.obeys or _strays(one, held.get(name))
        if not (certain or one.is_silent):
            continue
        x, y = one.pose[0] + vx * one.pose_age_s, one.pose[1] + vy * one.pose_age_s
        found.append(Runaway(name, x, y, vx, vy, turn, one.radius_m, certain))
    return found


def _seen_from(one: Member, held: Held) -> int:
    """Number of the promised place behind which the camera can still see the robot.

    Its report is newer than its pose.
    """
    first = max(0, held.executed - 1)
    late_m = one.limits.speed * one.pose_age_s
    while first > 0 and late_m > 0.0:
        late_m -= math.dist(held.promise.points[first - 1], held.promise.points[first])
        first -= 1
    return first


def _strays(one: Member, held: Held | None) -> bool:
    if held is None or held.broken or held.errand or one.pose is None:
        return False
    if one.state not in (State.DRIVING, State.HOLDING):
        return False
    last = max(held.sent, held.executed)
    sent = held.promise.points[_seen_from(one, held) : last + 1]
    return distance_to_polyline(sent, one.pose[:2]) > one.max_deviation_m

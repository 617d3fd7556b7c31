"""Leases and stops of a cycle, sent as orders on the link.

The lease is renewed at least every ``LEASE_EVERY_S``, and at once if it changes.
"""

from __future__ import annotations

import math
from typing import Final

from navigation.config import Config
from navigation.link.robot_link import RobotLink
from navigation.mission.cycle import Orders

LEASE_EVERY_S: Final = 0.08
STOP_GRACE_S: Final = 0.35
"""Beyond lease and brakes, for the last words on the wire."""


class RobotOrders:
    """The robot's present lease, and the time by which it is at rest without."""

    def __init__(self, link: RobotLink, config: Config) -> None:
        self._link, self._config = link, config
        self._permitted = False
        self._leased_s = -math.inf
        self.stands_s = -math.inf
        """When a robot without a lease should be at rest, even if no order reached it."""

    def halt(self, now_s: float) -> None:
        """Withdraw the lease: the robot begins to brake."""
        if self._permitted:
            self._link.lease(permit=False)
            self._link.pause()
            self._withdrawn(now_s)

    def carry_out(self, orders: Orders, now_s: float, pose_age_s: float) -> None:
        """Send a cycle's lease and stops; an emergency stop is sent alone."""
        if orders.estop:
            link = self._link.snapshot()
            if link.leaving_estop or not link.estopped:
                self._link.estop()
            return
        if orders.rearm:
            self._link.reset_estop()
        if orders.halt:
            self._link.clear()
        if orders.permit != self._permitted or now_s - self._leased_s >= LEASE_EVERY_S:
            self._link.lease(orders.permit, pose_age_s, self._config.safety.lease_s)
            if self._permitted and not orders.permit:
                self._withdrawn(now_s)
            self._permitted, self._leased_s = orders.permit, now_s

    def _withdrawn(self, now_s: float) -> None:
        self._permitted = False
        robot = self._config.robot
        braking_s = robot.speed_m_s / robot.acceleration_m_s2
        self.stands_s = now_s + self._config.safety.lease_s + braking_s + STOP_GRACE_S

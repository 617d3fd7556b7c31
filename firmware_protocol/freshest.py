"""Lease and pose: sent once each, and a newer one replaces one that still waits.

Both carry an age, which goes on until they leave. Seconds of the host's clock.
"""

from __future__ import annotations

import math

from firmware_protocol.framing import wire_bytes
from firmware_protocol.line_pace import LinePace
from firmware_protocol.messages import Lease, LeaseFlag, PoseFix


class Freshest:
    """What waits to be sent of each, and when the pose sent last was seen."""

    def __init__(self) -> None:
        self.pose_captured_s = -math.inf
        self._lease: tuple[Lease, float] | None = None
        self._pose: tuple[PoseFix, float] | None = None

    def give_lease(self, lease: Lease, now_s: float) -> None:
        """LocalError where a value does not fit the wire."""
        lease.pack()
        self._lease = (lease, now_s)

    def give_pose(self, fix: PoseFix, captured_s: float) -> None:
        """LocalError where a value does not fit the wire."""
        fix.pack()
        self._pose = (fix, captured_s)

    def forget(self) -> None:
        """Nothing waits any more."""
        self._lease = self._pose = None

    def take(self, now_s: float, pace: LinePace) -> Lease | PoseFix | None:
        """What goes out now, the lease first, with its age when it has arrived."""
        if self._lease is not None:
            lease, given_s = self._lease
            self._lease = None
            return Lease(lease.ttl_s, lease.flags, lease.pose_age_s + (now_s - given_s))
        if self._pose is not None:
            fix, self.pose_captured_s = self._pose
            self._pose = None
            on_the_wire_s = pace.wire_s(wire_bytes(PoseFix.LAYOUT.size))
            age_s = max(0.0, now_s - self.pose_captured_s) + on_the_wire_s
            return PoseFix(fix.x_m, fix.y_m, fix.heading_rad, age_s)
        return None


def lease_of(ttl_s: float, permit: bool, pose_age_s: float, odometry: bool) -> Lease:
    """A lease in the words of the control loop."""
    flags = LeaseFlag.PERMIT * permit | LeaseFlag.ODOMETRY * odometry
    return Lease(ttl_s, LeaseFlag(flags), pose_age_s)

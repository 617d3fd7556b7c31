"""Lease and pose: each sent once; a newer one replaces a waiting one.

Both carry a time of the robot's clock, so that they age everywhere. A lease gets the earliest date
within the clock's bound, a pose the best estimate. Nothing is sent while that bound exceeds
``ERROR_MAX_S``. Seconds of the host's clock.
"""

from __future__ import annotations

import math
from typing import Final

from firmware_protocol.host.line.clock_sync import ClockEstimate
from firmware_protocol.wire.messages import Lease, PoseFix

ERROR_MAX_S: Final = 0.05
"""At 0.5 m/s a pose dated so wrong is 25 mm off; leases get shorter by as much."""
_POSE_KEPT_S: Final = 0.5
"""Largest age that the robot accepts."""


class Freshest:
    """The waiting lease and pose, and the last sent pose's capture time."""

    def __init__(self) -> None:
        self.pose_captured_s = -math.inf
        self.stale = 0
        """Poses and leases too old to be sent."""
        self._lease: tuple[Lease, float] | None = None
        self._pose: tuple[PoseFix, float] | None = None

    def give_lease(self, lease: Lease, issued_s: float) -> None:
        """Replace the waiting lease; LocalError if it does not fit the wire."""
        lease.pack()
        self._lease = (lease, issued_s)

    def give_pose(self, fix: PoseFix, captured_s: float) -> None:
        """Replace the waiting pose; LocalError if it does not fit the wire."""
        fix.pack()
        self._pose = (fix, captured_s)

    def forget(self) -> None:
        """Drop both."""
        self._lease = self._pose = None

    def take(self, now_s: float, clock: ClockEstimate) -> Lease | PoseFix | None:
        """Take the next to send, the lease first; None if none waits or the clock is unknown."""
        if self._lease is None and self._pose is None:
            return None
        self._drop_stale(now_s)
        error_s = clock.error_s(now_s)
        if error_s > ERROR_MAX_S:
            return None
        if self._lease is not None:
            (lease, issued_s), self._lease = self._lease, None
            issued_us = clock.robot_us(issued_s - error_s)
            return Lease(lease.ttl_s, lease.flags, lease.pose_age_s, issued_us)
        if self._pose is not None:
            (fix, self.pose_captured_s), self._pose = self._pose, None
            captured_us = clock.robot_us(self.pose_captured_s)
            return PoseFix(fix.x_m, fix.y_m, fix.heading_rad, captured_us)
        return None

    def _drop_stale(self, now_s: float) -> None:
        if self._lease is not None and now_s - self._lease[1] >= self._lease[0].ttl_s:
            self._lease = None
            self.stale += 1
        if self._pose is not None and now_s - self._pose[1] >= _POSE_KEPT_S:
            self._pose = None
            self.stale += 1

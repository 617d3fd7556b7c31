"""The link to one robot: its orders, which real and virtual links carry out in their own time."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from typing import Final, TypeAlias

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.host.events import Event
from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.messages import Lease, LeaseFlag, PoseFix, Waypoint
from firmware_protocol.wire.mission import Mission
from navigation.link.link_snapshot import LinkSnapshot

LATENCIES_KEPT: Final = 10_000

Order: TypeAlias = Callable[[HostConnection, float], None]
"""An order to the host's end of the line, at the time when it is carried out."""


class RobotLink(ABC):
    """Link to one robot; ``clock`` gives monotonic seconds, also for pose capture times."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self.turns = 0
        """Grows while the link works."""
        self.capture_to_wire_s: deque[float] = deque(maxlen=LATENCIES_KEPT)
        """Ages of the pose fixes when sent, seconds, the newest last."""

    @abstractmethod
    def _order(self, order: Order) -> None:
        """Carry an order out, now or in its turn."""

    def upload(
        self,
        mission: int,
        waypoints: Sequence[Waypoint],
        start: bool = True,
        released: int | None = None,
    ) -> Mission:
        """Replace the robot's mission and (``start``) drive it; returns what is sent.

        ``mission`` is an id in [1, 2**32) that is new to this robot, or its present mission's id,
        to continue with the same waypoints. LocalError if a value does not fit on the wire. Start
        needs a lease with permit and a pose within a second. ``released``: number of waypoints sent
        before :meth:`release`; None: all.
        """
        whole = Mission(mission, waypoints)
        self._order(lambda host, now_s: host.upload(whole, now_s, start, released))
        return whole

    def release(self, mission: int, count: int) -> None:
        """Let the first ``count`` waypoints of this mission be sent; never fewer than before."""
        self._order(lambda host, _now_s: host.release(mission, count))

    def pause(self) -> None:
        """Stop under control and keep the mission."""
        self._order(lambda host, _now_s: host.pause())

    def clear(self) -> None:
        """Stop under control and drop the mission."""
        self._order(lambda host, _now_s: host.clear())

    def lease(
        self,
        permit: bool,
        pose_age_s: float = math.inf,
        ttl_s: float = 0.5,
        odometry: bool = False,
    ) -> None:
        """Renew the lease, 10 times a second or more: the loop is alive, and the robot may drive.

        ``pose_age_s`` is the age of the camera's last pose: above 0.5 s the robot holds, unless
        ``odometry`` lets it drive without the camera.
        """
        Lease(ttl_s, LeaseFlag.NONE, pose_age_s).pack()  # an error belongs to the caller's thread
        issued_s = self._clock()  # now, not when the order's turn comes
        self._order(lambda host, _now_s: host.lease(issued_s, ttl_s, permit, pose_age_s, odometry))

    def pose_fix(self, x_m: float, y_m: float, heading_rad: float, captured_s: float) -> None:
        """Send the pose that the camera saw at ``captured_s`` of the clock."""
        PoseFix(x_m, y_m, heading_rad).pack()
        if not math.isfinite(captured_s):
            raise LocalError(f"captured_s = {captured_s}: must be finite")
        self._order(lambda host, _now_s: host.pose_fix(x_m, y_m, heading_rad, captured_s))

    def estop(self) -> None:
        """Stop in an emergency: before every other order, repeated until confirmed."""
        self._order(lambda host, _now_s: host.estop())

    def reset_estop(self) -> None:
        """Leave the emergency stop; the mission is void."""
        self._order(HostConnection.reset_estop)

    @abstractmethod
    def open(self) -> None:
        """Open the port; ``PortError`` if it cannot be used."""

    @abstractmethod
    def close(self) -> None:
        """Close it; the robot stops when its lease ends."""

    @abstractmethod
    def restart(self) -> None:
        """Open again after a failure."""

    @abstractmethod
    def failure(self) -> str | None:
        """Error that ended the link, in words; None while it works."""

    @abstractmethod
    def late_s(self) -> float:
        """Longest delay in waking its thread since the last call."""

    @abstractmethod
    def snapshot(self) -> LinkSnapshot:
        """Present state, ages counted up to now."""

    @abstractmethod
    def events(self) -> list[Event]:
        """Events since the last call, oldest first."""

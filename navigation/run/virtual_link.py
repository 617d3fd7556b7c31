"""The link to the robot in virtual time. Metres, radians, virtual seconds."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from firmware_protocol.host.events import Event
from firmware_protocol.wire.messages import Waypoint
from firmware_protocol.wire.mission import Mission
from navigation.link.link_snapshot import LinkSnapshot, snapshot_of
from navigation.run.troubled_robot import RobotTroubles
from navigation.simulator.virtual_loop import VirtualLoop

LATENCIES_KEPT = 10_000


@dataclass(slots=True)
class VirtualLink:
    """`SerialLink` without thread or port, on the virtual loop's line."""

    loop: VirtualLoop
    troubles: RobotTroubles
    capture_to_wire_s: deque[float] = field(default_factory=lambda: deque(maxlen=LATENCIES_KEPT))
    turns: int = 0

    def open(self) -> None:
        """Open a new session, as a freshly started program does."""
        host = self.loop.host
        self.loop.events.clear()
        host.close("another program opens the port")
        host.open(self.loop.now_s)

    def failure(self) -> str | None:
        """None: no thread can fail."""
        return None

    def late_s(self) -> float:
        """0: no thread can be late."""
        return 0.0

    def restart(self) -> None:
        """Nothing to do."""

    def close(self) -> None:
        """End like a killed program; the robot stops when its lease runs out."""
        self.loop.host.close()

    def upload(
        self,
        mission: int,
        waypoints: Sequence[Waypoint],
        start: bool = True,
        released: int | None = None,
    ) -> Mission:
        """Replace the robot's mission and drive its released part."""
        whole = Mission(mission, waypoints)
        self.loop.host.upload(whole, self.loop.now_s, start, released)
        return whole

    def release(self, mission: int, count: int) -> None:
        """Allow the mission's first ``count`` waypoints to be sent."""
        self.loop.host.release(mission, count)

    def pause(self) -> None:
        """Stop under control and keep the mission."""
        self.loop.host.pause()

    def clear(self) -> None:
        """Stop under control and drop the mission."""
        self.loop.host.clear()

    def lease(self, permit: bool, pose_age_s: float = math.inf, ttl_s: float = 0.5) -> None:
        """Renew the lease, and say whether the robot may drive."""
        self.turns += 1
        self.loop.host.lease(self.loop.now_s, ttl_s, permit, pose_age_s)

    def pose_fix(self, x_m: float, y_m: float, heading_rad: float, captured_s: float) -> None:
        """Send the pose that the camera saw."""
        self.loop.host.pose_fix(x_m, y_m, heading_rad, captured_s)
        self.capture_to_wire_s.append(self.loop.now_s - captured_s)

    def estop(self) -> None:
        """Emergency stop."""
        self.loop.host.estop()

    def reset_estop(self) -> None:
        """Leave the emergency stop."""
        self.loop.host.reset_estop(self.loop.now_s)

    def events(self) -> list[Event]:
        """Return the events since the last call, oldest first."""
        happened, self.loop.events = self.loop.events, []
        return happened

    def snapshot(self) -> LinkSnapshot:
        """Present state."""
        snapshot = snapshot_of(
            self.loop.host, self.loop.now_s, port_fault="the port is not open", estop_waits=False
        )
        if self.troubles.port_broken:
            return replace(snapshot, down_reason="the port virtual broke")
        return snapshot

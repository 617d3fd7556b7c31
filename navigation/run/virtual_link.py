"""The link to the robot in virtual time. Metres, radians, virtual seconds."""

from __future__ import annotations

from firmware_protocol.host.events import Event
from navigation.link.link_snapshot import LinkSnapshot, snapshot_of
from navigation.link.robot_link import Order, RobotLink
from navigation.simulator.virtual_loop import VirtualLoop


class VirtualLink(RobotLink):
    """`SerialLink` without thread or port, on the virtual loop's line."""

    def __init__(self, loop: VirtualLoop) -> None:
        super().__init__(lambda: loop.now_s)
        self.loop = loop

    def _order(self, order: Order) -> None:
        self.turns += 1
        order(self.loop.host, self.loop.now_s)

    def pose_fix(self, x_m: float, y_m: float, heading_rad: float, captured_s: float) -> None:
        """Send the pose that the camera saw."""
        super().pose_fix(x_m, y_m, heading_rad, captured_s)
        self.capture_to_wire_s.append(self.loop.now_s - captured_s)

    def open(self) -> None:
        """Open a new session, as a freshly started program does."""
        host = self.loop.host
        host.close("another program opens the port")
        while host.next_event() is not None:
            pass  # the news of the program before
        self.loop.events.clear()
        host.open(self.loop.now_s)

    def close(self) -> None:
        """End like a killed program; the robot stops when its lease runs out."""
        self.loop.host.close()

    def restart(self) -> None:
        """Nothing to do."""

    def failure(self) -> str | None:
        """None: no thread can fail."""
        return None

    def late_s(self) -> float:
        """0: no thread can be late."""
        return 0.0

    def events(self) -> list[Event]:
        """Return the events since the last call, oldest first."""
        happened, self.loop.events = self.loop.events, []
        return happened

    def snapshot(self) -> LinkSnapshot:
        """Present state."""
        return snapshot_of(
            self.loop.host, self.loop.now_s, port_fault="the port is not open", estop_waits=False
        )

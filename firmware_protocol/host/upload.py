"""The upload of a mission: the waypoints to send next, and a comparison with the robot's.

The robot's reports are the truth: accepted waypoints are never sent again, lost ones are. Each
report's fingerprints of accepted and executed waypoints are compared with the mission's; a
difference ends it. A mission may be released in parts: unreleased waypoints are not sent, and the
robot waits at its last one.
"""

from __future__ import annotations

from typing import Final

from firmware_protocol.wire.messages import Status, StatusFlag, Waypoints
from firmware_protocol.wire.mission import Mission

BATCH: Final = 5
"""Waypoints a frame. Six bring 4 % more waypoints a second and cost every frame behind them 1.4 ms;
see benchmarks/results/link.md."""


class Upload:
    """One mission on its way to one robot."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission
        self.released = len(mission)
        """Number of its waypoints that may be sent."""
        self.on_robot = False
        """True if the robot has reported this mission's id."""
        self.accepted = 0
        self.executed = 0
        self.done = False
        self.announced = False
        """True once the user knows that the robot has everything."""
        self._next = 0
        self._limit = 0

    @property
    def complete(self) -> bool:
        """True if the robot has all waypoints."""
        return self.on_robot and self.accepted == len(self.mission)

    @property
    def blocked(self) -> bool:
        """True if nothing more can be sent before the robot drives."""
        return self.accepted == self._next > 0 and self.next_batch() is None

    def hold_back(self, count: int) -> None:
        """Send only the first ``count`` waypoints before :meth:`release`."""
        self.released = min(count, len(self.mission))

    def release(self, count: int) -> None:
        """Let the first ``count`` waypoints be sent; never fewer than before."""
        self.released = max(self.released, min(count, len(self.mission)))

    def new_session(self) -> None:
        """Void the frames in flight; continue from the robot's next report."""
        self._next = self.accepted
        self._limit = 0

    def see_ack(self, accept_next: int, credit: int) -> None:
        """Take an acknowledgement; a number beyond the sent ones is an old mission's."""
        if self.on_robot and accept_next <= self._next:
            self.accepted = max(self.accepted, accept_next)
            self._limit = accept_next + credit

    def see_status(self, status: Status, credit: int, all_acknowledged: bool) -> str | None:
        """Compare with a report; return a sentence if the mission cannot continue.

        ``all_acknowledged``: the report follows every frame sent.
        """
        if status.mission != self.mission.id:
            if self.on_robot:
                return f"the robot holds mission {status.mission:#010x} instead"
            return None
        if status.prefix_crc != self.mission.prefix_crc(status.accept_next):
            return f"the robot's first {status.accept_next} waypoints are not those of the mission"
        if status.exec_crc != self.mission.prefix_crc(status.exec_next):
            return f"the {status.exec_next} executed waypoints are not the mission's first"
        if not self.on_robot or all_acknowledged:
            self._next = status.accept_next
        self.on_robot = True
        self._next = max(self._next, status.accept_next)
        self.accepted = max(self.accepted, status.accept_next)
        self.executed = max(self.executed, status.exec_next)
        self._limit = status.accept_next + credit
        finished = bool(status.flags & StatusFlag.MISSION_DONE)
        self.done = finished and status.exec_next == len(self.mission)
        return None

    def next_batch(self) -> Waypoints | None:
        """Next frame's waypoints; None if none can be sent."""
        end = min(self._next + BATCH, self._limit, self.released)
        full = end - self._next == BATCH or end == self.released
        # a partly filled frame costs the line more than it brings
        if not self.on_robot or end <= self._next or not full:
            return None
        return Waypoints(self.mission.id, self._next, self.mission.records[self._next : end])

    def sent(self, batch: Waypoints) -> None:
        """Count the batch as sent."""
        self._next = batch.first + len(batch.records)

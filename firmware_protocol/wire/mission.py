"""A mission: waypoints with an id, and the fingerprints of its beginnings.

The prefix CRC of n waypoints is the CRC-32C over the mission id (u32, little-endian) and the first
n 16-byte records. The robot computes it over the accepted and the executed waypoints: none was
lost, doubled or reordered.
"""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.wire.crc import crc32c
from firmware_protocol.wire.errors import LocalError
from firmware_protocol.wire.messages import Waypoint, WaypointFlag

MAX_WAYPOINTS = 0xFFFF_FFF0


def mission_seed(mission: int) -> int:
    """The prefix CRC of no waypoints."""
    return crc32c(mission.to_bytes(4, "little"))


class Mission:
    """Waypoints of a mission as records; ``id`` is in [1, 2**32), unused before on this robot.

    The last waypoint gets the END flag.
    """

    def __init__(self, mission_id: int, waypoints: Sequence[Waypoint]) -> None:
        if not 0 < mission_id < 1 << 32:
            raise LocalError(f"mission id {mission_id}: must be in [1, {(1 << 32) - 1}]")
        if not waypoints:
            raise LocalError(f"mission {mission_id} has no waypoints")
        if len(waypoints) > MAX_WAYPOINTS:
            raise LocalError(f"mission of {len(waypoints)} waypoints: at most {MAX_WAYPOINTS}")
        self.id = mission_id
        records = [waypoint.pack() for waypoint in waypoints]
        records[-1] = records[-1][:-1] + bytes([records[-1][-1] | WaypointFlag.END])
        self.records: tuple[bytes, ...] = tuple(records)
        prefix = [mission_seed(mission_id)]
        for record in self.records:
            prefix.append(crc32c(record, prefix[-1]))
        self._prefix = tuple(prefix)

    def __len__(self) -> int:
        return len(self.records)

    def prefix_crc(self, count: int) -> int | None:
        """CRC of the first ``count`` waypoints; None if there are fewer."""
        return self._prefix[count] if 0 <= count <= len(self.records) else None

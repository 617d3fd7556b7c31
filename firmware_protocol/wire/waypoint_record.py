"""A queued waypoint as the robot reads it: the wire's own whole numbers.

``Waypoint`` in ``host_messages`` is the same in SI units, for the host.
"""

from __future__ import annotations

from struct import Struct
from typing import Final, NamedTuple, Self

from firmware_protocol.wire.fixed_point import Place
from firmware_protocol.wire.values import HEADING_FREE

_LAYOUT: Final = Struct("<iihHHBB")


class Target(NamedTuple):
    """One waypoint of 16 bytes."""

    place: Place
    heading: int
    """1e-4 rad, or HEADING_FREE."""
    speed_mm_s: int
    acceptance: int
    """0.1 mm."""
    dwell: int
    """0.1 s."""
    flags: int

    @classmethod
    def of(cls, record: bytes) -> Self:
        """Read a record that has been checked."""
        x_um, y_um, heading, speed, acceptance, dwell, flags = _LAYOUT.unpack(record)
        return cls(Place(x_um, y_um), heading, speed, acceptance, dwell, flags)


__all__ = ["HEADING_FREE", "Target"]

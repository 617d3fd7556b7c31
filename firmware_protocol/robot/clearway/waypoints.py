"""The waypoints to be executed: the line's records, unchanged.

A leg between waypoints is measured once, when queued.
"""

from array import array

from .fixed import VECTOR, clip, measure
from .native import micropython
from .wire import WAYPOINT_BYTES, get_place

QUEUE_SIZE = 32
FAR = 32000
"""Longest length, in counts of 64 um: 2 m, further than any brake or look ahead."""


class WaypointQueue:
    """A ring of the line's 16-byte records, ``count`` of them waiting."""

    def __init__(self) -> None:
        self.data = bytearray(QUEUE_SIZE * WAYPOINT_BYTES)
        self.lengths = array("H", bytes(2 * QUEUE_SIZE))
        """By place in the ring: the length of the leg from the waypoint before, if that waited."""
        self.directions = array("H", bytes(2 * QUEUE_SIZE))
        """Its direction."""
        self.head = 0
        self.count = 0

    @micropython.native
    def at(self, index: int) -> int:
        """Place of the record that is ``index`` behind the next one."""
        return (self.head + index) % QUEUE_SIZE * WAYPOINT_BYTES

    @micropython.native
    def add(self, record: bytearray, at: int) -> None:
        """Queue the record at ``record[at]``; one place must be free."""
        data, to = self.data, self.at(self.count)
        for byte in range(WAYPOINT_BYTES):
            data[to + byte] = record[at + byte]
        if self.count:
            before, leg = self.at(self.count - 1), to // WAYPOINT_BYTES
            begin_leg(data, to, get_place(data, before), get_place(data, before + 4))
            self.directions[leg] = measure()
            self.lengths[leg] = leg_length()
        self.count += 1

    @micropython.native
    def drop_first(self) -> None:
        """Drop the next waypoint: it is executed."""
        self.head = (self.head + 1) % QUEUE_SIZE
        self.count -= 1

    def clear(self) -> None:
        """Drop all of them."""
        self.head = 0
        self.count = 0


@micropython.native
def begin_leg(data: bytearray, at: int, x_um: int, y_um: int) -> None:
    """Leave the vector from a place to the record there in ``VECTOR``."""
    VECTOR[0] = (get_place(data, at) >> 2) - (x_um >> 2)
    VECTOR[1] = (get_place(data, at + 4) >> 2) - (y_um >> 2)


@micropython.native
def leg_length() -> int:
    """Length of the vector measured last, in counts of 64 um."""
    return clip(VECTOR[0] >> 4, FAR) & 0xFFFF

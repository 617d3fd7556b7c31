"""The waypoints that wait to be executed: the records of the line, as they came."""

from .native import micropython
from .wire import WAYPOINT_BYTES

QUEUE_SIZE = 32


class Queue:
    """The waypoints that wait: a ring of the line's 16-byte records."""

    def __init__(self) -> None:
        self.data = bytearray(QUEUE_SIZE * WAYPOINT_BYTES)
        self.head = 0
        self.count = 0

    @micropython.native
    def at(self, index: int) -> int:
        """Where the record lies that is ``index`` places behind the next one."""
        return (self.head + index) % QUEUE_SIZE * WAYPOINT_BYTES

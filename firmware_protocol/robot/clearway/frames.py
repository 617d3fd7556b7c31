"""The robot's frames: built behind two free bytes, then encoded in place.

Each function leaves its frame in ``frame`` and returns its size, including the zeros.
"""

from array import array

from .fixed import heading_of
from .native import micropython
from .robot import Robot
from .waypoints import QUEUE_SIZE
from .wire import (
    MAX_ENCODED,
    MAX_PAYLOAD,
    MINOR_VERSION,
    SCHEMA_HASH,
    VERSION,
    check_bytes,
    put_halves,
    put_place,
    put_u16,
)

HELLO_ACK, CHALLENGE, ACK, STATUS, TIMESYNC_REPLY = 129, 130, 144, 145, 162
RX_WINDOW = 248
"""Two full frames of waypoints, and less than a receive ring of 256 bytes."""
OF_ROBOT = (0xF975, 0xE263)
"""CRC of the byte that is not sent: its lower and upper half."""


class Frames:
    """One robot's frames. Every frame acknowledges the sequence number ``expected``."""

    def __init__(self, robot: Robot, boot_id: int, reset_cause: int, firmware: int) -> None:
        self.frame = bytearray(MAX_ENCODED + 2)
        self.schema = SCHEMA_HASH
        self.expected = 0
        self.result = 0
        self.command = 0
        self._robot = robot
        self._boot = array("H", (boot_id & 0xFFFF, boot_id >> 16 & 0xFFFF))
        self._cause = reset_cause
        self._firmware = firmware
        self._crc = array("H", (0, 0))

    def _begin(self, kind: int, session: int, flags: int) -> None:
        frame = self.frame
        frame[2] = VERSION << 4 | flags
        frame[3] = kind
        put_u16(frame, 4, session)
        frame[6] = 0
        frame[7] = self.expected
        frame[8] = QUEUE_SIZE - self._robot.queue.count
        frame[9] = 0

    @micropython.native
    def _end(self, end: int) -> int:
        """Append length and check, then apply COBS in place."""
        frame, crc = self.frame, self._crc
        frame[9] = end - 10
        crc[0], crc[1] = OF_ROBOT[0], OF_ROBOT[1]
        check_bytes(crc, 0, frame, 2, end - 2)
        end = put_halves(frame, end, crc, 0)
        code = 1
        for i in range(end - 1, 1, -1):
            if frame[i]:
                code += 1
            else:
                frame[i] = code
                code = 1
        frame[1] = code
        frame[0] = 0
        frame[end] = 0
        return end + 1

    def _put_bytes(self, at: int, data: bytearray) -> int:
        for i in range(4):
            self.frame[at + i] = data[i]
        return at + 4

    def _put_numbers(self, at: int) -> int:
        while self._robot.sum():
            pass
        for i in range(10):
            at = put_u16(self.frame, at, self._robot.numbers[i])
        return at

    def hello_ack(self, session: int) -> int:
        """HELLO_ACK."""
        frame = self.frame
        self._begin(HELLO_ACK, session, 0)
        frame[10] = VERSION
        frame[11] = MINOR_VERSION
        for i in range(4):
            frame[12 + i] = self.schema[i]
        put_place(frame, 16, self._firmware)
        put_halves(frame, 20, self._boot, 0)
        frame[24] = self._cause
        frame[25] = MAX_PAYLOAD
        put_u16(frame, 26, RX_WINDOW)
        frame[28] = QUEUE_SIZE
        frame[29] = self._robot.state
        return self._end(self._put_numbers(30))

    def challenge(self, session: int, nonce: "array[int]") -> int:
        """CHALLENGE."""
        self._begin(CHALLENGE, session, 0)
        return self._end(put_halves(self.frame, 10, nonce, 0))

    def ack(self, session: int, flags: int) -> int:
        """ACK."""
        self._begin(ACK, session, flags)
        return self._end(put_halves(self.frame, 10, self._robot.numbers, 2))

    def time(self, session: int, host: bytearray, then: bytearray, clock: bytearray) -> int:
        """TIMESYNC_REPLY: the host's time, and ours when its question came and now."""
        self._begin(TIMESYNC_REPLY, session, 0)
        at = self._put_bytes(10, host)
        at = self._put_bytes(at, then)
        return self._end(self._put_bytes(at, clock))

    def status(self, session: int, clock: bytearray, count: "array[int]") -> int:
        """STATUS, with the time and the line's counters."""
        frame, robot = self.frame, self._robot
        self._begin(STATUS, session, 0)
        at = self._put_bytes(10, clock)
        at = self._put_numbers(put_halves(frame, at, self._boot, 0))
        frame[at] = robot.state
        frame[at + 1] = robot.flags()
        frame[at + 2] = robot.reason
        frame[at + 3] = self.result
        at = put_u16(frame, at + 4, self.command)
        pose = robot.estimate.pose
        at = put_place(frame, put_place(frame, at, pose[0]), pose[1])
        at = put_u16(frame, at, heading_of(pose[2]))
        at = put_u16(frame, at, robot.speed_mm_s())
        at = put_u16(frame, at, robot.turning_mrad_s())
        at = put_u16(frame, at, robot.pose_age_ms())
        at = put_u16(frame, at, robot.lease_left_ms())
        for i in range(8):
            at = put_u16(frame, at, count[i])
        return self._end(at)

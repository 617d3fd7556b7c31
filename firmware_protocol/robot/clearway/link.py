"""The robot's end of the line: bytes in, decisions through ``robot``, frames out.

- ``receive`` takes bytes in any portions and acts on whole frames at once.
- ``next_frame`` gives one frame at a time, by urgency: no queue, one transmit buffer.
- HELLO asks for a session, which opens when the host returns the CHALLENGE's number. Until then the
  present session continues: a stray HELLO or a recording changes nothing.
- A frame counts only in the present session; HELLO, CONFIRM and ESTOP need none.
- Reports give the present state, so that a lost frame loses nothing.

The twin of ``link.c``.
"""

from array import array

from .estimate import TIME
from .fixed import angle_of
from .frames import Frames
from .native import micropython
from .robot import ESTOP_HOST, Robot
from .wire import (
    HALF_TURN,
    HEADING_FREE,
    MAX_DECODED,
    MAX_ENCODED,
    VERSION,
    WAYPOINT_BYTES,
    check_byte,
    check_bytes,
    get_i16,
    get_u16,
    put_place,
    same_halves,
)

HELLO, CONFIRM, WAYPOINTS, START, PAUSE, CLEAR, RESET_ESTOP = 1, 2, 16, 17, 18, 19, 20
LEASE, POSE, TIMESYNC, ESTOP_TYPE = 32, 33, 34, 46
HELLO_ACK = 129
LENGTHS = b"\x0a\x02\x06\x02"
"""Payload bytes of START to RESET_ESTOP."""
ORDERS = b"\x09\x0e\x04"
"""Payload bytes of LEASE to TIMESYNC."""
RELIABLE, NAK = 1, 2
STATUS_INTERVAL_US = 50000
STATUS_SPACING_US = 10000
"""Least interval of reports of changes; a stop is reported at once."""
NAK_INTERVAL_US = 3000
"""Least interval of complaints, so that noise cannot fill the line."""
ESTOP_FRAME = b"\x00\x03\x10\x2e\x01\x01\x01\x01\x01\x05\xa2\x48\xb2\x50\x00"
# the CRC, inverted, as low and high half: of the unsent byte, and over a sound frame
OF_HOST = (0xE9DD, 0x6620)
OF_SOUND = (0xB438, 0xB798)
# counters of STATUS, in order
FRAMES, CRC_ERRORS, FORMAT_ERRORS, OVERRUNS, SESSION_ERRORS, GAPS, DUPLICATES, REJECTED = range(8)


class Link:
    """One robot's line. ``boot_id`` has 32 bits and must differ from boot to boot."""

    def __init__(
        self,
        robot: Robot,
        boot_id: int,
        reset_cause: int = 0,
        firmware: int = 1,
    ) -> None:
        self.robot = robot
        self.frames = Frames(robot, boot_id, reset_cause, firmware)
        self.frame = self.frames.frame
        self.count = array("H", bytes(16))
        self.turns = 0
        """Turns of the clock, which is modulo 2^30, modulo 4."""
        self.session = 0
        self.nonce = array("H", (boot_id & 0xFFFF, boot_id >> 16 & 0xFFFF))
        """Number that a host has to return, made from boot and clock."""
        self._buffer = bytearray(MAX_DECODED)
        self._crc = array("H", (0, 0))
        self._encoded = 0
        self._block = 0
        self._filled = 0
        self._hello_due = False
        self._hello_session = 0
        self._nak_sent = False
        self._nak_us = 0
        self._status_us = 0
        self._sync_host = bytearray(4)
        self._sync_robot = bytearray(4)
        self._clock = bytearray(4)
        self._forget_session()

    def _forget_session(self) -> None:
        self._asked = 0  # the session asked for by a host and not yet confirmed
        self.frames.command = 0
        self.frames.result = 0
        self.frames.expected = 0
        self._challenge_due = False
        self._ack_due = False
        self._nak_due = False
        self._sync_due = False
        self._status_sent = False

    def _write_clock(self) -> None:
        """Write the line's 32-bit time."""
        put_place(self._clock, 0, self.robot.now_us)
        self._clock[3] |= self.turns << 6

    @micropython.native
    def receive(self, data: bytearray, count: int, now_us: int) -> None:
        """Take ``count`` bytes from the line."""
        self.robot.tick(now_us)
        for i in range(count):
            byte = data[i]
            if byte:
                self._take_byte(byte)
                continue
            if 0 < self._encoded <= MAX_ENCODED:
                self._take_frame()
            self._encoded = 0

    def _damaged(self, counter: int) -> None:
        self._add(counter)
        if self.session:
            self._nak_due = True  # ask at once; do not wait for the host's timeout

    def _add(self, counter: int) -> None:
        self.count[counter] = self.count[counter] + 1 & 0xFFFF

    def lost(self, count: int) -> None:
        """Count bytes that the board lost before receipt."""
        self.count[OVERRUNS] = self.count[OVERRUNS] + count & 0xFFFF

    @micropython.native
    def _take_byte(self, byte: int) -> None:
        if self._encoded == MAX_ENCODED:
            self._encoded += 1
            self._damaged(FORMAT_ERRORS)
        if self._encoded > MAX_ENCODED:
            return  # too long: skip to the next zero
        self._encoded += 1
        if self._encoded == 1:
            self._filled = 0
            self._crc[0], self._crc[1] = OF_HOST[0], OF_HOST[1]
            self._block = byte
        elif self._block == 1:
            self._keep(0)
            self._block = byte
        else:
            self._keep(byte)
            self._block -= 1

    @micropython.native
    def _keep(self, byte: int) -> None:
        self._buffer[self._filled] = byte
        self._filled += 1
        check_byte(self._crc, 0, byte)

    def _take_frame(self) -> None:
        """Take a possible frame, ended by a zero."""
        frame = self._buffer
        if self._block != 1 or self._filled < 12:
            self._damaged(FORMAT_ERRORS)
            return
        if self._crc[0] != OF_SOUND[0] or self._crc[1] != OF_SOUND[1]:
            self._damaged(CRC_ERRORS)
            return
        length, kind = self._filled - 12, frame[1]
        other = frame[0] >> 4 != VERSION or frame[0] & 0x0C != 0
        if frame[7] != length or (other and kind != HELLO and kind != HELLO_ACK):
            self._damaged(FORMAT_ERRORS)
            return
        self._add(FRAMES)
        session = get_u16(frame, 2)
        if kind == ESTOP_TYPE:
            self.robot.emergency_stop(ESTOP_HOST)
        elif session == 0:
            self._add(SESSION_ERRORS)
        elif kind == HELLO:
            self._greet(session, length)
        elif kind == CONFIRM:
            self._confirm(session, length)
        elif session != self.session:
            self._add(SESSION_ERRORS)
        else:
            self._take_message(length)

    def _greet(self, session: int, length: int) -> None:
        frame = self._buffer
        if length != 6:
            self._add(REJECTED)
            return
        self._hello_due = True
        self._hello_session = session
        if frame[8] != VERSION:
            return
        for i in range(4):
            if frame[10 + i] != self.frames.schema[i]:
                return
        if self.session == session:
            return
        self._challenge_due = True
        if self._asked != session:
            self._asked = session
            self._write_clock()
            check_bytes(self.nonce, 0, self._clock, 0, 4)

    def _confirm(self, session: int, length: int) -> None:
        if length != 4 or session != self._asked or not same_halves(self._buffer, 8, self.nonce, 0):
            self._add(SESSION_ERRORS)
            return
        self.robot.open_session()
        self.session = session
        self._forget_session()

    def _take_message(self, length: int) -> None:
        frame = self._buffer
        reliable, kind = frame[0] & RELIABLE != 0, frame[1]
        ahead = frame[4] - self.frames.expected & 255
        if not self._is_sound(kind, length):
            self._add(REJECTED)
            if reliable and ahead == 0:
                # nonsense in a whole frame stays nonsense
                self.frames.expected = self.frames.expected + 1 & 255
                self._ack_due = True
            return
        if reliable != (WAYPOINTS <= kind <= RESET_ESTOP):
            self._add(REJECTED)
            return
        if reliable:
            self._ack_due = True
            if ahead > 128:
                self._add(DUPLICATES)
                return
            if ahead > 0:
                self._add(GAPS)
                self._nak_due = True
                return
        if not self._act(kind):
            self._add(REJECTED)
        elif reliable:
            self.frames.expected = self.frames.expected + 1 & 255

    def _is_sound(self, kind: int, length: int) -> bool:
        if kind == WAYPOINTS:
            return self._waypoints_are_right(length)
        if START <= kind <= RESET_ESTOP:
            return LENGTHS[kind - START] == length
        if not LEASE <= kind <= TIMESYNC or ORDERS[kind - LEASE] != length:
            return False
        if kind == LEASE:
            return self._buffer[16] & 0xFC == 0
        return kind != POSE or self._heading_is_right(16, False)

    def _heading_is_right(self, at: int, may_be_free: bool) -> bool:
        heading = get_i16(self._buffer, at)
        if heading == HEADING_FREE:
            return may_be_free
        return -HALF_TURN <= heading <= HALF_TURN

    def _waypoints_are_right(self, length: int) -> bool:
        frame = self._buffer
        if length < 10:
            return False
        count = frame[16]
        if not 1 <= count <= 6 or length != 10 + WAYPOINT_BYTES * count:
            return False
        for i in range(count):
            at = 18 + WAYPOINT_BYTES * i
            if frame[at + 15] & 0xFC or not self._heading_is_right(at + 8, True):
                return False
            if self._is_lowest(at) or self._is_lowest(at + 4):
                return False
        return True

    def _is_lowest(self, at: int) -> bool:
        """True for -2^31, which is not a place."""
        frame = self._buffer
        return frame[at + 3] == 0x80 and not (frame[at] or frame[at + 1] or frame[at + 2])

    def _act(self, kind: int) -> bool:
        frame, robot = self._buffer, self.robot
        if kind == WAYPOINTS:
            return robot.accept(frame, 8)
        if kind == START:
            self._answer(robot.start(frame, 10))
        elif kind == PAUSE:
            self._answer(robot.pause())
        elif kind == CLEAR:
            self._answer(robot.clear(frame, 10))
        elif kind == RESET_ESTOP:
            self._answer(robot.reset_estop())
        elif kind == LEASE:
            self._ack_due = True  # a short sign of life where noise eats the long STATUS
            return self._is_recent(8) and robot.lease(frame, 8)
        elif kind == POSE:
            return self._is_recent(18) and robot.see(frame, 8, angle_of(get_i16(frame, 16)))
        else:
            self._sync_due = True
            self._write_clock()
            for i in range(4):
                self._sync_host[i] = frame[8 + i]
                self._sync_robot[i] = self._clock[i]
        return True

    def _is_recent(self, at: int) -> bool:
        """True if a 32-bit time is at most 9 minutes old, or a second ahead."""
        self._write_clock()
        low = get_u16(self._clock, 0) - get_u16(self._buffer, at)
        high = get_u16(self._clock, 2) - get_u16(self._buffer, at + 2) + (low >> 16) & 0xFFFF
        return high < 0x2000 or high >= 0xFFF0

    def _answer(self, result: int) -> None:
        self.frames.command = get_u16(self._buffer, 8)
        self.frames.result = result
        self.robot.news = True

    @micropython.native
    def next_frame(self, now_us: int) -> int:
        """Leave the most urgent due frame in ``frame``; return its size, 0 without one."""
        self.robot.tick(now_us)
        frames = self.frames
        if self._hello_due:
            self._hello_due = False
            return frames.hello_ack(self._hello_session)
        if self._challenge_due:
            self._challenge_due = False
            return frames.challenge(self._asked, self.nonce)
        if self.session == 0:
            return 0
        nak_waited = not self._nak_sent or now_us - self._nak_us & TIME >= NAK_INTERVAL_US
        if self._nak_due and nak_waited:
            self._nak_sent = True
            self._nak_us = now_us
            self._nak_due = False
            self._ack_due = False
            return frames.ack(self.session, NAK)
        if self._ack_due:
            self._ack_due = False
            return frames.ack(self.session, 0)
        if self._sync_due:
            self._sync_due = False
            self._write_clock()
            return frames.time(self.session, self._sync_host, self._sync_robot, self._clock)
        if self._status_is_due(now_us):
            self._status_sent = True
            self._status_us = now_us
            self.robot.news = False
            self.robot.alarm = False
            self._write_clock()
            return frames.status(self.session, self._clock, self.count)
        return 0

    @micropython.native
    def _status_is_due(self, now_us: int) -> bool:
        return not self._status_sent or self._status_wait_us(now_us) <= 0

    @micropython.native
    def _status_wait_us(self, now_us: int) -> int:
        """Time until a report is due, after the first; not positive if one is."""
        if self.robot.alarm:
            return 0
        spacing_us = STATUS_SPACING_US if self.robot.news else STATUS_INTERVAL_US
        return spacing_us - (now_us - self._status_us & TIME)

    def quiet_us(self) -> int:
        """Time for which no frame is due if nothing arrives and no cycle is run.

        Not positive if one may be due.
        """
        if self._hello_due or self._challenge_due:
            return 0
        if self.session == 0:
            return STATUS_INTERVAL_US
        if self._nak_due or self._ack_due or self._sync_due or not self._status_sent:
            return 0
        return min(self._status_wait_us(self.robot.now_us), self.robot.quiet_us())


def estop_match(matched: int, byte: int) -> int:
    """Number of the emergency stop's first bytes matched, with this one."""
    if matched == len(ESTOP_FRAME):
        matched = 1  # the last zero may be the next frame's first
    if byte == ESTOP_FRAME[matched]:
        return matched + 1
    return 1 if byte == 0 else 0

"""The driver of the iRobot Create 2 and of Roombas of the 500 series and later.

- It is woken with START, driven in SAFE mode, and streams what its sensors feel every 15 ms; each
  frame of the stream is found again by its sum after lost bytes.
- START leads to PASSIVE and so stops the wheels: that is how an order that may have been damaged
  underway, and a driver that was killed, are made harmless.
- The orders have no check: they are repeated, end in zeros, and no byte of a speed is an order of
  its own that could do harm. A wheel's speed is a whole number of mm/s.
- A cliff or a wheel that hangs takes it out of SAFE mode, and so does the charger, or a byte that
  the line made up; then it is asked back. A bumper stops it here, not there.

Open Interface, big-endian. Metres and seconds elsewhere.
"""

from __future__ import annotations

import math
import struct
from typing import Final

from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.robot_driver import Heard
from navigation.link.drivers.wheel_odometry import WheelOdometry

START, SAFE, DRIVE_DIRECT, STREAM = 128, 131, 145, 148
BUMPS, CLIFFS, CHARGE, CAPACITY, MODE, LEFT, RIGHT = 7, (9, 10, 11, 12), 25, 26, 35, 43, 44
SIZES: Final = {BUMPS: 1, **dict.fromkeys(CLIFFS, 1), MODE: 1, CHARGE: 2, CAPACITY: 2,
                LEFT: 2, RIGHT: 2}  # fmt: skip
"""Of the packets that are streamed, in their order."""
BODY: Final = len(SIZES) + sum(SIZES.values())
HEADER: Final = bytes([19, BODY])
MODE_SAFE: Final = 2
FILL: Final = bytes(4)
"""Zeros are no order, and end one that lost a byte before the next begins."""
NEVER: Final = frozenset(
    (7, *range(128, 131), *range(132, 139), 140, 143, 144, 146, *range(148, 151), 173)
)
"""Low bytes of a speed that would be an order if the byte before them were lost: reset, power off,
clean, dock, another baud, or one that takes the next orders for its data. Such a speed is changed
by as few mm/s as helps."""
REPEAT_S: Final = 0.05
SILENT_S: Final = 0.3
"""Frames come every 15 ms: twenty missing ones, and it is greeted again."""
GREET_S: Final = 1.0
LOST_MODE_S: Final = 0.2
"""A robot that was just ordered into SAFE mode may report the old one for a frame or two."""


class Create2Driver:
    """See `RobotDriver`."""

    robot = KNOWN_ROBOTS["create2"]

    def __init__(self) -> None:
        self.heard = Heard()
        assert self.robot.metres_per_count is not None
        self._odometry = WheelOdometry(
            self.robot.metres_per_count, self.robot.wheel_m_s, modulus=1 << 16
        )
        self._buffer = bytearray()
        self._greeted_s = self._heard_s = -math.inf
        self._wanted = (0, 0)
        self._sent = (0, 0)
        self._sent_s = -math.inf

    def open(self, now_s: float) -> None:
        """Greet it at once."""
        self._buffer.clear()
        self._odometry.forget()
        self._greeted_s = self._heard_s = -math.inf
        self._wanted = (0, 0)

    def drive(self, left_m_s: float, right_m_s: float) -> None:
        """Whole mm/s."""
        self._wanted = (harmless(round(left_m_s * 1000)), harmless(round(right_m_s * 1000)))

    def clear_fault(self) -> None:
        """It is greeted again, which brings it back into SAFE mode."""
        if self.heard.fault is not None:
            self.heard.fault = None
            self._greeted_s = -math.inf

    # Bytes out.

    def bytes_to_send(self, now_s: float) -> bytes:
        """The greeting, or the wheels' speeds when they change and now and then."""
        silent = now_s - self._heard_s > SILENT_S or self._greeted_s == -math.inf
        if (silent or self.heard.held is not None) and now_s - self._greeted_s >= GREET_S:
            self._greeted_s = now_s
            self._sent, self._sent_s = (0, 0), now_s
            stream = bytes([STREAM, len(SIZES), *SIZES])
            return FILL + bytes([0, START, SAFE]) + _wheels(0, 0) + stream
        if self._wanted == self._sent and now_s - self._sent_s < REPEAT_S:
            return b""
        self._sent, self._sent_s = self._wanted, now_s
        return _wheels(*self._wanted)

    # Bytes in.

    def receive(self, data: bytes, now_s: float) -> None:
        """Find the frames of the stream by their sum; anything else is skipped."""
        buffer = self._buffer
        buffer += data
        while (at := buffer.find(HEADER)) >= 0:
            frame = bytes(buffer[at : at + BODY + 3])
            if len(frame) < BODY + 3:
                break
            packets = _packets(frame) if sum(frame) & 0xFF == 0 else None
            if packets is None:
                self.heard.damaged += 1
                del buffer[: at + 1]
                continue
            del buffer[: at + len(frame)]
            self._take(packets, now_s)
        del buffer[: -(BODY + 2)]

    def _take(self, packets: dict[int, int], now_s: float) -> None:
        heard = self.heard
        heard.messages += 1
        heard.identity = f"{self.robot.title} (Open Interface)"
        self._heard_s = now_s
        if packets[CAPACITY]:
            heard.battery = min(1.0, packets[CHARGE] / packets[CAPACITY])
        heard.held = None
        fault = _fault(packets)
        if fault is not None:
            heard.fault = fault
        elif packets[MODE] < MODE_SAFE and now_s - self._greeted_s > LOST_MODE_S:
            heard.held = "has left its safe mode (a charger, or a bad cable?) and is asked back"
            return  # no odometry: it does not drive, and what it does is its own idea
        if not self._odometry.count(packets[LEFT], packets[RIGHT], now_s):
            heard.damaged += 1
            return
        heard.left_m, heard.right_m = self._odometry.left_m, self._odometry.right_m
        heard.odometry_s = now_s


def _fault(packets: dict[int, int]) -> str | None:
    """What its sensors feel that must stop it."""
    bumps = packets[BUMPS]
    if bumps & 0b1100:
        return "a wheel hangs in the air: put the robot back on the floor"
    if any(packets[cliff] & 1 for cliff in CLIFFS):
        return "it is at a cliff: its sensors see no floor"
    if bumps & 0b0011:
        side = ("", "right ", "left ", "")[bumps & 0b0011]
        return f"its {side}bumper is pressed"
    return None


def _wheels(left_mm_s: int, right_mm_s: int) -> bytes:
    return struct.pack(">Bhh", DRIVE_DIRECT, right_mm_s, left_mm_s) + FILL


def harmless(speed_mm_s: int) -> int:
    """The nearest speed whose low byte is not in `NEVER`; the slower of two."""
    for off in range(5):
        for speed in (abs(speed_mm_s) - off, abs(speed_mm_s) + off):
            signed = speed if speed_mm_s >= 0 else -speed
            if speed >= 0 and signed & 0xFF not in NEVER:
                return signed
    raise AssertionError(f"{speed_mm_s}: nine speeds in a row, and each an order")


def _packets(frame: bytes) -> dict[int, int] | None:
    """The values by packet; None where the frame is none of ours."""
    values, at = {}, 2
    for number, size in SIZES.items():
        if frame[at] != number:
            return None
        values[number] = int.from_bytes(frame[at + 1 : at + 1 + size], "big")
        at += 1 + size
    return values

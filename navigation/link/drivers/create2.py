"""Driver of the iRobot Create 2 and of Roombas of the 500 series and later.

- START wakes it, it drives in SAFE mode, and streams its sensors every 15 ms; checksums find the
  frames again after lost bytes. It is deaf for a moment after START, so the greeting comes in two
  bursts.
- START leads to PASSIVE and so stops the wheels: this makes a possibly damaged order, and a killed
  driver, harmless.
- Orders have no check: they are repeated, end in zeros, and no byte of a speed is a harmful order
  of its own. A wheel has few speeds, between which the orders alternate, and counts without a sign
  (`create2_wheel`).
- A cliff or a hanging wheel takes it out of SAFE mode, and so does a byte made up by the line; then
  it is asked back. This driver, not the robot, stops for a bumper.
- It charges only in PASSIVE mode: on its home base it rests there until it is to drive. With the
  charger's cable in its socket it cannot be driven.

Open Interface, big-endian. Metres and seconds elsewhere.
"""

from __future__ import annotations

import math
import struct
from typing import Final

from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.create2_wheel import Create2Wheel
from navigation.link.drivers.robot_driver import Heard
from navigation.link.drivers.wheel_odometry import WheelOdometry

START, SAFE, DRIVE_DIRECT, STREAM = 128, 131, 145, 148
BUMPS, CLIFFS, CHARGER, CHARGE, CAPACITY, MODE = 7, (9, 10, 11, 12), 34, 25, 26, 35
LEFT, RIGHT = 43, 44
SIZES: Final = {BUMPS: 1, **dict.fromkeys(CLIFFS, 1), CHARGER: 1, MODE: 1, CHARGE: 2, CAPACITY: 2,
                LEFT: 2, RIGHT: 2}  # fmt: skip
"""Sizes of the streamed packets, in their order."""
BODY: Final = len(SIZES) + sum(SIZES.values())
HEADER: Final = bytes([19, BODY])
MODE_SAFE: Final = 2
SOCKET, HOME_BASE = 1, 2
"""Bits of the chargers that have power for it."""
RESTS: Final = "is on its charger and rests: it charges until it is to drive"
STAYS: Final = "stays in its passive mode on its charger: take it off, and it drives"
NO_SAFE_MODE: Final = "has left its safe mode (a bad cable?) and is asked back"
BOOTS: Final = b"bl-start"
"""First words of a robot whose battery has just been put in."""
FILL: Final = bytes(4)
"""Zeros are no order, and end one that lost a byte before the next begins."""
CYCLE_S: Final = 0.03
"""Duration of an order while it drives: two turns of the robot's own 15 ms."""
REPEAT_S: Final = 0.05
SILENT_S: Final = 0.3
"""Silence after which it is greeted again: twenty frames of 15 ms."""
GREET_S: Final = 1.0
SETTLE_S: Final = 0.05
"""Pause between the greeting's bursts: more than the 20 ms of a change of mode."""
REST_S: Final = 5.0
"""Time without an order to drive after which a robot on its home base rests."""
AWAKE_S: Final = 120.0
"""Interval of greeting a robot that rests: it would sleep after five minutes."""
LOST_MODE_S: Final = 0.2
"""Time for which a robot just ordered into SAFE mode may report the old one."""


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
        self._wheels = (Create2Wheel(), Create2Wheel())
        self._greeted_s = self._heard_s = self._driven_s = -math.inf
        self._safe_is_due = False
        """The greeting's second burst has not gone out."""
        self._asked_s: float | None = None
        """Time of the order into SAFE mode; None if it was left to rest."""
        self._charger, self._mode = 0, MODE_SAFE
        self._feels_a_fault = False
        self._wanted = (0.0, 0.0)
        self._sent = (0, 0)
        self._sent_s = self._chosen_s = self._burst_s = -math.inf

    def open(self, now_s: float) -> None:
        """Greet it at once."""
        self._buffer.clear()
        self._odometry.forget()
        self._greeted_s = self._heard_s = -math.inf
        self._safe_is_due = False
        self._asked_s, self._charger = None, 0
        self._wanted = (0.0, 0.0)

    def drive(self, left_m_s: float, right_m_s: float) -> None:
        """Set the speeds in mm/s."""
        self._wanted = (left_m_s * 1000, right_m_s * 1000)

    def clear_fault(self) -> None:
        """Greet it again, which brings it back into SAFE mode."""
        if self.heard.fault is not None:
            self.heard.fault = None
            self._greeted_s = -math.inf

    # Bytes out.

    def bytes_to_send(self, now_s: float) -> bytes:
        """The greeting, or the wheels' speeds when they change and now and then."""
        if self._wanted != (0.0, 0.0):
            self._driven_s = now_s
        if self._safe_is_due:
            return self._second_burst(now_s) if now_s - self._greeted_s >= SETTLE_S else b""
        if self._is_to_be_greeted(now_s):
            self._greeted_s, self._safe_is_due = now_s, True
            self._order((0, 0), now_s)
            return FILL + bytes([0, START])
        if self._is_silent(now_s) and now_s - self._burst_s >= SILENT_S:
            return self._second_burst(now_s)  # a stalled line joins both bursts
        return self._speeds(now_s)

    def _is_to_be_greeted(self, now_s: float) -> bool:
        if self._greeted_s == -math.inf:
            return True
        age_s, rests = now_s - self._greeted_s, self._rests(now_s)
        other_mode = rests is (self._mode >= MODE_SAFE) and not self._feels_a_fault
        if self._is_silent(now_s) or other_mode:
            return age_s >= GREET_S
        return rests and age_s >= AWAKE_S

    def _is_silent(self, now_s: float) -> bool:
        return now_s - self._heard_s > SILENT_S

    def _rests(self, now_s: float) -> bool:
        idle = now_s - self._driven_s >= REST_S
        return bool(self._charger & SOCKET or (self._charger & HOME_BASE and idle))

    def _second_burst(self, now_s: float) -> bytes:
        self._safe_is_due, self._burst_s = False, now_s
        stream = bytes([STREAM, len(SIZES), *SIZES])
        if self._rests(now_s):
            self._asked_s = None
            return stream
        self._asked_s = now_s
        return bytes([SAFE]) + _wheels(0, 0) + stream

    def _speeds(self, now_s: float) -> bytes:
        if self._wanted == (0.0, 0.0):
            self._chosen_s = -math.inf
            for wheel in self._wheels:
                wheel.forget()
            if self._sent == (0, 0) and now_s - self._sent_s < REPEAT_S:
                return b""
            return self._order((0, 0), now_s)
        if now_s - self._chosen_s < CYCLE_S:
            return b""
        self._chosen_s = now_s
        left, right = (
            wheel.next_order(wanted)
            for wheel, wanted in zip(self._wheels, self._wanted, strict=True)
        )
        return self._order((left, right), now_s)

    def _order(self, speeds: tuple[int, int], now_s: float) -> bytes:
        for wheel, speed in zip(self._wheels, speeds, strict=True):
            wheel.ordered(speed, now_s)
        self._sent, self._sent_s = speeds, now_s
        return _wheels(*speeds)

    # Bytes in.

    def receive(self, data: bytes, now_s: float) -> None:
        """Find the stream's frames by their checksum; skip the rest."""
        buffer = self._buffer
        buffer += data
        if BOOTS in buffer:
            self.heard.held = "starts up: its battery was put in, or it was reset"
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
        self._charger, self._mode = packets[CHARGER], packets[MODE]
        rests = self._rests(now_s) and self._mode < MODE_SAFE
        heard.held, heard.remark = None, RESTS if rests else None
        fault = _fault(packets)
        self._feels_a_fault = fault is not None
        if fault is not None:
            heard.fault = fault
        elif self._charger & SOCKET:
            heard.held = "charges by its cable and rests: pull the cable out before it is to drive"
        elif self._mode < MODE_SAFE and self._was_asked(now_s):
            heard.held = NO_SAFE_MODE if self._charger == 0 else STAYS
        if heard.held is not None:
            return  # no odometry: it moves of its own accord
        left, right = (wheel.direction(now_s) for wheel in self._wheels)
        if not self._odometry.count(packets[LEFT], packets[RIGHT], now_s, (left, right)):
            heard.damaged += 1
            return
        heard.left_m, heard.right_m = self._odometry.left_m, self._odometry.right_m
        heard.odometry_s = now_s

    def _was_asked(self, now_s: float) -> bool:
        return self._asked_s is not None and now_s - self._asked_s > LOST_MODE_S


def _fault(packets: dict[int, int]) -> str | None:
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


def _packets(frame: bytes) -> dict[int, int] | None:
    """Values by packet; None if the frame is not ours."""
    values, at = {}, 2
    for number, size in SIZES.items():
        if frame[at] != number:
            return None
        values[number] = int.from_bytes(frame[at + 1 : at + 1 + size], "big")
        at += 1 + size
    return values

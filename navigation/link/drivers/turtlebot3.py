"""Driver of the TurtleBot3 (Burger or Waffle) with ROBOTIS's ROS 2 firmware on its OpenCR.

- Dynamixel protocol 2.0 over USB: the board is slave 200, whose control table is read and written.
  An answer is known by its length, so a lost one upsets no order.
- The heartbeat counts up ten times a second; without it the board stops the wheels after half a
  second.
- Speeds have steps of 1 cm/s and 0.01 rad/s. The remainder goes into the next order, so that the
  mean speed is right.
- The board looks for its motors only at its start; motors that lost power wake without torque. Both
  are faults; the torque returns when a person re-arms the robot.

Little-endian; metres and seconds elsewhere.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from typing import Final

from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.robot_driver import Heard
from navigation.link.drivers.wheel_odometry import WheelOdometry

BOARD: Final = 200
READ, WRITE, STATUS = 2, 3, 0x55
HEADER: Final = bytes((0xFF, 0xFF, 0xFD, 0x00))
LONGEST: Final = 64
"""Longest part of an answer after its length."""
WHO, STATE, BEAT, CHARGE, TRAVEL, SPEEDS = (0, 7), (18, 1), 19, (46, 4), (136, 8), 150
TORQUE: Final = (149, 2)
"""Addresses in the board's table, with a length where it is read, which identifies the answer."""
MODEL: Final = 0x5000
TRACKS_M: Final = {
    1: ("Burger", 0.160),
    2: ("Waffle", 0.287),
    3: ("Waffle with OpenMANIPULATOR", 0.287),
}
"""By the table's model information: its firmware divides an angular speed by these."""
NO_MOTORS: Final = b"\xff"
NOT_FOUND: Final = (
    "its motors were not found when its board started: switch the battery on, and press RESET on "
    "the OpenCR board"
)
NO_TORQUE: Final = (
    "its motors have no torque: they lost their power, or a program switched it off. Look at the "
    "battery; re-arming switches it on"
)
CYCLE_S: Final = 0.02
"""Interval in which the board renews its table."""
BEAT_S: Final = 0.1
ASK_S: Final = 1.0
"""Interval of the questions for its identity, its motors, their torque and its battery."""
STEP: Final = 100
"""Steps of 1 cm/s and of 0.01 rad/s."""


class Turtlebot3Driver:
    """See `RobotDriver`."""

    robot = KNOWN_ROBOTS["turtlebot3"]

    def __init__(self) -> None:
        self.heard = Heard()
        assert self.robot.metres_per_count is not None
        self._odometry = WheelOdometry(
            self.robot.metres_per_count, self.robot.wheel_m_s, modulus=1 << 32
        )
        self._buffer = bytearray()
        self._track_m = self.robot.track_m
        self._cycle_s = self._beat_s = self._asked_s = -math.inf
        self._beat = 0
        self._wanted = (0.0, 0.0)
        self._left_over = [0.0, 0.0]
        self._motors_found, self._torque_is_due = True, False

    def open(self, now_s: float) -> None:
        """Begin with a stop as the first order."""
        self._buffer.clear()
        self._odometry.forget()
        self._cycle_s = self._beat_s = self._asked_s = -math.inf
        self._wanted = (0.0, 0.0)

    def drive(self, left_m_s: float, right_m_s: float) -> None:
        """Set the speeds as linear and angular ones of the robot's own track."""
        self._wanted = ((left_m_s + right_m_s) / 2, (right_m_s - left_m_s) / self._track_m)

    def clear_fault(self) -> None:
        """Clear the fault; one that persists returns with the next answer."""
        self._torque_is_due = self.heard.fault == NO_TORQUE
        self.heard.fault = None

    # Bytes out.

    def bytes_to_send(self, now_s: float) -> bytes:
        """Speeds and the question for the travel every 20 ms; the rest in its turn."""
        if now_s - self._cycle_s < CYCLE_S:
            return b""
        self._cycle_s = now_s
        linear, angular = self._steps(0), self._steps(1)
        packets = [_write(SPEEDS, struct.pack("<iiiiii", linear, 0, 0, 0, 0, angular))]
        if now_s - self._beat_s >= BEAT_S:
            self._beat_s, self._beat = now_s, (self._beat + 1) & 0xFF
            packets.append(_write(BEAT, bytes([self._beat])))
        if self._torque_is_due:
            self._torque_is_due = False
            self._asked_s = now_s  # the board reads its motors before it is asked again
            packets.append(_write(TORQUE[0], b"\1"))
        if now_s - self._asked_s >= ASK_S:
            self._asked_s = now_s
            packets += [_read(*WHO), _read(*STATE), _read(*CHARGE), _read(*TORQUE)]
        packets.append(_read(*TRAVEL))
        return b"".join(packets)

    def _steps(self, which: int) -> int:
        """Steps of the next order; a stop takes effect at once."""
        wanted = self._wanted[which] * STEP
        if wanted == 0.0:
            self._left_over[which] = 0.0
            return 0
        wanted += self._left_over[which]
        steps = round(wanted)
        self._left_over[which] = wanted - steps
        return steps

    # Bytes in.

    def receive(self, data: bytes, now_s: float) -> None:
        """Read answers; anything else, or damaged, is skipped to the next header."""
        self._buffer += data
        for error, answer in self._answers():
            self.heard.messages += 1
            if error & 0x7F == 0:
                self._take(answer, now_s)

    def _answers(self) -> Iterator[tuple[int, bytes]]:
        buffer = self._buffer
        while (at := buffer.find(HEADER)) >= 0:
            del buffer[:at]
            if len(buffer) < 7:
                return
            size = buffer[5] | buffer[6] << 8
            if not 4 <= size <= LONGEST:
                self.heard.damaged += 1
                del buffer[0]
                continue
            if len(buffer) < 7 + size:
                return
            packet = bytes(buffer[: 7 + size])
            if packet[-2] | packet[-1] << 8 != crc16(packet[:-2]):
                self.heard.damaged += 1
                del buffer[0]
                continue
            del buffer[: len(packet)]
            if packet[4] == BOARD and packet[7] == STATUS:
                yield packet[8], _unstuffed(packet[9:-2])
        del buffer[: -(len(HEADER) - 1)]

    def _take(self, answer: bytes, now_s: float) -> None:
        heard = self.heard
        match len(answer):
            case 8:
                left, right = struct.unpack("<ii", answer)
                if not self._odometry.count(left, right, now_s):
                    heard.damaged += 1
                elif heard.identity is not None:
                    heard.left_m, heard.right_m = self._odometry.left_m, self._odometry.right_m
                    heard.odometry_s = now_s
            case 7:
                model, kind = struct.unpack("<HI", answer[:6])
                if model == MODEL and kind in TRACKS_M:
                    name, self._track_m = TRACKS_M[kind]
                    heard.identity = f"{self.robot.title} {name}, firmware {answer[6]}"
                    heard.held = None
                elif model == MODEL:
                    heard.held = f"says that it is model {kind}, which this driver does not know"
            case 4:
                heard.battery = min(1.0, int.from_bytes(answer, "little") / 10_000)
            case 1:
                self._motors_found = answer != NO_MOTORS
                if not self._motors_found:
                    heard.fault = NOT_FOUND
            case 2 if self._motors_found and answer[0] == 0:
                heard.fault = NO_TORQUE


def _packet(instruction: int, data: bytes) -> bytes:
    body = bytes([instruction]) + data.replace(HEADER[:3], HEADER[:3] + HEADER[2:3])
    head = HEADER + bytes([BOARD]) + (len(body) + 2).to_bytes(2, "little") + body
    return head + crc16(head).to_bytes(2, "little")


def _read(address: int, length: int) -> bytes:
    return _packet(READ, struct.pack("<HH", address, length))


def _write(address: int, data: bytes) -> bytes:
    return _packet(WRITE, struct.pack("<H", address) + data)


def _unstuffed(data: bytes) -> bytes:
    """Remove the byte that keeps data from looking like a header."""
    return data.replace(HEADER[:3] + HEADER[2:3], HEADER[:3])


def _table() -> tuple[int, ...]:
    rows = []
    for value in range(256):
        row = value << 8
        for _ in range(8):
            row = row << 1 ^ (0x8005 if row & 0x8000 else 0)
        rows.append(row & 0xFFFF)
    return tuple(rows)


_CRC: Final = _table()


def crc16(data: bytes) -> int:
    """CRC of protocol 2.0: polynomial 0x8005, initial value 0, not reflected."""
    value = 0
    for byte in data:
        value = (value << 8 & 0xFFFF) ^ _CRC[value >> 8 ^ byte]
    return value

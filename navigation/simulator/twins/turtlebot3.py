"""Twin of a TurtleBot3: its OpenCR board, from ROBOTIS's protocol 2.0 and control table.

- A slave of Dynamixel protocol 2.0 with id 200: PING, READ and WRITE of a little-endian table of
  bytes. A packet with a wrong CRC is ignored; writing a read-only address is an error.
- Every 20 ms the table is updated and the motors are driven. Speeds are ordered in steps of 1 cm/s
  and 0.01 rad/s; a motor's own step is 0.229 turns a minute, rounded towards zero.
- Watchdog: the wheels stop if the heartbeat at 19 has not changed for 500 ms.
- Encoder counts are 32 bits, 4,096 a turn. Without profile acceleration a wheel obeys at once.
- The board looks for its motors only when it starts: if it finds none, register 18 stays 0xFF and
  nothing is driven until RESET (`boot`), whatever the motors' power (`power_motors`).
- Motors that lost power wake without torque; 149 reads it, and writing 1 there switches it on.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from typing import Final

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.simulator.twins.twin import Body, Twin

DXL_ID: Final = 200
BROADCAST: Final = 254
MODEL: Final = 0x5000
BURGER, WAFFLE, WITH_MANIPULATOR = 1, 2, 3
FIRMWARE: Final = 10
WHEEL_RADIUS_M: Final = 0.033
TICKS_A_TURN: Final = 4_096
BUILDS: Final = {BURGER: (0.160, 61), WAFFLE: (0.287, 77), WITH_MANIPULATOR: (0.287, 77)}
"""Track in metres and turns a minute, by the table's model information."""
MOTOR_STEP_M_S: Final = WHEEL_RADIUS_M * 0.229 * math.tau / 60
HEARTBEAT_S: Final = 0.5
TABLE_S: Final = 0.02
TABLE_BYTES: Final = 384
STATE, HEARTBEAT, TORQUE, LINEAR, ANGULAR = 18, 19, 149, 150, 170
NO_MOTORS: Final = 0xFF
WRITABLE: Final = ((19, 20), (20, 24), (50, 51), (59, 60), (149, 182))
"""Addresses from and up to."""
PING, READ, WRITE, STATUS = 1, 2, 3, 0x55
ERR_INSTRUCTION, ERR_CRC, ERR_RANGE, ERR_LENGTH, ERR_ACCESS = 2, 3, 4, 5, 7
BATTERY_V: Final = 11.7
PREAMBLE: Final = b"\xff\xff\xfd\x00"


class Turtlebot3Twin(Twin):
    """USB port, table and motors of a TurtleBot3."""

    baud = 1_000_000
    has_frames = False

    def __init__(self, build: int = BURGER) -> None:
        self._build = build
        track_m, turns = BUILDS[build]
        a_turn_m = math.tau * WHEEL_RADIUS_M
        self.body = Body(track_m, TICKS_A_TURN / a_turn_m, 337 * MOTOR_STEP_M_S)
        self._fastest_m_s = a_turn_m * turns / 60
        self._motors_have_power = True
        self._has_torque = False
        self.boot(0.0)

    def boot(self, now_s: float) -> None:
        """Set the table as after a reset."""
        self._table = bytearray(TABLE_BYTES)
        struct.pack_into("<HIBBB", self._table, 0, MODEL, self._build, FIRMWARE, DXL_ID, 3)
        struct.pack_into("<II", self._table, 42, round(BATTERY_V * 100), 6_666)
        self._motors_found = self._has_torque = self._motors_have_power
        self._table[TORQUE] = self._has_torque
        self._table[STATE] = 0 if self._motors_found else NO_MOTORS
        self._received = bytearray()
        self._out = bytearray()
        self._linear = self._angular = 0.0
        self._beat, self._beat_s, self._is_connected = 0, now_s, False
        self._cycle_s = now_s
        self._wheels = WheelSpeeds(0.0, 0.0, powered=True)

    def bump(self, pressed: bool) -> None:
        """Press or release both bumpers that can be plugged in."""
        self._table[28:30] = bytes([pressed, pressed])

    def power_motors(self, powered: bool) -> None:
        """Switch the battery; the board itself is powered over USB."""
        self._motors_have_power = powered
        self._has_torque = self._has_torque and powered

    def receive(self, data: bytes, now_s: float) -> None:
        """Obey whole packets at once."""
        self._received += data
        for packet in self._packets():
            self._obey(packet, now_s)

    def _packets(self) -> Iterator[bytes]:
        got = self._received
        while (at := got.find(PREAMBLE)) >= 0:
            del got[:at]
            if len(got) < 7:
                return
            end = 7 + int.from_bytes(got[5:7], "little")
            if end > 7 + TABLE_BYTES:
                del got[:4]
                continue
            if len(got) < end:
                return
            packet = bytes(got[:end])
            if _check(packet[:-2]) == int.from_bytes(packet[-2:], "little"):
                del got[:end]
                yield packet
            else:
                del got[:4]
        del got[:-3]

    def _obey(self, packet: bytes, now_s: float) -> None:
        if packet[4] not in (DXL_ID, BROADCAST):
            return
        data = packet[8:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
        match packet[7]:
            case 1:
                self._answer(0, struct.pack("<HB", MODEL, FIRMWARE))
            case 2 if len(data) == 4:
                address, length = struct.unpack("<HH", data)
                if address + length > TABLE_BYTES:
                    self._answer(ERR_RANGE)
                else:
                    self._answer(0, bytes(self._table[address : address + length]))
            case 3 if len(data) > 2:
                self._write(int.from_bytes(data[:2], "little"), data[2:], now_s)
            case _:
                self._answer(ERR_INSTRUCTION)

    def _write(self, address: int, data: bytes, now_s: float) -> None:
        end = address + len(data)
        if not any(low <= address and end <= high for low, high in WRITABLE):
            self._answer(ERR_ACCESS)
            return
        self._table[address:end] = data
        if address <= TORQUE < end and self._motors_found:
            self._has_torque = bool(self._table[TORQUE]) and self._motors_have_power
        if address <= LINEAR and end >= LINEAR + 4:
            self._linear = self._speed(LINEAR, self._fastest_m_s)
        if address <= ANGULAR and end >= ANGULAR + 4:
            self._angular = self._speed(ANGULAR, self._fastest_m_s / (self.body.track_m / 2))
        self._answer(0)

    def _speed(self, address: int, most: float) -> float:
        hundredths: int = struct.unpack_from("<i", self._table, address)[0]
        return max(-most, min(most, hundredths / 100))

    def _answer(self, error: int, data: bytes = b"") -> None:
        body = bytes([STATUS, error]) + data
        body = body.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
        packet = PREAMBLE + bytes([DXL_ID]) + struct.pack("<H", len(body) + 2) + body
        self._out += packet + struct.pack("<H", _check(packet))

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """Update table and motors every 20 ms; check the heartbeat at every call."""
        if self._table[HEARTBEAT] != self._beat:
            self._beat, self._beat_s, self._is_connected = self._table[HEARTBEAT], now_s, True
        elif now_s - self._beat_s >= HEARTBEAT_S:
            self._is_connected = False
        if now_s - self._cycle_s < TABLE_S:
            return self._wheels
        self._cycle_s = now_s
        struct.pack_into("<I", self._table, 10, round(now_s * 1000) & 0xFFFFFFFF)
        if self._motors_found:
            self._table[TORQUE] = self._has_torque
            if self._motors_have_power:
                counts = _wrapped(left_ticks), _wrapped(right_ticks)
                struct.pack_into("<ii", self._table, 136, *counts)
        if not self._is_connected:
            self._linear = self._angular = 0.0
        turn_m_s = self._angular * self.body.track_m / 2
        self._wheels = WheelSpeeds(
            _motor(self._linear - turn_m_s), _motor(self._linear + turn_m_s), self._has_torque
        )
        return self._wheels

    def bytes_to_send(self, now_s: float) -> bytes:
        """Return the answers."""
        answer = bytes(self._out)
        self._out.clear()
        return answer


def _motor(speed_m_s: float) -> float:
    return max(-337, min(337, math.trunc(speed_m_s / MOTOR_STEP_M_S))) * MOTOR_STEP_M_S


def _wrapped(count: int) -> int:
    return (count + (1 << 31)) % (1 << 32) - (1 << 31)


def _check(data: bytes) -> int:
    """CRC-16 of the polynomial x16 + x15 + x2 + 1, high bit first, from 0."""
    remainder = 0
    for value in data:
        remainder ^= value << 8
        for _ in range(8):
            remainder <<= 1
            if remainder & 0x10000:
                remainder ^= 0x18005
    return remainder

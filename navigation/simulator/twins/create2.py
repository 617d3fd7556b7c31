"""Twin of an iRobot Create 2, from its Open Interface specification.

- Modes are off, passive, safe and full. Off, it hears only Start and reset; only safe and full
  drive. In safe mode a wheel drop or a cliff stops the wheels and leads to passive.
- No watchdog: the wheels keep the last order. In passive mode it sleeps after five minutes; then
  only its CLEAN button (`press_clean`) wakes it, no byte.
- Its speed controller has steps of about 28.5 mm/s. Owners measured that orders from -10 to 10 mm/s
  do nothing, and that all from 11 up to the next step at 40 drive at 39 mm/s.
- Orders have no check: after a lost byte the next opcode is taken as data. Streamed sensor frames,
  one every 15 ms, end with a sum.
- After Start it is deaf for the 20 ms of a mode change.
- Encoder counts wrap at 16 bits. The sensors feel no direction: counts decrease while the wheel is
  ordered backwards and increase otherwise, even if a wheel ordered to stop rolls.
- It charges in passive mode only. On the home base (`dock`), safe and full mode end the charging;
  with the charger's cable plugged in (`plug_in`), safe mode leads to passive.
- After a reset or a new battery it hears nothing for three seconds of text; then it is off.

Bytes are big-endian; speeds in mm/s; metres and seconds elsewhere.
"""

from __future__ import annotations

import math
import struct
from enum import IntEnum
from typing import Final

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.simulator.twins.twin import ON_FOR_S, Body, Twin

WHEEL_M: Final = 0.072
TICKS_A_TURN: Final = 508.8
STREAM_S: Final = 0.015
SLEEP_S: Final = 300.0
LIMIT_MM_S: Final = 500
LEAST_MM_S, STEP_MM_S, STEP_ADDS_MM_S = 11, 28.5, 10.5
"""The least order that turns a wheel, a step's width, and what step n drives beyond n widths."""
DEAF_S: Final = 0.020
BOOT_S: Final = 3.0
BOOT_TEXT: Final = b"bl-start\r\n2007-05-14-1715-L   \r\nRDK by iRobot!\r\n"
"""Text on the line when the processor starts, in a protocol of its own."""
BATTERY_MAH: Final = (2_050.0, 2_696)
CHARGE_MA: Final = 1_250
NOT_CHARGING, FULL_CHARGING = 0, 2
SOCKET, HOME_BASE = 1, 2
LONGEST_STREAM: Final = 80
ACTUATORS: Final = (137, 138, 139, 144, 145, 146)
"""Orders that passive mode does not have: they keep nothing awake."""

DATA_BYTES: Final = {
    128: 0, 129: 1, 131: 0, 132: 0, 133: 0, 134: 0, 135: 0, 136: 0, 137: 4, 138: 1, 139: 3,
    141: 1, 142: 1, 143: 0, 144: 3, 145: 4, 146: 4, 147: 1, 150: 1, 162: 2, 163: 4, 164: 4,
    165: 1, 168: 3, 173: 0, 7: 0,
}  # fmt: skip
"""By opcode; those whose length is in their first byte are `COUNTED`."""
COUNTED: Final = {140: 2, 148: 1, 149: 1}
"""By opcode: number of data bytes up to and with the count."""


class OpenInterfaceMode(IntEnum):
    """Modes of the Open Interface, as in packet 35."""

    OFF = 0
    PASSIVE = 1
    SAFE = 2
    FULL = 3


class Create2Twin(Twin):
    """Serial port, modes and wheel orders of a Create 2."""

    body = Body(0.235, TICKS_A_TURN / (math.pi * WHEEL_M), LIMIT_MM_S / 1000)
    baud = 115_200
    has_frames = False

    def __init__(self, sleep_s: float = SLEEP_S) -> None:
        self._sleep_s = sleep_s
        self._bumped = self._lifted = False
        self._charger = 0
        self.charge_mah = BATTERY_MAH[0]
        self._stepped_s = 0.0
        self.boot(-ON_FOR_S)

    def boot(self, now_s: float) -> None:
        """Insert the battery, or reset: off, no stream, zero counts."""
        self.mode = OpenInterfaceMode.OFF
        self._booted_s = now_s + BOOT_S
        self._texts = 3
        self._deaf_until_s = -math.inf
        self.asleep = False
        self._heard_s = now_s
        self._order = bytearray()
        self._wanted = [0, 0]
        self._counts = [0, 0]
        self._ticks: tuple[int, int] | None = None
        self._stream: tuple[int, ...] = ()
        self._streaming = False
        self._streamed_s = now_s
        self._out = bytearray()

    def press_clean(self, now_s: float) -> None:
        """Press the button on top."""
        self.asleep = False
        self._heard_s = now_s

    def bump(self, pressed: bool) -> None:
        """Press or release both halves of the bumper."""
        self._bumped = pressed

    def lift(self, lifted: bool) -> None:
        """Drop both wheels out of the body, or back."""
        self._lifted = lifted

    def dock(self, docked: bool) -> None:
        """Put it on its home base, or take it off."""
        self._charger = HOME_BASE if docked else 0

    def plug_in(self, plugged: bool) -> None:
        """Plug in the charger's cable, or pull it out."""
        self._charger = SOCKET if plugged else 0

    def receive(self, data: bytes, now_s: float) -> None:
        """Take orders byte by byte."""
        for value in data:
            if not self.asleep and now_s >= max(self._booted_s, self._deaf_until_s):
                self._take(value, now_s)

    def _take(self, value: int, now_s: float) -> None:
        order = self._order
        if not order and value not in DATA_BYTES and value not in COUNTED:
            return
        order.append(value)
        length = self._length()
        if length is None or len(order) < length:
            return
        opcode, data = order[0], bytes(order[1:])
        order.clear()
        if self.mode is not OpenInterfaceMode.OFF or opcode in (7, 128):
            if self.mode is not OpenInterfaceMode.PASSIVE or opcode not in ACTUATORS:
                self._heard_s = now_s
            self._obey(opcode, data, now_s)

    def _length(self) -> int | None:
        order = self._order
        if order[0] in DATA_BYTES:
            return 1 + DATA_BYTES[order[0]]
        head = COUNTED[order[0]]
        if len(order) <= head:
            return None
        return 1 + head + order[head] * (2 if order[0] == 140 else 1)

    def _obey(self, opcode: int, data: bytes, now_s: float) -> None:
        match opcode:
            case 7:
                self.boot(now_s)
            case 128:
                self._enter(OpenInterfaceMode.PASSIVE)
                self._deaf_until_s = now_s + DEAF_S
            case 173:
                self._enter(OpenInterfaceMode.OFF)
                self._streaming = False
            case 131:
                self._enter(OpenInterfaceMode.SAFE)
            case 132:
                self._enter(OpenInterfaceMode.FULL)
            case 145 if self.mode >= OpenInterfaceMode.SAFE:
                right, left = struct.unpack(">hh", data)
                self._turn(left, right)
            case 137 if self.mode >= OpenInterfaceMode.SAFE:
                self._drive(*struct.unpack(">hh", data))
            case 142:
                self._out += self._packet(data[0])
            case 149:
                self._out += b"".join(self._packet(number) for number in data[1:])
            case 148:
                self._stream = tuple(data[1 : 1 + LONGEST_STREAM])
                self._streaming = bool(self._stream)
            case 150:
                self._streaming = bool(data[0]) and bool(self._stream)
            case 134 | 135 | 136 | 143:
                self._enter(OpenInterfaceMode.PASSIVE)

    def _enter(self, mode: OpenInterfaceMode) -> None:
        """Change the mode, which stops the wheels."""
        self.mode = mode
        self._wanted = [0, 0]

    def _turn(self, left: int, right: int) -> None:
        for side, speed in enumerate((left, right)):
            self._wanted[side] = max(-LIMIT_MM_S, min(LIMIT_MM_S, speed))

    def _drive(self, speed: int, radius: int) -> None:
        if radius in (-32768, 32767):
            self._turn(speed, speed)
        elif radius in (-1, 1):
            self._turn(-speed * radius, speed * radius)
        else:
            half = self.body.track_m * 500
            self._turn(round(speed * (1 - half / radius)), round(speed * (1 + half / radius)))

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """Count, feel, charge, and fall asleep."""
        before = self._ticks or (left_ticks, right_ticks)
        self._ticks = (left_ticks, right_ticks)
        for side, moved in enumerate((left_ticks - before[0], right_ticks - before[1])):
            self._counts[side] += -abs(moved) if self._wanted[side] < 0 else abs(moved)
        if self.mode is OpenInterfaceMode.SAFE and (self._lifted or self._charger == SOCKET):
            self._enter(OpenInterfaceMode.PASSIVE)
        if self._charging_state() == FULL_CHARGING:
            hours = max(0.0, now_s - self._stepped_s) / 3600
            self.charge_mah = min(BATTERY_MAH[1], self.charge_mah + CHARGE_MA * hours)
        self._stepped_s = now_s
        if self.mode <= OpenInterfaceMode.PASSIVE and now_s - self._heard_s >= self._sleep_s:
            self.asleep, self.mode, self._streaming = True, OpenInterfaceMode.OFF, False
        left, right = map(_turned, self._wanted)
        return WheelSpeeds(left / 1000, right / 1000, powered=self.mode >= OpenInterfaceMode.SAFE)

    def _charging_state(self) -> int:
        charges = self._charger and self.mode <= OpenInterfaceMode.PASSIVE
        return FULL_CHARGING if charges else NOT_CHARGING

    def bytes_to_send(self, now_s: float) -> bytes:
        """Return the answers, then a due frame of the stream."""
        if self._booted_s > now_s >= self._booted_s - self._texts * BOOT_S / 3:
            self._texts -= 1
            self._out += BOOT_TEXT
        if self._out:
            answer = bytes(self._out)
            self._out.clear()
            return answer
        if not self._streaming or self.asleep or now_s - self._streamed_s < STREAM_S:
            return b""
        late = now_s - self._streamed_s >= 2 * STREAM_S
        self._streamed_s = now_s if late else self._streamed_s + STREAM_S
        body = b"".join(bytes([number]) + self._packet(number) for number in self._stream)
        frame = bytes([19, len(body)]) + body
        return frame + bytes([-sum(frame) & 0xFF])

    def _packet(self, number: int) -> bytes:
        match number:
            case 7:
                return bytes([(0b0011 if self._bumped else 0) | (0b1100 if self._lifted else 0)])
            case 9 | 10 | 11 | 12:
                return bytes([int(self._lifted)])
            case 21:
                return bytes([self._charging_state()])
            case 34:
                return bytes([self._charger])
            case 22:
                return (15_800).to_bytes(2, "big")
            case 25:
                return int(self.charge_mah).to_bytes(2, "big")
            case 26:
                return BATTERY_MAH[1].to_bytes(2, "big")
            case 35:
                return bytes([self.mode])
            case 43 | 44:
                return (self._counts[number - 43] & 0xFFFF).to_bytes(2, "big")
            case 19 | 20 | 23 | 27 | 28 | 29 | 30 | 31 | 39 | 40 | 41 | 42:
                return bytes(2)
        return bytes(1)


def _turned(ordered_mm_s: int) -> float:
    number = math.floor((abs(ordered_mm_s) - LEAST_MM_S) / STEP_MM_S) + 1
    if number <= 0:
        return 0.0
    return math.copysign(min(LIMIT_MM_S, number * STEP_MM_S + STEP_ADDS_MM_S), ordered_mm_s)

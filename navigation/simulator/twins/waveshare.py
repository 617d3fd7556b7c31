"""Twin of a Waveshare UGV with encoders (UGV01), from the list of its commands.

- One JSON object a line, both ways; invalid lines and incomplete commands are ignored. Commands are
  echoed unless 143 switches that off.
- 1 orders the wheels' speeds in m/s (the whole order is ignored if a speed exceeds 2 m/s), 13
  linear and angular speed; 131 switches the reports on, 142 makes them rarer, 130 asks for one.
- 900 sets the robot's type (`WaveshareKind`), in memory only: after each start it is another. The
  type sets the value of a pulse and the motors' direction. In the ordinary firmware, for a type
  without encoders, 1 is a share of the power. The firmware for ROS regulates every type and reports
  its battery in hundredths of a volt.
- Watchdog: the wheels stop without a speed order for the heartbeat's time, 3,000 ms unless 136 sets
  another.
- A report is 1001 with the wheels' speeds in the last turn of the program's loop: whole encoder
  pulses over its 10 ms, so a slow wheel reports nothing or much.
- A robot without encoders (``has_encoders``) reports zeros; if it is taken for one with encoders,
  its regulator runs at full power.
- It starts with two seconds of text; its UART keeps 256 bytes of what arrives meanwhile.
"""

from __future__ import annotations

import json
import math
from typing import Any, Final, NamedTuple

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.simulator.twins.twin import ON_FOR_S, Body, Twin

WHEEL_M: Final = 0.0523
PULSES_A_TURN: Final = 1_092
PULSE_M: Final = math.pi * WHEEL_M / PULSES_A_TURN
TRACK_M: Final = 0.141


class WaveshareKind(NamedTuple):
    """The robot's own belief about its type."""

    pulse_m: float
    track_m: float
    is_turned: bool
    """The motors are wired the other way round than on the UGV01."""
    is_regulated: bool


_RASP = WaveshareKind(math.pi * 0.08 / 2_100, 0.125, is_turned=True, is_regulated=True)
_ROVER = WaveshareKind(math.pi * 0.08 / 1_650, 0.172, is_turned=True, is_regulated=True)
_UGV01 = WaveshareKind(PULSE_M, TRACK_M, is_turned=False, is_regulated=True)
ORDINARY: Final = {
    1: _RASP._replace(is_regulated=False),
    2: _ROVER._replace(is_turned=False, is_regulated=False),
    3: _UGV01,
}
FOR_ROS: Final = {1: _RASP, 2: _ROVER, 3: _UGV01}
"""By the number in command 900."""
FULL_POWER: Final = 255 / 512
"""Order with full power, where an order is a share of the power; a larger one is cut."""
BOOT_S: Final = 2.0
UART_BYTES: Final = 256
BOOT_TEXT: Final = (
    b"Initialize LittleFS for Flash files ctrl.\r\nPower up the servos.\r\nUGV started.\r\n"
)
MOST_M_S: Final = 2.0
"""Highest speed that a regulated robot accepts in an order."""
FASTEST_M_S: Final = 0.35
LOOP_S: Final = 0.01
HEARTBEAT_MS: Final = 3_000
LONGEST: Final = 512
BATTERY_V: Final = 11.9


class WaveshareTwin(Twin):
    """UART, loop and wheels of a UGV01."""

    body = Body(TRACK_M, 1 / PULSE_M, FASTEST_M_S)
    baud = 115_200
    has_frames = False

    def __init__(self, *, is_for_ros: bool = False, has_encoders: bool = True) -> None:
        self._is_for_ros, self._has_encoders = is_for_ros, has_encoders
        self._kinds = FOR_ROS if is_for_ros else ORDINARY
        self.boot(-ON_FOR_S)

    def boot(self, now_s: float) -> None:
        """Start the lower computer with its defaults."""
        self.main_type = 2 if self._is_for_ros else 1
        self._started_s = now_s + BOOT_S
        self._has_said = False
        self._waiting = bytearray()
        self._line = bytearray()
        self._out = bytearray()
        self._wanted = (0.0, 0.0)
        self._ordered_s = now_s
        self._heartbeat_s = HEARTBEAT_MS / 1000
        self._echoes, self._reports = not self._is_for_ros, self._is_for_ros
        self._extra_s = 0.0
        self._loop_s = self._reported_s = now_s
        self._pulses: tuple[int, int] | None = None
        self._measured = (0.0, 0.0)

    def receive(self, data: bytes, now_s: float) -> None:
        """Take lines."""
        if now_s < self._started_s:
            self._waiting = (self._waiting + data)[:UART_BYTES]
            return
        data, self._waiting = bytes(self._waiting) + data, bytearray()
        for value in data:
            if value == 10:
                self._take(bytes(self._line), now_s)
                self._line.clear()
            elif len(self._line) < LONGEST:
                self._line.append(value)

    def _take(self, line: bytes, now_s: float) -> None:
        try:
            order = json.loads(line)
        except ValueError:
            return
        if not isinstance(order, dict):
            return
        if self._echoes:
            self._out += line + b"\n"
        self._obey(order, now_s)

    def _obey(self, order: dict[str, Any], now_s: float) -> None:
        match order.get("T"):
            case 1 if _is_number(order.get("L")) and _is_number(order.get("R")):
                self._order(order["L"], order["R"], now_s)
            case 13:
                speed, turn = _number(order.get("X")), _number(order.get("Z"))
                aside = turn * self._kind.track_m / 2
                self._order(speed - aside, speed + aside, now_s)
            case 130:
                self._report()
            case 131:
                self._reports = _number(order.get("cmd")) == 1
            case 136:
                self._heartbeat_s = _number(order.get("cmd")) / 1000
            case 142:
                self._extra_s = abs(_number(order.get("cmd"))) / 1000
            case 900 if order.get("main") in self._kinds:
                self.main_type = order["main"]
            case 143:
                self._echoes = bool(_number(order.get("cmd")))

    def _order(self, left: float, right: float, now_s: float) -> None:
        self._ordered_s = now_s
        if max(abs(left), abs(right)) <= MOST_M_S or not self._kind.is_regulated:
            self._wanted = (left, right)

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """Run the program's loop: measure, report, watch the heartbeat."""
        if now_s < self._started_s:
            return WheelSpeeds(0.0, 0.0, powered=False)
        if self._waiting:
            self.receive(b"", now_s)
        kind = self._kind
        if now_s - self._loop_s >= LOOP_S:
            before, took_s = self._pulses or (left_ticks, right_ticks), now_s - self._loop_s
            a_pulse = (-kind.pulse_m if kind.is_turned else kind.pulse_m) * self._has_encoders
            self._measured = (
                (left_ticks - before[0]) * a_pulse / took_s,
                (right_ticks - before[1]) * a_pulse / took_s,
            )
            self._pulses, self._loop_s = (left_ticks, right_ticks), now_s
            if self._reports and now_s - self._reported_s >= self._extra_s:
                self._reported_s = now_s
                self._report()
        if now_s - self._ordered_s > self._heartbeat_s:
            self._wanted = (0.0, 0.0)
        left, right = map(self._turned, self._wanted)
        return WheelSpeeds(left, right, powered=True)

    @property
    def _kind(self) -> WaveshareKind:
        return self._kinds[self.main_type]

    def _turned(self, ordered: float) -> float:
        kind = self._kind
        if not kind.is_regulated:
            speed = ordered / FULL_POWER * FASTEST_M_S
        elif self._has_encoders:
            speed = ordered * PULSE_M / kind.pulse_m
        else:
            speed = math.copysign(FASTEST_M_S, ordered) if ordered else 0.0
        speed = max(-FASTEST_M_S, min(FASTEST_M_S, speed))
        return -speed if kind.is_turned else speed

    def _report(self) -> None:
        left, right = self._measured
        volts = round(BATTERY_V * 100) if self._is_for_ros else BATTERY_V
        told = {"T": 1001, "L": round(left, 9), "R": round(right, 9), "r": 0.31, "p": -0.12,
                "y": "null", "v": volts}  # fmt: skip
        self._out += json.dumps(told, separators=(",", ":")).encode() + b"\r\n"

    def bytes_to_send(self, now_s: float) -> bytes:
        """Return echoes and reports."""
        if self._started_s > now_s and not self._has_said:
            self._has_said = True
            return BOOT_TEXT
        told = bytes(self._out)
        self._out.clear()
        return told


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _number(value: object) -> float:
    """Number as the program's library reads it: 0 if missing or no number."""
    return float(value) if isinstance(value, int | float) else 0.0

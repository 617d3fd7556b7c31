"""The twin of a Waveshare UGV with encoders (UGV01), from the list of its commands.

- One JSON object a line, both ways; a line that is no JSON, and a command without what it needs,
  is ignored. Commands are echoed unless 143 switches that off.
- 1 orders the wheels' speeds in m/s (a speed beyond 2 m/s is ignored as a whole order), 13 linear
  and angular speed, 131 switches the reports on, 142 makes them rarer, 130 asks for one.
- Watchdog: without a speed order for the heartbeat's time, 3,000 ms unless 136 sets another, the
  wheels stop.
- A report is 1001 with the speeds of the wheels in the last turn of the program's loop: whole
  encoder pulses over its 10 ms, so a slow wheel reports nothing in one turn and much in the next.
"""

from __future__ import annotations

import json
import math
from typing import Any, Final

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.simulator.twins.twin import Body

WHEEL_M: Final = 0.0523
PULSES_A_TURN: Final = 1_092
PULSE_M: Final = math.pi * WHEEL_M / PULSES_A_TURN
TRACK_M: Final = 0.141
MOST_M_S: Final = 2.0
"""What an order may say."""
FASTEST_M_S: Final = 0.35
LOOP_S: Final = 0.01
HEARTBEAT_MS: Final = 3_000
LONGEST: Final = 512
BATTERY_V: Final = 11.9


class WaveshareTwin:
    """Its UART, its loop and its wheels."""

    body = Body(TRACK_M, 1 / PULSE_M, FASTEST_M_S)
    baud = 115_200

    def __init__(self) -> None:
        self.boot(0.0)

    def boot(self, now_s: float) -> None:
        """The lower computer starts with its defaults."""
        self._line = bytearray()
        self._out = bytearray()
        self._wanted = (0.0, 0.0)
        self._ordered_s = now_s
        self._heartbeat_s = HEARTBEAT_MS / 1000
        self._echoes, self._reports = True, False
        self._extra_s = 0.0
        self._loop_s = self._reported_s = now_s
        self._pulses: tuple[int, int] | None = None
        self._measured = (0.0, 0.0)

    def bump(self, pressed: bool) -> None:
        """It has no bumper."""

    def lift(self, lifted: bool) -> None:
        """It does not feel that."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Lines."""
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
                self._order(speed - turn * TRACK_M / 2, speed + turn * TRACK_M / 2, now_s)
            case 130:
                self._report()
            case 131:
                self._reports = _number(order.get("cmd")) == 1
            case 136:
                self._heartbeat_s = _number(order.get("cmd")) / 1000
            case 142:
                self._extra_s = abs(_number(order.get("cmd"))) / 1000
            case 143:
                self._echoes = bool(_number(order.get("cmd")))

    def _order(self, left: float, right: float, now_s: float) -> None:
        self._ordered_s = now_s
        if abs(left) <= MOST_M_S and abs(right) <= MOST_M_S:
            self._wanted = (left, right)

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """The program's loop: measure, report, watch the heartbeat."""
        if now_s - self._loop_s >= LOOP_S:
            before, took_s = self._pulses or (left_ticks, right_ticks), now_s - self._loop_s
            self._measured = (
                (left_ticks - before[0]) * PULSE_M / took_s,
                (right_ticks - before[1]) * PULSE_M / took_s,
            )
            self._pulses, self._loop_s = (left_ticks, right_ticks), now_s
            if self._reports and now_s - self._reported_s >= self._extra_s:
                self._reported_s = now_s
                self._report()
        if now_s - self._ordered_s > self._heartbeat_s:
            self._wanted = (0.0, 0.0)
        return WheelSpeeds(*self._wanted, powered=True)

    def _report(self) -> None:
        left, right = self._measured
        told = {"T": 1001, "L": round(left, 9), "R": round(right, 9), "r": 0.31, "p": -0.12,
                "y": "null", "v": BATTERY_V}  # fmt: skip
        self._out += json.dumps(told, separators=(",", ":")).encode() + b"\r\n"

    def bytes_to_send(self, now_s: float) -> bytes:
        """Echoes and reports."""
        told = bytes(self._out)
        self._out.clear()
        return told


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _number(value: object) -> float:
    """What the program's library makes of a value that is missing or no number: 0."""
    return float(value) if isinstance(value, int | float) else 0.0

"""Driver of Waveshare's UGVs with encoders, over their JSON commands.

- One JSON object a line. The greeting switches the echo off and the stream of reports on, and sets
  the robot's watchdog to half a second; a robot whose reports stop may have restarted, and is
  greeted again.
- The robot's program keeps its type (``model``) only in memory and never reports it, but needs it
  for the motors' direction and a pulse's length: it is in the greeting and repeated.
- Reports hold speeds, not counts. The travel is their integral over the time between them; reports
  that arrive together share it. A robot that reports only zeros while driven has no encoders, and
  may be at full power: it is stopped.

Metres and seconds.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any, Final

from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.robot_driver import Heard
from navigation.shared.outside import finite_number

WATCHDOG_MS: Final = 500
GREET_S: Final = 1.0
SILENT_S: Final = 0.3
REPEAT_S: Final = 0.1
SPACING_S: Final = 0.02
LONGEST: Final = 1024
REPORT: Final = 1001
EMPTY_V, FULL_V = 9.0, 12.6
"""Three lithium cells in a row."""
HUNDREDTHS_V: Final = 100.0
"""A battery of more volts is one of hundredths of a volt, as the firmware for ROS reports it."""
MAIN_TYPES: Final[Mapping[str, int]] = {"rasp_rover": 1, "ugv_rover": 2, "ugv01": 3}
"""The robot's number in command 900, by its model."""
TYPE_S: Final = 0.5
"""Interval of repeating the command: it may be lost, and an ESP32 that starts again has forgotten
it."""
DRIVEN_M_S: Final = 0.03
BLIND_S: Final = 0.5
"""Time in which a wheel ordered faster than that turns by hundreds of pulses."""
BLIND: Final = (
    "its wheels are driven, and it counts nothing: it has no encoders (a WAVE ROVER), robot.model "
    "names another robot, or its motors have no power"
)
GREETING: Final = (
    {"T": 143, "cmd": 0},
    {"T": 142, "cmd": 0},
    {"T": 136, "cmd": WATCHDOG_MS},
    {"T": 131, "cmd": 1},
)


class WaveshareDriver:
    """See `RobotDriver`."""

    robot = KNOWN_ROBOTS["waveshare"]

    def __init__(self, model: str = "ugv01") -> None:
        self.heard = Heard()
        self._type = _line({"T": 900, "main": MAIN_TYPES[model], "module": 0})
        self._buffer = bytearray()
        self._wanted = (0.0, 0.0)
        self._forget_the_line()

    def _forget_the_line(self) -> None:
        self._sent = (0.0, 0.0)
        self._sent_s = self._greeted_s = self._heard_s = self._typed_s = -math.inf
        self._has_counted = False
        self._driven_since_s: float | None = None

    def open(self, now_s: float) -> None:
        """Greet it at once, which stops it."""
        self._buffer.clear()
        self._wanted = (0.0, 0.0)
        self._forget_the_line()

    def drive(self, left_m_s: float, right_m_s: float) -> None:
        """Set the speeds, to a tenth of a millimetre a second."""
        self._wanted = (round(left_m_s, 4), round(right_m_s, 4))

    def clear_fault(self) -> None:
        """Try its wheels again."""
        self.heard.fault = None
        self._driven_since_s = None

    # Bytes out.

    def bytes_to_send(self, now_s: float) -> bytes:
        """The greeting, or the wheels' speeds when they change and now and then."""
        if now_s - self._heard_s > SILENT_S and now_s - self._greeted_s >= GREET_S:
            self._greeted_s = self._typed_s = now_s
            self._has_counted = False
            greeting = b"\n" + self._order(0.0, 0.0, now_s) + self._type
            return greeting + b"".join(map(_line, GREETING))
        age_s = now_s - self._sent_s
        stops = self._wanted == (0.0, 0.0) != self._sent
        if stops or age_s >= REPEAT_S or (self._wanted != self._sent and age_s >= SPACING_S):
            return self._order(*self._wanted, now_s)
        if now_s - self._typed_s >= TYPE_S:
            self._typed_s = now_s
            return self._type
        return b""

    def _order(self, left_m_s: float, right_m_s: float, now_s: float) -> bytes:
        self._sent, self._sent_s = (left_m_s, right_m_s), now_s
        if max(abs(left_m_s), abs(right_m_s)) < DRIVEN_M_S:
            self._driven_since_s = None
        elif self._driven_since_s is None:
            self._driven_since_s = now_s
        return _line({"T": 1, "L": left_m_s, "R": right_m_s})

    # Bytes in.

    def receive(self, data: bytes, now_s: float) -> None:
        """Read lines; the reports among them share the time since the last one."""
        self._buffer += data
        *lines, rest = self._buffer.split(b"\n")
        self._buffer = bytearray(rest[-LONGEST:])
        reports = [report for line in lines if (report := self._read(bytes(line))) is not None]
        if not reports:
            return
        heard, gone_s = self.heard, now_s - self._heard_s
        self._heard_s = now_s
        if gone_s <= SILENT_S:
            heard.left_m += sum(left for left, _ in reports) * gone_s / len(reports)
            heard.right_m += sum(right for _, right in reports) * gone_s / len(reports)
        heard.odometry_s = now_s
        self._has_counted = self._has_counted or any(map(any, reports))
        since_s = self._driven_since_s
        if not self._has_counted and since_s is not None and now_s - since_s > BLIND_S:
            heard.fault = BLIND

    def _read(self, line: bytes) -> tuple[float, float] | None:
        line = line.strip()
        if not line:
            return None
        if line.startswith((b"q,", b"v,Version", b"z,Command not found")):
            self.heard.stranger = "epuck2"
        try:
            report = json.loads(line)
        except ValueError:
            self.heard.damaged += 1
            return None
        if not isinstance(report, dict) or report.get("T") != REPORT:
            return None
        speeds = finite_number(report.get("L")), finite_number(report.get("R"))
        most = 2.0 * self.robot.wheel_m_s
        if any(speed is None or abs(speed) > most for speed in speeds):
            self.heard.damaged += 1
            return None
        self.heard.messages += 1
        self.heard.identity = self.robot.title
        volts = finite_number(report.get("v"))
        if volts is not None:
            volts = volts / 100 if volts > HUNDREDTHS_V else volts
            self.heard.battery = max(0.0, min(1.0, (volts - EMPTY_V) / (FULL_V - EMPTY_V)))
        left, right = speeds
        assert left is not None
        assert right is not None
        return left, right


def _line(order: dict[str, Any]) -> bytes:
    return json.dumps(order, separators=(",", ":")).encode() + b"\n"

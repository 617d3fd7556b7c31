"""Driver of the e-puck2 over its text commands, by USB or Bluetooth.

- Lines of text: `D,left,right` orders steps a second, `Q` asks for the steps made. The next
  question waits for the last one's answer or timeout.
- Each command begins with a zero. It means nothing in text, but ends the binary mode into which a
  damaged character puts the robot.
- The first command on an open port also begins with an end of line, so that an order cut off by a
  dead sender spoils nothing.
- The text has no check: a count that the wheels cannot have made is left out. The robot keeps the
  last order for ever, so orders are repeated, stops too.

Metres and seconds.
"""

from __future__ import annotations

import math
import re
from typing import Final

from navigation.config.known_robots import KNOWN_ROBOTS
from navigation.link.drivers.robot_driver import Heard
from navigation.link.drivers.wheel_odometry import WheelOdometry

CYCLE_S: Final = 0.02
PATIENCE_S: Final = 0.1
"""Time after which an answer is lost; Bluetooth takes some 40 ms."""
REPEAT_S: Final = 0.1
ASK_S: Final = 5.0
"""Interval of asking for its battery."""
WHO_S: Final = 1.0
LONGEST: Final = 256
STEPS: Final = re.compile(rb"q,(-?\d+),(-?\d+)")
BATTERY: Final = re.compile(rb"b,\d+ \((\d+)%\)")
OTHERS: Final = re.compile(rb"[a-pr-z](,.*)?|HW version.*|.*WELCOME.*|.*the EPFL.*|z,.*|g .*")
"""Other lines of the robot."""


class Epuck2Driver:
    """See `RobotDriver`."""

    robot = KNOWN_ROBOTS["epuck2"]

    def __init__(self) -> None:
        self.heard = Heard()
        assert self.robot.metres_per_count is not None
        self._metres_per_step = self.robot.metres_per_count
        self._odometry = WheelOdometry(self._metres_per_step, self.robot.wheel_m_s, modulus=None)
        self._buffer = bytearray()
        self._wanted = (0, 0)
        self._forget_the_line()

    def _forget_the_line(self) -> None:
        self._sent: tuple[int, int] | None = None
        self._sent_s = self._asked_s = self._who_s = self._battery_s = -math.inf
        self._waits = False
        self._is_new = True

    def open(self, now_s: float) -> None:
        """Begin with a stop as the first order."""
        self._buffer.clear()
        self._odometry.forget()
        self._wanted = (0, 0)
        self._forget_the_line()

    def drive(self, left_m_s: float, right_m_s: float) -> None:
        """Set the speeds in whole steps a second."""
        self._wanted = (
            round(left_m_s / self._metres_per_step),
            round(right_m_s / self._metres_per_step),
        )

    def clear_fault(self) -> None:
        """Do nothing: it reports no fault."""

    # Bytes out.

    def bytes_to_send(self, now_s: float) -> bytes:
        """An order when it changes and now and then, and the next question."""
        commands = []
        stops = self._wanted == (0, 0) and self._sent != (0, 0)
        age_s = now_s - self._sent_s
        if stops or age_s >= REPEAT_S or (self._wanted != self._sent and age_s >= CYCLE_S):
            self._sent, self._sent_s = self._wanted, now_s
            commands.append(f"D,{self._wanted[0]},{self._wanted[1]}")
        if now_s - self._asked_s >= (PATIENCE_S if self._waits else CYCLE_S):
            self._asked_s, self._waits = now_s, True
            commands.append("Q")
        if self.heard.identity is None and now_s - self._who_s >= WHO_S:
            self._who_s = now_s
            commands.append("V")
        if now_s - self._battery_s >= ASK_S:
            self._battery_s = now_s
            commands.append("b")
        begins = b"\r" if self._is_new and commands else b""
        self._is_new = self._is_new and not commands
        return begins + b"".join(b"\0" + command.encode() + b"\r" for command in commands)

    # Bytes in.

    def receive(self, data: bytes, now_s: float) -> None:
        """Read whole lines; the rest waits for its end."""
        self._buffer += data
        *lines, rest = self._buffer.replace(b"\r", b"\n").split(b"\n")
        self._buffer = bytearray(rest[-LONGEST:])
        for line in lines:
            if line:
                self._take(bytes(line), now_s)

    def _take(self, line: bytes, now_s: float) -> None:
        heard = self.heard
        if (steps := STEPS.fullmatch(line)) is not None:
            self._waits = False
            heard.messages += 1
            if not self._odometry.count(int(steps[1]), int(steps[2]), now_s):
                heard.damaged += 1
            elif heard.identity is not None:
                heard.left_m, heard.right_m = self._odometry.left_m, self._odometry.right_m
                heard.odometry_s = now_s
        elif line.startswith(b"v,Version"):
            heard.messages += 1
            heard.identity = f"{self.robot.title}, {line[2:60].decode('ascii', 'replace')}"
        elif (battery := BATTERY.fullmatch(line)) is not None:
            heard.messages += 1
            heard.battery = min(1.0, int(battery[1]) / 100)
        elif line.startswith(b'{"T":'):
            heard.stranger = "waveshare"
        elif OTHERS.fullmatch(line) is None:
            heard.damaged += 1

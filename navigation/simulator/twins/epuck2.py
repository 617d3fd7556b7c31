"""Twin of an e-puck2, from the handler of its text commands (its selector at 3 or 8).

- A command is a line that ends with CR or LF; its first letter counts. The answer begins with that
  letter in lower case and ends with CR LF; for an unknown command it is "z,Command not found".
- Stepper motors obey exactly, in whole steps a second; the counts are the ordered steps, 1,000 a
  turn, of 32 bits. Only the motors limit `D`.
- A character with the highest bit at a line's beginning starts the binary mode, which consumes all
  up to the next zero. A zero in text is ignored.
- No watchdog: the wheels keep the last order.
- An unreadable number keeps its last value, as in C's sscanf.
"""

from __future__ import annotations

import math
import re
from typing import Final

from firmware_protocol.robot.controller import WheelSpeeds
from navigation.simulator.twins.twin import Body, Twin

STEPS_A_TURN: Final = 1_000
WHEEL_M: Final = 0.041
STEP_M: Final = math.pi * WHEEL_M / STEPS_A_TURN
MOST_STEPS_S: Final = 1_100
WELCOME: Final = (
    b'\x0c\x07WELCOME to the SerCom protocol on e-Puck\r\nthe EPFL education robot type "H" for '
    b"help\r\n"
)
VERSION: Final = b"v,Version 2.0 January 2018 GCtronic\r\nHW version: FFFF\r\n"
LONGEST: Final = 80


class Epuck2Twin(Twin):
    """Serial port and two steppers of an e-puck2."""

    body = Body(0.053, 1 / STEP_M, MOST_STEPS_S * STEP_M)
    baud = 115_200
    has_frames = False

    def __init__(self) -> None:
        self.boot(0.0)

    def boot(self, now_s: float) -> None:
        """Start, with a greeting on the line."""
        self._line = bytearray()
        self._out = bytearray(WELCOME)
        self._wanted = [0, 0]
        self._steps = [0, 0]
        self._near = self._is_binary = False

    def bump(self, pressed: bool) -> None:
        """Put something before its front distance sensors, or take it away."""
        self._near = pressed

    def receive(self, data: bytes, now_s: float) -> None:
        """Take characters; the binary mode consumes some."""
        for value in data:
            if self._is_binary or (value >= 0x80 and not self._line):
                self._is_binary = value != 0
            elif value in b"\r\n":
                if self._line:
                    self._obey(self._line.decode("latin-1"))
                self._line.clear()
            elif value != 0 and len(self._line) < LONGEST:
                self._line.append(value)

    def _obey(self, line: str) -> None:
        letter = line[0] if line[0] in "bg" else line[0].upper()
        match letter:
            case "D":
                for side, value in enumerate(_numbers(line)):
                    self._wanted[side] = value
                self._say("d")
            case "E":
                self._say(f"e,{self._wanted[0]},{self._wanted[1]}")
            case "Q":
                self._say(f"q,{self._steps[0]},{self._steps[1]}")
            case "S":
                self._wanted = [0, 0]
                self._say("s")
            case "V":
                self._out += VERSION
            case "N":
                near = 3_000 if self._near else 20
                self._say(f"n,{near},30,10,0,0,12,25,{near}")
            case "b":
                self._say("b,1810 (71%)")
            case "C":
                self._say("c,8")
            case "L" | "F" | "B" | "P" | "T" | "J":
                self._say(letter.lower())
            case "R":
                pass
            case _:
                self._say("z,Command not found")

    def _say(self, words: str) -> None:
        self._out += words.encode() + b"\r\n"

    def step(self, now_s: float, left_ticks: int, right_ticks: int) -> WheelSpeeds:
        """Turn the steppers as ordered."""
        self._steps = [left_ticks, right_ticks]
        left, right = (max(-MOST_STEPS_S, min(MOST_STEPS_S, w)) * STEP_M for w in self._wanted)
        return WheelSpeeds(left, right, powered=True)

    def bytes_to_send(self, now_s: float) -> bytes:
        """Return the answers, in the order of the commands."""
        answer = bytes(self._out)
        self._out.clear()
        return answer


def _numbers(line: str) -> list[int]:
    found: list[int] = []
    rest = line[1:]
    while len(found) < 2 and (match := re.match(r",\s*([+-]?\d+)", rest)):
        found.append(int(match[1]))
        rest = rest[match.end() :]
    return found

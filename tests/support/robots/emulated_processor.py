"""A microcontroller in another process, in lockstep with this one's time.

The program emulates the robot's processor with its real firmware. Messages on stdin and stdout are
little-endian integers, packed. Request: u32 microseconds to run, i16 and i16 encoder steps (left,
right) to make meanwhile, u8 flags (bit 0: reset first), u16 count, count bytes for the UART.
Answer: u8 PWM left, u8 PWM right, u8 bit 0 powered, bit 1 left backwards, bit 2 right backwards;
u32 cycle of the last power-off, u32 cycle now; u16 count, count bytes from the UART. The cycles
wrap after 268 s and are unwrapped here, if power-offs are read within that time.
"""

from __future__ import annotations

import struct
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

CLOCK_HZ = 16_000_000
FULL_SPEED_M_S = 0.8
"""A wheel's speed at full PWM, as in the firmware."""
TICK_M = 250e-6
"""A wheel's travel per encoder step."""
_CYCLES_WRAP = 1 << 32
_REQUEST = struct.Struct("<IhhBH")
_ANSWER = struct.Struct("<BBBIIH")


class EmulatorError(ValueError):
    """The emulator cannot be started, or has ended."""


class Motors(NamedTuple):
    """State of the board's outputs."""

    left_m_s: float
    right_m_s: float
    powered: bool
    off_s: float
    """Last power-off of the motors, in the emulated processor's time."""
    now_s: float


class EmulatedProcessor:
    """The running program ``command``; :meth:`close` ends it. EmulatorError if it is missing."""

    def __init__(self, command: Sequence[str | Path]) -> None:
        try:
            self._process = subprocess.Popen(
                list(command),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        except OSError as error:
            raise EmulatorError(f"emulator '{command[0]}': {error.strerror}") from None
        self._rest = [0.0, 0.0]
        self._cycles = 0

    def run(
        self,
        seconds: float,
        data: bytes = b"",
        wheels_m: tuple[float, float] = (0.0, 0.0),
        reset: bool = False,
    ) -> tuple[Motors, bytes]:
        """Let time pass with arriving bytes and wheels turning by ``wheels_m``; EmulatorError."""
        steps = []
        for side, travel in enumerate(wheels_m):
            self._rest[side] += travel / TICK_M
            whole = round(self._rest[side])
            self._rest[side] -= whole
            steps.append(whole)
        head = _REQUEST.pack(round(seconds * 1e6), *steps, int(reset), len(data))
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(head + data)
            self._process.stdin.flush()
        except OSError:
            raise EmulatorError("the emulator has ended") from None
        left, right, state, off, now, count = _ANSWER.unpack(self._read(_ANSWER.size))
        powered = bool(state & 1)
        speeds = [
            pwm / 255.0 * FULL_SPEED_M_S * (-1.0 if state & backwards else 1.0) if powered else 0.0
            for pwm, backwards in ((left, 2), (right, 4))
        ]
        self._cycles += (now - self._cycles) % _CYCLES_WRAP
        off_cycles = self._cycles - (now - off) % _CYCLES_WRAP
        left_m_s, right_m_s = speeds
        motors = Motors(
            left_m_s, right_m_s, powered, off_cycles / CLOCK_HZ, self._cycles / CLOCK_HZ
        )
        return motors, self._read(count)

    def _read(self, size: int) -> bytes:
        assert self._process.stdout is not None
        data = self._process.stdout.read(size)
        if len(data) < size:
            raise EmulatorError("the emulator has ended")
        return data

    def close(self) -> None:
        """End the program."""
        self._process.kill()
        self._process.communicate()

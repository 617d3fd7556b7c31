"""Wheels that do not turn below a least speed: what is slower, they are driven in pulses of it.

- A pulse begins when a wheel owes what it travels in PULSE_US at its least speed, and ends when it
  owes nothing: so it is never too short to break a wheel loose, and what a wheel has been ordered
  and what it was driven differ by less than a pulse and a cycle, however long it goes on.
- The left wheel is half a pulse ahead. A robot that turns on the spot turns by one wheel's pulse at
  a time, half of what both together would turn it by.
- An order of zero is zero at once, and so is everything slower while the robot stops.

The twin of ``firmware/pulses.c``: whole numbers, speeds in eighths of mm/s, what is
owed in those times microseconds.
"""

from __future__ import annotations

from firmware_protocol.wire.drive_settings import PULSE_US


class WheelPulses:
    """Both wheels; ask for :meth:`next` once a cycle."""

    def __init__(self, least: int) -> None:
        self._least = least
        self._owed = [0, 0]
        self._ordered = [0, 0]
        self._driven = [0, 0]

    def forget(self) -> None:
        """A stop: nothing is owed, and nothing driven."""
        self._owed, self._ordered, self._driven = [0, 0], [0, 0], [0, 0]

    def next(self, dt_us: int, left: int, right: int) -> tuple[int, int]:
        """What to drive the wheels at from now on, so long after the last time."""
        for side, order in enumerate((left, right)):
            self._owed[side] += (self._ordered[side] - self._driven[side]) * dt_us
            self._ordered[side] = order
            self._driven[side] = self._pulsed(side, order)
        return self._driven[0], self._driven[1]

    def stop(self, _dt_us: int, left: int, right: int) -> tuple[int, int]:
        """The same for a robot that stops: no pulse keeps it moving."""
        self._owed = [0, 0]
        for side, order in enumerate((left, right)):
            self._ordered[side] = order
            self._driven[side] = order if abs(order) >= self._least else 0
        return self._driven[0], self._driven[1]

    def _pulsed(self, side: int, order: int) -> int:
        if order == 0 or abs(order) >= self._least:
            return order
        sign = 1 if order > 0 else -1
        pulse = self._least * PULSE_US
        owed = sign * self._owed[side] + (0 if side else pulse >> 1)
        goes_on = sign * self._driven[side] > 0 and owed > 0
        return sign * self._least if goes_on or owed >= pulse else 0

"""Pulses for wheels that do not turn below a least speed: slower orders become pulses of it.

- A pulse begins when a wheel owes its travel of PULSE_US at the least speed, and ends when it owes
  nothing. It breaks a wheel loose, and ordered and driven travel differ by less than a pulse and a
  cycle.
- The left wheel is half a pulse ahead, so that turns on the spot have half the step.
- An order of zero is zero at once, and so is any slow order while the robot stops.

Speeds are eighths of mm/s; what a wheel owes is in those times microseconds. The twin of
``pulses.c``.
"""

from array import array

from .native import micropython

PULSE_US = 25000
"""Three control cycles, in which a wheel breaks loose."""


class WheelPulses:
    """Both wheels. ``driven``: the speeds to drive, the left one first."""

    def __init__(self, least: int) -> None:
        self.driven = array("i", (0, 0))
        self._least = least
        self._ordered = array("i", (0, 0))
        self._owed = array("i", (0, 0))

    def forget(self) -> None:
        """Stop: nothing is owed, and nothing driven."""
        for side in (0, 1):
            self._ordered[side] = self._owed[side] = self.driven[side] = 0

    @micropython.native
    def next(self, dt_us: int, left: int, right: int) -> None:
        """Take new orders, ``dt_us`` after the last ones."""
        owed, ordered, driven = self._owed, self._ordered, self.driven  # four would take heap
        least = self._least
        owed[0] += (ordered[0] - driven[0]) * dt_us
        owed[1] += (ordered[1] - driven[1]) * dt_us
        ordered[0], ordered[1] = left, right
        driven[0] = pulsed(least, left, driven[0], owed[0], True)
        driven[1] = pulsed(least, right, driven[1], owed[1], False)

    @micropython.native
    def stop(self, left: int, right: int) -> None:
        """Take new orders while the robot stops: no pulse keeps it moving."""
        least = self._least
        self._owed[0] = self._owed[1] = 0
        self._ordered[0], self._ordered[1] = left, right
        self.driven[0] = left if abs(left) >= least else 0
        self.driven[1] = right if abs(right) >= least else 0


@micropython.native
def pulsed(least: int, order: int, driven: int, owed: int, ahead: bool) -> int:
    """Speed to drive a wheel ordered at ``order`` and last driven at ``driven``."""
    if order == 0 or abs(order) >= least:
        return order
    pulse = least * PULSE_US
    if order < 0:
        owed, driven, least = -owed, -driven, -least
    if ahead:
        owed += pulse >> 1
    return least if owed >= pulse or (driven > 0 and owed > 0) else 0

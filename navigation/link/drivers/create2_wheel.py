"""One wheel of a Create 2: the next of its few speeds, and its direction.

- Its controller has steps of 28.5 mm/s and nothing below 11. The orders alternate between two
  steps; each one's error is carried into the next, so that speed and bend are right in the mean.
- Its encoder senses no direction: the robot counts down while it orders the wheel backwards and up
  otherwise, even if a wheel rolls out from backwards. A wheel keeps its direction until it has
  passed zero: only that gives a count its sign. While only a hand can turn the wheel, counts have
  none.

Whole mm/s, seconds.
"""

from __future__ import annotations

import math
from typing import Final

LEAST_MM_S, STEP_MM_S, STEP_ADDS_MM_S = 11, 28.5, 10.5
"""Step n is driven at n widths and 10.5 for orders from 11 and n - 1 widths on, below the next."""
MOST_MM_S: Final = 500
FASTEST_STEP: Final = 17
"""495 mm/s; what lies above is cut at 500."""
LAG_S: Final = 0.05
"""Time in which a wheel comes nearer to its order by a factor of e; twice or half of it serves as
well (`test_a_create_s_wheels_may_lag_otherwise`)."""
AT_REST_MM_S: Final = 0.5
"""A wheel that rolled out to this speed moves by 0.03 mm more."""
NEVER: Final = frozenset(
    (7, *range(128, 131), *range(132, 139), 140, 143, 144, 146, *range(148, 151), 173)
)
"""Low bytes of a speed that would be an order if the byte before them were lost: reset, power off,
clean, dock, another baud, or one that takes the next orders for its data. Such a speed is changed
by as few mm/s as helps."""


class Create2Wheel:
    """A wheel; call :meth:`next_order` once a cycle, and report orders by :meth:`ordered`."""

    def __init__(self) -> None:
        self._left_over = 0.0
        self._order = 0.0
        self._ordered_s = -math.inf
        self._speed = 0.0
        """Speed at the last order."""

    def next_order(self, wanted_mm_s: float) -> int:
        """Order of the step nearest to the speed plus the remainder; sends nothing."""
        due = wanted_mm_s + self._left_over
        number = _nearest_step(abs(due))
        spare = due - math.copysign(_speed_of(number), due)
        # speed beyond the fastest step is never caught up on
        self._left_over = max(-STEP_MM_S, min(STEP_MM_S, spare))
        return harmless(round(math.copysign(_order_of(number), due)))

    def forget(self) -> None:
        """Drop the remainder at a stop."""
        self._left_over = 0.0

    def ordered(self, order_mm_s: int, now_s: float) -> None:
        """Note that this order has gone out to the wheel."""
        self._speed, self._ordered_s = self._speed_at(now_s), now_s
        self._order = driven(order_mm_s)

    def direction(self, now_s: float) -> int:
        """Direction: 1 forwards, -1 backwards, 0 at rest, if only a hand can turn it."""
        speed = self._speed_at(now_s)
        if abs(speed) < AT_REST_MM_S:
            speed = self._order
        return (speed > 0) - (speed < 0)

    def _speed_at(self, now_s: float) -> float:
        gone = math.exp(-max(0.0, now_s - self._ordered_s) / LAG_S)
        return self._order + (self._speed - self._order) * gone


def driven(order_mm_s: int) -> float:
    """Speed given by an order."""
    number = math.floor((abs(order_mm_s) - LEAST_MM_S) / STEP_MM_S) + 1
    speed = min(float(MOST_MM_S), _speed_of(max(0, number)))
    return speed if order_mm_s >= 0 else -speed


def harmless(speed_mm_s: int) -> int:
    """Nearest speed whose low byte is not in `NEVER`; the slower of two."""
    for off in range(5):
        for speed in (abs(speed_mm_s) - off, abs(speed_mm_s) + off):
            signed = speed if speed_mm_s >= 0 else -speed
            if speed >= 0 and signed & 0xFF not in NEVER:
                return signed
    raise AssertionError(f"{speed_mm_s}: nine speeds in a row, and each an order")


def _speed_of(number: int) -> float:
    return number * STEP_MM_S + STEP_ADDS_MM_S if number else 0.0


def _order_of(number: int) -> float:
    return LEAST_MM_S + (number - 0.5) * STEP_MM_S if number else 0.0


def _nearest_step(speed_mm_s: float) -> int:
    """Nearest step; the slower of two."""
    if speed_mm_s <= _speed_of(1) / 2:
        return 0
    number = math.ceil((speed_mm_s - STEP_ADDS_MM_S) / STEP_MM_S - 0.5)
    return max(1, min(FASTEST_STEP, number))

"""Whole-number geometry, as a processor without floating point does it.

The twin of ``firmware/fixed.c``, bit for bit: the same additions and shifts in the same order,
so that both robots can be compared exactly.

- Places are micrometres. Angles are 32-bit binary angles: 2**32 is a full turn, so that sums
  wrap by themselves.
- Speeds are mm/s times 1024, "q10".
- A vector's x and y are within 2**29 micrometres; :func:`between` keeps to that.
"""

from __future__ import annotations

from math import isqrt
from typing import Final, NamedTuple

FULL_TURN: Final = 1 << 32
ANGLE_PER_MRAD: Final = 683_565
GAIN: Final = 39_797
"""65536 over the length that the steps of turning add."""
_LARGE_BITS: Final = 29
_FAR: Final = 1 << 27
_STEP_ANGLES: Final = (
    *(536870912, 316933406, 167458907, 85004756, 42667331, 21354465, 10679838, 5340245),
    *(2670163, 1335087, 667544, 333772, 166886, 83443, 41722, 20861),
)
"""atan(2**-i) as binary angles."""
_STEPS: Final = tuple(enumerate(_STEP_ANGLES))


class Place(NamedTuple):
    """A point of the arena."""

    x_um: int
    y_um: int


def mrad(milliradians: int) -> int:
    """A binary angle."""
    return milliradians * ANGLE_PER_MRAD


def wrapped(number: int) -> int:
    """Modulo 2**32, as a signed number."""
    return ((number + 0x80000000) & 0xFFFFFFFF) - 0x80000000


def scale(number: int, part: int) -> int:
    """``number * part / 65536``, to the nearest; 0 <= part < 65536."""
    return (number * part + 0x8000) >> 16


def root(square: int) -> int:
    """The whole part of the square root."""
    return isqrt(square)


def between(start: Place, end: Place) -> tuple[int, int]:
    """The vector from one place to another; further than 536 m counts as 536 m."""
    return _apart(start.x_um, end.x_um), _apart(start.y_um, end.y_um)


def _apart(start: int, end: int) -> int:
    coarse = (end >> 2) - (start >> 2)
    if coarse >= _FAR:
        return 4 * _FAR
    if coarse <= -_FAR:
        return -4 * _FAR
    return end - start


def turned(x: int, y: int, angle: int) -> tuple[int, int]:
    """The vector turned by an angle: Volder's algorithm (CORDIC, 1959)."""
    if x == 0 == y:
        return 0, 0
    up = max(0, _LARGE_BITS - (abs(x) | abs(y)).bit_length())
    x, y = x << up, y << up
    if abs(angle) > 0x40000000:
        x, y, angle = -x, -y, wrapped(angle + 0x80000000)
    for i, step in _STEPS:
        if angle >= 0:
            x, y, angle = x - (y >> i), y + (x >> i), angle - step
        else:
            x, y, angle = x + (y >> i), y - (x >> i), angle + step
    half = (1 << up) >> 1
    return (scale(x, GAIN) + half) >> up, (scale(y, GAIN) + half) >> up


def measured(x: int, y: int) -> tuple[int, int]:
    """A vector's length and bearing, by turning it onto the x axis."""
    if x == 0 == y:
        return 0, 0
    up = max(0, _LARGE_BITS - (abs(x) | abs(y)).bit_length())
    x, y, angle = x << up, y << up, 0
    if x < 0:
        x, y, angle = -x, -y, 0x80000000
    for i, step in _STEPS:
        if y < 0:
            x, y, angle = x - (y >> i), y + (x >> i), angle - step
        else:
            x, y, angle = x + (y >> i), y - (x >> i), angle + step
    return (scale(x, GAIN) + ((1 << up) >> 1)) >> up, wrapped(angle)


def angle_of(heading: int) -> int:
    """A heading of the wire, 1e-4 rad, as a binary angle: 2**32 over 20000 pi is 68356.53."""
    return wrapped(heading * 68356 + (heading >> 1))


def heading_of(angle: int) -> int:
    """A binary angle as a heading of the wire."""
    return (scale(angle, 62832) + 0x8000) >> 16

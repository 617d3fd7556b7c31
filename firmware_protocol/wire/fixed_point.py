"""Whole-number geometry, as a processor without floating point does it.

The twin of ``firmware/fixed.c``, bit for bit: the same sums, products and shifts, so that both
robots can be compared exactly.

- Places are micrometres. Headings are 32-bit binary angles: 2**32 is a full turn, so that sums
  wrap by themselves; all other angles are their upper 16 bits, 2**16 a turn.
- Parts of a whole are of 16384, signed, or of 65536, unsigned.
- A vector between two places is in quarters: 4 um, so that the whole range of the wire fits.
"""

from __future__ import annotations

from functools import lru_cache
from math import isqrt
from typing import Final, NamedTuple

FULL_TURN: Final = 1 << 16
HALF_TURN: Final = 1 << 15
QUARTER_TURN: Final = 1 << 14
_SINE: Final = (51_455, 42_078, 4_709)
_ARC: Final = (41_528, 24_095, 6_627)
"""Odd polynomials on 0..1, the coefficients fitted for the least largest error: the sine of a
quarter turn, and the arc tangent as a part of an eighth of a turn."""


class Place(NamedTuple):
    """A point of the arena."""

    x_um: int
    y_um: int


def mrad(milliradians: int) -> int:
    """An angle of 2**16 a turn."""
    return milliradians * 10_430 // 1000


def wrapped(number: int) -> int:
    """Modulo 2**32, as a signed number."""
    return ((number + 0x80000000) & 0xFFFFFFFF) - 0x80000000


def wrapped_short(number: int) -> int:
    """Modulo 2**16, as a signed number."""
    return ((number + 0x8000) & 0xFFFF) - 0x8000


def aside(angle: int) -> int:
    """How far an angle of 2**16 a turn is from 0, either way round."""
    return abs(((angle + 0x8000) & 0xFFFF) - 0x8000)


def clip(number: int, most: int) -> int:
    """The nearest number within plus and minus ``most``."""
    return most if number > most else -most if number < -most else number


def part_of(number: int, part: int) -> int:
    """``number * part / 65536``, rounded down."""
    return number * part >> 16


def scale(number: int, part: int) -> int:
    """``number * part / 16384``, to the nearest."""
    return (number * part + 0x2000) >> 14


def root(square: int) -> int:
    """The whole part of the square root."""
    return isqrt(square)


def _series(z: int, coefficients: tuple[int, int, int]) -> int:
    """``z (c0 - z**2 (c1 - z**2 c2))``, of 32768; z of 65536."""
    first, second, third = coefficients
    square = z * z >> 16
    return z * (first - ((square * (second - (square * third >> 16)) >> 16) >> 1)) >> 16


@lru_cache(maxsize=4096)
def sine(angle: int) -> int:
    """The sine, of 16384, of an angle in 0 .. 65535."""
    up = angle << 1 & 0xFFFF
    if up & 0x8000:
        up = min(0x10000 - up, 0x7FFF)
    size = (_series(up << 1, _SINE) + 1) >> 1
    return -size if angle & 0x8000 else size


def between(start: Place, end: Place) -> tuple[int, int]:
    """The vector from one place to another, in quarters."""
    return (end[0] >> 2) - (start[0] >> 2), (end[1] >> 2) - (start[1] >> 2)


def turned(x: int, y: int, angle: int) -> tuple[int, int]:
    """The vector turned by an angle."""
    s, c = sine(angle & 0xFFFF), sine((angle + QUARTER_TURN) & 0xFFFF)
    return (
        ((x * c + 0x2000) >> 14) - ((y * s + 0x2000) >> 14),
        ((x * s + 0x2000) >> 14) + ((y * c + 0x2000) >> 14),
    )


def measured(x: int, y: int) -> tuple[int, int]:
    """A vector's length, and its bearing in 0 .. 65535."""
    large, small = abs(x), abs(y)
    steep = small > large
    if steep:
        large, small = small, large
    down = max(0, large.bit_length() - 16)
    large, small = large >> down, small >> down
    ratio = (small << 16) // large if small != large else 0xFFFF
    angle = (_series(ratio, _ARC) + 2) >> 2
    if steep:
        angle = QUARTER_TURN - angle
    if x < 0:
        angle = HALF_TURN - angle
    if y < 0:
        angle = -angle
    s, c = sine(-angle & 0xFFFF), sine((QUARTER_TURN - angle) & 0xFFFF)
    return ((x * c + 0x2000) >> 14) - ((y * s + 0x2000) >> 14), angle & 0xFFFF


def angle_of(heading: int) -> int:
    """A heading of the wire, 1e-4 rad, as an angle of 2**16 a turn, in 0 .. 65535."""
    return scale(heading, 17_089) & 0xFFFF


def heading_of(angle: int) -> int:
    """An angle as a heading of the wire."""
    return scale(wrapped_short(angle), 15_708)

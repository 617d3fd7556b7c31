"""Whole-number geometry for processors without floating point.

It has the sums, products and shifts of ``fixed.c``, in the same order, to the bit.

- Places are micrometres. Angles are 2^16 a turn; a heading is kept in two such halves.
- Parts of a whole are of 16384, signed, or of 65536, unsigned.
- A vector between two places is in quarters: 4 um, so that the line's whole range fits.
- For places within a kilometre every step stays below 2^30: MicroPython then needs no heap for a
  number.
"""

from array import array

from .native import micropython

VECTOR = array("i", (0, 0))
"""The vector of ``turn`` and ``measure``."""


@micropython.native
def part(a: int, share: int) -> int:
    """``a * share / 65536``, rounded down; both have 16 bits."""
    return ((a >> 8) * share + ((a & 255) * share >> 8)) >> 8


@micropython.native
def scale(a: int, share: int) -> int:
    """``a * share / 16384``, to the nearest."""
    low = (a >> 8 & 255) * share + ((a & 255) * share + 0x2000 >> 8)
    return ((a >> 16) * share << 2) + (low >> 6)


@micropython.native
def clip(a: int, most: int) -> int:
    """The nearest number within plus and minus ``most``."""
    return most if a > most else -most if a < -most else a


@micropython.native
def short(a: int) -> int:
    """The lower 16 bits as a signed number."""
    a &= 0xFFFF
    return a - 0x10000 if a & 0x8000 else a


@micropython.native
def word(a: int) -> int:
    """The lower 32 bits as a signed number; large ones take heap."""
    if -0x3FFFFFFF <= a <= 0x3FFFFFFF:
        return a
    a &= 0xFFFFFFFF
    return a - 0x100000000 if a & 0x80000000 else a


@micropython.native
def aside(angle: int) -> int:
    """Distance of an angle from 0."""
    angle &= 0xFFFF
    return 0x10000 - angle if angle & 0x8000 else angle


@micropython.native
def root(square: int) -> int:
    """Whole part of the square root of a number below 2^30."""
    found, bit = 0, 0x4000
    while bit:
        larger = found | bit
        if larger * larger <= square:
            found = larger
        bit >>= 1
    return found


# odd polynomials, z (c0 - z^2 (c1 - z^2 c2)) with z of 65536, of least maximum error: the sine of a
# quarter turn, and the arc tangent as a part of an eighth of a turn


@micropython.native
def _sine_series(z: int) -> int:
    square = part(z, z)
    return part(z, 51455 - (part(square, 42078 - part(square, 4709)) >> 1))


@micropython.native
def _arc_series(z: int) -> int:
    square = part(z, z)
    return part(z, 41528 - (part(square, 24095 - part(square, 6627)) >> 1))


@micropython.native
def sine(angle: int) -> int:
    """Sine, of 16384, of an angle in 0 .. 65535."""
    up = angle << 1 & 0xFFFF
    if up & 0x8000:
        up = 0x10000 - up
        if up & 0x8000:
            up -= 1
    size = _sine_series(up << 1 & 0xFFFF) + 1 >> 1
    return -size if angle & 0x8000 else size


@micropython.native
def turn(angle: int) -> None:
    """Turn ``VECTOR`` by an angle."""
    angle &= 0xFFFF
    up = sine(angle)
    along = sine(angle + 0x4000 & 0xFFFF)
    x, y = VECTOR[0], VECTOR[1]
    VECTOR[0] = scale(x, along) - scale(y, up)
    VECTOR[1] = scale(x, up) + scale(y, along)


@micropython.native
def measure() -> int:
    """Turn ``VECTOR`` onto the x axis, x being its length; return its bearing in 0 .. 65535."""
    x, y = VECTOR[0], VECTOR[1]
    large = -x if x < 0 else x
    small = -y if y < 0 else y
    steep = small > large
    if steep:
        large, small = small, large
    while large > 0xFFFF:
        large >>= 1
        small >>= 1
    angle = 0xFFFF
    if small != large:
        # small * 65536 // large in two steps
        high = (small << 14) // large
        rest = (small << 14) - high * large
        angle = high << 2 | (rest << 2) // large
    angle = _arc_series(angle) + 2 >> 2
    if steep:
        angle = 0x4000 - angle
    if x < 0:
        angle = 0x8000 - angle
    if y < 0:
        angle = -angle
    turn(-angle)
    return angle & 0xFFFF


@micropython.native
def angle_of(heading: int) -> int:
    """A heading of the line, 1e-4 rad, as an angle in 0 .. 65535."""
    return scale(heading, 17089) & 0xFFFF


@micropython.native
def heading_of(angle: int) -> int:
    """An angle as a heading of the line."""
    return scale(short(angle), 15708)

"""Whole-number geometry: the same sums, products and shifts as ``fixed.c``, in the same order.

Places are micrometres. Angles are 2^16 a turn. Parts of a whole are of 16384, signed, or of 65536,
unsigned. Every step stays below 2^30 in size for places within a kilometre.
"""

from array import array

from .native import micropython

VECTOR = array("i", (0, 0))
"""Where ``turn`` and ``measure`` take their vector, and leave it."""


@micropython.native
def part(a: int, share: int) -> int:
    """a * share / 65536, rounded down; both have 16 bits."""
    return ((a >> 8) * share + ((a & 255) * share >> 8)) >> 8


@micropython.native
def scale(a: int, share: int) -> int:
    """a * share / 16384, to the nearest."""
    low = (a >> 8 & 255) * share + ((a & 255) * share + 0x2000 >> 8)
    return ((a >> 16) * share << 2) + (low >> 6)


@micropython.native
def clip(a: int, most: int) -> int:
    """A number within plus and minus ``most``."""
    return most if a > most else -most if a < -most else a


@micropython.native
def short(a: int) -> int:
    """The lower 16 bits as a signed number."""
    a &= 0xFFFF
    return a - 0x10000 if a & 0x8000 else a


@micropython.native
def aside(angle: int) -> int:
    """How far an angle is from 0, either way round."""
    angle &= 0xFFFF
    return 0x10000 - angle if angle & 0x8000 else angle


@micropython.native
def root(square: int) -> int:
    """The whole part of the square root, of a number below 2^30."""
    found, bit = 0, 0x4000
    while bit:
        larger = found | bit
        if larger * larger <= square:
            found = larger
        bit >>= 1
    return found


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
    """The sine of an angle, of 16384."""
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
    """Turn ``VECTOR`` onto the x axis, so that x becomes its length; its bearing."""
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

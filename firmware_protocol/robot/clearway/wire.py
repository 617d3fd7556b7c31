"""Numbers of the line in bytes, and its check, as in ``docs/protocol.md``.

A 32-bit number that is not a place is two 16-bit halves in an array.
"""

from array import array

from .native import micropython

VERSION = 1
MINOR_VERSION = 0
SCHEMA_HASH = b"\x10\x98\xfb\x1f"
"""CRC-32C of the layouts, as on the line."""
MAX_PAYLOAD = 112
MAX_DECODED = 8 + MAX_PAYLOAD + 4
MAX_ENCODED = MAX_DECODED + 1
WAYPOINT_BYTES = 16
HEADING_FREE = -32768
HALF_TURN = 31416

_LOW = array("H", bytes(512))
_HIGH = array("H", bytes(512))


def _fill_tables() -> None:
    for byte in range(256):
        low, high = byte, 0
        for _ in range(8):
            odd = low & 1
            low = low >> 1 | (high & 1) << 15
            high >>= 1
            if odd:
                low ^= 0x3B78
                high ^= 0x82F6
        _LOW[byte], _HIGH[byte] = low, high


_fill_tables()


@micropython.native
def check_byte(halves: "array[int]", at: int, byte: int) -> None:
    """Add one byte to the CRC kept, inverted, in ``halves[at]`` (low) and the next."""
    low, high = halves[at], halves[at + 1]
    row = (low ^ byte) & 255
    halves[at] = (low >> 8 | (high & 255) << 8) ^ _LOW[row]
    halves[at + 1] = high >> 8 ^ _HIGH[row]


@micropython.native
def check_bytes(halves: "array[int]", at: int, data: bytearray, begin: int, count: int) -> None:
    """Continue a finished CRC in ``halves`` by some bytes, and finish it again."""
    low, high = halves[at] ^ 0xFFFF, halves[at + 1] ^ 0xFFFF
    for i in range(begin, begin + count):
        row = (low ^ data[i]) & 255
        low = (low >> 8 | (high & 255) << 8) ^ _LOW[row]
        high = high >> 8 ^ _HIGH[row]
    halves[at] = low ^ 0xFFFF
    halves[at + 1] = high ^ 0xFFFF


@micropython.native
def get_u16(data: bytearray, at: int) -> int:
    """Two bytes without a sign."""
    return data[at] | data[at + 1] << 8


@micropython.native
def get_i16(data: bytearray, at: int) -> int:
    """Two bytes with a sign."""
    value = data[at] | data[at + 1] << 8
    return value - 0x10000 if value & 0x8000 else value


@micropython.native
def get_place(data: bytearray, at: int) -> int:
    """Four bytes with a sign: micrometres."""
    top = data[at + 3]
    if top & 0x80:
        top -= 256
    return data[at] | data[at + 1] << 8 | data[at + 2] << 16 | top << 24


@micropython.native
def get_time(data: bytearray, at: int) -> int:
    """The lower 30 of 32 bits: microseconds."""
    return data[at] | data[at + 1] << 8 | data[at + 2] << 16 | (data[at + 3] & 0x3F) << 24


@micropython.native
def put_u16(data: bytearray, at: int, value: int) -> int:
    """Write two bytes; return the place behind."""
    data[at] = value & 255
    data[at + 1] = value >> 8 & 255
    return at + 2


@micropython.native
def put_place(data: bytearray, at: int, value: int) -> int:
    """Write four bytes with a sign; return the place behind."""
    put_u16(data, at, value)
    return put_u16(data, at + 2, value >> 16)


@micropython.native
def put_halves(data: bytearray, at: int, halves: "array[int]", begin: int) -> int:
    """Write a number kept in halves; return the place behind."""
    put_u16(data, at, halves[begin])
    return put_u16(data, at + 2, halves[begin + 1])


@micropython.native
def same_halves(data: bytearray, at: int, halves: "array[int]", begin: int) -> bool:
    """True if four bytes are that number."""
    return get_u16(data, at) == halves[begin] and get_u16(data, at + 2) == halves[begin + 1]

from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.wire.crc import CHECK_VALUE, crc32c


def bit_by_bit(data: bytes) -> int:
    """The definition: polynomial division, one bit at a time, most significant bit first."""
    polynomial, register = 0x1EDC6F41, 0xFFFFFFFF
    for value in data:
        for bit in range(8):
            top = register >> 31 ^ (value >> bit & 1)
            register = (register << 1 & 0xFFFFFFFF) ^ (polynomial if top else 0)
    return int(f"{register:032b}"[::-1], 2) ^ 0xFFFFFFFF


def test_crc_has_the_catalogued_check_value() -> None:
    assert crc32c(b"123456789") == CHECK_VALUE


def test_crc_has_the_values_of_rfc_3720() -> None:
    assert crc32c(bytes(32)) == 0x8A9136AA
    assert crc32c(b"\xff" * 32) == 0x62A8AB43
    assert crc32c(bytes(range(32))) == 0x46DD794E


@given(st.binary(max_size=130))
def test_crc_equals_polynomial_division(data: bytes) -> None:
    assert crc32c(data) == bit_by_bit(data)


@given(st.binary(max_size=60), st.binary(max_size=60))
def test_crc_can_be_continued(a: bytes, b: bytes) -> None:
    assert crc32c(b, crc32c(a)) == crc32c(a + b)


@given(st.binary(min_size=1, max_size=124), st.data())
def test_crc_sees_every_change_of_up_to_five_bits(data: bytes, draw: st.DataObject) -> None:
    bits = draw.draw(st.sets(st.integers(0, 8 * len(data) - 1), min_size=1, max_size=5))
    damaged = bytearray(data)
    for bit in bits:
        damaged[bit // 8] ^= 1 << bit % 8
    assert crc32c(bytes(damaged)) != crc32c(data)

"""CRC-32C, the check of every frame and the fingerprint of every mission.

Reflected polynomial 0x82F63B78 (Castagnoli), initial value and final inversion 0xFFFFFFFF; the
check value of ``b"123456789"`` is 0xE3069283. A running value can be continued: ``crc32c(b,
crc32c(a)) == crc32c(a + b)``.
"""

from __future__ import annotations

from typing import Final

CHECK_VALUE: Final = 0xE3069283
"""``crc32c(b"123456789")``, from the catalogue of parametrised CRCs (CRC-32/ISCSI)."""

_POLYNOMIAL: Final = 0x82F63B78


def _byte_table() -> tuple[int, ...]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = (value >> 1) ^ (_POLYNOMIAL if value & 1 else 0)
        table.append(value)
    return tuple(table)


_TABLE: Final = _byte_table()


def crc32c(data: bytes | bytearray, running: int = 0) -> int:
    """CRC-32C of ``data``, continued from ``running``; an integer in [0, 2**32). O(n)."""
    table = _TABLE
    crc = running ^ 0xFFFFFFFF
    for value in data:
        crc = (crc >> 8) ^ table[(crc ^ value) & 0xFF]
    return crc ^ 0xFFFFFFFF

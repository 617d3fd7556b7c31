"""Small PNG files of every kind: colour types, depths, interlaced, with texts, animated."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tests.support.files.small_picture import DARK, HEIGHT, LIGHT, WIDTH, grey_picture

ADAM7 = (
    (0, 0, 8, 8),
    (4, 0, 8, 8),
    (0, 4, 4, 8),
    (2, 0, 4, 4),
    (0, 2, 2, 4),
    (1, 0, 2, 2),
    (0, 1, 1, 2),
)
"""First column and row, then the steps between columns and rows, of PNG's seven passes."""

PNG_KINDS = ((0, (1, 2, 4, 8, 16)), (2, (8, 16)), (3, (1, 2, 4, 8)), (4, (8, 16)), (6, (8, 16)))
"""Colour types and the bit depths that each may have."""


# PNG


def chunk(kind: bytes, body: bytes) -> bytes:
    """A PNG chunk with its right check sum."""
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def pngs() -> Iterator[tuple[str, bytes]]:
    for colour, depths in PNG_KINDS:
        for depth in depths:
            for interlaced in (False, True):
                for clear in (False, True) if colour in (0, 2, 3) else (False,):
                    name = f"c{colour}_{depth}" + "_i" * interlaced + "_t" * clear
                    yield f"{name}.png", png(colour, depth, interlaced, clear)
    yield "turned.png", png(0, 8, more=chunk(b"eXIf", exif(6)))
    yield "texts.png", png(0, 8, more=_png_texts())
    yield "animated.png", _animated_png()


def png(
    colour: int, depth: int, interlaced: bool = False, clear: bool = False, more: bytes = b""
) -> bytes:
    """A PNG of a colour type and a depth; ``clear`` adds tRNS, ``more`` stands before the data."""
    header = struct.pack(">IIBBBBB", WIDTH, HEIGHT, depth, colour, 0, 0, int(interlaced))
    parts = [chunk(b"IHDR", header)]
    if colour == 3:
        parts.append(chunk(b"PLTE", bytes((LIGHT,) * 3 + (DARK,) * 3)))
    if clear:
        parts.append(chunk(b"tRNS", {0: b"\0\1", 2: b"\0\1" * 3, 3: b"\xff\x80"}[colour]))
    data = zlib.compress(png_rows(colour, depth, interlaced))
    return (
        b"\x89PNG\r\n\x1a\n" + b"".join(parts) + more + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    )


def png_rows(colour: int, depth: int, interlaced: bool) -> bytes:
    """The rows of the picture, each with a filter byte, the filters in turn."""
    dark = grey_picture() == DARK
    top = (1 << depth) - 1
    low, high = (1, 0) if colour == 3 else (round(top * DARK / 255), round(top * LIGHT / 255))
    values = np.where(dark, low, high).astype(np.int64)
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    picture = np.repeat(values[:, :, None], channels, axis=2)
    if colour in (4, 6):
        picture[:, :, -1] = top
    passes = ADAM7 if interlaced else ((0, 0, 1, 1),)
    out = b""
    for x, y, dx, dy in passes:
        for row in picture[y::dy, x::dx]:
            out += b"\x00" + _packed(row.ravel(), depth)
    return out


def _packed(values: NDArray[np.int64], depth: int) -> bytes:
    if depth == 16:
        return values.astype(">u2").tobytes()
    if depth == 8:
        return values.astype(np.uint8).tobytes()
    bits = (values[:, None] >> np.arange(depth - 1, -1, -1)) & 1
    return np.packbits(bits.astype(np.uint8).ravel()).tobytes()


def _png_texts() -> bytes:
    return (
        chunk(b"gAMA", struct.pack(">I", 45455))
        + chunk(b"pHYs", struct.pack(">IIB", 2835, 2835, 1))
        + chunk(b"tEXt", b"Title\0a picture")
        + chunk(b"zTXt", b"Comment\0\0" + zlib.compress(b"packed"))
        + chunk(b"iTXt", b"Name\0\0\0de\0Name\0" + "ä".encode())
        + chunk(b"iCCP", b"p\0\0" + zlib.compress(b"\0" * 128))
        + chunk(b"bKGD", b"\0\xff")
        + chunk(b"tIME", struct.pack(">HBBBBB", 2024, 2, 29, 23, 59, 60))
    )


def _animated_png() -> bytes:
    """Three frames, of which the first is the picture itself."""
    control = struct.pack(">IIIIHHBB", WIDTH, HEIGHT, 0, 0, 1, 10, 0, 0)
    data = zlib.compress(png_rows(2, 8, False))
    body = chunk(b"IHDR", struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0))
    body += chunk(b"acTL", struct.pack(">II", 3, 0))
    body += chunk(b"fcTL", struct.pack(">I", 0) + control) + chunk(b"IDAT", data)
    for number in (1, 3):
        body += chunk(b"fcTL", struct.pack(">I", number) + control)
        body += chunk(b"fdAT", struct.pack(">I", number + 1) + data)
    return b"\x89PNG\r\n\x1a\n" + body + chunk(b"IEND", b"")


def exif(orientation: int) -> bytes:
    """EXIF with one tag, the orientation, 1 .. 8 (EXIF 2.32, 4.6.4)."""
    return b"II*\0" + struct.pack("<IHHHIHHI", 8, 1, 0x112, 3, 1, orientation, 0, 0)

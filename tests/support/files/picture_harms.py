"""Harms to picture files that decoders look into: parts with right lengths and check sums.

A byte that is flipped anywhere mostly breaks a check sum, and a decoder stops there. These harms
know the parts of their kind (PNG chunks, JPEG segments, TIFF tags, RIFF chunks and the boxes of
JPEG 2000 and AVIF) and leave the frame around the part that they harm well.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from tests.support.files.png_pictures import chunk

Harm: TypeAlias = Callable[[bytes, np.random.Generator], bytes]

_SIDES = (0, 1, 2, 7, 8, 9, 300, 20000, 65535, 65536, 1 << 20, 1 << 30, 0x7FFFFFFF, 0xFFFFFFFF)


def harms_for(data: bytes) -> tuple[Harm, ...]:
    """The harms that know this kind of file."""
    if data.startswith(b"\x89PNG"):
        return (png_chunk,)
    if data.startswith(b"\xff\xd8"):
        return (jpeg_segment,)
    if data[:4] in (b"II*\0", b"MM\0*"):
        return (tiff_tag,)
    if data.startswith((b"BM", b"GIF8", b"RIFF")):
        return (little_field,)
    if data[4:8] in (b"ftyp", b"jP  "):
        return (box,)
    return ()


def flip(data: bytes, rng: np.random.Generator) -> bytes:
    """Up to eight bits turned over."""
    if not data:
        return data
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 9))):
        out[int(rng.integers(len(out)))] ^= 1 << int(rng.integers(8))
    return bytes(out)


def cut(data: bytes, rng: np.random.Generator) -> bytes:
    """The beginning."""
    return data[: int(rng.integers(0, len(data) + 1))]


def splice(data: bytes, rng: np.random.Generator) -> bytes:
    """Up to thirty random bytes put in."""
    at = int(rng.integers(0, len(data) + 1))
    return data[:at] + rng.bytes(int(rng.integers(1, 30))) + data[at:]


def put_number(data: bytes, rng: np.random.Generator) -> bytes:
    """Four bytes that are an extreme number, early more often than late."""
    if len(data) < 8:
        return data
    value = (0, 1, 0xFF, 0x7FFF, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
    order = ">I" if rng.random() < 0.5 else "<I"
    at = int(rng.integers(0, min(len(data) - 4, 128 if rng.random() < 0.7 else len(data) - 4)))
    return data[:at] + struct.pack(order, value[int(rng.integers(9))]) + data[at + 4 :]


def png_chunk(data: bytes, rng: np.random.Generator) -> bytes:
    """A PNG with one chunk harmed, doubled, dropped or moved, and its check sum right."""
    chunks: list[tuple[bytes, bytes]] = []
    at = 8
    while at + 8 <= len(data) and len(chunks) < 64:
        size = struct.unpack(">I", data[at : at + 4])[0]
        if size > len(data):
            break
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + size]))
        at += 12 + size
    if not chunks:
        return data
    if rng.random() < 0.15:
        _shuffle(chunks, rng)
    else:
        i = 0 if rng.random() < 0.4 else int(rng.integers(len(chunks)))
        kind, body = chunks[i]
        chunks[i] = kind, _png_body(kind, body, rng)
    return data[:8] + b"".join(chunk(k, b) for k, b in chunks)


def _png_body(kind: bytes, body: bytes, rng: np.random.Generator) -> bytes:
    if kind == b"IDAT" and rng.random() < 0.5:
        try:
            rows = zlib.decompress(body)
        except zlib.error:
            return flip(body, rng)
        return zlib.compress((flip, cut, splice)[int(rng.integers(3))](rows, rng))
    if kind == b"IHDR" and rng.random() < 0.6:
        width, height = (_SIDES[int(v)] for v in rng.integers(0, len(_SIDES), 2))
        if rng.random() < 0.5:
            return struct.pack(">II", width, height) + body[8:]
        depth, colour = (int(v) for v in rng.integers(0, 18, 2))
        last = (0, 0, int(rng.integers(0, 3)))
        return body[:8] + bytes((depth, colour % 8, *last))
    return (flip, cut, put_number, splice)[int(rng.integers(4))](body, rng)


def jpeg_segment(data: bytes, rng: np.random.Generator) -> bytes:
    """A JPEG with one segment before the scan harmed and its length right."""
    parts, at = [], 2
    while at + 4 <= len(data) and data[at] == 0xFF and data[at + 1] != 0xDA:
        size = int(struct.unpack(">H", data[at + 2 : at + 4])[0])
        parts.append((data[at + 1 : at + 2], data[at + 4 : at + 2 + size]))
        at += 2 + size
    if not parts:
        return flip(data, rng)
    if rng.random() < 0.2:
        _shuffle(parts, rng)
    else:
        i = int(rng.integers(len(parts)))
        kind, body = parts[i]
        if 0xC0 <= kind[0] <= 0xCF and kind[0] not in (0xC4, 0xC8, 0xCC) and rng.random() < 0.5:
            height, width = (_SIDES[int(v)] & 0xFFFF for v in rng.integers(0, len(_SIDES), 2))
            kind = bytes((0xC0 | int(rng.integers(16)),)) if rng.random() < 0.5 else kind
            body = body[:1] + struct.pack(">HH", height, width) + body[5:]
        else:
            body = (flip, cut, splice)[int(rng.integers(3))](body, rng)
        parts[i] = kind, body[:65533]
    head = b"".join(b"\xff" + k + struct.pack(">H", len(b) + 2) + b for k, b in parts)
    scan = flip(data[at:], rng) if rng.random() < 0.3 else data[at:]
    return data[:2] + head + scan


def tiff_tag(data: bytes, rng: np.random.Generator) -> bytes:
    """A TIFF with one entry of its first directory harmed: kind, count or value."""
    order = "<" if data[:2] == b"II" else ">"
    if len(data) < 10:
        return data
    directory = int(struct.unpack(order + "I", data[4:8])[0])
    if directory + 2 > len(data):
        return flip(data, rng)
    count = int(struct.unpack(order + "H", data[directory : directory + 2])[0])
    entry = directory + 2 + 12 * int(rng.integers(max(count, 1)))
    if entry + 12 > len(data):
        return flip(data, rng)
    tag, kind, number, value = struct.unpack(order + "HHII", data[entry : entry + 12])
    extreme = _SIDES[int(rng.integers(len(_SIDES)))]
    what = int(rng.integers(5))
    if what == 0:
        tag = int(rng.integers(254, 345))
    elif what == 1:
        kind = int(rng.integers(0, 19))
    elif what == 2:
        number = extreme
    elif kind == 3:
        value = (extreme & 0xFFFF) << (0 if order == "<" else 16)
    else:
        value = extreme
    harmed = struct.pack(order + "HHII", tag, kind, number, value)
    return data[:entry] + harmed + data[entry + 12 :]


def little_field(data: bytes, rng: np.random.Generator) -> bytes:
    """Two or four bytes of the header, on their own place, that are an extreme number."""
    if len(data) < 70:
        return data
    at = 2 * int(rng.integers(2, 32))
    extreme = _SIDES[int(rng.integers(len(_SIDES)))]
    if rng.random() < 0.5:
        return data[:at] + struct.pack("<H", extreme & 0xFFFF) + data[at + 2 :]
    return data[:at] + struct.pack("<I", extreme) + data[at + 4 :]


def box(data: bytes, rng: np.random.Generator) -> bytes:
    """One box of JPEG 2000 or AVIF, outer or inner, with its body harmed and its length right."""
    path, begin, end = [], 0, len(data)
    while True:
        spans, at = [], begin
        while at + 8 <= end:
            size = int(struct.unpack(">I", data[at : at + 4])[0])
            if size < 8 or at + size > end:
                break
            spans.append((at, at + size))
            at += size
        if not spans:
            break
        a, b = spans[int(rng.integers(len(spans)))]
        path.append((a, b))
        # `meta` is a full box: four bytes of version and flags before what it holds.
        begin, end = a + (12 if data[a + 4 : a + 8] == b"meta" else 8), b
        if rng.random() < 0.3:
            break
    if not path:
        return flip(data, rng)
    a, b = path[-1]
    body = (flip, cut, put_number, splice)[int(rng.integers(4))](data[a + 8 : b], rng)
    grown = len(body) - (b - a - 8)
    out = bytearray(data[: a + 8] + body + data[b:])
    for start, stop in path:
        out[start : start + 4] = struct.pack(">I", stop - start + grown)
    return bytes(out)


def _shuffle(parts: list[tuple[bytes, bytes]], rng: np.random.Generator) -> None:
    """One part is dropped, doubled, or put elsewhere."""
    part = parts.pop(int(rng.integers(len(parts))))
    for _ in range(int(rng.integers(0, 3))):
        parts.insert(int(rng.integers(len(parts) + 1)), part)

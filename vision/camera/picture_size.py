"""The size that a picture claims, from the first bytes of its file.

A file of a hundred bytes can claim gigabytes: the size is read, and refused, before decoding.
Sources: the PNG, JPEG (T.81), JPEG 2000 (T.800), GIF89a, BMP, TIFF 6, WebP, AVIF (HEIF), Radiance,
Sun raster and Netpbm specifications.
"""

from __future__ import annotations

import re
import struct

_PNG = b"\x89PNG\r\n\x1a\n"

MOST_PIXELS = 1 << 28
"""A square of 16384: beyond every camera and scanned plan."""


def oversize(data: bytes) -> str:
    """Reason why a picture file claims too much; empty if not, or unknown."""
    width, height = picture_size(data) or (0, 0)
    if width * height > MOST_PIXELS:
        return f"a picture of {width} x {height} pixels: must be at most {MOST_PIXELS}"
    longest = _longest_chunk(data) if data.startswith(_PNG) else 0
    if longest > len(data):
        of = f"a part of {longest} bytes in a file of {len(data)}"
        return f"not a picture, or a damaged picture: {of}"
    return ""


def picture_size(data: bytes) -> tuple[int, int] | None:
    """Width and height in pixels, by the header; None for another kind of file."""
    try:
        if data.startswith(_PNG):
            return _pair(">II", data, 16) if data[12:16] == b"IHDR" else None
        if data.startswith(b"\xff\xd8"):
            return _jpeg(data)
        if data.startswith(b"GIF8"):
            return _pair("<HH", data, 6)
        if data.startswith(b"BM"):
            return _bmp(data)
        if data[:4] in (b"II*\x00", b"MM\x00*"):
            return _tiff(data)
        if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
            return _webp(data)
        if data.startswith(b"\x59\xa6\x6a\x95"):
            return _pair(">II", data, 4)
        if data.startswith(b"\xff\x4f\xff\x51") or data[4:8] == b"jP  ":
            return _jpeg_2000(data)
        if data[4:8] == b"ftyp":
            return _avif(data)
    except struct.error:
        return None
    return _in_words(data[:4096])


def _longest_chunk(data: bytes) -> int:
    """Greatest length that a PNG's chunk claims: the decoder allocates it unchecked."""
    longest, at = 0, len(_PNG)
    while at + 8 <= len(data):
        size = int(struct.unpack_from(">I", data, at)[0])
        longest = max(longest, size)
        at += 12 + size
    return longest


def _pair(form: str, data: bytes, at: int) -> tuple[int, int]:
    first, second = struct.unpack_from(form, data, at)
    return int(first), int(second)


def _bmp(data: bytes) -> tuple[int, int]:
    """OS/2's header of twelve bytes has two-byte sides; a negative height runs down."""
    if struct.unpack_from("<I", data, 14)[0] == 12:
        return _pair("<HH", data, 18)
    width, height = _pair("<ii", data, 18)
    return abs(width), abs(height)


def _jpeg(data: bytes) -> tuple[int, int] | None:
    """Find the frame header: SOF0 to SOF15, except DHT, JPG and DAC."""
    at = 2
    while at + 4 <= len(data):
        if data[at] != 0xFF:
            return None
        kind = data[at + 1]
        if kind == 0xFF or kind == 0x01 or 0xD0 <= kind <= 0xD8:
            at += 1 if kind == 0xFF else 2
            continue
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            height, width = _pair(">HH", data, at + 5)
            return width, height
        at += 2 + int(struct.unpack_from(">H", data, at + 2)[0])
    return None


def _tiff(data: bytes) -> tuple[int, int] | None:
    """Tags 256 and 257 of the first directory."""
    order = "<" if data[:2] == b"II" else ">"
    directory = int(struct.unpack_from(order + "I", data, 4)[0])
    sides = {256: 0, 257: 0}
    for i in range(int(struct.unpack_from(order + "H", data, directory)[0])):
        entry = directory + 2 + 12 * i
        tag, kind = _pair(order + "HH", data, entry)
        if tag in sides:
            form = "H" if kind == 3 else "I"
            sides[tag] = int(struct.unpack_from(order + form, data, entry + 8)[0])
    return sides[256], sides[257]


def _webp(data: bytes) -> tuple[int, int] | None:
    """Canvas of an extended file, or frame of a plain one, lossy or lossless."""
    kind = data[12:16]
    if kind == b"VP8X":
        width, height = (int.from_bytes(data[at : at + 3], "little") for at in (24, 27))
        return width + 1, height + 1
    if kind == b"VP8L":
        bits = int(struct.unpack_from("<I", data, 21)[0])
        return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    if kind == b"VP8 ":
        width, height = _pair("<HH", data, 26)
        return width & 0x3FFF, height & 0x3FFF
    return None


def _jpeg_2000(data: bytes) -> tuple[int, int] | None:
    """Segment SIZ of the codestream, by which the decoder allocates, not by the box `ihdr`."""
    at = data.find(b"\xff\x4f\xff\x51")
    if at < 0:
        return None
    right, bottom, left, top = struct.unpack_from(">IIII", data, at + 8)
    return max(0, int(right) - int(left)), max(0, int(bottom) - int(top))


def _avif(data: bytes) -> tuple[int, int] | None:
    """Largest of the boxes `ispe`: a picture, its alpha and its parts have one each."""
    sizes = [_pair(">II", data, found.end() + 4) for found in re.finditer(rb"ispe", data[:65536])]
    return max(sizes, key=lambda size: size[0] * size[1]) if sizes else None


def _in_words(head: bytes) -> tuple[int, int] | None:
    """Size in a text header: Netpbm with PFM and PAM, and Radiance."""
    words = re.sub(rb"#[^\n]*\n", b" ", head).split(None, 3)
    if len(words) >= 3 and re.fullmatch(rb"P[1-6Ff]", words[0]):
        sides = words[1:3]
        if all(re.fullmatch(rb"\d{1,12}", side) for side in sides):
            return int(sides[0]), int(sides[1])
    if words[:1] == [b"P7"]:
        found = [re.search(rb"\b%s\s+(\d{1,12})\s" % key, head) for key in (b"WIDTH", b"HEIGHT")]
        if found[0] and found[1]:
            return int(found[0][1]), int(found[1][1])
    radiance = re.search(rb"\n[-+][XY] (\d{1,12}) [-+]([XY]) (\d{1,12})\n", head)
    if head.startswith(b"#?") and radiance:
        first, second = int(radiance[1]), int(radiance[3])
        return (second, first) if radiance[2] == b"X" else (first, second)
    return None

"""Small pictures of every kind of file that OpenCV reads, made by code.

Every one shows the same thing, a dark rectangle on light ground of ``WIDTH`` x ``HEIGHT`` pixels,
as far as its kind can; JPEG 2000 four times as large, as its decoder wants, JPEG with four
components in blocks. Written by hand from the specifications where OpenCV cannot write it:
PNG (all depths, interlaced, transparent, animated), BMP (palettes, run lengths, bit fields),
TIFF (both byte orders, one bit, palette, planes, turned), JPEG with four components, Netpbm.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tests.support.files.png_pictures import _packed, exif, pngs
from tests.support.files.small_picture import DARK, HEIGHT, LIGHT, WIDTH, grey_picture


def formats() -> Iterator[tuple[str, bytes]]:
    """Every kind, by a file name that says what it is."""
    yield from pngs()
    yield from jpegs()
    yield from bmps()
    yield from tiffs()
    yield from netpbms()
    yield from written_by_opencv()


# JPEG


def jpegs() -> Iterator[tuple[str, bytes]]:
    grey = grey_picture()
    colour = cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)
    for name, picture, how in (
        ("grey", grey, []),
        ("colour", colour, []),
        ("progressive", colour, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1]),
        ("grey_progressive", grey, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1]),
        ("restarts", colour, [cv2.IMWRITE_JPEG_RST_INTERVAL, 1]),
        ("sampled", colour, [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, 0x411111]),
        ("poor", colour, [cv2.IMWRITE_JPEG_QUALITY, 1]),
    ):
        yield f"{name}.jpg", cv2.imencode(".jpg", picture, how)[1].tobytes()
    for orientation in range(1, 9):
        yield f"turned_{orientation}.jpg", turned_jpeg(orientation)
    yield "cmyk.jpg", four_components(0)
    yield "ycck.jpg", four_components(2)


def turned_jpeg(orientation: int) -> bytes:
    """The grey picture as it is, with an EXIF orientation."""
    data = cv2.imencode(".jpg", grey_picture())[1].tobytes()
    body = b"Exif\0\0" + exif(orientation)
    return data[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + data[2:]


def four_components(transform: int) -> bytes:
    """A baseline JPEG of four components (T.81; Adobe's marker says CMYK, 0, or YCCK, 2).

    Blocks of one value each: a Huffman table of two codes, 0 for no change, 10 for six bits.
    """

    def segment(kind: int, body: bytes) -> bytes:
        return bytes((0xFF, kind)) + struct.pack(">H", len(body) + 2) + body

    dark = grey_picture()[4::8, 4::8] == DARK
    bits, before = "", [0] * 4
    for is_dark in dark.ravel():
        for component in range(4):
            value = (-20 if is_dark else 20) if component == 3 else 0
            step = value - before[component]
            before[component] = value
            # A difference of category 6 as T.81, F.1.2.1 has it; then the end of the block.
            size = "0" if step == 0 else "10" + f"{step if step > 0 else step + 63:06b}"
            bits += size + "0"
    bits += "1" * (-len(bits) % 8)
    scan = bytes(int(bits[i : i + 8], 2) for i in range(0, len(bits), 8)).replace(
        b"\xff", b"\xff\0"
    )
    frame = struct.pack(">BHHB", 8, HEIGHT, WIDTH, 4) + b"".join(
        bytes((i, 0x11, 0)) for i in range(1, 5)
    )
    codes = bytes((1, 1)) + bytes(14)
    return (
        b"\xff\xd8"
        + segment(0xEE, b"Adobe" + struct.pack(">HHHB", 100, 0, 0, transform))
        + segment(0xDB, b"\0" + b"\x10" * 64)
        + segment(0xC0, frame)
        + segment(0xC4, b"\x00" + codes + bytes((0, 6)))
        + segment(0xC4, b"\x10" + codes + bytes((0, 1)))
        + segment(0xDA, b"\4" + b"".join(bytes((i, 0)) for i in range(1, 5)) + b"\0\x3f\0")
        + scan
        + b"\xff\xd9"
    )


# BMP


def bmps() -> Iterator[tuple[str, bytes]]:
    dark = grey_picture() == DARK
    index = dark.astype(np.int64)
    palette = bytes((LIGHT, LIGHT, LIGHT, 0, DARK, DARK, DARK, 0))
    for depth in (1, 4, 8):
        rows = b"".join(_padded(_packed(row, depth)) for row in index[::-1])
        yield f"palette_{depth}.bmp", bmp(depth, rows, palette)
    yield "runs_8.bmp", bmp(8, _runs(index, 8), palette, compression=1)
    yield "runs_4.bmp", bmp(4, _runs(index, 4), palette, compression=2)
    grey = grey_picture()
    wide = np.where(dark, DARK >> 3, LIGHT >> 3).astype(np.uint16)
    plain = (wide << 10 | wide << 5 | wide).astype("<u2")
    yield "15_bits.bmp", bmp(16, plain[::-1].tobytes())
    fields = struct.pack("<III", 0xF800, 0x7E0, 0x1F)
    green = (wide << 11 | wide << 6 | wide).astype("<u2")
    yield "16_bits.bmp", bmp(16, green[::-1].tobytes(), fields, compression=3)
    colour = np.repeat(grey[:, :, None], 3, axis=2)
    yield "24_bits.bmp", bmp(24, colour[::-1].tobytes())
    yield "down.bmp", bmp(24, colour.tobytes(), height=-HEIGHT)
    alpha = np.dstack([colour, np.full(grey.shape, 255, np.uint8)])
    yield "32_bits.bmp", bmp(32, alpha[::-1].tobytes())
    core = struct.pack("<IHHHH", 12, WIDTH, HEIGHT, 1, 24)
    yield (
        "os2.bmp",
        struct.pack("<2sIHHI", b"BM", 26 + colour.size, 0, 0, 26) + core + colour[::-1].tobytes(),
    )


def bmp(
    depth: int, rows: bytes, table: bytes = b"", compression: int = 0, height: int = HEIGHT
) -> bytes:
    """A BMP with a header of 40 bytes; ``table`` is its palette or its bit fields."""
    colours = len(table) // 4 if depth <= 8 else 0
    at = 14 + 40 + len(table)
    head = struct.pack("<2sIHHI", b"BM", at + len(rows), 0, 0, at)
    sides = struct.pack(
        "<IiiHHIIiiII", 40, WIDTH, height, 1, depth, compression, len(rows), 0, 0, colours, 0
    )
    return head + sides + table + rows


def _padded(row: bytes) -> bytes:
    return row + b"\0" * (-len(row) % 4)


def _runs(index: NDArray[np.int64], depth: int) -> bytes:
    """Run lengths of a row: (count, value), then the end of the line, at last of the picture."""
    out = b""
    for row in index[::-1]:
        edges = np.flatnonzero(np.diff(row)) + 1
        for part in np.split(row, edges):
            value = int(part[0]) * (0x11 if depth == 4 else 1)
            out += bytes((len(part), value))
        out += b"\0\0"
    return out + b"\0\1"


# TIFF


def tiffs() -> Iterator[tuple[str, bytes]]:
    dark = grey_picture() == DARK
    grey = grey_picture()
    for order in "<>":
        name = "little" if order == "<" else "big"
        yield f"{name}.tif", tiff(order, grey.tobytes(), 8, 1)
        deep = (grey.astype(np.uint16) * 257).astype(order + "u2")
        yield f"{name}_deep.tif", tiff(order, deep.tobytes(), 16, 1)
    bits = b"".join(_packed(row, 1) for row in (~dark).astype(np.int64))
    yield "one_bit.tif", tiff("<", bits, 1, 1)
    colours = np.zeros((3, 256), "<u2")
    colours[:, 0], colours[:, 1] = LIGHT * 257, DARK * 257
    index = dark.astype(np.uint8).tobytes()
    yield "palette.tif", tiff("<", index, 8, 3, {320: ("H", colours.ravel().tolist())})
    yield "white_is_0.tif", tiff("<", (255 - grey).tobytes(), 8, 0)
    yield "deflated.tif", tiff("<", zlib.compress(grey.tobytes()), 8, 1, {259: ("H", [8])})
    for orientation in (3, 6, 8):
        yield (
            f"turned_{orientation}.tif",
            tiff("<", grey.tobytes(), 8, 1, {274: ("H", [orientation])}),
        )
    colour = np.repeat(grey[:, :, None], 3, axis=2)
    rgb = {277: ("H", [3]), 258: ("H", [8, 8, 8])}
    yield "colour.tif", tiff("<", colour.tobytes(), 8, 2, rgb)
    planes = {**rgb, 284: ("H", [2]), 279: ("I", [grey.size] * 3)}
    yield "planes.tif", tiff("<", colour.transpose(2, 0, 1).tobytes(), 8, 2, planes)
    single = (grey.astype("<f4") / 255.0).astype("<f4")
    yield "float.tif", tiff("<", single.tobytes(), 32, 1, {339: ("H", [3])})
    for number, name in ((5, "lzw"), (32773, "packbits"), (7, "jpeg"), (1, "none")):
        written, data = cv2.imencode(".tif", colour, [cv2.IMWRITE_TIFF_COMPRESSION, number])
        if written:
            yield f"{name}.tif", data.tobytes()
    yield "pages.tif", cv2.imencodemulti(".tif", [grey, 255 - grey])[1].tobytes()


def tiff(
    order: str,
    data: bytes,
    depth: int,
    photometric: int,
    more: dict[int, tuple[str, list[int]]] | None = None,
) -> bytes:
    """A classic TIFF of one directory (TIFF 6.0); ``more`` tags: (form of a value, values)."""
    tags: dict[int, tuple[str, list[int]]] = {
        256: ("H", [WIDTH]),
        257: ("H", [HEIGHT]),
        258: ("H", [depth]),
        259: ("H", [1]),
        262: ("H", [photometric]),
        277: ("H", [1]),
    }
    tags |= {278: ("H", [HEIGHT]), 279: ("I", [len(data)])}
    tags |= more or {}
    counts = tags[279][1]
    tags[273] = ("I", [8 + sum(counts[:i]) for i in range(len(counts))])
    data += b"\0" * (len(data) % 2)
    directory = 8 + len(data)
    values_at = directory + 2 + 12 * len(tags) + 4
    entries, values = b"", b""
    for tag, (form, numbers) in sorted(tags.items()):
        packed = struct.pack(f"{order}{len(numbers)}{form}", *numbers)
        if len(packed) > 4:
            place = struct.pack(order + "I", values_at + len(values))
            values += packed + b"\0" * (len(packed) % 2)
        else:
            place = packed + b"\0" * (4 - len(packed))
        kind = 3 if form == "H" else 4
        entries += struct.pack(order + "HHI", tag, kind, len(numbers)) + place
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "I", directory)
    count = struct.pack(order + "H", len(tags))
    return head + data + count + entries + b"\0\0\0\0" + values


# Netpbm and its kin


def netpbms() -> Iterator[tuple[str, bytes]]:
    grey = grey_picture()
    dark = (grey == DARK).astype(np.int64)
    words = "\n".join(" ".join(map(str, row)) for row in dark)
    yield "text.pbm", f"P1\n# a comment\n{WIDTH} {HEIGHT}\n{words}\n".encode()
    rows = b"".join(_packed(row, 1) for row in dark)
    yield "binary.pbm", f"P4\n{WIDTH} {HEIGHT}\n".encode() + rows
    numbers = "\n".join(" ".join(map(str, row)) for row in grey)
    head = f"{WIDTH} # wide\n#\n{HEIGHT}\n255\n"
    yield "text.pgm", f"P2 {head}{numbers}\n".encode()
    yield "binary.pgm", f"P5\n#c\n{WIDTH} {HEIGHT}\n255\n".encode() + grey.tobytes()
    few = f"P5 {WIDTH} {HEIGHT} 15\n".encode() + (grey // 17).tobytes()
    yield "sixteen_shades.pgm", few
    deep = (grey.astype(np.uint16) * 257).astype(">u2").tobytes()
    yield "deep.pgm", f"P5 {WIDTH} {HEIGHT} 65535\n".encode() + deep
    colour = np.repeat(grey[:, :, None], 3, axis=2)
    triples = "\n".join(" ".join(map(str, row.ravel())) for row in colour)
    yield "text.ppm", f"P3\n{WIDTH} {HEIGHT}\n255\n{triples}\n".encode()
    yield "binary.ppm", f"P6\n{WIDTH} {HEIGHT}\n255\n".encode() + colour.tobytes()
    pam = f"P7\nWIDTH {WIDTH}\nHEIGHT {HEIGHT}\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n"
    yield "grey.pam", pam.encode() + grey.tobytes()


def written_by_opencv() -> Iterator[tuple[str, bytes]]:
    """The kinds that only OpenCV writes here; a build without one of them leaves it out."""
    grey = grey_picture()
    colour = cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)
    alpha = np.dstack([colour, np.where(grey > 100, 255, 128).astype(np.uint8)])
    deep = grey.astype(np.uint16) * 257
    light = colour.astype(np.float32) / np.float32(255.0)
    lossless = [cv2.IMWRITE_WEBP_QUALITY, 101]
    wanted: tuple[tuple[str, NDArray[Any], list[int]], ...] = (
        ("lossy.webp", colour, []),
        ("lossless.webp", colour, lossless),
        ("alpha.webp", alpha, lossless),
        ("colour.gif", colour, []),
        ("alpha.gif", alpha, []),
        ("colour.avif", colour, []),
        ("grey.jp2", np.kron(grey, np.ones((4, 4), np.uint8)), []),
        ("deep.jp2", np.kron(deep, np.ones((4, 4), np.uint16)), []),
        ("colour.pfm", light, []),
        ("colour.ras", colour, []),
        ("colour.hdr", light, []),
    )
    for name, picture, how in wanted:
        try:
            written, data = cv2.imencode(name[name.index(".") :], picture, how)
        except cv2.error:
            continue
        if written:
            yield name, data.tobytes()
    if hasattr(cv2, "imencodeanimation"):
        film = cv2.Animation()
        film.frames = [colour, 255 - colour, colour]
        film.durations = [100, 100, 100]
        for kind in ("gif", "webp", "avif"):
            written, data = cv2.imencodeanimation(f".{kind}", film)
            if written:
                yield f"animated.{kind}", data.tobytes()

"""The turn that a picture's EXIF orientation asks for: how the camera was held.

- Viewers and ``cv2.imread`` turn a picture accordingly.
- A lens, and a camera's place above an arena, belong to the sensor's own pixels, and a camera that
  looks down writes a random orientation: ``vision.camera.picture_files.read_picture`` leaves
  pictures as stored.

Orientations are those of EXIF 2.32, 4.6.4: 1 as stored, 2 mirrored, 3 upside down, 4 mirrored
upside down, 5 transposed, 6 to be turned 90 degrees clockwise, 7 transposed the other way, 8
counter-clockwise.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

_ORIENTATION = 0x0112
_SHORT = 3


def orientation(data: bytes) -> int:
    """Orientation 1 .. 8 of a JPEG, PNG or WebP file; 1 if it has none, or an invalid one.

    A TIFF's decoder has already turned the picture.
    """
    try:
        number = _of_exif(_exif(data))
    except struct.error:
        return 1
    return number if 1 <= number <= 8 else 1


def turned(image: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Turn a picture (h, w) or (h, w, c) for display; its sides swap from 5 on."""
    if orientation >= 5:
        image = image.swapaxes(0, 1)
    if orientation in (2, 3, 6, 7):
        image = image[:, ::-1]
    if orientation in (3, 4, 7, 8):
        image = image[::-1]
    return np.ascontiguousarray(image)


def _exif(data: bytes) -> bytes:
    if data.startswith(b"\xff\xd8"):
        return _in_jpeg(data)
    if data.startswith(b"\x89PNG"):
        return _in_chunks(data, 8, b"eXIf", ">")
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return _in_chunks(data, 12, b"EXIF", "<").removeprefix(b"Exif\0\0")
    return b""


def _in_jpeg(data: bytes) -> bytes:
    """First segment APP1 that begins with "Exif", before the scan."""
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF and data[at + 1] != 0xDA:
        if data[at + 1] == 0xFF:
            at += 1
            continue
        size = int(struct.unpack_from(">H", data, at + 2)[0])
        if data[at + 1] == 0xE1 and data[at + 4 : at + 10] == b"Exif\0\0":
            return data[at + 10 : at + 2 + size]
        at += 2 + size
    return b""


def _in_chunks(data: bytes, at: int, wanted: bytes, order: str) -> bytes:
    """Chunk of a PNG (length, kind, body, sum) or of a WebP (kind, length, body, even)."""
    png = order == ">"
    while at + 8 <= len(data):
        kind, length = (data[at + 4 : at + 8], at) if png else (data[at : at + 4], at + 4)
        size = int(struct.unpack_from(order + "I", data, length)[0])
        if kind == wanted:
            return data[at + 8 : at + 8 + size]
        at += 12 + size if png else 8 + size + size % 2
    return b""


def _of_exif(exif: bytes) -> int:
    if exif[:4] not in (b"II*\0", b"MM\0*"):
        return 1
    order = "<" if exif[:2] == b"II" else ">"
    directory = int(struct.unpack_from(order + "I", exif, 4)[0])
    for i in range(int(struct.unpack_from(order + "H", exif, directory)[0])):
        tag, kind = struct.unpack_from(order + "HH", exif, directory + 2 + 12 * i)
        if tag == _ORIENTATION:
            at = directory + 2 + 12 * i + 8
            return int(struct.unpack_from(order + "H", exif, at)[0]) if kind == _SHORT else 1
    return 1

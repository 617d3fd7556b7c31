"""Map pictures in Netpbm's PGM format, P2 (text) and P5 (binary)."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner.scene import SceneError

PGM_HEADER = re.compile(
    rb"P([25])(?:\s|#[^\r\n]*[\r\n])+(\d{1,9})(?:\s|#[^\r\n]*[\r\n])+(\d{1,9})"
    rb"(?:\s|#[^\r\n]*[\r\n])+(\d{1,9})"
)
GLUED_COMMENTS = re.compile(rb"(?:#[^\r\n]*[\r\n])+")
"""Comments attached to a number of a PGM's header."""


def parse_pgm(data: bytes, name: str) -> NDArray[np.float64]:
    """Parse a PGM file into (h, w) shades in [0, 1].

    A comment may directly follow any number, including the maximum.
    """
    header = PGM_HEADER.match(data)
    if header is None:
        raise SceneError(f"{name}: not a PGM picture: its header (P2 or P5, size, maximum) is bad")
    kind, width, height, maximum = (int(v) for v in header.groups())
    if width == 0 or height == 0 or not 0 < maximum < 65536:
        raise SceneError(
            f"{name}: PGM of {width} x {height}, maximum {maximum}: the sides must be > 0 and"
            " the maximum in 1..65535"
        )
    body = data[header.end() :]
    cells = width * height
    if kind == 5:
        values = _binary_values(body, cells, maximum, name)
    else:
        values = _text_values(body, cells, name)
    if values.max(initial=0) > maximum:
        raise SceneError(f"{name}: PGM value {values.max()}: the maximum is {maximum}")
    return values.reshape(height, width).astype(np.float64) / maximum


def _binary_values(body: bytes, cells: int, maximum: int, name: str) -> NDArray[Any]:
    """Pixels of a P5 file, from the bytes after its maximum.

    One white space precedes the pixels. After a comment attached to the maximum, Netpbm's document
    requires another, its readers do not: the number of bytes decides.
    """
    kind = np.dtype(np.uint8) if maximum < 256 else np.dtype(">u2")
    size = cells * kind.itemsize
    glued = GLUED_COMMENTS.match(body)
    begin = glued.end() if glued else 0
    if body[begin : begin + 1].isspace() and (not glued or len(body) - begin > size):
        begin += 1
    elif not glued:
        raise SceneError(f"{name}: PGM without white space between its maximum and its pixels")
    if len(body) - begin < size:
        raise SceneError(f"{name}: PGM cut short: {len(body) - begin} of {size} bytes of pixels")
    return np.frombuffer(body, dtype=kind, count=cells, offset=begin)


def _text_values(body: bytes, cells: int, name: str) -> NDArray[Any]:
    words = re.sub(rb"#[^\r\n]*", b" ", body).split()
    if len(words) < cells:
        raise SceneError(f"{name}: PGM cut short: {len(words)} of {cells} pixels")
    if not all(word.isdigit() and len(word) <= 9 for word in words[:cells]):
        raise SceneError(f"{name}: PGM with a pixel that is not a whole number >= 0")
    return np.array([int(word) for word in words[:cells]], dtype=np.int64)

"""Arrays on the wire: one binary message with a JSON head, which browsers read without copying.

A message is the head's length (uint32), the head (JSON, padded with spaces to four bytes), then the
arrays in turn. The head has ``type``, its own fields, and ``arrays``: name -> [type, first byte
after the head, number of values]. Everything is little-endian.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

_TYPES = {"float32": "f4", "int32": "i4", "uint8": "u1"}


@dataclass(slots=True)
class Made:
    """The newest message of a kind, made by a worker; number 0 before the first."""

    message: bytes = b""
    number: int = 0


def pack(kind: str, fields: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Packed message; arrays are float32, int32 or uint8, of any shape (row by row)."""
    parts: list[bytes] = []
    index: dict[str, tuple[str, int, int]] = {}
    offset = 0
    for name, array in arrays.items():
        kind_of_values = array.dtype.name
        data = np.ascontiguousarray(array, dtype="<" + _TYPES[kind_of_values]).tobytes()
        index[name] = (kind_of_values, offset, array.size)
        parts += [data, b"\0" * (-len(data) % 4)]
        offset += len(data) + len(parts[-1])
    head = json.dumps({"type": kind, **fields, "arrays": index}, allow_nan=False).encode()
    head += b" " * (-len(head) % 4)
    return b"".join([struct.pack("<I", len(head)), head, *parts])

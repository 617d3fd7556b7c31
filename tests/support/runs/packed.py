"""Reads a packed message as the page does."""

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray


def unpack(message: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Head and arrays, flat, of a packed message."""
    (length,) = struct.unpack_from("<I", message)
    head: dict[str, Any] = json.loads(message[4 : 4 + length])
    arrays = {
        name: np.frombuffer(message, np.dtype(kind).newbyteorder("<"), count, 4 + length + first)
        for name, (kind, first, count) in head.pop("arrays").items()
    }
    return head, arrays

"""Memory reused from one picture to the next.

Rules and units
- Large arrays that a scene does not keep come from a pool: fresh pages are slow. An array keeps its
  contents until the same name is taken again; no part of it may be handed out.
- Every thread has its own.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray


class ArrayPool(threading.local):
    """Named arrays that grow as needed."""

    def __init__(self) -> None:
        self._bytes: dict[str, NDArray[np.uint8]] = {}

    def take(self, name: str, count: int, dtype: Any) -> NDArray[Any]:
        """Array (count,) under a name, with undefined contents."""
        size = count * np.dtype(dtype).itemsize
        held = self._bytes.get(name)
        if held is None or len(held) < size:
            held = self._bytes[name] = np.empty(size, np.uint8)
        return held[:size].view(dtype)

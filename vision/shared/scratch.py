"""Memory that one picture after the other is worked on in.

Rules and units
- Fresh pages cost more than many a pass over them, so that what is large and gone when a
  picture's scene is made comes from a room. What was taken from it stays as it is until the
  same name is taken again; nothing of it may be handed out.
- Every thread has its own.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Room(threading.local):
    """Named arrays that grow with what is asked of them."""

    def __init__(self) -> None:
        self._bytes: dict[str, NDArray[np.uint8]] = {}

    def take(self, name: str, count: int, dtype: Any) -> NDArray[Any]:
        """An array (count,) under a name; what is in it is undefined."""
        size = count * np.dtype(dtype).itemsize
        held = self._bytes.get(name)
        if held is None or len(held) < size:
            held = self._bytes[name] = np.empty(size, np.uint8)
        return held[:size].view(dtype)

"""The memory in which borders are fitted, one after the other."""

from __future__ import annotations

import threading

import numpy as np

from vision.outline.fit.separating_fit_kernels import RADII
from vision.outline.outline_types import BorderMemory, Fitted

SHORTEST_BORDER = RADII + 1
"""Shortest border of the memory: defined, whole circles get their radius in it."""


class _Kept(threading.local):
    """Memory of this thread's last picture, reused: fresh pages cost as much as a small fit."""

    memory: BorderMemory | None = None


_KEPT = _Kept()


def memory_for(longest: int) -> BorderMemory:
    """Memory to fit borders of up to ``longest`` points or cracks; the next call reuses it."""
    memory = _KEPT.memory
    if memory is None or memory.most <= longest:
        memory = _KEPT.memory = make_memory(max(longest + 1, SHORTEST_BORDER))
    return memory


def make_memory(most: int) -> BorderMemory:
    """Memory to fit borders of fewer than ``most`` points or cracks."""
    row = 2 * most + 1
    return BorderMemory(
        most,
        np.empty((15, row)),
        np.empty((11, row), np.int64),
        np.empty((9, row), np.bool_),
        np.empty((5 * most, 8)),
        np.empty((2 * most + 1, 2), np.int64),
        np.empty((most, 2), np.bool_),
        np.empty(most, np.int8),
    )


def make_fitted(borders: int, edges: int) -> Fitted:
    """Output arrays for that many borders and edges."""
    return Fitted(
        np.empty(borders, np.int8),
        np.empty(borders + 1, np.int64),
        np.empty(edges, np.int8),
        np.empty((edges, 6)),
    )

"""Free places around a place: the nearest on each of several rays."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from planner.scene import FloatArray


def nearest_free(
    place: FloatArray,
    angles: FloatArray,
    distances: FloatArray,
    is_free: Callable[[FloatArray], NDArray[np.bool_]],
    halvings: int,
) -> FloatArray:
    """Places (m, 2) where rays from ``place`` (2,) become free, the nearest first.

    Each ray of ``angles`` (n,), radians, is tried at growing ``distances`` (k,); the step to its
    first free place is halved. A ray without one is left out. ``is_free`` maps points (j, 2) to
    (j,).
    """
    units = np.column_stack([np.cos(angles), np.sin(angles)])
    tried = place + distances[:, None, None] * units
    free = is_free(tried.reshape(-1, 2)).reshape(tried.shape[:2])
    rays = np.flatnonzero(free.any(axis=0))
    first, units = free[:, rays].argmax(axis=0), units[rays]
    low, high = np.where(first > 0, distances[first - 1], 0.0), distances[first]
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        enough = is_free(place + middle[:, None] * units)
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    found: FloatArray = place + high[:, None] * units
    return found[np.argsort(high, kind="stable")]

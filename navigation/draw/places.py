"""Distances from places in a picture to its lines, to keep words off them."""

from __future__ import annotations

import numpy as np

from planner.scene import FloatArray


def distance_to_line(place: FloatArray, line: FloatArray) -> float:
    """Distance from a place to a polyline (n, 2)."""
    a, d = line[:-1], np.diff(line, axis=0)
    t = np.clip(((place - a) * d).sum(axis=1) / np.maximum((d * d).sum(axis=1), 1e-12), 0.0, 1.0)
    return float(np.hypot(*(a + t[:, None] * d - place).T).min())

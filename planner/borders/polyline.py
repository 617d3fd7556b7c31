"""Polylines: length along them, places and distances to them, and fewer vertices."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from planner.borders import polyline_kernels as kernels
from planner.scene import FloatArray, IntArray, Vec

TINY: Final = float(np.finfo(float).tiny)


def length_of(points: FloatArray) -> float:
    """Length of the (n, 2) polyline, 0 for a single point."""
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def arc_lengths(points: FloatArray) -> FloatArray:
    """Length (n,) along the (n, 2) polyline at each of its points, from 0."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def moves(points: FloatArray) -> NDArray[np.bool_]:
    """True (n,) for points (n, 2) other than the one before, and for the first."""
    return np.concatenate([[True], np.any(np.diff(points, axis=0) != 0.0, axis=1)])


def points_at(points: FloatArray, lengths: FloatArray, at: FloatArray) -> FloatArray:
    """Points (m, 2) of the polyline at the lengths ``at`` (m,) along it. O(m log n)."""
    if len(points) == 1:
        return np.repeat(points, len(at), axis=0)
    i = np.clip(np.searchsorted(lengths, at, side="right") - 1, 0, len(points) - 2)
    step = lengths[i + 1] - lengths[i]
    slope = (points[i + 1] - points[i]) / np.where(step > 0.0, step, 1.0)[:, None]
    found = slope * (at - lengths[i])[:, None] + points[i]
    found[at >= lengths[-1]] = points[-1]
    found[at <= lengths[0]] = points[0]
    return found


def nearest_length(
    points: FloatArray, lengths: FloatArray, place: Vec, least: float = 0.0
) -> float:
    """Length, at least ``least``, along the polyline at its point nearest to the place."""
    a, step = points[:-1], np.diff(points, axis=0)
    squared = np.maximum((step**2).sum(axis=1), 1e-300)
    part = np.clip(((np.array(place) - a) * step).sum(axis=1) / squared, 0.0, 1.0)
    at = np.maximum(lengths[:-1] + part * np.diff(lengths), least)
    away = np.hypot(*(points_at(points, lengths, at) - place).T)
    return float(at[np.argmin(away)])


def distance_to_polyline(points: FloatArray, position: tuple[float, float]) -> float:
    """Distance from a position to a polyline (n, 2), n >= 1, in the same units."""
    return float(distances_to_polyline(points, np.array([position]))[0])


def distances_to_polyline(points: FloatArray, positions: FloatArray) -> FloatArray:
    """Distances (m,) from positions (m, 2) to a polyline (n, 2), n >= 1; O(m n) memory."""
    x, y = points[:, 0] - positions[:, :1], points[:, 1] - positions[:, 1:]
    if len(points) == 1:
        return np.hypot(x[:, 0], y[:, 0])
    dx, dy = x[:, 1:] - x[:, :-1], y[:, 1:] - y[:, :-1]
    x, y = x[:, :-1], y[:, :-1]
    squared = dx * dx + dy * dy
    t = -(x * dx + y * dy) / np.maximum(squared, TINY)
    t = np.minimum(np.maximum(t, 0.0), 1.0)
    x, y = x + t * dx, y + t * dy
    return np.asarray(np.sqrt((x * x + y * y).min(axis=1)))


def fewer_vertices(
    points: FloatArray, tolerance: float, spacing: float = np.inf, lengths: FloatArray | None = None
) -> IntArray:
    """Indices of vertices, including first and last, whose chords stay near the polyline.

    Every skipped vertex lies within ``tolerance`` of its chord; no chord spans more than
    ``spacing`` if a vertex lies closer. Greedy, by doubling and halving each chord's reach: O(n log
    n).
    """
    along = arc_lengths(points) if lengths is None else lengths
    return kernels.fewer_vertices(  # type: ignore[no-any-return]
        np.array(points, np.float64, order="C"), along, float(tolerance), float(spacing)
    )

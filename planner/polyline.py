"""Polylines: length along them, and fewer vertices within a tolerance."""

from __future__ import annotations

import numpy as np

from planner.scene import FloatArray, IntArray


def arc_lengths(points: FloatArray) -> FloatArray:
    """(n,) length along the (n, 2) polyline at each of its points, from 0."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def points_at(points: FloatArray, lengths: FloatArray, at: FloatArray) -> FloatArray:
    """(m, 2) points of the polyline at the lengths ``at`` (m,) along it."""
    return np.stack(
        [np.interp(at, lengths, points[:, 0]), np.interp(at, lengths, points[:, 1])], axis=1
    )


def distances_to_chord(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """(n,) distances from the points to the segment from ``start`` to ``end``."""
    chord = end - start
    squared = float(chord @ chord)
    offset = points - start
    t = np.clip(offset @ chord / squared, 0.0, 1.0) if squared > 0.0 else np.zeros(len(points))
    distances: FloatArray = np.hypot(*(offset - t[:, None] * chord).T)
    return distances


def fewer_vertices(
    points: FloatArray, tolerance: float, spacing: float = np.inf, lengths: FloatArray | None = None
) -> IntArray:
    """Indices of vertices, first and last among them, whose chords stay near the polyline.

    Every skipped vertex lies within ``tolerance`` of its chord; no chord spans more than
    ``spacing`` along the polyline where a vertex lies closer. Greedy, by doubling and halving
    the reach of each chord: O(n log n) for chords that skip many vertices.
    """
    along = arc_lengths(points) if lengths is None else lengths
    last = len(points) - 1
    kept = [0]
    while kept[-1] < last:
        here = kept[-1]
        limit = int(np.searchsorted(along, along[here] + spacing, side="right")) - 1
        limit = min(max(limit, here + 1), last)
        kept.append(_reach(points, here, limit, tolerance))
    return np.array(kept, dtype=np.int32)


def _reach(points: FloatArray, here: int, limit: int, tolerance: float) -> int:
    """How far a chord from vertex ``here`` may go; at least to the next vertex."""

    def fits(there: int) -> bool:
        between = points[here + 1 : there]
        return bool(np.all(distances_to_chord(between, points[here], points[there]) <= tolerance))

    good, step = here + 1, 1
    while good < limit:
        there = min(good + step, limit)
        if not fits(there):
            break
        good, step = there, 2 * step
    while step > 1:
        step //= 2
        there = good + step
        if there <= limit and fits(there):
            good = there
    return good

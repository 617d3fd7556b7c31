"""Borders of a scene as polylines, for viewers and for comparing scenes."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from planner.scene import (
    Edge,
    FloatArray,
    PointRecord,
    Record,
    Scene,
    Segment,
    object_records,
    record_edges,
)

CHORD_TOLERANCE = 0.0005
"""Largest gap between an arc and its chord, as a part of the scene's shorter side."""


def border_polylines(scene: Scene) -> Iterator[tuple[int, FloatArray]]:
    """Yield the object's id and points (n, 2) of each record; a P is one point."""
    tolerance = CHORD_TOLERANCE * min(scene.bounds.width, scene.bounds.height)
    for obj in scene.objects:
        for record in object_records(obj):
            yield obj.id, record_polyline(record, scene.y_down, tolerance)


def record_polyline(record: Record, y_down: bool, tolerance: float) -> FloatArray:
    """Points (n, 2) along a record, arcs within ``tolerance``."""
    if isinstance(record, PointRecord):
        return np.array([record.at], dtype=np.float64)
    edges = record_edges(record)
    parts = [_edge_points(edge, y_down, tolerance) for edge in edges]
    return np.vstack([*parts, np.array([edges[-1].end], dtype=np.float64)])


def _edge_points(edge: Edge, y_down: bool, tolerance: float) -> FloatArray:
    if isinstance(edge, Segment):
        return np.array([edge.start], dtype=np.float64)
    start_rad, sweep_rad = edge.sweep(y_down)
    flat = max(-1.0, 1.0 - tolerance / max(edge.radius, tolerance))
    step_rad = max(2.0 * math.acos(flat), 0.05)
    count = max(1, math.ceil(abs(sweep_rad) / step_rad))
    angles = start_rad + sweep_rad * np.arange(count) / count
    x, y = edge.center
    points: FloatArray = np.stack(
        [x + edge.radius * np.cos(angles), y + edge.radius * np.sin(angles)], axis=1
    )
    return points

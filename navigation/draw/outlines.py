"""Borders of records as lines through points, in the scene's units."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from planner.scene import (
    Arc,
    CircleRecord,
    FloatArray,
    PointRecord,
    PolygonRecord,
    Record,
    SceneObject,
    object_records,
    record_edges,
)

ARC_STEP_RAD: Final = math.radians(3.0)
"""Chosen: a circle looks round."""


def ring_points(thing: SceneObject, y_down: bool) -> Iterator[FloatArray]:
    """Yield the closed borders of an object and its holes as (n, 2) rings."""
    for record in object_records(thing):
        if isinstance(record, PolygonRecord | CircleRecord):
            yield chain_points(record, y_down)


def object_lines(thing: SceneObject, y_down: bool) -> Iterator[FloatArray]:
    """Yield each record of an object as a polyline (n, 2); a point is one place."""
    for record in object_records(thing):
        if isinstance(record, PointRecord):
            yield np.array([record.at])
        else:
            yield chain_points(record, y_down)


def chain_points(record: Record, y_down: bool) -> FloatArray:
    """Edges of a record as an (n, 2) polyline; arcs in steps of ``ARC_STEP_RAD``."""
    points: list[tuple[float, float]] = []
    for edge in record_edges(record):
        points.append(edge.start)
        if isinstance(edge, Arc):
            start, sweep = edge.sweep(y_down)
            steps = max(2, math.ceil(abs(sweep) / ARC_STEP_RAD))
            (x, y), r = edge.center, edge.radius
            points += [
                (x + r * math.cos(a), y + r * math.sin(a))
                for a in (start + sweep * k / steps for k in range(1, steps))
            ]
        points.append(edge.end)
    return np.array(points, dtype=np.float64).reshape(-1, 2)

"""Obstacles by their size, and scenes without the small ones.

Rules and units
- An obstacle's size is the area that its outline encloses, holes included, in square units of the
  scene: an unbroken outline of cells or pixels encloses as much as they cover.
- A point of a picture or a grid is one pixel or cell, a line is one wide. In metres a point has no
  size, and a line is a wall without thickness: its size is infinite.
- A path does not avoid an obstacle that was left out. So nothing that drives a robot calls this.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from planner.scene.records import (
    Arc,
    ArcRecord,
    CircleRecord,
    PointRecord,
    PolygonRecord,
    Record,
    SceneObject,
    Segment,
    SegmentRecord,
    Vec,
    extent_points,
    record_edges,
)
from planner.shared.figures import placed, sized

FLAT_POLYGON = 1e-12
"""A polygon with less area than this share of its squared length is a line: rounding."""
SQUARED = {"px": "square px", "m": "square m", "cells": "cells"}
"""Units of areas."""


def without_small(
    objects: Sequence[SceneObject], least_area: float, units: str, *, y_down: bool
) -> tuple[tuple[SceneObject, ...], str]:
    """Leave out the objects smaller than ``least_area``; the sentence counts them. O(edges)."""
    sizes = [size_of(one, units, y_down=y_down) for one in objects]
    kept = tuple(one for one, size in zip(objects, sizes, strict=True) if size >= least_area)
    least = sized(least_area, SQUARED[units])
    if len(kept) == len(objects):
        return kept, f"no obstacle is smaller than {least}: none was left out"
    size, largest = max(
        ((size, one) for one, size in zip(objects, sizes, strict=True) if size < least_area),
        key=lambda left_out: left_out[0],
    )
    which = (
        "1 obstacle" if len(objects) - len(kept) == 1 else f"{len(objects) - len(kept)} obstacles"
    )
    return kept, (
        f"left out {which} smaller than {least}, the largest of "
        f"{sized(size, SQUARED[units], beside=least_area)} at {placed(*_middle(largest))}: paths "
        "may cross them"
    )


def size_of(one: SceneObject, units: str, *, y_down: bool) -> float:
    """Area of an object's outline, in square units of its scene."""
    line_width = math.inf if units == "m" else 1.0
    return sum(_size(record, line_width, y_down=y_down) for record in one.records)


def _size(record: Record, line_width: float, *, y_down: bool) -> float:
    match record:
        case PointRecord():
            return 0.0 if math.isinf(line_width) else line_width**2
        case CircleRecord(_, radius):
            return math.pi * radius**2
        case SegmentRecord() | ArcRecord():
            return _length(record, y_down=y_down) * line_width + line_width**2
        case PolygonRecord():
            area, length = _area(record, y_down=y_down), _length(record, y_down=y_down)
            if area <= FLAT_POLYGON * length**2:
                return 0.5 * length * line_width + line_width**2
            return area


def _area(record: PolygonRecord, *, y_down: bool) -> float:
    """Area inside a closed row of edges: that of its corners, and between arcs and chords."""
    if not record.edges:
        return 0.0
    x0, y0 = record.edges[0].start
    doubled = 0.0
    for edge in record.edges:
        (ax, ay), (bx, by) = edge.start, edge.end
        doubled += (ax - x0) * (by - y0) - (bx - x0) * (ay - y0)
        if isinstance(edge, Arc):
            _, sweep = edge.sweep(y_down)
            doubled += edge.radius**2 * (sweep - math.sin(sweep))
    return 0.5 * abs(doubled)


def _length(record: Record, *, y_down: bool) -> float:
    return sum(
        edge.length if isinstance(edge, Segment) else abs(edge.sweep(y_down)[1]) * edge.radius
        for edge in record_edges(record)
    )


def _middle(one: SceneObject) -> Vec:
    """Middle of the object's box."""
    xs, ys = zip(*extent_points(one), strict=True)
    return 0.5 * (min(xs) + max(xs)), 0.5 * (min(ys) + max(ys))

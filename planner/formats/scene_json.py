"""The scene as JSON, schema ``clearway.scene/1``, for programs that read ``clearway extract``.

Coordinates are the scene's own (``units``), residuals pixels of the picture. Outlines run clockwise
as seen on the screen, holes counter-clockwise; arcs' ``ccw`` is as seen there, too. Of the
``counts``, only ``border_pixels`` is read again.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from planner.scene import (
    Arc,
    CircleRecord,
    Edge,
    PointRecord,
    PolygonRecord,
    Record,
    Scene,
    SegmentRecord,
    object_records,
)

SCHEMA = "clearway.scene/1"


def scene_to_json(scene: Scene) -> dict[str, Any]:
    """Convert a scene to a dictionary of plain values."""
    b = scene.bounds
    how = scene.binarisation
    return {
        "schema": SCHEMA,
        "units": scene.units,
        "size": None if scene.size is None else list(scene.size),
        "bounds": [b.x_min, b.y_min, b.x_max, b.y_max],
        "bounds_given": scene.bounds_given,
        "binarisation": None
        if how is None
        else {
            "method": how.method,
            "threshold": how.threshold,
            "polarity": how.polarity,
            "reason": how.reason,
        },
        "counts": _counts(scene),
        "timings_ms": dict(scene.timings_ms),
        "remarks": list(scene.remarks),
        "objects": [
            {
                "id": obj.id,
                "records": _records(obj.records),
                "holes": [_records(hole) for hole in obj.holes],
            }
            for obj in scene.objects
        ],
    }


def _counts(scene: Scene) -> dict[str, int]:
    counts = {"P": 0, "S": 0, "C": 0, "A": 0, "L": 0}
    holes = arcs = 0
    for obj in scene.objects:
        holes += len(obj.holes)
        for record in object_records(obj):
            letter = _record(record)["type"]
            counts[letter] += 1
            arcs += sum(isinstance(e, Arc) for e in getattr(record, "edges", ()))
    return {
        "objects": len(scene.objects),
        "holes": holes,
        "border_pixels": scene.border_pixels,
        "vertices": scene.vertex_count,
        "arcs": arcs,
        **counts,
    }


def _records(records: Iterable[Record]) -> list[dict[str, Any]]:
    return [_record(record) for record in records]


def _record(record: Record) -> dict[str, Any]:
    body: dict[str, Any]
    match record:
        case PointRecord(at):
            body = {"type": "P", "at": list(at)}
        case SegmentRecord(start, end):
            body = {"type": "S", "from": list(start), "to": list(end)}
        case CircleRecord(center, radius):
            body = {"type": "C", "center": list(center), "radius": radius}
        case _:
            letter = "L" if isinstance(record, PolygonRecord) else "A"
            body = {"type": letter, "edges": [_edge(edge) for edge in record.edges]}
    return {**body, "residual_px": record.residual_px}


def _edge(edge: Edge) -> dict[str, Any]:
    ends = {"from": list(edge.start), "to": list(edge.end)}
    if isinstance(edge, Arc):
        curve = {"center": list(edge.center), "radius": edge.radius, "ccw": edge.ccw}
        return {"kind": "arc", **ends, **curve}
    return {"kind": "segment", **ends}

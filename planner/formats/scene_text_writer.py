"""Writer of a scene as text (:mod:`planner.formats.scene_text`)."""

from __future__ import annotations

import json
from collections.abc import Iterator

from planner.formats.line_scanner import MAX_COORDINATE
from planner.formats.scene_text_reader import HEADER, arc_problem
from planner.scene import (
    Arc,
    ArcRecord,
    CircleRecord,
    Edge,
    PointRecord,
    PolygonRecord,
    Record,
    Scene,
    SceneError,
    SegmentRecord,
    Vec,
)


def scene_lines(scene: Scene) -> Iterator[str]:
    """Lines of the whole text."""
    b = scene.bounds
    corners = " ".join(_number(v) for v in (b.x_min, b.y_min, b.x_max, b.y_max))
    yield HEADER
    yield f"#@ units {scene.units}"
    yield f"#@ bounds {'given' if scene.bounds_given else 'derived'} {corners}"
    if scene.size is not None:
        yield f"#@ size {int(scene.size[0])} {int(scene.size[1])}"
    if scene.border_pixels:
        yield f"#@ border_pixels {int(scene.border_pixels)}"
    if scene.binarisation is not None:
        how = scene.binarisation
        fields = {
            "method": how.method,
            "threshold": float(how.threshold),
            "polarity": how.polarity,
            "reason": how.reason,
        }
        yield f"#@ binarisation {_json(fields)}"
    if scene.timings_ms:
        yield f"#@ timings_ms {_json({k: float(v) for k, v in scene.timings_ms.items()})}"
    for remark in scene.remarks:
        yield f"#@ remark {_json(remark)}"
    for obj in scene.objects:
        yield f"#@ object {obj.id}"
        for record in obj.records:
            yield from _record_lines(record)
        for hole in obj.holes:
            yield "#@ hole"
            for record in hole:
                yield from _record_lines(record)


def _json(value: object) -> str:
    try:
        return json.dumps(value, allow_nan=False)
    except ValueError as error:
        raise SceneError(f"the scene cannot be written: {error}") from None


def _record_lines(record: Record) -> Iterator[str]:
    match record:
        case PointRecord(at):
            yield f"P {_point(at)}"
        case SegmentRecord(start, end):
            yield f"S {_point(start)} {_point(end)}"
        case CircleRecord(center, radius):
            yield f"C {_point(center)} {_radius(radius)}"
        case ArcRecord(edges):
            yield from _chain_lines("A", edges, closed=False)
        case PolygonRecord(edges):
            yield from _chain_lines("L", edges, closed=True)
    if record.residual_px != 0.0:
        yield f"#@ residual_px {_number(record.residual_px)}"


def _chain_lines(letter: str, edges: tuple[Edge, ...], *, closed: bool) -> Iterator[str]:
    if not edges:
        raise SceneError(f"the scene cannot be written: a record {letter} without edges")
    follow = [*edges[1:], edges[0]] if closed else edges[1:]
    for number, (edge, after) in enumerate(zip(edges, follow, strict=False), start=1):
        if edge.end != after.start:
            raise SceneError(
                f"the scene cannot be written: in a record {letter}, edge {number} ends at"
                f" {edge.end} but the next begins at {after.start}"
            )
    vertices = [edge.start for edge in edges]
    if not closed:
        vertices.append(edges[-1].end)
    yield f"{letter} {len(vertices)} {''.join(_point(v) for v in vertices)}"
    for number, edge in enumerate(edges, start=1):
        if isinstance(edge, Arc):
            problem = arc_problem(edge)
            if problem:
                raise SceneError(f"the scene cannot be written: {problem}")
            x, y = (_number(v) for v in edge.center)
            sense = "ccw" if edge.ccw else "cw"
            yield f"#@ arc {number} {x} {y} {_radius(edge.radius)} {sense}"


def _number(value: float) -> str:
    value = float(value)
    if not abs(value) <= MAX_COORDINATE:
        raise SceneError(
            f"the scene cannot be written: {value!r} must lie within +-{MAX_COORDINATE:g}"
        )
    return repr(value)


def _radius(value: float) -> str:
    if not value > 0.0:
        raise SceneError(f"the scene cannot be written: radius = {value!r}: must be > 0")
    return _number(value)


def _point(point: Vec) -> str:
    return f"({_number(point[0])},{_number(point[1])})"

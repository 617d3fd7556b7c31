"""Conversion of polygons and GeoJSON-like geometry to objects, and back.

Rules and units
- A ring is an (n, 2) array of vertices, turning either way; a first vertex repeated at the end is
  dropped, and so is one repeated in a row.
- ``__geo_interface__`` (S. Gillies, A Python Protocol for Geospatial Data) is a mapping in the
  form of GeoJSON (RFC 7946); shapely, GeoPandas, fiona and others have it and accept it.
  Coordinates are the scene's, in its units; a third one is dropped.
- Outlines are turned clockwise as seen on the screen, holes the other way.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from planner.scene.records import (
    Arc,
    ArcRecord,
    CircleRecord,
    PointRecord,
    PolygonRecord,
    Record,
    SceneError,
    SceneObject,
    Segment,
    SegmentRecord,
    record_edges,
)

FEWEST_VERTICES: Final = 3
"""Vertices of the smallest ring: defined."""
FINEST_RAD: Final = math.radians(1.0)
"""An arc is at most so finely divided, whatever its tolerance: chosen, 360 sides a circle."""


def objects_from_polygons(
    polygons: Iterable[ArrayLike], circles: Iterable[Sequence[float]], *, y_down: bool
) -> tuple[SceneObject, ...]:
    """Objects of polygons and circles (x, y, radius), numbered in that order.

    Raises :class:`SceneError` naming the unusable one and the reason.
    """
    records: list[Record] = [
        _polygon(ring, f"polygon {number}", clockwise=True, y_down=y_down)
        for number, ring in enumerate(polygons)
    ]
    for number, circle in enumerate(circles):
        row = _numbers(circle, f"circle {number}")
        if row.shape != (3,):
            raise SceneError(f"circle {number}: shape {row.shape}: must be x, y, radius")
        x, y, radius = row.tolist()
        records.append(CircleRecord((x, y), radius))
    return tuple(SceneObject(number, (record,)) for number, record in enumerate(records))


def objects_from_geo(geometry: object, *, y_down: bool) -> tuple[SceneObject, ...]:
    """Objects of a geometry, a feature, or a collection of them.

    A polygon is an object, a line a wall without thickness, a point a point. Raises
    :class:`SceneError` for anything else.
    """
    objects: list[SceneObject] = []
    for kind, coordinates, where in _geometries(geometry, "geometry"):
        number = len(objects)
        match kind:
            case "Polygon":
                if not coordinates:
                    continue
                outline, *holes = (
                    _polygon(ring, f"{where}, ring {k}", clockwise=k == 0, y_down=y_down)
                    for k, ring in enumerate(coordinates)
                )
                objects.append(SceneObject(number, (outline,), tuple((hole,) for hole in holes)))
            case "LineString":
                objects.append(SceneObject(number, (_line(coordinates, where),)))
            case _:
                row = _numbers(coordinates, where)
                if row.shape not in ((2,), (3,)):
                    raise SceneError(f"{where}: shape {row.shape}: a point must be x, y")
                objects.append(SceneObject(number, (PointRecord((row[0].item(), row[1].item())),)))
    return tuple(objects)


def geo_of(objects: Iterable[SceneObject], tolerance: float, *, y_down: bool) -> dict[str, Any]:
    """Convert the objects to a GeoJSON-like feature collection; ``id`` is the object's.

    Arcs become chords within ``tolerance`` of them, with corners on the arc.
    """
    return {
        "type": "FeatureCollection",
        "features": [
            {
                "type": "Feature",
                "id": one.id,
                "properties": {},
                "geometry": _geometry(one, tolerance, y_down),
            }
            for one in objects
        ],
    }


def _numbers(values: object, what: str) -> NDArray[np.float64]:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise SceneError(f"{what}: must be numbers") from None
    if not np.isfinite(array).all():
        raise SceneError(f"{what}: all coordinates must be finite")
    return array


def _vertices(ring: object, what: str) -> NDArray[np.float64]:
    array = _numbers(ring, what)
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise SceneError(f"{what}: shape {array.shape}: must be (n, 2)")
    return array[:, :2]


def _polygon(ring: object, what: str, *, clockwise: bool, y_down: bool) -> PolygonRecord:
    """Convert the ring to a record, turned as requested."""
    array = _vertices(ring, what)
    moves = np.any(array != np.roll(array, -1, axis=0), axis=1)
    array = array[moves] if len(array) > 1 else array
    if len(array) < FEWEST_VERTICES:
        raise SceneError(
            f"{what}: {len(array)} different vertices: must have at least {FEWEST_VERTICES}"
        )
    x, y = (array - array.mean(axis=0)).T
    doubled_area = float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    crossing = first_crossing(array)
    if crossing is not None:
        i, j = crossing
        raise SceneError(f"{what}: its sides {i} and {j} cross each other")
    if doubled_area == 0.0:
        raise SceneError(f"{what}: encloses nothing: its area is 0")
    # a positive area turns from x to y: clockwise on the screen if y grows down
    if (doubled_area > 0.0) != (clockwise == y_down):
        array[1:] = array[:0:-1].copy()
    corners = [(x, y) for x, y in array.tolist()]
    return PolygonRecord(tuple(map(Segment, corners, [*corners[1:], corners[0]])))


def _line(coordinates: object, what: str) -> Record:
    array = _vertices(coordinates, what)
    if len(array) < 2:
        raise SceneError(f"{what}: {len(array)} vertices: a line must have at least 2")
    ends = [(x, y) for x, y in array.tolist()]
    if len(ends) == 2:
        return SegmentRecord(ends[0], ends[1])
    return ArcRecord(tuple(map(Segment, ends, ends[1:])))


def first_crossing(ring: NDArray[np.float64]) -> tuple[int, int] | None:
    """Two sides of a closed ring (n, 2) that cross between their ends, or None.

    Side i runs from vertex i to the next. O(n log n), plus the pairs whose x overlap.
    """
    starts, ends = ring, np.roll(ring, -1, axis=0)
    lows, highs = np.minimum(starts, ends), np.maximum(starts, ends)
    order = np.argsort(lows[:, 0], kind="stable")
    low_x = lows[order, 0]
    for place, i in enumerate(order.tolist()):
        last = int(np.searchsorted(low_x, highs[i, 0], side="right"))
        others = order[place + 1 : last]
        beside = (lows[others, 1] <= highs[i, 1]) & (highs[others, 1] >= lows[i, 1])
        others = others[beside]
        a, b, c, d = starts[i], ends[i], starts[others], ends[others]
        apart = _side(a, b, c) * _side(a, b, d) < 0.0
        apart &= _side(c, d, a) * _side(c, d, b) < 0.0
        if apart.any():
            j = int(others[np.argmax(apart)])
            return min(i, j), max(i, j)
    return None


def _side(
    a: NDArray[np.float64], b: NDArray[np.float64], p: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Side of the lines from a to b on which p lies: the sign."""
    along, to = b - a, p - a
    return np.sign(along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0])


def _geometries(geometry: object, where: str) -> Iterator[tuple[str, Any, str]]:
    """Each plain geometry: its type, its coordinates, and its name in messages."""
    told = getattr(geometry, "__geo_interface__", geometry)
    if not isinstance(told, Mapping):
        raise SceneError(
            f"{where}: a {type(geometry).__name__}: must have __geo_interface__, as shapely's "
            "geometries do, or be a mapping as GeoJSON has it"
        )
    kind = told.get("type")
    match kind:
        case "FeatureCollection":
            for number, feature in enumerate(_members(told, "features", where)):
                yield from _geometries(feature, f"feature {number}")
        case "Feature":
            if told.get("geometry") is not None:
                yield from _geometries(told["geometry"], where)
        case "GeometryCollection":
            for number, part in enumerate(_members(told, "geometries", where)):
                yield from _geometries(part, f"{where}, part {number}")
        case "Polygon" | "LineString" | "Point":
            yield kind, _members(told, "coordinates", where), where
        case "LinearRing":
            yield "Polygon", [_members(told, "coordinates", where)], where
        case "MultiPolygon" | "MultiLineString" | "MultiPoint":
            for number, part in enumerate(_members(told, "coordinates", where)):
                yield kind.removeprefix("Multi"), part, f"{where}, part {number}"
        case _:
            raise SceneError(f"{where}: type {kind!r}: must be a GeoJSON geometry or feature")


def _members(told: Mapping[str, Any], key: str, where: str) -> Any:
    members = told.get(key)
    if not isinstance(members, Sequence | np.ndarray) or isinstance(members, str):
        raise SceneError(f"{where}: {told.get('type')} without {key}")
    return members


def _geometry(one: SceneObject, tolerance: float, y_down: bool) -> dict[str, Any]:
    """Outline and holes of one object; a collection if it has several records."""
    outlines = [_record_geometry(record, tolerance, y_down) for record in one.records]
    holes = [_ring(record, tolerance, y_down) for hole in one.holes for record in hole]
    if holes and outlines[0]["type"] == "Polygon":
        outlines[0]["coordinates"] += tuple(ring[::-1] for ring in holes)
    if len(outlines) == 1:
        return outlines[0]
    return {"type": "GeometryCollection", "geometries": outlines}


def _record_geometry(record: Record, tolerance: float, y_down: bool) -> dict[str, Any]:
    match record:
        case PointRecord(at):
            return {"type": "Point", "coordinates": at}
        case PolygonRecord() | CircleRecord():
            return {"type": "Polygon", "coordinates": (_ring(record, tolerance, y_down),)}
        case _:
            edges = record_edges(record)
            line = [point for edge in edges for point in _corners(edge, tolerance, y_down)]
            return {"type": "LineString", "coordinates": (*line, edges[-1].end)}


def _ring(record: Record, tolerance: float, y_down: bool) -> tuple[tuple[float, float], ...]:
    """Vertices of a closed record, the first repeated last, counter-clockwise if y is up.

    RFC 7946 wants outlines so; the caller turns holes.
    """
    edges = record_edges(record)
    ring = [point for edge in edges for point in _corners(edge, tolerance, y_down)]
    x, y = (np.array(ring) - ring[0]).T
    turned = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0.0
    ring[1:] = ring[:0:-1] if turned else ring[1:]
    return (*ring, ring[0])


def _corners(edge: Segment | Arc, tolerance: float, y_down: bool) -> Iterator[tuple[float, float]]:
    """Vertices of an edge without its last one."""
    yield edge.start
    if isinstance(edge, Segment) or edge.radius <= tolerance:
        return
    begin, sweep = edge.sweep(y_down)
    step = max(2.0 * math.acos(1.0 - tolerance / edge.radius), FINEST_RAD)
    sides = math.ceil(abs(sweep) / step)
    for k in range(1, sides):
        angle = begin + sweep * k / sides
        x, y = edge.center
        yield x + edge.radius * math.cos(angle), y + edge.radius * math.sin(angle)

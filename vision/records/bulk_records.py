"""Frozen records in bulk, each the same as from its constructor.

Rules and units
- A frozen dataclass sets each field by name; for thousands of edges the slots' setters, in bulk,
  take a third of the time.
- Only records without ``__post_init__``: nothing is checked here.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from itertools import repeat
from typing import Any

from planner.scene import Arc, Edge, PolygonRecord, Record, SceneObject, Segment, Vec

_NEW: Any = object.__new__


def _setters(record: type, *names: str) -> list[Any]:
    return [record.__dict__[name].__set__ for name in names]


_SET_START, _SET_END = _setters(Segment, "start", "end")
_ARC_SETTERS = _setters(Arc, "start", "end", "center", "radius", "ccw")
_SET_EDGES, _SET_RESIDUAL = _setters(PolygonRecord, "edges", "residual_px")
_SET_ID, _SET_RECORDS, _SET_HOLES = _setters(SceneObject, "id", "records", "holes")


def new_segments(starts: Sequence[Vec], ends: Sequence[Vec]) -> list[Segment]:
    """``Segment(start, end)`` for each pair."""
    segments: list[Segment] = list(map(_NEW, repeat(Segment, len(starts))))
    _set_all(_SET_START, segments, starts)
    _set_all(_SET_END, segments, ends)
    return segments


def new_arcs(
    starts: Sequence[Vec],
    ends: Sequence[Vec],
    centers: Sequence[Vec],
    radii: Sequence[float],
    ccws: Sequence[bool],
) -> list[Arc]:
    """``Arc(start, end, center, radius, ccw)`` for each set of five."""
    arcs: list[Arc] = list(map(_NEW, repeat(Arc, len(starts))))
    for setter, values in zip(_ARC_SETTERS, (starts, ends, centers, radii, ccws), strict=True):
        _set_all(setter, arcs, values)
    return arcs


def _set_all(setter: Any, records: Sequence[Any], values: Sequence[Any]) -> None:
    # keeps nothing: only calls the setter
    deque(map(setter, records, values), maxlen=0)


def new_polygon(edges: tuple[Edge, ...], residual_px: float) -> PolygonRecord:
    """``PolygonRecord(edges, residual_px)``."""
    record: PolygonRecord = _NEW(PolygonRecord)
    _SET_EDGES(record, edges)
    _SET_RESIDUAL(record, residual_px)
    return record


def new_object(
    number: int, records: tuple[Record, ...], holes: tuple[tuple[Record, ...], ...]
) -> SceneObject:
    """``SceneObject(number, records, holes)``."""
    thing: SceneObject = _NEW(SceneObject)
    _SET_ID(thing, number)
    _SET_RECORDS(thing, records)
    _SET_HOLES(thing, holes)
    return thing

"""The paper's records: P (point), S (segment), C (circle), A (open chain), L (generalized polygon).

Rules and units
- An edge is a segment or an arc, in the units of its scene.
- Outlines run clockwise as seen on the screen, holes counter-clockwise; an arc's ``ccw`` is as
  seen on the screen too, so that it survives the change from y down to y up.
- Everything here is immutable. Coordinates are finite and radii >= 0; a circle of radius 0 is a
  point. Other records cannot be made.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

Vec: TypeAlias = tuple[float, float]


class SceneError(ValueError):
    """A scene, or a file that should hold one, cannot be used; the message says why."""

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


def printable(message: str) -> str:
    """Message with unprintable characters as escapes.

    Messages quote damaged files, which must not control a terminal.
    """
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in message)


def _finite(point: Vec, what: str) -> None:
    """Raise SceneError if a coordinate is infinite or NaN; zero times any other is zero."""
    if point[0] * 0.0 + point[1] * 0.0 != 0.0:
        raise SceneError(f"{what} ({point[0]:g}, {point[1]:g}): must be finite")


def _round(center: Vec, radius: float, what: str) -> None:
    """Raise SceneError if a circle has no place or size; one of radius 0 is a point."""
    _finite(center, f"the centre of {what}")
    if not 0.0 <= radius < math.inf:
        raise SceneError(f"the radius of {what} = {radius:g}: must be >= 0 and finite")


def _measured(residual_px: float, what: str) -> None:
    if residual_px * 0.0 != 0.0:
        raise SceneError(f"the residual of {what} = {residual_px:g} px: must be finite")


@dataclass(frozen=True, slots=True)
class Segment:
    """Straight edge from ``start`` to ``end``; ``SceneError`` if one is not finite."""

    start: Vec
    end: Vec

    def __post_init__(self) -> None:
        (x0, y0), (x1, y1) = self.start, self.end
        # written out: scenes have a hundred thousand of them
        if x0 * 0.0 + y0 * 0.0 + x1 * 0.0 + y1 * 0.0 != 0.0:
            _finite(self.start, "the start of a segment")
            _finite(self.end, "the end of a segment")

    @property
    def length(self) -> float:
        """Length in the scene's units."""
        return math.dist(self.start, self.end)


@dataclass(frozen=True, slots=True)
class Arc:
    """Circular edge from ``start`` to ``end``; ``ccw`` as seen on the screen.

    Equal ends mean the whole circle. ``SceneError`` if a coordinate is not finite or the radius is
    not >= 0.
    """

    start: Vec
    end: Vec
    center: Vec
    radius: float
    ccw: bool

    def __post_init__(self) -> None:
        _finite(self.start, "the start of an arc")
        _finite(self.end, "the end of an arc")
        _round(self.center, self.radius, "an arc")

    def sweep(self, y_down: bool) -> tuple[float, float]:
        """Return ``(start_rad, sweep_rad)`` in the coordinates' own sense: angle = atan2(y, x).

        ``sweep_rad`` is signed: in (0, 2 pi] if the angle grows along the edge, else in [-2 pi, 0).
        """
        a0 = math.atan2(self.start[1] - self.center[1], self.start[0] - self.center[0])
        a1 = math.atan2(self.end[1] - self.center[1], self.end[0] - self.center[0])
        if self.ccw != y_down:
            turn = (a1 - a0) % math.tau
            return a0, turn if turn > 0.0 else math.tau
        turn = (a0 - a1) % math.tau
        return a0, -(turn if turn > 0.0 else math.tau)


Edge: TypeAlias = Segment | Arc


@dataclass(frozen=True, slots=True)
class PointRecord:
    """P: a single pixel."""

    at: Vec
    residual_px: float = 0.0

    def __post_init__(self) -> None:
        _finite(self.at, "a point")
        _measured(self.residual_px, "a point")


@dataclass(frozen=True, slots=True)
class SegmentRecord:
    """S: a straight line segment, an object without an inside."""

    start: Vec
    end: Vec
    residual_px: float = 0.0

    def __post_init__(self) -> None:
        _finite(self.start, "the start of a segment")
        _finite(self.end, "the end of a segment")
        _measured(self.residual_px, "a segment")


@dataclass(frozen=True, slots=True)
class CircleRecord:
    """C: a circle, by its centre and radius."""

    center: Vec
    radius: float
    residual_px: float = 0.0

    def __post_init__(self) -> None:
        _round(self.center, self.radius, "a circle")
        _measured(self.residual_px, "a circle")


@dataclass(frozen=True, slots=True)
class ArcRecord:
    """A: an open chain of edges; in the paper the polygonal line along one arc."""

    edges: tuple[Edge, ...]
    residual_px: float = 0.0

    def __post_init__(self) -> None:
        _measured(self.residual_px, "a chain of edges")


@dataclass(frozen=True, slots=True)
class PolygonRecord:
    """L: a generalized polygon, an ordered closed sequence of edges."""

    edges: tuple[Edge, ...]
    residual_px: float = 0.0

    def __post_init__(self) -> None:
        _measured(self.residual_px, "a polygon")


Record: TypeAlias = PointRecord | SegmentRecord | CircleRecord | ArcRecord | PolygonRecord


@dataclass(frozen=True, slots=True)
class SceneObject:
    """One connected obstacle: the records of its outline and of each hole's border."""

    id: int
    records: tuple[Record, ...]
    holes: tuple[tuple[Record, ...], ...] = ()


def object_records(obj: SceneObject) -> Iterator[Record]:
    """Records of the outline, then of every hole."""
    yield from obj.records
    for hole in obj.holes:
        yield from hole


def record_edges(record: Record) -> tuple[Edge, ...]:
    """Edges of a record: none for P, one for S, two half circles for C."""
    match record:
        case PointRecord():
            return ()
        case SegmentRecord(start, end):
            return (Segment(start, end),)
        case CircleRecord(center, radius):
            left, right = (center[0] - radius, center[1]), (center[0] + radius, center[1])
            return (
                Arc(left, right, center, radius, ccw=False),
                Arc(right, left, center, radius, ccw=False),
            )
        case ArcRecord(edges) | PolygonRecord(edges):
            return edges


def extent_points(obj: SceneObject) -> Iterator[Vec]:
    """Points whose bounding box holds the object; an arc counts as its whole circle."""
    for record in object_records(obj):
        if isinstance(record, PointRecord):
            yield record.at
        for edge in record_edges(record):
            if isinstance(edge, Arc):
                (x, y), r = edge.center, edge.radius
                yield from ((x - r, y - r), (x + r, y + r))
            yield from (edge.start, edge.end)

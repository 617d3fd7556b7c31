"""The scene: the free space's boundary and the objects in it, as the paper's records.

Rules and units
- A scene has its own units: ``px`` (a picture, y down, pixel centres at integers), ``m``
  (a calibrated arena, y up) or ``cells`` (a grid map without a size, y down).
- The paper's records: P (point), S (segment), C (circle), A (open chain of edges),
  L (generalized polygon: closed sequence of edges). An edge is a segment or an arc.
- An object is one connected obstacle: its outline's records and, for each hole, the records
  of the hole's border. The solid is what lies between; a hole is free space.
- Outlines run clockwise as seen on the screen, holes counter-clockwise; an arc's ``ccw``
  is as seen on the screen too, so that it survives the change from y down to y up.
- Everything here is immutable; arrays are read-only.
- Coordinates are finite and radii >= 0, a circle of none being a point: any other record cannot
  be made.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Vec: TypeAlias = tuple[float, float]
Units: TypeAlias = Literal["px", "m", "cells"]
FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int32]

POINT, SEGMENT, CIRCLE, ARC = 0, 1, 2, 3
"""The kinds of a flat primitive, see :class:`Primitives`."""


class SceneError(ValueError):
    """A scene, or a file that should hold one, cannot be used; the message says why."""

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


def printable(message: str) -> str:
    """The message with what cannot be printed as escapes.

    Words of a damaged file stand in messages: nothing of them may steer a terminal.
    """
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in message)


def _finite(point: Vec, what: str) -> None:
    """SceneError where a coordinate is infinite or no number; zero times any other is zero."""
    if point[0] * 0.0 + point[1] * 0.0 != 0.0:
        raise SceneError(f"{what} ({point[0]:g}, {point[1]:g}): must be finite")


def _round(center: Vec, radius: float, what: str) -> None:
    """SceneError where a circle has no place or size; one of no radius is a point."""
    _finite(center, f"the centre of {what}")
    if not 0.0 <= radius < math.inf:
        raise SceneError(f"the radius of {what} = {radius:g}: must be >= 0 and finite")


def _measured(residual_px: float, what: str) -> None:
    if residual_px * 0.0 != 0.0:
        raise SceneError(f"the residual of {what} = {residual_px:g} px: must be finite")


@dataclass(frozen=True, slots=True)
class Segment:
    """A straight edge from ``start`` to ``end``; ``SceneError`` where one is not finite."""

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
        """Its length, in the scene's units."""
        return math.dist(self.start, self.end)


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular edge from ``start`` to ``end``; ``ccw`` as seen on the screen.

    Equal ends mean the whole circle. ``SceneError`` where a coordinate is not finite or the
    radius is not >= 0.
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
        """``(start_rad, sweep_rad)`` in the coordinates' own sense: angle = atan2(y, x).

        ``sweep_rad`` is signed, in (0, 2 pi] where the angle grows along the edge and in
        [-2 pi, 0) where it falls.
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


@dataclass(frozen=True, slots=True)
class Bounds:
    """The rectangle that holds the free space; its sides are walls."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float

    @property
    def width(self) -> float:
        """Extent along x."""
        return self.x_max - self.x_min

    @property
    def height(self) -> float:
        """Extent along y."""
        return self.y_max - self.y_min

    def contains(self, point: Vec) -> bool:
        """Whether the point lies inside or on the rectangle."""
        return self.x_min <= point[0] <= self.x_max and self.y_min <= point[1] <= self.y_max

    def corners(self) -> tuple[Vec, Vec, Vec, Vec]:
        """The four corners, in the order of growing angle (x right, y along the axis)."""
        return (
            (self.x_min, self.y_min),
            (self.x_max, self.y_min),
            (self.x_max, self.y_max),
            (self.x_min, self.y_max),
        )


@dataclass(frozen=True, slots=True)
class Binarisation:
    """How a picture was made black and white, and why so."""

    method: str
    threshold: float
    polarity: Literal["dark", "light"]
    reason: str


@dataclass(frozen=True, slots=True)
class Primitives:
    """All borders of a scene as flat arrays, the form that kernels take.

    ``kind`` (k,) int8: POINT, SEGMENT, CIRCLE or ARC. ``data`` (k, 6) float64, unused = 0:
    POINT x, y; SEGMENT x0, y0, x1, y1; CIRCLE cx, cy, r; ARC cx, cy, r, start_rad, sweep_rad
    with sweep_rad in (0, 2 pi], the angle growing (an edge that ran the other way is turned
    round; ``reversed`` says so). ``owner`` (k,) int32: index of the object in
    ``Scene.objects``, or -1 for the bounds. ``border`` (k,) int32: number of the connected
    border (outline or hole) the primitive belongs to, in order along it; the bounds come
    last. ``is_hole`` (k,) bool: part of a hole's border.
    """

    kind: NDArray[np.int8]
    data: FloatArray
    owner: IntArray
    border: IntArray
    is_hole: NDArray[np.bool_]
    reversed: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Scene:
    """The free space's boundary and the objects, with what was learned while seeing them.

    ``bounds_given`` is False where the source had none and a generous rectangle was derived.
    ``size`` is the picture's (width, height) in pixels, or the grid's in cells.
    ``border_pixels`` is n of the paper; ``timings_ms`` holds the stages' wall times.
    ``remarks`` are plain sentences on what was degraded, dropped or found touching.
    """

    units: Units
    bounds: Bounds
    objects: tuple[SceneObject, ...]
    bounds_given: bool = True
    size: tuple[int, int] | None = None
    border_pixels: int = 0
    binarisation: Binarisation | None = None
    timings_ms: Mapping[str, float] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        b = self.bounds
        if not all(math.isfinite(v) for v in (b.x_min, b.y_min, b.x_max, b.y_max)):
            raise SceneError(f"bounds {b}: must be finite")
        if not (b.x_min < b.x_max and b.y_min < b.y_max):
            raise SceneError(f"bounds {b}: must have a positive width and height")

    @property
    def y_down(self) -> bool:
        """Whether y grows downwards on the screen (pictures and grid maps)."""
        return self.units != "m"

    @property
    def vertex_count(self) -> int:
        """m of the paper: the number of points and circles that the records store."""
        return sum(_stored_points(r) for o in self.objects for r in object_records(o))

    def with_bounds(self, bounds: Bounds) -> Scene:
        """The same objects inside other bounds."""
        return replace(self, bounds=bounds, bounds_given=True)

    def primitives(self, include_bounds: bool = True) -> Primitives:
        """All borders as flat arrays, in the order of the objects; the bounds come last."""
        flat = Flattener(self.y_down)
        for index, obj in enumerate(self.objects):
            flat.add_object(obj, index)
        if include_bounds:
            c = self.bounds.corners()
            sides = tuple(Segment(c[i], c[(i + 1) % 4]) for i in range(4))
            flat.add_border((PolygonRecord(sides),), -1, is_hole=True)
        return flat.finish()


def object_records(obj: SceneObject) -> Iterator[Record]:
    """The outline's records, then those of every hole."""
    yield from obj.records
    for hole in obj.holes:
        yield from hole


def record_edges(record: Record) -> tuple[Edge, ...]:
    """The edges of a record: none for P, one for S, two half circles for C."""
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


def _stored_points(record: Record) -> int:
    match record:
        case SegmentRecord():
            return 2
        case ArcRecord(edges):
            return len(edges) + 1
        case PolygonRecord(edges):
            return len(edges)
        case _:
            return 1


class Flattener:
    """Collects primitives border by border: a row and a kind each, and how many per border."""

    def __init__(self, y_down: bool) -> None:
        self.y_down = y_down
        self.rows: list[tuple[float, ...]] = []
        self.kind: list[int] = []
        self.turned: list[int] = []
        self.borders: list[tuple[int, int, bool]] = []

    def add_object(self, obj: SceneObject, owner: int) -> None:
        """An object's outline and holes."""
        self.add_border(obj.records, owner, is_hole=False)
        for hole in obj.holes:
            self.add_border(hole, owner, is_hole=True)

    def add_border(self, records: Sequence[Record], owner: int, *, is_hole: bool) -> None:
        """The records of one border of an object; -1 owns the bounds."""
        before = len(self.kind)
        for record in records:
            match record:
                case PointRecord(at):
                    self._add(POINT, (*at, 0.0, 0.0, 0.0, 0.0))
                case CircleRecord(center, radius):
                    self._add(CIRCLE, (*center, radius, 0.0, 0.0, 0.0))
                case _:
                    self._add_edges(record_edges(record))
        self.borders.append((len(self.kind) - before, owner, is_hole))

    def _add_edges(self, edges: Sequence[Edge]) -> None:
        # most primitives are segments: they are told by their type, patterns are slower
        rows, kind = self.rows, self.kind
        for edge in edges:
            if type(edge) is Segment:
                start, end = edge.start, edge.end
                if start == end:
                    self._add(POINT, (*start, 0.0, 0.0, 0.0, 0.0))
                    continue
                rows.append((start[0], start[1], end[0], end[1], 0.0, 0.0))
                kind.append(SEGMENT)
            elif isinstance(edge, Arc):
                a0, turn = edge.sweep(self.y_down)
                if turn < 0.0:
                    a0, turn = a0 + turn, -turn
                    self.turned.append(len(kind))
                self._add(ARC, (*edge.center, edge.radius, a0, turn, 0.0))

    def _add(self, kind: int, row: tuple[float, ...]) -> None:
        self.kind.append(kind)
        self.rows.append(row)

    def finish(self) -> Primitives:
        """All that was added, as flat arrays."""
        count = len(self.kind)
        flat = chain.from_iterable(self.rows)
        backwards = np.zeros(count, dtype=np.bool_)
        backwards[self.turned] = True
        sizes = [size for size, _, _ in self.borders]
        arrays = (
            np.array(self.kind, dtype=np.int8),
            np.fromiter(flat, np.float64, 6 * count).reshape(-1, 6),
            np.repeat(np.array([o for _, o, _ in self.borders], np.int32), sizes),
            np.repeat(np.arange(len(self.borders), dtype=np.int32), sizes),
            np.repeat(np.array([hole for _, _, hole in self.borders], np.bool_), sizes),
            backwards,
        )
        for array in arrays:
            array.setflags(write=False)
        return Primitives(*arrays)

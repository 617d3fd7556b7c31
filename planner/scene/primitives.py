"""Borders of a scene as flat arrays of primitives, the form that kernels take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from planner.scene.records import (
    Arc,
    CircleRecord,
    Edge,
    PointRecord,
    PolygonRecord,
    Record,
    SceneObject,
    Segment,
    record_edges,
)

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int32]

POINT, SEGMENT, CIRCLE, ARC = 0, 1, 2, 3
"""The kinds of a flat primitive, see :class:`Primitives`."""
ROUND = CIRCLE, ARC
"""Those that have a centre and a radius."""


@dataclass(frozen=True, slots=True)
class Primitives:
    """All borders of a scene as flat arrays.

    ``kind`` (k,) int8: POINT, SEGMENT, CIRCLE or ARC. ``data`` (k, 6) float64, unused = 0: POINT x,
    y; SEGMENT x0, y0, x1, y1; CIRCLE cx, cy, r; ARC cx, cy, r, start_rad, sweep_rad with sweep_rad
    in (0, 2 pi], the angle growing (``reversed`` marks edges that ran the other way and were
    turned). ``owner`` (k,) int32: index of the object in ``Scene.objects``, or -1 for the bounds.
    ``border`` (k,) int32: number of the primitive's connected border (outline or hole), in order
    along it; the bounds come last. ``is_hole`` (k,) bool: part of a hole's border.
    """

    kind: NDArray[np.int8]
    data: FloatArray
    owner: IntArray
    border: IntArray
    is_hole: NDArray[np.bool_]
    reversed: NDArray[np.bool_]


class Flattener:
    """Collects primitives border by border: a kind and six numbers each, one count per border."""

    def __init__(self, y_down: bool) -> None:
        self.y_down = y_down
        self.numbers: list[float] = []
        self.kind: list[int] = []
        self.turned: list[int] = []
        self.borders: list[tuple[int, int, bool]] = []

    def add_object(self, obj: SceneObject, owner: int) -> None:
        """Add an object's outline and holes."""
        self.add_border(obj.records, owner, is_hole=False)
        for hole in obj.holes:
            self.add_border(hole, owner, is_hole=True)

    def add_border(self, records: Sequence[Record], owner: int, *, is_hole: bool) -> None:
        """Add the records of one border of an object; -1 owns the bounds."""
        before = len(self.kind)
        for record in records:
            # most are polygons of segments: type checks are faster than patterns
            if type(record) is PolygonRecord:
                self._add_edges(record.edges)
            elif isinstance(record, PointRecord):
                self._add(POINT, (*record.at, 0.0, 0.0, 0.0, 0.0))
            elif isinstance(record, CircleRecord):
                self._add(CIRCLE, (*record.center, record.radius, 0.0, 0.0, 0.0))
            else:
                self._add_edges(record_edges(record))
        self.borders.append((len(self.kind) - before, owner, is_hole))

    def _add_edges(self, edges: Sequence[Edge]) -> None:
        numbers, kind = self.numbers, self.kind
        for edge in edges:
            if type(edge) is Segment:
                start, end = edge.start, edge.end
                if start == end:
                    self._add(POINT, (*start, 0.0, 0.0, 0.0, 0.0))
                    continue
                numbers += (*start, *end, 0.0, 0.0)
                kind.append(SEGMENT)
            elif isinstance(edge, Arc):
                a0, turn = edge.sweep(self.y_down)
                if turn < 0.0:
                    a0, turn = a0 + turn, -turn
                    self.turned.append(len(kind))
                self._add(ARC, (*edge.center, edge.radius, a0, turn, 0.0))

    def _add(self, kind: int, row: tuple[float, ...]) -> None:
        self.kind.append(kind)
        self.numbers += row

    def finish(self) -> Primitives:
        """Everything added, as flat arrays."""
        count = len(self.kind)
        backwards = np.zeros(count, dtype=np.bool_)
        backwards[self.turned] = True
        sizes = [size for size, _, _ in self.borders]
        arrays = (
            np.array(self.kind, dtype=np.int8),
            np.array(self.numbers, dtype=np.float64).reshape(-1, 6),
            np.repeat(np.array([o for _, o, _ in self.borders], np.int32), sizes),
            np.repeat(np.arange(len(self.borders), dtype=np.int32), sizes),
            np.repeat(np.array([hole for _, _, hole in self.borders], np.bool_), sizes),
            backwards,
        )
        for array in arrays:
            array.setflags(write=False)
        return Primitives(*arrays)

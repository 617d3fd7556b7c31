"""Nearly straight arcs as chords, computed from their ends.

Doubles place the border of a circle from its centre to some 2^-52 of its radius: for a radius of a
hundred million metres to 0.02 micrometres. An arc of so large a radius is flat, so that few chords
follow it more closely than that.

Rules and units
- A radius is large if that rounding would exceed ``FLATNESS`` of the larger side of the bounds;
  then no chord inside them is further than ``FLATNESS`` of that side from its arc.
- Beyond the bounds a chord may be off by its distance to them: the walls are nearer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from planner.scene.primitives import Flattener
from planner.scene.records import (
    Arc,
    ArcRecord,
    CircleRecord,
    Edge,
    PolygonRecord,
    Record,
    SceneObject,
    Segment,
    Vec,
    record_edges,
)

FLATNESS = 1e-10
"""Over the bounds' larger side: a tenth of what the planner's searches take for equal."""
ROUNDINGS = 2.0**-51
"""Error bound of a distance to a circle, over its radius: its centre's, the root's and the rest."""


def flatten(
    objects: Sequence[SceneObject], bounds: tuple[float, float, float, float], y_down: bool
) -> Flattener:
    """Borders of objects in the given order, those of large radius as chords.

    ``bounds`` are x_min, y_min, x_max, y_max.
    """
    flat, arcs = Flattener(y_down), FlatArcs(bounds, y_down)
    for index, obj in enumerate(objects):
        flat.add_object(obj, index)
    # a circle's or an arc's radius, or a segment's far end, of which there may be many
    if not arcs.are_needed(max(flat.numbers[2::6], default=0.0)):
        return flat
    flat = Flattener(y_down)
    for index, obj in enumerate(objects):
        flat.add_object(arcs.straightened(obj), index)
    return flat


@dataclass(frozen=True, slots=True)
class FlatArcs:
    """Chords that replace arcs of large radius."""

    bounds: tuple[float, float, float, float]
    y_down: bool

    @property
    def tolerance(self) -> float:
        """Largest distance of a chord inside the bounds from its arc."""
        x0, y0, x1, y1 = self.bounds
        return FLATNESS * max(x1 - x0, y1 - y0)

    def are_needed(self, radius: float) -> bool:
        """True if distances from the centre would be off by more than the tolerance."""
        return ROUNDINGS * radius > self.tolerance

    def straightened(self, obj: SceneObject) -> SceneObject:
        """Replace the object's arcs of large radius with chords."""
        records = tuple(map(self._record, obj.records))
        holes = tuple(tuple(map(self._record, hole)) for hole in obj.holes)
        return replace(obj, records=records, holes=holes)

    def _record(self, record: Record) -> Record:
        if isinstance(record, CircleRecord) and self.are_needed(record.radius):
            record = PolygonRecord(record_edges(record), record.residual_px)
        if not isinstance(record, ArcRecord | PolygonRecord):
            return record
        edges: list[Edge] = []
        for edge in record.edges:
            if isinstance(edge, Arc) and self.are_needed(edge.radius):
                edges += self.chords(edge)
            else:
                edges.append(edge)
        return replace(record, edges=tuple(edges))

    def chords(self, arc: Arc) -> Iterator[Segment]:
        """Yield the chords of an arc, in its order. O(log radius) beyond those in the bounds."""
        side = 1.0 if arc.ccw != self.y_down else -1.0
        (x0, y0), (x1, y1), (cx, cy) = arc.start, arc.end, arc.center
        if arc.start == arc.end:
            opposite = (2.0 * cx - x0, 2.0 * cy - y0)
            yield from self._halved(arc.start, opposite, arc.radius, side, is_minor=True)
            yield from self._halved(opposite, arc.end, arc.radius, side, is_minor=True)
            return
        to_centre = (x1 - x0) * (cy - y0) - (y1 - y0) * (cx - x0)
        yield from self._halved(
            arc.start, arc.end, arc.radius, side, is_minor=side * to_centre >= 0.0
        )

    def _halved(
        self, start: Vec, end: Vec, radius: float, side: float, *, is_minor: bool
    ) -> Iterator[Segment]:
        """Yield chords from start to end; the arc bulges to the right if ``side`` is 1."""
        dx, dy = end[0] - start[0], end[1] - start[1]
        chord = math.hypot(dx, dy)
        half = min(0.5 * chord, radius)
        across = math.sqrt((radius - half) * (radius + half))
        # avoids differences of lengths near the radius
        height = half * (half / (radius + across)) if is_minor else radius + across
        if height <= max(self.tolerance, self._beyond(start, end, height)) or chord == 0.0:
            yield Segment(start, end)
            return
        apex = (
            0.5 * (start[0] + end[0]) + side * height * dy / chord,
            0.5 * (start[1] + end[1]) - side * height * dx / chord,
        )
        yield from self._halved(start, apex, radius, side, is_minor=True)
        yield from self._halved(apex, end, radius, side, is_minor=True)

    def _beyond(self, start: Vec, end: Vec, height: float) -> float:
        """Distance of the chord and its arc beyond the bounds; 0 or less if they may reach them."""
        x0, y0, x1, y1 = self.bounds
        return (
            max(
                min(start[0], end[0]) - x1,
                x0 - max(start[0], end[0]),
                min(start[1], end[1]) - y1,
                y0 - max(start[1], end[1]),
            )
            - height
        )

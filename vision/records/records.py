"""From fitted borders to the paper's records P, S, C, A and L.

Rules and units
- Coordinates are pixels, y down, or metres, y up, from rectified pixels by a ``Placement``; an
  arc's turn is as seen on the screen and needs no change.
- An outline comes first, then the borders of its holes in their order.
- P: a pixel. S, A: a straight or curved line, one pixel wide. C: a circle. L: anything else; a tiny
  object's border is its pixels' outline.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner.scene import (
    Arc,
    ArcRecord,
    CircleRecord,
    Edge,
    PointRecord,
    PolygonRecord,
    Record,
    SceneObject,
    Segment,
    SegmentRecord,
    Vec,
)
from vision.binarise.binarise_kernels import SIGMAS
from vision.borders.contours import Contours
from vision.outline.fitted_borders import ARC_CCW, TINY_BORDER, WHOLE_CIRCLE, FittedBorders
from vision.records.bulk_records import new_arcs, new_object, new_polygon, new_segments
from vision.records.clipping import clip_circle, clip_polygon
from vision.records.placement import Placement
from vision.records.record_kernels import look_at_borders
from vision.records.thin_curves import chain_edges, open_chain

SPECK_AREA = 4
"""Pixels of the largest border that counts as noise."""


@dataclass(frozen=True, slots=True)
class Specks:
    """Borders that noise alone may have made, and the remark on them."""

    borders: frozenset[int]
    remarks: tuple[str, ...]


def find_specks(borders: Contours, noise: float, contrast: float) -> Specks:
    """Borders of at most ``SPECK_AREA`` pixels that noise could have made.

    None if noise cannot cross the level: a single pixel is an obstacle (P).
    """
    if noise <= 0.0 or 0.5 * contrast >= SIGMAS * noise:
        return Specks(frozenset(), ())
    small = np.flatnonzero(np.abs(borders.area) <= SPECK_AREA)
    if len(small) == 0:
        return Specks(frozenset(), ())
    remark = (
        f"{len(small)} {'speck' if len(small) == 1 else 'specks'} of up to {SPECK_AREA} pixels "
        f"left out as noise (standard deviation {noise:.0f} of {contrast:.0f} grey levels)"
    )
    return Specks(frozenset(small.tolist()), (remark,))


def build_objects(
    borders: Contours,
    fitted: FittedBorders,
    placement: Placement,
    skip: frozenset[int] = frozenset(),
) -> tuple[SceneObject, ...]:
    """Objects of the scene in the order of their first pixel."""
    bounds = placement.bounds
    limits = (bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max)
    ends, bent, stray, thin = look_at_borders(
        fitted.kind, fitted.data, fitted.edge_starts, limits, borders.area, borders.starts
    )
    strays, may_be_thin = stray.tolist(), thin.tolist()
    outlines = _Outlines.of(fitted, ends, bent, placement)
    border_kind = fitted.border_kind.tolist()
    starts = fitted.edge_starts.tolist()
    # in metres the picture's edge is not the bounds' edge
    in_pixels = placement.calibration is None
    outline: dict[int, Record] = {}
    holes: dict[int, list[tuple[Record, ...]]] = {}
    for b, owner in enumerate(borders.owner.tolist()):
        if b in skip:
            continue
        record: Record
        if border_kind[b] == TINY_BORDER:
            record = tiny_record(borders, b, placement)
        elif may_be_thin[b] and (straight := thin_record(borders, b, placement)) is not None:
            record = straight
        elif border_kind[b] == WHOLE_CIRCLE:
            circle = outlines.circle(starts[b])
            record = clip_circle(circle, limits) if in_pixels else circle
        else:
            polygon = outlines.polygon(starts[b], starts[b + 1])
            record = clip_polygon(polygon, limits) if in_pixels and strays[b] else polygon
        if owner == b:
            outline[b] = record
        else:
            holes.setdefault(owner, []).append((record,))
    return tuple(
        [
            new_object(number, (record,), tuple(holes[b]) if b in holes else ())
            for number, (b, record) in enumerate(outline.items())
        ]
    )


@dataclass(frozen=True, slots=True)
class _Outlines:
    """Fitted edges in the scene's coordinates.

    ``edges`` (k,): each from its first point to the next edge's; ``data`` (k, 6) as in
    ``FittedBorders``; ``rms`` (k,).
    """

    edges: list[Edge]
    data: NDArray[np.float64]
    rms: list[float]

    @classmethod
    def of(
        cls,
        fitted: FittedBorders,
        next_edges: NDArray[np.int64],
        bent: NDArray[np.int64],
        placement: Placement,
    ) -> _Outlines:
        data = fitted.data
        if placement.calibration is not None:
            x, y = placement.scale, placement.y_scale
            data = data * np.array([x, y, x, y, x, 1.0])
        corners: list[Vec] = list(zip(data[:, 0].tolist(), data[:, 1].tolist(), strict=True))
        ends = [corners[e] for e in next_edges.tolist()]
        edges: list[Edge] = [*new_segments(corners, ends)]
        which = bent.tolist()
        center_xs, center_ys, radii = data[bent, 2:5].T.tolist()
        arcs = new_arcs(
            [corners[e] for e in which],
            [ends[e] for e in which],
            list(zip(center_xs, center_ys, strict=True)),
            radii,
            (fitted.kind[bent] == ARC_CCW).tolist(),
        )
        for e, arc in zip(which, arcs, strict=True):
            edges[e] = arc
        return cls(edges, data, data[:, 5].tolist())

    def circle(self, edge: int) -> CircleRecord:
        """Record of a circle's only edge."""
        cx, cy, r, rms = self.data[edge, 2:].tolist()
        return CircleRecord((cx, cy), r, rms)

    def polygon(self, first: int, last: int) -> PolygonRecord:
        """Record of edges first .. last - 1."""
        return new_polygon(tuple(self.edges[first:last]), self.rms[first])


def tiny_record(borders: Contours, border: int, placement: Placement) -> Record:
    """P, S, or the pixels' outline as L, for an object too small for a fit."""
    thin = thin_record(borders, border, placement)
    if thin is not None:
        return thin
    corners = _placed(pixel_outline(*borders.cracks_of(border)), placement)
    edges = tuple(Segment(corners[i], corners[(i + 1) % len(corners)]) for i in range(len(corners)))
    return PolygonRecord(edges)


def thin_record(
    borders: Contours, border: int, placement: Placement
) -> PointRecord | SegmentRecord | ArcRecord | None:
    """P, S or A if an object is one pixel, or one line one pixel wide."""
    xs, ys, _ = borders.cracks_of(border)
    pixels = list(dict.fromkeys(zip(xs.tolist(), ys.tolist(), strict=True)))
    if borders.owner[border] != border or borders.area[border] != len(pixels):
        return None
    if len(pixels) == 1:
        return PointRecord(_placed(pixels, placement)[0])
    line = straight_line(pixels)
    if line is None:
        chain = open_chain(pixels)
        return None if chain is None else _curved_line(chain, placement)
    start, end = _placed([line.start, line.end], placement)
    return SegmentRecord(start, end, line.residual_px)


def _curved_line(chain: list[tuple[int, int]], placement: Placement) -> ArcRecord:
    edges, residual_px = chain_edges(placement.rectified(np.array(chain, dtype=np.float64)))
    sx, sy = placement.scale, placement.y_scale
    placed: list[Edge] = []
    for edge in edges:
        start, end = (edge.start[0] * sx, edge.start[1] * sy), (edge.end[0] * sx, edge.end[1] * sy)
        if isinstance(edge, Arc):
            center = (edge.center[0] * sx, edge.center[1] * sy)
            placed.append(Arc(start, end, center, edge.radius * sx, edge.ccw))
        else:
            placed.append(Segment(start, end))
    return ArcRecord(tuple(placed), residual_px)


def _placed(points: Sequence[tuple[float, float]], placement: Placement) -> list[Vec]:
    there = placement.rectified(np.array(points, dtype=np.float64))
    there = there * np.array([placement.scale, placement.y_scale])
    return [(x, y) for x, y in there.tolist()]


def straight_line(pixels: list[tuple[int, int]]) -> SegmentRecord | None:
    """Segment along pixels that form one straight digital line, one pixel wide, or None."""
    points = np.array(pixels, dtype=np.float64)
    low, high = points.min(axis=0), points.max(axis=0)
    if len(pixels) != int((high - low).max()) + 1:
        return None
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    along = (points - middle) @ axes[0]
    across = (points - middle) @ np.array([-axes[0, 1], axes[0, 0]])
    if float(np.abs(across).max()) > 0.5:
        return None
    a = middle + along.min() * axes[0]
    b = middle + along.max() * axes[0]
    start, end = sorted([(float(a[0]), float(a[1])), (float(b[0]), float(b[1]))])
    return SegmentRecord(start, end, float(np.sqrt((across**2).mean())))


def pixel_outline(
    xs: NDArray[Any], ys: NDArray[Any], directions: NDArray[Any]
) -> list[tuple[float, float]]:
    """Corners of a sequence of cracks."""
    corners = []
    for i in range(len(xs)):
        if directions[i] != directions[i - 1]:
            d = int(directions[i])
            corners.append(
                (
                    float(xs[i]) + (0.5 if d in (1, 2) else -0.5),
                    float(ys[i]) + (0.5 if d in (2, 3) else -0.5),
                )
            )
    return corners

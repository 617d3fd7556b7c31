"""The paper's recipe to the letter, sections 3.1 to 3.3.

Rules and units
- Pixels, centres at integers, y down; vertices are border pixels, so a record runs half a pixel
  inside the edge.
- Border pixels come from the Laplacian; contours run clockwise, 8-connected. Corners are where
  lambda_S exceeds 0.1 with k = 7, at least k apart; the same vertices approximate arcs; a circle
  passes Sauer's test.
- Our addition: a contour with fewer than three corners keeps pixels about k apart as vertices, and
  the smallest are points, segments, or their own pixels.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from planner.scene import (
    CircleRecord,
    PointRecord,
    PolygonRecord,
    Record,
    SceneObject,
    Segment,
    SegmentRecord,
)
from vision.borders.contours import Contours
from vision.paper.circles import digital_circle
from vision.paper.corners import SUPPORT, find_corners
from vision.records.records import straight_line


def paper_objects(borders: Contours) -> tuple[SceneObject, ...]:
    """Objects of all borders by the paper's recipe. O(border pixels)."""
    contours, starts = borders.contours()
    corners = find_corners(contours, starts)
    owners = borders.owner.tolist()
    records = [
        _record(contours[a:b], corners[a:b], clockwise=owner == number)
        for number, (a, b, owner) in enumerate(
            zip(starts[:-1].tolist(), starts[1:].tolist(), owners, strict=True)
        )
    ]
    holes: dict[int, list[tuple[Record, ...]]] = {}
    for b, owner in enumerate(owners):
        if owner != b:
            holes.setdefault(owner, []).append((records[b],))
    outlines = [b for b, owner in enumerate(owners) if owner == b]
    return tuple(
        SceneObject(number, (records[b],), tuple(holes.get(b, ())))
        for number, b in enumerate(outlines)
    )


def _record(contour: NDArray[np.int32], corner: NDArray[np.bool_], *, clockwise: bool) -> Record:
    """P, S, C or L for one closed contour (n, 2), an outline ``clockwise`` on the screen."""
    reach = int(np.ptp(contour, axis=0).max())
    if reach == 0:
        return PointRecord((float(contour[0, 0]), float(contour[0, 1])))
    if len(contour) <= 2 * reach + 2:
        straight = straight_line(list(dict.fromkeys(map(tuple, contour.tolist()))))
        if straight is not None:
            return straight
    circle = digital_circle(contour)
    if circle is not None:
        return CircleRecord(circle.center, circle.radius)
    chosen = np.flatnonzero(corner)
    if len(chosen) < 3:
        count = max(min(3, len(contour)), round(len(contour) / SUPPORT))
        chosen = np.unique(np.arange(count) * len(contour) // count)
    vertices = contour[chosen].astype(np.float64)
    points = [(float(x), float(y)) for x, y in vertices]
    # where it is one pixel wide the contour passes a pixel twice
    points = [here for i, here in enumerate(points) if here != points[i - 1]]
    if len(points) < 2:
        return PointRecord((float(vertices[0, 0]), float(vertices[0, 1])))
    if len(points) == 2:
        return SegmentRecord(points[0], points[1])
    turn = sum(
        points[i - 1][0] * points[i][1] - points[i - 1][1] * points[i][0]
        for i in range(len(points))
    )
    if turn < 0.0 if clockwise else turn > 0.0:
        # a ragged speck's few vertices may run the other way round
        points.reverse()
    edges = tuple(Segment(points[i], points[(i + 1) % len(points)]) for i in range(len(points)))
    return PolygonRecord(edges, _rms_distance(contour, chosen))


def _rms_distance(contour: NDArray[np.int32], chosen: NDArray[np.int64]) -> float:
    n = len(contour)
    points = contour.astype(np.float64)
    side = np.searchsorted(chosen, np.arange(n), side="right") - 1
    a = points[chosen[side]]
    b = points[chosen[(side + 1) % len(chosen)]]
    along = b - a
    length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-12)
    across = (points - a)[:, 0] * along[:, 1] - (points - a)[:, 1] * along[:, 0]
    return math.sqrt(float(np.mean((across / length) ** 2)))

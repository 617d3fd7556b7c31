"""Pictures of scenes with known truth: anti-aliased, blurred, noisy, unevenly lit.

Rules and units
- Scenes in pixels, pixel centres at integers, y down. A pixel's value is the share of its
  area that is obstacle: exact along x, averaged over ``LINES`` lines along y.
- Then blur (a Gaussian), then light (a factor per pixel), then noise, then rounding to 8 bits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Arc, CircleRecord, Edge, PolygonRecord, Scene, Segment, record_edges

LINES = 16
SAG_PX = 0.001
"""How far the polyline that stands for an arc may leave it."""

Points = NDArray[np.float64]


def polygon(vertices: Iterable[Sequence[float]]) -> PolygonRecord:
    """A polygon's record from its vertices, in their order."""
    v = [(float(x), float(y)) for x, y in vertices]
    return PolygonRecord(tuple(Segment(v[i], v[(i + 1) % len(v)]) for i in range(len(v))))


def rounded(vertices: Points, radius: float) -> PolygonRecord:
    """A disc swept over a convex polygon that runs clockwise on the screen (or a segment)."""
    edges: list[Edge] = []
    n = len(vertices)
    turns = []
    for i in range(n):
        along = vertices[(i + 1) % n] - vertices[i]
        normal = np.array([along[1], -along[0]]) / math.hypot(*along)
        turns.append(normal * radius)
    for i in range(n):
        a = tuple((vertices[i] + turns[i - 1]).tolist())
        b = tuple((vertices[i] + turns[i]).tolist())
        c = tuple((vertices[(i + 1) % n] + turns[i]).tolist())
        edges += [Arc(a, b, tuple(vertices[i].tolist()), radius, ccw=False), Segment(b, c)]
    return PolygonRecord(tuple(edges))


def cut_disc(center: Points, radius: float, angle: float, half: float) -> PolygonRecord:
    """A disc without what lies beyond the chord at ``angle`` +- ``half`` radians."""
    ends = [
        (center[0] + radius * math.cos(angle + s), center[1] + radius * math.sin(angle + s))
        for s in (half, -half)
    ]
    arc = Arc(ends[0], ends[1], (float(center[0]), float(center[1])), radius, ccw=False)
    return PolygonRecord((arc, Segment(ends[1], ends[0])))


def outline_points(record: PolygonRecord | CircleRecord, sag: float = SAG_PX) -> Points:
    """A closed polyline along a record, (n, 2), within ``sag`` of it; y down."""
    points: list[tuple[float, float]] = []
    for edge in record_edges(record):
        points.append(edge.start)
        if isinstance(edge, Arc):
            begin, sweep = edge.sweep(y_down=True)
            step = 2.0 * math.acos(1.0 - min(sag / edge.radius, 0.5))
            count = max(2, math.ceil(abs(sweep) / step))
            (x, y), r = edge.center, edge.radius
            angles = [begin + sweep * i / count for i in range(1, count)]
            points += [(x + r * math.cos(a), y + r * math.sin(a)) for a in angles]
    return np.array(points)


def coverage(outlines: Sequence[Points], size: tuple[int, int], lines: int = LINES) -> Points:
    """The share of each pixel (h, w) that lies inside the outlines, even-odd."""
    width, height = size
    total = np.zeros((height, width))
    if not outlines:
        return total
    every = np.concatenate(outlines)
    top = max(0, math.floor(every[:, 1].min() + 0.5))
    bottom = min(height, math.ceil(every[:, 1].max() + 0.5) + 1)
    left = max(0, math.floor(every[:, 0].min() + 0.5))
    right = min(width, math.ceil(every[:, 0].max() + 0.5) + 1)
    if top >= bottom or left >= right:
        return total
    ys = top - 0.5 + (np.arange((bottom - top) * lines) + 0.5) / lines
    edges = np.concatenate([np.concatenate([o, np.roll(o, -1, axis=0)], axis=1) for o in outlines])
    rows, xs = _crossings(edges, ys)
    order = np.lexsort((xs, rows))
    rows, xs = rows[order], xs[order]
    first = np.searchsorted(rows, rows)
    sign = np.where((np.arange(len(rows)) - first) % 2 == 0, -1.0, 1.0)
    # what lies left of a crossing: all of some pixels, and a share of one
    high, wide = bottom - top, right - left
    along = np.clip(xs - (left - 0.5), 0.0, wide)
    whole = np.floor(along).astype(np.int64)
    cell, shape = rows // lines * (wide + 1) + whole, (high, wide + 1)
    share = np.bincount(cell, sign * (along - whole), high * (wide + 1)).reshape(shape)
    steps = np.bincount(cell, sign, high * (wide + 1)).reshape(shape)
    filled = np.cumsum(steps[:, :0:-1], axis=1)[:, ::-1]
    out = (filled + share[:, :-1]) / lines
    total[top:bottom, left:right] = out
    return total


def centers_inside(outlines: Sequence[Points], size: tuple[int, int]) -> NDArray[np.bool_]:
    """The pixels (h, w) whose centres lie inside the outlines, even-odd."""
    width, height = size
    passed = np.zeros((height, width + 1), np.int64)
    for o in outlines:
        edges = np.concatenate([o, np.roll(o, -1, axis=0)], axis=1)
        rows, xs = _crossings(edges, np.arange(height, dtype=float))
        # the first centre to the right of each crossing
        np.add.at(passed, (rows, np.clip(np.floor(xs) + 1.0, 0, width).astype(np.int64)), 1)
    return np.cumsum(passed, axis=1)[:, :width] % 2 == 1


def _crossings(edges: Points, ys: Points) -> tuple[NDArray[np.int64], Points]:
    low = np.minimum(edges[:, 1], edges[:, 3])
    high = np.maximum(edges[:, 1], edges[:, 3])
    first = np.searchsorted(ys, low, side="left")
    last = np.searchsorted(ys, high, side="left")
    counts = last - first
    which = np.repeat(np.arange(len(edges)), counts)
    offsets = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    rows = first[which] + offsets
    e = edges[which]
    t = (ys[rows] - e[:, 1]) / (e[:, 3] - e[:, 1])
    return rows, e[:, 0] + t * (e[:, 2] - e[:, 0])


def scene_coverage(scene: Scene, size: tuple[int, int], lines: int = LINES) -> Points:
    """The share of each pixel (h, w) that the scene's L and C records cover."""
    total = np.zeros((size[1], size[0]))
    for obj in scene.objects:
        outlines = [
            outline_points(r)
            for r in (*obj.records, *(r for hole in obj.holes for r in hole))
            if isinstance(r, PolygonRecord | CircleRecord)
        ]
        np.maximum(total, coverage(outlines, size, lines), out=total)
    return total


def draw(
    records: Iterable[PolygonRecord | CircleRecord],
    size: tuple[int, int],
    *,
    dark: float = 40.0,
    light: float = 215.0,
    blur: float = 0.7,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
    lit: Points | None = None,
) -> NDArray[np.uint8]:
    """A picture (h, w) uint8 of dark objects; ``lit`` is the light's factor per pixel."""
    share = np.zeros((size[1], size[0]))
    for record in records:
        np.maximum(share, coverage([outline_points(record)], size), out=share)
    grey = light + (dark - light) * share
    if blur > 0.0:
        grey = cv2.GaussianBlur(grey, (0, 0), blur, borderType=cv2.BORDER_REPLICATE)
    if lit is not None:
        grey = grey * lit
    if noise > 0.0:
        if rng is None:
            raise ValueError("noise needs a generator")
        grey = grey + rng.normal(0.0, noise, grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def ramp(size: tuple[int, int], fall: float, angle: float = 0.0) -> Points:
    """Light that falls linearly by the share ``fall`` across the picture, (h, w)."""
    width, height = size
    y, x = np.mgrid[0:height, 0:width]
    along = x * math.cos(angle) + y * math.sin(angle)
    along = (along - along.min()) / max(float(np.ptp(along)), 1.0)
    return np.asarray(1.0 - fall * along)

"""The promise that records drawn again cover a drawing: outlines that do not are mended.

Rules and units
- For pictures without grey and without a calibration, where every pixel is known for certain.
  Pixels, centres at integers, y down.
- A large object may get wrong ``WRONG_SHARE`` of its pixels, and none by more than a pixel.
- Mending goes from the least to the most: corners are moved a little; edges that get pixels
  wrong become chords through the middles of their cracks; at last the border is its pixels' own
  outline, which is never wrong. What was taken for a circle stays one while no pixel is far off.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vision.contours import Borders
from vision.raster_kernels import audit, find_misfits
from vision.structure import CIRCLE, LINE, POLYGON, TINY, FittedBorders

WRONG_SHARE, FROM_AREA = 0.0047, 400
"""Of an object's pixels, from so many on: 0.995 of an intersection over union is promised."""
CHORDS_PX = 0.3, 0.15
"""How far chords may leave the cracks' middles: less than the 0.354 px by which the shortest way
between two middles passes a pixel's centre; the second leaves a lone pixel half of its row."""
NEAR_PX = 8.0
"""A corner is moved for wrong pixels so near to it."""
STEPS_PX = 0.15, 0.4
"""How far it is moved at a time."""
AROUND = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (0.7, 0.7), (-0.7, 0.7), (0.7, -0.7),
                   (-0.7, -0.7)])  # fmt: skip

FloatArray = NDArray[np.float64]
OUT_X, OUT_Y = np.array([0.0, 0.5, 0.0, -0.5]), np.array([-0.5, 0.0, 0.5, 0.0])
"""From a crack's pixel to the crack's middle, by the walk's direction."""
STEP_X, STEP_Y = np.array([0, 1, 0, -1]), np.array([-1, 0, 1, 0])
"""From a crack's pixel to the free one."""
LOOK = 256
"""Cracks that tell most pictures with grey."""


@dataclass(slots=True)
class _Outline:
    """One border's edges, as rows of ``FittedBorders``."""

    kind: NDArray[np.int8]
    data: FloatArray
    circle: bool

    def misfits(self, borders: Borders, b: int) -> NDArray[np.int64]:
        """Rows x, y, whether the border has the pixel, whether it is far off."""
        begin, end = int(borders.starts[b]), int(borders.starts[b + 1])
        found: NDArray[np.int64] = find_misfits(
            self.kind, self.data, 0, len(self.kind), self.circle, borders.x, borders.y,
            borders.direction, begin, end,
        )  # fmt: skip
        return found


def is_drawing(grey: NDArray[Any], borders: Borders) -> bool:
    """Whether every border runs between the same two values of grey. O(1) for most others."""
    height, width = grey.shape
    for part in (slice(LOOK), slice(LOOK, None)):
        x, y, direction = borders.x[part], borders.y[part], borders.direction[part]
        free_x, free_y = x + STEP_X[direction], y + STEP_Y[direction]
        there = (free_x >= 0) & (free_y >= 0) & (free_x < width) & (free_y < height)
        for values in (grey[y, x], grey[free_y[there], free_x[there]]):
            if len(values) and (values != values[0]).any():
                return False
    return True


def keep_cover(borders: Borders, fitted: FittedBorders) -> FittedBorders:
    """The same borders, those mended that would not cover their pixels. O(border)."""
    wrong = audit(
        fitted.border_kind, fitted.edge_starts, fitted.kind, fitted.data, borders.x, borders.y,
        borders.direction, borders.starts,
    )  # fmt: skip
    area = np.bincount(borders.owner, borders.area, len(borders.owner))
    total = np.bincount(borders.owner, wrong[:, 0], len(borders.owner))
    allowed = np.where(area >= FROM_AREA, WRONG_SHARE * area, np.inf)
    mended: dict[int, _Outline | None] = {}
    for b in np.argsort(-wrong[:, 0], kind="stable").tolist():
        owner = borders.owner[b]
        near = wrong[b, 1] == 0
        if near and (total[owner] <= allowed[owner] or fitted.border_kind[b] == CIRCLE):
            continue
        if wrong[b, 0] == 0:
            break
        spare = max(allowed[owner] - (total[owner] - wrong[b, 0]), 0.0)
        mended[b], left = _mend(borders, b, _outline(fitted, b), spare)
        total[owner] += left - wrong[b, 0]
    return _with(fitted, mended) if mended else fitted


def _outline(fitted: FittedBorders, b: int) -> _Outline:
    part = slice(int(fitted.edge_starts[b]), int(fitted.edge_starts[b + 1]))
    return _Outline(fitted.kind[part], fitted.data[part], fitted.border_kind[b] == CIRCLE)


def _mend(borders: Borders, b: int, outline: _Outline, spare: float) -> tuple[_Outline | None, int]:
    """An outline that gets at most ``spare`` pixels wrong, and how many; None: its pixels' own."""
    if not outline.circle:
        outline = _with_corners_moved(borders, b, outline, spare)
        found = outline.misfits(borders, b)
        if _good(found, spare):
            return outline, len(found)
    xs, ys, directions = borders.cracks_of(b)
    middles = np.stack([xs + OUT_X[directions], ys + OUT_Y[directions]], axis=1)
    for away_px in CHORDS_PX:
        if not outline.circle and len(outline.kind) > 1:
            tried, left = _chords_where_wrong(borders, b, outline, middles, away_px, spare)
            if tried is not None:
                return tried, left
        tried = _polygon(middles[_closed_chords(middles, away_px)])
        found = tried.misfits(borders, b)
        if len(tried.kind) >= 3 and _good(found, spare):
            return tried, len(found)
    return None, 0


def _good(found: NDArray[np.int64], spare: float) -> bool:
    return len(found) <= spare and not found[:, 3].any()


def _with_corners_moved(borders: Borders, b: int, outline: _Outline, spare: float) -> _Outline:
    """Move corners between lines, a little at a time, where that gets fewer pixels wrong."""
    found = outline.misfits(borders, b)
    lines = (outline.kind == LINE) & (np.roll(outline.kind, 1) == LINE)
    for step_px in STEPS_PX:
        away = np.hypot(*(outline.data[:, None, :2] - found[:, :2]).transpose(2, 0, 1))
        near = away.min(axis=1, initial=np.inf) <= NEAR_PX
        for e in np.flatnonzero(lines & near).tolist():
            for toward in AROUND:
                if _good(found, spare):
                    return outline
                moved = _Outline(outline.kind, outline.data.copy(), circle=False)
                moved.data[e, :2] += step_px * toward
                left = moved.misfits(borders, b)
                if _worth(left) < _worth(found):
                    outline, found = moved, left
    return outline


def _worth(found: NDArray[np.int64]) -> tuple[int, int]:
    return int(found[:, 3].sum()), len(found)


def _chords_where_wrong(
    borders: Borders, b: int, outline: _Outline, middles: FloatArray, away_px: float, spare: float
) -> tuple[_Outline | None, int]:
    """Chords instead of the edges that get pixels wrong, more and more of them."""
    edges = len(outline.kind)
    at = _places(outline.data[:, :2], middles)
    bad = np.zeros(edges, dtype=np.bool_)
    tried = outline
    for _ in range(edges):
        found = tried.misfits(borders, b)
        if _good(found, spare):
            return tried, len(found)
        more = bad.copy()
        for x, y in found[:, :2].tolist():
            crack = int(np.square(middles - (x, y)).sum(axis=1).argmin())
            more[_edge_at(at, crack, len(middles))] = True
        if (more == bad).all():
            more |= np.roll(bad, 1) | np.roll(bad, -1)
        bad = more
        if bad.all():
            break
        tried = _replaced(outline, bad, at, middles, away_px)
    return None, 0


def _places(joints: FloatArray, middles: FloatArray) -> list[int]:
    """Where along the cracks every joint lies; from the first on they only go forward."""
    n = len(middles)
    first = int(np.square(middles - joints[0]).sum(axis=1).argmin())
    places = [first]
    for joint in joints[1:]:
        rest = np.arange(places[-1], first + n) % n
        ahead = int(np.square(middles[rest] - joint).sum(axis=1).argmin())
        places.append(places[-1] + ahead)
    return places


def _edge_at(places: list[int], crack: int, n: int) -> int:
    ahead = places[0] + (crack - places[0]) % n
    return int(np.searchsorted(places, ahead, side="right")) - 1


def _replaced(
    outline: _Outline, bad: NDArray[np.bool_], at: list[int], middles: FloatArray, away_px: float
) -> _Outline:
    kinds: list[int] = []
    rows: list[FloatArray] = []
    n = len(middles)
    for e, is_bad in enumerate(bad.tolist()):
        row = outline.data[e].copy()
        if not is_bad:
            kinds.append(int(outline.kind[e]))
            rows.append(row)
            continue
        end = at[e + 1] if e + 1 < len(at) else at[0] + n
        way = middles[np.arange(at[e], end + 1) % n]
        if not bad[e - 1]:
            way[0] = row[:2]
        if not bad[(e + 1) % len(bad)]:
            way[-1] = outline.data[(e + 1) % len(bad), :2]
        for i in _chords(way, away_px)[:-1]:
            kinds.append(LINE)
            rows.append(np.array([*way[i], 0.0, 0.0, 0.0, 0.5 * away_px]))
    return _Outline(np.array(kinds, dtype=np.int8), np.array(rows), circle=False)


def _polygon(vertices: FloatArray) -> _Outline:
    data = np.zeros((len(vertices), 6))
    data[:, :2] = vertices
    data[:, 5] = 0.5 * CHORDS_PX[-1]
    return _Outline(np.full(len(vertices), LINE, dtype=np.int8), data, circle=False)


def _closed_chords(points: FloatArray, away_px: float) -> list[int]:
    """Vertices of a closed polygon that stays within ``away_px`` of every point."""
    first = int(np.square(points - points.mean(axis=0)).sum(axis=1).argmax())
    around = np.roll(points, -first, axis=0)
    other = int(np.square(around - around[0]).sum(axis=1).argmax())
    there = _chords(around[: other + 1], away_px)
    back = _chords(np.concatenate([around[other:], around[:1]]), away_px)
    kept = there[:-1] + [other + i for i in back[:-1]]
    return [(first + i) % len(points) for i in kept]


def _chords(points: FloatArray, away_px: float) -> list[int]:
    """Points at which a polyline from first to last stays within ``away_px`` of all others.

    Ramer's and Douglas and Peucker's method, with distances from the chord, not from its line.
    """
    kept = {0, len(points) - 1}
    stack = [(0, len(points) - 1)]
    while stack:
        a, b = stack.pop()
        if b - a < 2:
            continue
        along = points[b] - points[a]
        off = points[a + 1 : b] - points[a]
        share = np.clip(off @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        far = np.square(off - share[:, None] * along).sum(axis=1)
        where = int(far.argmax())
        if far[where] > away_px * away_px:
            kept.add(a + 1 + where)
            stack += [(a, a + 1 + where), (a + 1 + where, b)]
    return sorted(kept)


def _with(fitted: FittedBorders, mended: dict[int, _Outline | None]) -> FittedBorders:
    """The fitted borders with the mended ones in their places."""
    border_kind = fitted.border_kind.copy()
    kinds: list[NDArray[np.int8]] = []
    rows: list[FloatArray] = []
    starts = [0]
    for b in range(len(border_kind)):
        part = slice(int(fitted.edge_starts[b]), int(fitted.edge_starts[b + 1]))
        kind, data = fitted.kind[part], fitted.data[part]
        if b in mended:
            outline = mended[b]
            border_kind[b] = TINY if outline is None else POLYGON
            kind = kind[:0] if outline is None else outline.kind
            data = data[:0] if outline is None else outline.data
        kinds.append(kind)
        rows.append(data)
        starts.append(starts[-1] + len(kind))
    return FittedBorders(
        border_kind, np.array(starts, dtype=np.int64), np.concatenate(kinds), np.concatenate(rows)
    )

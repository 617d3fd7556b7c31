"""Outlines in which texture is left out: fewer edges, by growing obstacles a stated amount.

Rules and units
- Texture is what of a border lies within a tolerance of its outline, in the picture's own pixels.
- An outline without texture encloses all points of its border, which in a drawing are the middles
  of its cracks, so that no pixel is lost: an obstacle grows by at most the
  tolerance and never shrinks, so that whatever keeps clear of the outline keeps clear of the
  obstacle. Between two obstacles each grows by less than half the way.
- Where that needs no fewer edges than the outline as it is, the outline stays: smooth obstacles
  are exact with any tolerance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.outline.fitted_borders import CIRCLE, LINE, POLYGON, TINY, FittedBorders
from vision.outline.texture_kernels import (
    SHARE_OF_GAP,
    Corners,
    Ring,
    gaps_between,
    grow_to_lines,
)

MOST_TEXTURE_PX = 5.0
"""The largest tolerance: derived, a part of a picture that is looked at again keeps 6 px from the
objects that stay (``vision.watch.refit``)."""
MOST_POINTS = 20_000
"""Points of the longest border that is looked at: a bound on the work, indifferent. One of them
takes a second at the worst."""
LEAST_REACH = 1e-6
"""Pixels: derived, borders that touch leave each other nothing, and nothing cannot be divided
by."""
TOUCHING_PX = 1e-4
"""A point so near to its outline lies on it: indifferent, above rounding and below what is seen."""
_CENTRE_STEPS = 60
"""Steps towards the centre that is as far from the nearest point as from the farthest: indifferent,
the last one moves it by a sixtieth of the difference."""

FloatArray = NDArray[np.float64]


class _Simple(NamedTuple):
    """One border without texture: ``rows`` (k, 6) as in ``FittedBorders``, and what it cost."""

    border_kind: int
    rows: FloatArray
    growth_px: float


def without_texture(
    fitted: FittedBorders,
    points: FloatArray,
    starts: NDArray[np.int64],
    owner: NDArray[np.int64],
    stretches: FloatArray,
    texture_px: float,
) -> tuple[FittedBorders, tuple[str, ...]]:
    """``fitted`` with simpler outlines where these take fewer edges, and the remark that says so.

    ``points`` (n, 2), ``starts`` (b + 1,): the borders' points in rectified pixels; ``owner`` (b,):
    the outline of each border's object; ``stretches`` (b,): what ``fitted`` is smaller by, as the
    border in the picture. O(points) for smooth borders.
    """
    reach = _reach(points, starts, owner, texture_px * stretches)
    edges = np.diff(fitted.edge_starts)
    found: dict[int, _Simple] = {}
    too_long = 0
    for b in np.flatnonzero((edges > 1) & (fitted.border_kind != TINY)).tolist():
        part = slice(int(starts[b]), int(starts[b + 1]))
        if part.stop - part.start > MOST_POINTS:
            too_long += 1
            continue
        size = float(stretches[b])
        simple = _simplest(points[part] / size, reach[part] / size, is_hole=owner[b] != b)
        if simple is not None and len(simple.rows) < edges[b]:
            found[b] = simple
    before = sum(int(edges[b]) for b in found)
    remarks = _remarks(list(found.values()), before, too_long, texture_px)
    return (_put_in(fitted, found) if found else fitted), remarks


def _reach(
    points: FloatArray,
    starts: NDArray[np.int64],
    owner: NDArray[np.int64],
    tolerance: FloatArray,
) -> FloatArray:
    """How far the outline may be from each point: the tolerance, less where others are near."""
    counts = np.diff(starts)
    whose = np.repeat(owner, counts)
    limit = np.repeat(tolerance, counts)
    if len(points) == 0:
        return limit
    cell = float(tolerance.max()) / SHARE_OF_GAP
    columns_rows = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    columns, rows = (columns_rows.max(axis=0) + 1).tolist()
    cells = columns_rows[:, 1] * columns + columns_rows[:, 0]
    cell_starts = np.zeros(rows * columns + 1, np.int64)
    np.cumsum(np.bincount(cells, minlength=rows * columns), out=cell_starts[1:])
    gap = limit / SHARE_OF_GAP
    x, y = np.ascontiguousarray(points[:, 0]), np.ascontiguousarray(points[:, 1])
    order = np.argsort(cells, kind="stable")
    gaps_between(x, y, whose, order, cell_starts, columns, cell, gap)
    reach: FloatArray = np.maximum(SHARE_OF_GAP * gap, LEAST_REACH)
    return reach


def _simplest(points: FloatArray, reach: FloatArray, is_hole: bool) -> _Simple | None:
    """A circle if one will do, else lines; None where there are none."""
    circle = _circle_around(points, reach, is_hole)
    if circle is not None:
        return circle
    n = len(points)
    ring = Ring(np.ascontiguousarray(points[:, 0]), np.ascontiguousarray(points[:, 1]), reach)
    point, before, after = np.empty((3, n), np.int64)
    corners = Corners(np.empty(n), np.empty(n), point, before, after)
    left, here = grow_to_lines(ring, corners)
    if left < 3 or left == n:
        return None
    order = np.empty(left, np.int64)
    for i in range(left):
        order[i] = here
        here = int(corners.after[here])
    rows = np.zeros((left, 6))
    rows[:, 0], rows[:, 1] = corners.x[order], corners.y[order]
    if not _encloses(rows[:, :2], points, is_hole):
        return None
    depths = _depths(points, rows[:, :2], corners.point[order])
    rows[:, 5] = np.sqrt((depths**2).mean())
    tips = np.hypot(*(rows[:, :2] - points[corners.point[order]]).T)
    return _Simple(POLYGON, rows, float(max(depths.max(), tips.max())))


def _encloses(rim: FloatArray, points: FloatArray, is_hole: bool) -> bool:
    """Whether all points are on the obstacle's side of the rim.

    Noise may cross a border with itself, and no step knows its sides then.
    """
    x, y = points[:, 0], points[:, 1]
    inside = np.zeros(len(points), np.bool_)
    ends = np.roll(rim, -1, axis=0)
    for (ax, ay), (bx, by) in zip(rim.tolist(), ends.tolist(), strict=True):
        if ay != by:
            inside ^= ((ay > y) != (by > y)) & (x < ax + (bx - ax) * (y - ay) / (by - ay))
    along = ends - rim
    long = np.maximum((along**2).sum(axis=1), LEAST_REACH**2)
    for point in points[inside if is_hole else ~inside]:
        off = point - rim
        share = np.clip((off * along).sum(axis=1) / long, 0.0, 1.0)
        if np.hypot(*(off - share[:, None] * along).T).min() > TOUCHING_PX:
            return False
    return True


def _depths(points: FloatArray, corners: FloatArray, at: NDArray[np.int64]) -> FloatArray:
    """How deep every point (n,) is behind the line that took its place."""
    n = len(points)
    lengths = (np.roll(at, -1) - at) % n
    which = (at[0] + np.arange(n)) % n
    line = np.repeat(np.arange(len(at)), lengths)
    begin, end = corners[line], np.roll(corners, -1, axis=0)[line]
    along, off = end - begin, points[which] - begin
    depths: FloatArray = np.abs(along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0])
    return depths / np.hypot(along[:, 0], along[:, 1])


def _circle_around(points: FloatArray, reach: FloatArray, is_hole: bool) -> _Simple | None:
    """The circle that leaves all points on the obstacle's side, none deeper than its reach."""
    middle = points.mean(axis=0)
    off = points - middle
    equations = np.column_stack([off, np.ones(len(off))])
    solved, _, rank, _ = np.linalg.lstsq(equations, (off**2).sum(axis=1), rcond=None)
    if rank < 3:
        return None
    centre = middle + 0.5 * solved[:2]
    best_centre, best_depth = centre, np.inf
    for step in range(1, _CENTRE_STEPS + 1):
        away = points - centre
        distance = np.hypot(away[:, 0], away[:, 1])
        far, near = int(distance.argmax()), int(distance.argmin())
        if distance[near] <= 0.0:
            return None
        if distance[far] - distance[near] < best_depth:
            best_centre, best_depth = centre, float(distance[far] - distance[near])
        pull = away[far] / distance[far] - away[near] / distance[near]
        centre = centre + pull * (distance[far] - distance[near]) / (2.0 * step)
    distance = np.hypot(*(points - best_centre).T)
    radius = float(distance.min() if is_hole else distance.max())
    depths = np.abs(distance - radius)
    if (depths > reach).any():
        return None
    row = [*points[0], *best_centre, radius, float(np.sqrt((depths**2).mean()))]
    return _Simple(CIRCLE, np.array([row]), float(depths.max()))


def _put_in(fitted: FittedBorders, found: dict[int, _Simple]) -> FittedBorders:
    """``fitted`` with the edges of some borders replaced."""
    border_kind = fitted.border_kind.copy()
    kinds, data, counts = [], [], []
    for b in range(len(border_kind)):
        part = slice(int(fitted.edge_starts[b]), int(fitted.edge_starts[b + 1]))
        kind, rows = fitted.kind[part], fitted.data[part]
        if b in found:
            border_kind[b], rows, _ = found[b]
            kind = np.full(len(rows), LINE, np.int8)
        kinds.append(kind)
        data.append(rows)
        counts.append(len(rows))
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return FittedBorders(border_kind, starts, np.concatenate(kinds), np.concatenate(data))


def _remarks(
    found: list[_Simple], before: int, too_long: int, texture_px: float
) -> tuple[str, ...]:
    """What was made simpler and its price; nothing where nothing was."""
    remarks = []
    if found:
        after = sum(len(simple.rows) for simple in found)
        growth_px = max(simple.growth_px for simple in found)
        which = "1 border has" if len(found) == 1 else f"{len(found)} borders have"
        remarks.append(
            f"texture of up to {texture_px:.3g} px was left out: {which} {after} edges instead of "
            f"{before}; obstacles are up to {growth_px:.2g} px larger there, and nowhere smaller"
        )
    if too_long:
        which = "1 border" if too_long == 1 else f"{too_long} borders"
        remarks.append(f"{which} of more than {MOST_POINTS} points: texture was not looked for")
    return tuple(remarks)

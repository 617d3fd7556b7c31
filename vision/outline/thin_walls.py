"""Thin walls that fitted outlines cut short, and that keep their pixels' outline.

Rules and units
- Pixels, y down. A wall of a few pixels lies within the blur of both its sides: well fitting edges
  may leave out pixels, and a path would lead through.
- Only objects thinner than ``THIN_PX``. In pictures with fine structure (``vision.binarise.humps``)
  all of them; in drawings without grey and noisy pictures only those beside holes narrower than
  ``NARROW_HOLE_PX``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.borders.contours import Contours
from vision.outline.fitted_borders import ARC_CCW, LINE, TINY_BORDER, WHOLE_CIRCLE, FittedBorders

Place: TypeAlias = Callable[[NDArray[np.float64]], NDArray[np.float64]]

THIN_PX = 4.5
"""Least mean width of an object that is no thin wall: chosen, outlines cut pieces off walls of up
to 4 px, and none off those of 6 px (``python -m benchmarks.vision.fine``)."""
NARROW_HOLE_PX = 2.0 * THIN_PX
"""Least mean width of a hole that is no narrow way: chosen, blur and noise widen ways by up to 2 px
(``python -m benchmarks.vision.fine --cells 81``)."""
MOST_LOST = 0.25
"""Largest share of its width that a wall loses on one side: derived, half of it remains."""
MOST_WORK = 20_000_000
"""Most pixels times edges of one border compared: chosen, some 50 ms. Beyond that it keeps its
pixels' outline."""
SAG_PX = 0.02
"""Distance of an arc from its polyline: indifferent."""


def keep_thin_walls(
    fitted: FittedBorders, borders: Contours, place: Place, *, fine: bool
) -> FittedBorders:
    """``fitted``, with the pixels' outline for thin walls that it cuts short.

    ``place`` takes pixels (n, 2) to the edges' coordinates. ``fine``: all thin walls count.
    O(cracks * edges), at most ``MOST_WORK`` a border.
    """
    holes = borders.owner != np.arange(len(borders.owner))
    if not (fine or holes.any()):
        return fitted
    cracks = np.diff(borders.starts)
    # a strip has two cracks for a pixel of length
    area = np.bincount(borders.owner, borders.area, len(cracks))
    length = np.bincount(borders.owner, cracks, len(cracks))
    walls = (2.0 * area / np.maximum(length, 1.0))[borders.owner]
    asked = (walls < THIN_PX) & (fitted.border_kind != TINY_BORDER)
    if not fine:
        asked &= holes & (-2.0 * borders.area < NARROW_HOLE_PX * cracks)
    lost = [
        b
        for b in np.flatnonzero(asked).tolist()
        if _cuts_short(fitted, borders, b, place, 0.5 - MOST_LOST * float(walls[b]))
    ]
    if not lost:
        return fitted
    border_kind = fitted.border_kind.copy()
    border_kind[lost] = TINY_BORDER
    edges = np.diff(fitted.edge_starts)
    kept = np.repeat(border_kind != TINY_BORDER, edges)
    edges[lost] = 0
    starts = np.concatenate([[0], np.cumsum(edges)])
    return FittedBorders(border_kind, starts, fitted.kind[kept], fitted.data[kept])


def _cuts_short(
    fitted: FittedBorders, borders: Contours, b: int, place: Place, least: float
) -> bool:
    """True if border b's outline leaves a pixel less than ``least`` inside, or is too long."""
    rim = _polyline(fitted, b).astype(np.float32)
    xs, ys, _ = borders.cracks_of(b)
    sign = 1.0 if borders.owner[b] == b else -1.0
    pixels = np.unique(np.stack([xs, ys], axis=1), axis=0).astype(np.float64)
    if len(pixels) * len(rim) > MOST_WORK:
        return True
    return any(
        sign * cv2.pointPolygonTest(rim, (x, y), True) < least for x, y in place(pixels).tolist()
    )


def _polyline(fitted: FittedBorders, b: int) -> NDArray[np.float64]:
    """Polyline (n, 2) of border b."""
    first, last = int(fitted.edge_starts[b]), int(fitted.edge_starts[b + 1])
    rows, kinds = fitted.data[first:last], fitted.kind[first:last]
    if fitted.border_kind[b] == WHOLE_CIRCLE:
        return _arc(rows[0, 2:5], 0.0, math.tau)
    points = []
    for i, kind in enumerate(kinds.tolist()):
        points.append(rows[i : i + 1, :2])
        if kind == LINE:
            continue
        ends = np.stack([rows[i, :2], rows[(i + 1) % len(rows), :2]]) - rows[i, 2:4]
        begin, end = np.arctan2(ends[:, 1], ends[:, 0])
        sweep = -((begin - end) % math.tau) if kind == ARC_CCW else (end - begin) % math.tau
        points.append(_arc(rows[i, 2:5], begin, sweep))
    return np.concatenate(points)


def _arc(circle: NDArray[np.float64], begin: float, sweep: float) -> NDArray[np.float64]:
    x, y, radius = circle.tolist()
    step = 2.0 * math.acos(1.0 - min(SAG_PX / radius, 0.5))
    angles = begin + sweep * np.linspace(0.0, 1.0, 2 + math.ceil(abs(sweep) / step))[1:-1]
    return np.stack([x + radius * np.cos(angles), y + radius * np.sin(angles)], axis=1)

"""A judge of extraction that knows the black and white picture and the written records only.

Rules and units
- Pixels, centres at integers, y down. The truth is the mask: its 8-connected regions are the
  objects, in the order of their first pixels, and the 4-connected free regions that an object
  encloses are its holes, in theirs. A border is the set of middles between a pixel of a region
  and one beside it that is not.
- Three measures of a record and its border: how far a point of the outline lies from the border,
  how far a point of the border lies from the outline, and how many pixels well off the border lie
  on the wrong side of the outline. P, S and A have no inside. Pointed corners are measured apart.
- Nothing of the extractor's fits is used. What it leaves out as specks has to be said, and does not
  count.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from planner.scene import Arc, CircleRecord, PointRecord, PolygonRecord, Record, Scene, record_edges
from vision.binarise.binarise import Method, Polarity
from vision.binarise.colour import binarise_by_colour
from vision.binarise.grey_picture import as_array
from vision.shared.array_pool import ArrayPool

FEW_PX = 4.0
"""What an outline and its border may be apart, but for a pointed corner: the light crosses the half
level within 2 px of the border's pixels, and outlines keep within 2 px of these crossings."""
TIP_PX, TIP_BASE_PX, TIP_FROM_PX = 15.0, 3.0, 2.0
"""A camera's blur and a smoothing against noise round pointed corners far back, and the outline has
the corner that the sides make: a tip may be so far from the border, and so wide where it begins, at
``TIP_FROM_PX`` from it. No robot fits into it."""
BLOCK = 4
"""Pixels a side of the squares that tell a side from a tip, which is too narrow for one."""
STEP_PX = 0.25
"""How close to each other an outline's points are looked at."""
MOST_POINTS = 200_000
"""Of one edge: what is longer lies far outside of the picture anyway."""
SPECK_AREA = 4
"""Pixels up to which a region may be left out as a speck, where the scene says so."""

Mask = NDArray[np.bool_]
Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Verdict:
    """One border and its record: ``hole`` is -1 for the outline.

    ``outline_px``: the outline's farthest point from the border, at ``outline_at``, ``tip_px`` the
    same for its pointed corners; ``border_px``: the border's farthest point from the outline;
    ``wrong``: squares of ``BLOCK`` pixels on the wrong side, more than ``FEW_PX`` off the border;
    ``pixels``: those that the border encloses.
    """

    number: int
    hole: int
    record: str
    pixels: int
    outline_px: float
    outline_at: tuple[float, float]
    tip_px: float
    border_px: float
    wrong: int

    def fails(self, limit_px: float = FEW_PX) -> bool:
        """Whether record and border do not stand for each other."""
        return max(self.outline_px, self.border_px) > limit_px or self.wrong > 0


def mask_of(
    image: NDArray[np.uint8],
    polarity: Polarity = "dark",
    method: Method = "auto",
    threshold: float | None = None,
) -> Mask:
    """Which pixels are obstacle (h, w), as the extractor's first stage decides."""
    binary = binarise_by_colour(
        as_array(image),
        polarity=polarity,
        method=method,
        threshold=threshold,
        ignore=None,
        pool=ArrayPool(),
    )
    return binary.inside.astype(bool)


def judge(mask: Mask, scene: Scene) -> list[Verdict]:
    """A verdict on every border of the mask (h, w); ``AssertionError`` where one has no record."""
    regions = [region for region in _regions(mask) if _counts(region.solid, scene)]
    assert len(regions) == len(scene.objects), (
        f"{len(regions)} obstacles in the picture, {len(scene.objects)} in the scene"
    )
    verdicts = []
    for number, (region, obj) in enumerate(zip(regions, scene.objects, strict=True)):
        holes = [hole for hole in region.holes if _counts(hole, scene)]
        assert len(holes) == len(obj.holes), f"object {number}: {len(holes)} holes"
        borders = [(-1, region.solid, obj.records)]
        borders += [(i, h, r) for i, (h, r) in enumerate(zip(holes, obj.holes, strict=True))]
        for hole, enclosed, (record,) in borders:
            verdicts.append(_verdict(number, hole, enclosed, region.corner, record))
    return verdicts


def failures(mask: Mask, scene: Scene, limit_px: float = FEW_PX) -> list[Verdict]:
    """The verdicts on records that do not stand for their borders."""
    return [one for one in judge(mask, scene) if one.fails(limit_px)]


@dataclass(frozen=True, slots=True)
class _Region:
    """An object: ``solid`` (h, w) with its holes filled, ``holes`` (h, w) each.

    They have a margin of one pixel; ``corner`` is the picture's (x, y) of their first pixel.
    """

    solid: Mask
    holes: list[Mask]
    corner: tuple[int, int]


def _regions(mask: Mask) -> Iterator[_Region]:
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    found, first = np.unique(labels, return_index=True)
    for label in found[np.argsort(first)]:
        if label == 0:
            continue
        x, y, w, h, _ = stats[label]
        own = np.zeros((h + 2, w + 2), bool)
        own[1:-1, 1:-1] = labels[y : y + h, x : x + w] == label
        _, free = cv2.connectedComponents((~own).astype(np.uint8), connectivity=4)
        outside = free[0, 0]
        solid = own | (free != outside)
        names, begins = np.unique(free, return_index=True)
        holes = [free == n for n in names[np.argsort(begins)] if n not in (0, outside)]
        yield _Region(solid, holes, (int(x) - 1, int(y) - 1))


def _counts(enclosed: Mask, scene: Scene) -> bool:
    """Whether a region has to have a record: specks need none where the scene says so."""
    said = any("speck" in remark for remark in scene.remarks)
    return not said or np.count_nonzero(enclosed) > SPECK_AREA


def _verdict(
    number: int, hole: int, enclosed: Mask, corner: tuple[int, int], record: Record
) -> Verdict:
    border = border_points(enclosed) + corner
    outline = record_points(record)
    from_border, _ = cKDTree(border).query(outline)
    from_outline, _ = cKDTree(outline).query(border)
    tips = _tips(outline, from_border)
    beside = np.where(tips, 0.0, from_border)
    where = int(np.argmax(beside))
    wrong = 0
    if isinstance(record, PolygonRecord | CircleRecord):
        wrong = _wrong_side(enclosed, outline - corner)
    return Verdict(
        number,
        hole,
        type(record).__name__.removesuffix("Record"),
        int(np.count_nonzero(enclosed)),
        float(beside[where]),
        (float(outline[where, 0]), float(outline[where, 1])),
        float(np.max(from_border, where=tips, initial=0.0)),
        float(from_outline.max()),
        wrong,
    )


def border_points(enclosed: Mask) -> Points:
    """The middles (n, 2) between a region's pixels (h, w) and those beside it."""
    y, x = np.nonzero(enclosed[:, 1:] != enclosed[:, :-1])
    upright = np.stack([x + 0.5, y], axis=1)
    y, x = np.nonzero(enclosed[1:] != enclosed[:-1])
    return np.concatenate([upright, np.stack([x, y + 0.5], axis=1)])


def record_points(record: Record) -> Points:
    """Points (n, 2) along a record, ``STEP_PX`` apart or less."""
    if isinstance(record, PointRecord):
        return np.array([record.at])
    points = []
    for edge in record_edges(record):
        if isinstance(edge, Arc):
            begin, sweep = edge.sweep(y_down=True)
            count = max(2, math.ceil(abs(sweep) * edge.radius / STEP_PX))
            count = min(count, MOST_POINTS)
            angles = begin + sweep * np.linspace(0.0, 1.0, count + 1)
            x = edge.center[0] + edge.radius * np.cos(angles)
            y = edge.center[1] + edge.radius * np.sin(angles)
        else:
            count = max(1, math.ceil(math.dist(edge.start, edge.end) / STEP_PX))
            x = np.linspace(edge.start[0], edge.end[0], count + 1)
            y = np.linspace(edge.start[1], edge.end[1], count + 1)
        points.append(np.stack([x, y], axis=1))
    return np.concatenate(points)


def _tips(outline: Points, away_px: NDArray[np.float64]) -> Mask:
    """Which points (n,) of an outline lie in a pointed corner that was rounded back."""
    off = away_px > TIP_FROM_PX
    tips = np.zeros(len(off), bool)
    if off.all() or not off.any():
        return tips
    # from a point on the border on, so that no run goes past the end
    order = np.roll(np.arange(len(off)), -int(np.argmin(off)))
    begins = np.flatnonzero(np.diff(off[order].astype(np.int8)) == 1) + 1
    ends = np.flatnonzero(np.diff(np.append(off[order], False).astype(np.int8)) == -1)
    for begin, end in zip(begins, ends, strict=True):
        run = order[begin : end + 1]
        base = math.dist(outline[run[0]], outline[run[-1]])
        far = float(away_px[run].max())
        tips[run] = base <= TIP_BASE_PX and FEW_PX < far <= TIP_PX
    return tips


def _wrong_side(enclosed: Mask, outline: Points) -> int:
    """Squares of pixels well off the border of ``enclosed`` (h, w), on an outline's wrong side."""
    margin = math.ceil(FEW_PX) + 2
    truth = np.pad(enclosed, margin)
    drawn = np.zeros(truth.shape, np.uint8)
    sub = 4
    cv2.fillPoly(drawn, [np.rint((outline + margin) * (1 << sub)).astype(np.int32)], 1, shift=sub)
    wrong = 0
    for side in (truth, ~truth):
        away = cv2.distanceTransform(side.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        there = ((away > FEW_PX + 0.5) & ((drawn > 0) != truth)).astype(np.uint8)
        wrong += int(np.count_nonzero(cv2.erode(there, np.ones((BLOCK, BLOCK), np.uint8))))
    return wrong

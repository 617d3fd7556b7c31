"""Distances of a map by a distance transform, with their bounds, and verdicts.

The transform (OpenCV) at a quarter of a cell, side s, gives the distance d between centres of small
cells, so the true distance of a centre to the obstacles lies in d - s/sqrt(2) .. d - s/2; any place
is within s/sqrt(2) of a centre, and a line's least distance within half a step of its samples'.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.audit.planted import CELL_M, ROWS, Point

FINER: Final = 4
SIDE_M: Final = CELL_M / FINER
RIM: Final = 16
"""Cells around the map: obstacles, as nothing may leave it."""
HALF_DIAGONAL: Final = SIDE_M / math.sqrt(2.0)
Named = tuple[str, str]


@dataclass
class Verdict:
    """Findings that an audit must have, and those that it may have besides."""

    must: set[Named] = field(default_factory=set)
    may: set[Named] = field(default_factory=set)

    def add(self, kind: str, name: object, sure: bool) -> None:
        (self.must if sure else self.may).add((kind, str(name)))


class Distances:
    """Bounds of the distance to the marked cells (rows, columns), row 0 the top."""

    def __init__(self, marked: NDArray[np.bool_], rim: bool) -> None:
        fine = np.pad(marked, RIM, constant_values=rim).repeat(FINER, 0).repeat(FINER, 1)
        self.fine = fine
        free = (~fine).astype(np.uint8)
        if free.all():
            self.between = np.full(fine.shape, np.inf)
        else:
            transform = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
            self.between = transform.astype(np.float64) * SIDE_M

    def index(self, points: Point) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        column = np.floor(points[:, 0] / SIDE_M).astype(np.int64) + RIM * FINER
        row = (ROWS + RIM) * FINER - 1 - np.floor(points[:, 1] / SIDE_M).astype(np.int64)
        return row, column

    def bounds(self, a: Point, b: Point) -> tuple[float, float]:
        """Lower and upper bound of the least distance of a line a b."""
        points, step = samples(a, b)
        least = float(self.between[self.index(points)].min())
        if least == 0.0:
            return 0.0, 0.0
        # the transform of 32 bits is exact to a millionth
        slack = 1e-5
        return least - 2.0 * HALF_DIAGONAL - 0.5 * step - slack, least - SIDE_M / 2 + HALF_DIAGONAL

    def passes(self, a: Point, b: Point) -> tuple[bool, bool]:
        """True twice if a line surely, and if it perhaps, runs through marked cells."""
        points, _ = samples(a, b)
        at = self.index(points)
        # two samples in marked cells are no grazed corner
        return int(self.fine[at].sum()) >= 2, float(self.between[at].min()) <= 3.0 * SIDE_M


def samples(a: Point, b: Point) -> tuple[Point, float]:
    """Points along a line, and the step between them."""
    length = float(np.hypot(*(b - a)))
    count = max(2, math.ceil(length / (0.5 * SIDE_M)) + 1)
    t = np.linspace(0.0, 1.0, count)[:, None]
    return a + t * (b - a), length / (count - 1)

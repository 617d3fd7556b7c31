"""The borders of all objects and holes, and their sub-pixel edge points.

Rules and units
- Pixels, centres at integers, y down; outlines clockwise and holes counter-clockwise as seen on the
  screen. Obstacles are 8-connected, free space is 4-connected.
- ``laplacian_border`` is the paper's list L; ``follow_borders`` visits exactly those of its pixels
  that bound an object, clockwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.binarise.grey_picture import Binary
from vision.borders import contour_kernels as kernels
from vision.borders.edge_kernels import edge_points
from vision.borders.staircase_kernels import follow_staircase
from vision.shared.array_pool import ArrayPool

LAPLACIAN = np.array([[0, -1, 0], [-1, 4, -1], [0, -1, 0]], dtype=np.float32)
"""The mask M of the paper's section 3.1."""
STEEPEST = 0.3989
"""Slope of an unblurred step in the smoothed profile: derived, a normal distribution's density in
its middle."""
LEAST_SLOPE, MOST_SLOPE = 0.05, 0.4
"""Range of slopes: chosen, a blur of 8 px and none."""
LEAST_VARIANCE = 0.08
"""Least variance of light's spread, square pixels: derived, a pixel's own width has 1 / 12."""


@dataclass(frozen=True, slots=True)
class Contours:
    """Every border as a closed sequence of cracks.

    ``x``, ``y`` (c,) int32: the obstacle pixel of each crack; ``direction`` (c,) int8: the
    walk's, 0 east, 1 south, 2 west, 3 north; ``starts`` (b + 1,); ``area`` (b,): pixels
    enclosed, negative for a hole; ``owner`` (b,): the outline of the border's object.
    """

    x: NDArray[np.int32]
    y: NDArray[np.int32]
    direction: NDArray[np.int8]
    starts: NDArray[np.int64]
    area: NDArray[np.int64]
    owner: NDArray[np.int64]

    def cracks_of(
        self, border: int
    ) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int8]]:
        """``x``, ``y`` and ``direction`` of one border."""
        part = slice(int(self.starts[border]), int(self.starts[border + 1]))
        return self.x[part], self.y[part], self.direction[part]

    @property
    def pixels(self) -> int:
        """Number of border pixels, counted at each visit: n of the paper."""
        moved = (np.diff(self.x) != 0) | (np.diff(self.y) != 0)
        moved[self.starts[1:-1] - 1] = True
        return int(moved.sum()) + (len(self.starts) > 1)

    def contours(self) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
        """The 8-connected contours: points (n, 2), and where each border's begin (b + 1,)."""
        x, y, starts = kernels.contour_pixels(self.x, self.y, self.starts)
        return np.stack([x, y], axis=1), starts


@dataclass(frozen=True, slots=True)
class EdgePoints:
    """Sub-pixel points (k, 2) along every border, and ``starts`` (b + 1,).

    ``slope`` is the smoothed profile's mean step at the edge as a share of the contrast;
    ``crispness`` the share of slanted cracks without grey. ``staircase``: the sums of
    ``vision.borders.staircase_kernels``, square pixels.
    """

    points: NDArray[np.float64]
    starts: NDArray[np.int64]
    slope: float
    crispness: float
    staircase: tuple[float, float]

    @property
    def blur_px(self) -> float:
        """Spread of light at an edge (sigma), in pixels, besides a pixel's own width."""
        return blur_of(self.slope)


def blur_of(slope: float) -> float:
    """Blur (sigma, pixels) of edges whose smoothed profile has this slope."""
    return math.sqrt(max((STEEPEST / slope) ** 2 - 1.0, LEAST_VARIANCE))


def laplacian_border(mask: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Obstacle pixels of a mask (h, w) where the paper's Laplacian is positive.

    Everything outside is free.
    """
    padded = cv2.copyMakeBorder(mask, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    response = cv2.filter2D(padded, cv2.CV_16S, LAPLACIAN)
    border: NDArray[np.bool_] = response[1:-1, 1:-1] > 0
    return border


def follow_borders(mask: NDArray[np.uint8], pool: ArrayPool | None = None) -> Contours:
    """Follow every border of a padded mask (see ``vision.binarise.grey_picture.Binary``).

    The mask is marked meanwhile and restored afterwards. With a ``pool`` the borders are valid
    until its next use.
    """
    pool = ArrayPool() if pool is None else pool
    likely = max(4096, mask.size // 16)
    x, y, direction, starts, area = kernels.follow_borders(
        mask,
        pool.take("x", likely, np.int32),
        pool.take("y", likely, np.int32),
        pool.take("direction", likely, np.int8),
    )
    owner = kernels.hole_owners(mask, x, y, direction, starts, area)
    return Contours(x, y, direction, starts, area, owner)


def locate_edges(binary: Binary, borders: Contours, pool: ArrayPool | None = None) -> EdgePoints:
    """Sub-pixel edge points of every border.

    With a ``pool`` they are valid until its next use.
    """
    pool = ArrayPool() if pool is None else pool
    most = len(borders.x) + 1
    points, starts, slope, crispness = edge_points(
        binary.grey,
        binary.mask,
        binary.level,
        binary.by_level,
        borders.x,
        borders.y,
        borders.direction,
        borders.starts,
        pool.take("points", 2 * most, np.float64).reshape(most, 2),
    )
    slope = min(max(float(slope), LEAST_SLOPE), MOST_SLOPE)
    staircase = follow_staircase(points, starts, blur_of(slope))
    return EdgePoints(points, starts, slope, float(crispness), staircase)

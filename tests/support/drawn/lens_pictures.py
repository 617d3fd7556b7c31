"""Pictures through any lens, ray-traced, with OpenCV's own inverse of it as the oracle.

Rules and units
- Nothing of ``vision`` is asked: a sample's ray is that of ``cv2.undistortPoints`` or
  ``cv2.fisheye.undistortPoints``, and truth is projected by ``cv2.projectPoints`` and
  ``cv2.fisheye.projectPoints``.
- A thing is given by its raw pixel and its size in raw pixels (the root of its area): so lenses are
  compared at the same places and sizes of the picture, whatever they cover of the floor.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.calibration import Calibration

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
LIGHT, DARK = 200.0, 35.0
NO_RAY = 1e6
_TERM = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 20, 1e-12)


@dataclass(frozen=True)
class LensCamera:
    """A camera: ``matrix`` (3, 3), ``terms`` of ``model``, ``pose`` (3, 4) from arena to camera."""

    name: str
    size: tuple[int, int]
    matrix: Array
    model: str
    terms: Array
    pose: Array

    def calibration(self) -> Calibration:
        """The true one."""
        return Calibration.from_camera(self.size, self.matrix, self.terms, self.pose, self.model)

    def rays(self, pixels: Array) -> Array:
        """Normalised rays (n, 2), OpenCV's."""
        points = np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2)
        if self.model == "brown" and not self.terms.any():
            return np.asarray((pixels - self.matrix[:2, 2]) / np.diag(self.matrix)[:2])
        if self.model == "fisheye":
            found = cv2.fisheye.undistortPoints(points, self.matrix, self.terms, criteria=_TERM)
        else:
            found = cv2.undistortPoints(points, self.matrix, self.terms, criteria=_TERM)
        rays = found.reshape(-1, 2)
        # OpenCV marks a pixel that it cannot undo by -1000000 or by the pixel itself
        seen = np.linalg.norm(self._bent(rays) - pixels, axis=1) < 1e-3
        return np.where(seen[:, None], rays, NO_RAY)

    def _bent(self, rays: Array) -> Array:
        space = np.column_stack([rays, np.ones(len(rays))])
        return self._projected(space, np.zeros(3), np.zeros(3))

    def _projected(self, space: Array, turn: Array, shift: Array) -> Array:
        project = cv2.fisheye.projectPoints if self.model == "fisheye" else None
        points = np.ascontiguousarray(space, dtype=np.float64).reshape(-1, 1, 3)
        if project is not None:
            return project(points, turn, shift, self.matrix, self.terms)[0].reshape(-1, 2)
        return cv2.projectPoints(points, turn, shift, self.matrix, self.terms)[0].reshape(-1, 2)

    def pixels(self, places: Array, height_m: float = 0.0) -> Array:
        """Raw pixels (n, 2) of places (n, 2)."""
        space = np.column_stack([places, np.full(len(places), height_m)])
        return self._projected(space, cv2.Rodrigues(self.pose[:, :3])[0], self.pose[:, 3])

    def places(self, pixels: Array, height_m: float = 0.0) -> Array:
        """Places (n, 2) that raw pixels (n, 2) look at."""
        directions = np.column_stack([self.rays(pixels), np.ones(len(pixels))]) @ self.pose[:, :3]
        center = -self.pose[:, :3].T @ self.pose[:, 3]
        far = (height_m - center[2]) / directions[:, 2]
        return center[:2] + directions[:, :2] * far[:, None]

    def metres_at(self, pixel: Array, height_m: float = 0.0) -> float:
        """The root of the area that one pixel covers."""
        steps = np.array([(0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, -0.5)])
        around = self.places(pixel + steps, height_m)
        (ax, ay), (bx, by) = around[0] - around[1], around[2] - around[3]
        return math.sqrt(abs(ax * by - ay * bx))


Paint = Callable[[Array], Array]
"""From places (n, 2) to whether they are dark, 0 or 1, (n,)."""


def marker_paint(bits: Array, size_m: float, pose: tuple[float, float, float]) -> Paint:
    """A marker with its light rim; ``bits`` (n, n) is 1 where light, with the dark border."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    n = len(bits)

    def paint(places: Array) -> Array:
        dx, dy = places[:, 0] - pose[0], places[:, 1] - pose[1]
        column = np.floor((c * dx + s * dy) / size_m * n + n / 2).astype(int)
        row = np.floor((s * dx - c * dy) / size_m * n + n / 2).astype(int)
        inside = (column >= 0) & (column < n) & (row >= 0) & (row < n)
        return np.where(inside, 1.0 - bits[row.clip(0, n - 1), column.clip(0, n - 1)], 0.0)

    return paint


def disc_paint(center: Array, radius_m: float) -> Paint:
    """A disc on the floor."""
    return lambda places: (np.hypot(*(places - center).T) <= radius_m).astype(np.float64)


def square_paint(center: Array, side_m: float, heading_rad: float) -> Paint:
    """A square on the floor."""
    c, s = math.cos(heading_rad), math.sin(heading_rad)

    def paint(places: Array) -> Array:
        away = places - center
        turned = np.abs(away @ np.array([[c, -s], [s, c]]))
        return (turned.max(axis=1) <= 0.5 * side_m).astype(np.float64)

    return paint


def square_corners(center: Array, side_m: float, heading_rad: float) -> Array:
    """Its corners (4, 2)."""
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    unit = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    return center + side_m * unit @ np.array([[c, s], [-s, c]])


def picture(
    camera: LensCamera,
    painted: list[tuple[Paint, tuple[int, int, int, int]]],
    rng: np.random.Generator,
    noise: float = 2.0,
    blur: float = 0.7,
    samples: int = 6,
    height_m: float = 0.0,
) -> NDArray[np.uint8]:
    """The picture (h, w): each paint within its window x0, y0, x1, y1, light everywhere else."""
    width, height = camera.size
    image = np.full((height, width), LIGHT)
    for paint, (x0, y0, x1, y1) in painted:
        pixels = np.meshgrid(np.arange(x0, x1), np.arange(y0, y1))
        dark = lambda points, paint=paint: paint(camera.places(points, height_m))  # noqa: E731
        share = _share(dark, samples, *pixels)
        image[y0:y1, x0:x1] += (DARK - LIGHT) * share
    image = cv2.GaussianBlur(image, (0, 0), blur) + rng.normal(0.0, noise, image.shape)
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def _share(dark: Paint, samples: int, xs: IntArray, ys: IntArray) -> Array:
    """Dark shares of pixels (h, w): of many samples where the pixels around are not all alike."""
    share = dark(np.column_stack([xs.ravel(), ys.ravel()])).reshape(xs.shape)
    around = np.ones((5, 5), np.uint8)
    mixed = cv2.dilate(share, around) != cv2.erode(share, around)
    fine = (np.arange(samples) + 0.5) / samples - 0.5
    offsets = np.stack(np.meshgrid(fine, fine), axis=-1).reshape(-1, 2)
    pixels = np.column_stack([xs[mixed], ys[mixed]])
    points = (pixels[:, None] + offsets).reshape(-1, 2)
    share[mixed] = dark(points).reshape(len(pixels), -1).mean(axis=1)
    return share


def window_around(pixels: Array, size: tuple[int, int], rim: int = 12) -> tuple[int, int, int, int]:
    """The pixels around points, within the picture."""
    x0, y0 = np.maximum(np.floor(pixels.min(axis=0)).astype(int) - rim, 0)
    x1, y1 = np.minimum(np.ceil(pixels.max(axis=0)).astype(int) + rim, size)
    return int(x0), int(y0), int(x1), int(y1)

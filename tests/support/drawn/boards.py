"""Rendered markers and boards with known truth, for the tests and benchmarks of vision.

A picture is made by asking, for each of several points within each pixel, where its ray meets
the floor (``Calibration.arena_from_image``) and what is painted there: perspective and lens
are those of the calibration, edges are area-averaged, and nothing is drawn with OpenCV's own
anti-aliasing. A pixel that lies within one cell is looked at once. Then blur, noise and rounding,
as a sensor would.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.calibration import Calibration

LIGHT, DARK = 200.0, 35.0
Extent = tuple[float, float, float, float]
"""The least and the greatest x and y, in pixels: x0, y0, x1, y1."""


@dataclass(frozen=True)
class Patch:
    """A painted square grid on the floor or above it.

    ``cells`` (n, m) grey values, row 0 at the top of the upright picture; ``cell_m`` their
    size; centre ``x``, ``y``, turned by ``heading_rad`` counter-clockwise; ``height_m``.
    """

    cells: NDArray[np.float64]
    cell_m: float
    x: float
    y: float
    heading_rad: float
    height_m: float = 0.0


def marker_patch(
    dictionary: int,
    marker_id: int,
    size_m: float,
    pose: tuple[float, float, float],
    height_m: float = 0.0,
) -> Patch:
    """A marker of side ``size_m`` with a white rim of one cell, at (x, y, heading)."""
    book = cv2.aruco.getPredefinedDictionary(dictionary)
    n = book.markerSize + 2
    bits = cv2.aruco.generateImageMarker(book, marker_id, n)
    cells = np.full((n + 2, n + 2), LIGHT)
    cells[1:-1, 1:-1] = np.where(bits > 0, LIGHT, DARK)
    return Patch(cells, size_m / n, *pose, height_m)


def chessboard_patch(
    inner: tuple[int, int], square_m: float, pose: tuple[float, float, float]
) -> Patch:
    """A chessboard with (columns, rows) inner corners and a white rim, its centre at the pose."""
    columns, rows = inner[0] + 1, inner[1] + 1
    cells = np.full((rows + 2, columns + 2), LIGHT)
    parity = np.add.outer(np.arange(rows), np.arange(columns)) % 2
    cells[1:-1, 1:-1] = np.where(parity == 0, DARK, LIGHT)
    return Patch(cells, square_m, *pose)


def render(
    calibration: Calibration,
    patches: Sequence[Patch],
    *,
    rng: np.random.Generator | None = None,
    noise: float = 0.0,
    blur: float = 0.7,
    samples: int = 4,
    window: tuple[int, int, int, int] | None = None,
) -> NDArray[np.uint8]:
    """The picture (h, w) of the patches; later ones cover earlier ones.

    ``window`` (x, y, width, height) renders only that part in detail; the rest is floor.
    """
    width, height = calibration.size
    x0, y0, w, h = window or (0, 0, width, height)
    image = np.full((height, width), LIGHT)
    image[y0 : y0 + h, x0 : x0 + w] = sharp(calibration, patches, (x0, y0, w, h), samples)
    if blur > 0.0:
        image = cv2.GaussianBlur(image, (0, 0), blur)
    if rng is not None and noise > 0.0:
        image = image + rng.normal(0.0, noise, image.shape)
    return rounded(image)


def sharp(
    calibration: Calibration,
    patches: Sequence[Patch],
    window: tuple[int, int, int, int],
    samples: int,
) -> NDArray[np.float64]:
    """The part ``window`` (x, y, width, height) of a picture without blur, noise and rounding."""
    x0, y0, w, h = window
    ys, xs = np.mgrid[y0 : y0 + h, x0 : x0 + w].astype(np.float64)
    extents = [_extent(calibration, patch) for patch in patches]
    grey, mixed = _at_centres(calibration, patches, extents, xs, ys)
    across, down = xs[mixed], ys[mixed]
    total = np.zeros(across.size)
    for i in range(samples):
        for j in range(samples):
            dx, dy = (i + 0.5) / samples - 0.5, (j + 0.5) / samples - 0.5
            total += _paint(calibration, patches, extents, across + dx, down + dy)
    grey[mixed] = total / samples**2
    return grey


def rounded(image: NDArray[np.float64]) -> NDArray[np.uint8]:
    """The grey values that a sensor gives for an exposed picture (h, w)."""
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def pose_bound(
    calibration: Calibration,
    patch: Patch,
    noise: float,
    window: tuple[int, int, int, int] | None = None,
) -> tuple[float, float]:
    """The least rms error that any unbiased estimate of a patch's pose can have.

    (position in pixels, heading in degrees) at white noise of ``noise`` grey levels, everything
    but x, y and heading known: the Cramer-Rao bound, from how the picture changes with each.
    """
    step_m, step_rad = 0.5 * calibration.metres_per_pixel, math.radians(1.0)
    slopes = []
    for name, step in (("x", step_m), ("y", step_m), ("heading_rad", step_rad)):
        there, here = (
            render(
                calibration,
                [replace(patch, **{name: getattr(patch, name) + way * step})],
                window=window,
            ).astype(np.float64)
            for way in (1.0, -1.0)
        )
        slopes.append((there - here).ravel() / (2.0 * step))
    jacobian = np.array(slopes)
    spread = noise * noise * np.linalg.inv(jacobian @ jacobian.T)
    position_m = math.sqrt(spread[0, 0] + spread[1, 1])
    return position_m / calibration.metres_per_pixel, math.degrees(math.sqrt(spread[2, 2]))


def _at_centres(
    calibration: Calibration,
    patches: Sequence[Patch],
    extents: Sequence[Extent],
    xs: NDArray[np.float64],
    ys: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The grey of each pixel's centre (h, w), and which pixels may have more than one grey."""
    grey, mixed = np.full(xs.shape, LIGHT), np.zeros(xs.shape, dtype=bool)
    for patch, (x0, y0, x1, y1) in zip(patches, extents, strict=True):
        # a pixel's samples may be within the extent where its centre is not
        near = (xs[0] >= x0 - 1) & (xs[0] <= x1 + 1), (ys[:, 0] >= y0 - 1) & (ys[:, 0] <= y1 + 1)
        part = np.ix_(near[1], near[0])
        if min(xs[part].shape) < 2:  # no slope: every sample counts
            mixed[part] = True
            continue
        column, row = (
            place.reshape(xs[part].shape)
            for place in _cell_of(calibration, patch, xs[part].ravel(), ys[part].ravel())
        )
        for place in (column, row):
            reach = sum(np.abs(slope) for slope in np.gradient(place))
            mixed[part] |= np.abs(place - np.round(place)) <= 0.6 * reach + 0.02
        painted = grey[part]
        _fill(patch, column, row, painted)
        grey[part] = painted
    return grey, mixed


def _paint(
    calibration: Calibration,
    patches: Sequence[Patch],
    extents: Sequence[Extent],
    xs: NDArray[np.float64],
    ys: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The grey of points of the picture (n,)."""
    grey = np.full(xs.shape, LIGHT)
    for patch, (x0, y0, x1, y1) in zip(patches, extents, strict=True):
        part = np.flatnonzero((xs >= x0) & (xs <= x1) & (ys >= y0) & (ys <= y1))
        painted = grey[part]
        _fill(patch, *_cell_of(calibration, patch, xs[part], ys[part]), painted)
        grey[part] = painted
    return grey


def _cell_of(
    calibration: Calibration, patch: Patch, xs: NDArray[np.float64], ys: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The columns and rows of the patch's grid in which points of the picture (n,) lie."""
    floor = calibration.arena_from_image(np.stack([xs, ys], axis=1), patch.height_m)
    dx, dy = floor[:, 0] - patch.x, floor[:, 1] - patch.y
    c, s = math.cos(patch.heading_rad), math.sin(patch.heading_rad)
    rows, columns = patch.cells.shape
    return (
        (c * dx + s * dy) / patch.cell_m + columns / 2,
        (s * dx - c * dy) / patch.cell_m + rows / 2,
    )


def _fill(
    patch: Patch,
    column: NDArray[np.float64],
    row: NDArray[np.float64],
    grey: NDArray[np.float64],
) -> None:
    """Paint the cells over the grey values that lie in them."""
    rows, columns = patch.cells.shape
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    grey[inside] = patch.cells[row[inside].astype(int), column[inside].astype(int)]


def _extent(calibration: Calibration, patch: Patch) -> Extent:
    """The pixels that a patch can reach: its rim's, and a little for what a lens bends."""
    rows, columns = patch.cells.shape
    along = np.linspace(-0.5, 0.5, 9)
    rim = np.vstack(
        [np.column_stack([along, np.full(9, v)]) for v in (-0.5, 0.5)]
        + [np.column_stack([np.full(9, v), along]) for v in (-0.5, 0.5)]
    ) * (columns * patch.cell_m, rows * patch.cell_m)
    c, s = math.cos(patch.heading_rad), math.sin(patch.heading_rad)
    places = rim @ np.array([[c, s], [-s, c]]) + (patch.x, patch.y)
    seen = calibration.image_from_arena(places, patch.height_m)
    (x0, y0), (x1, y1) = seen.min(axis=0) - 3.0, seen.max(axis=0) + 3.0
    return float(x0), float(y0), float(x1), float(y1)

"""A marker's place from all of its pixels: its known pattern, laid where it fits best.

Rules and units
- The four sides (``vision.markers.marker_corners``) say where a marker is; its inner cells have as
  many edges again. Here the whole pattern, blurred as the picture is, is fitted to the grey values
  by least squares (Gauss-Newton): with white noise no estimate of the same unknowns is better.
- The unknowns are an affine map from the arena's plane at the marker's height to the pattern's
  cells, the blur, and the dark and the light as planes over the marker, since light is uneven.
  The perspective and the lens are the calibration's and are not asked of a small marker.
- Pixels that disagree (dirt, a cable) weigh less; a picture that is not like the pattern gives
  no result, and the four sides stay.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Image
from vision.markers.marker_pattern_kernels import (
    LEAST_PIXELS,
    UNKNOWNS,
    collect_pixels,
    settle_pattern,
)

_RIM_PX = 3.0
_RIM_CELLS = 0.75
"""How far around the marker pixels are used: the rim is light for a cell at least."""

_MOST_PIXELS = 12_000
"""In the box around a marker: more are thinned out. From 200 px on the centre stays within 0.01 px
(``test_marker_pattern.py``)."""
_MAX_MOVE_PX = 1.5


def pattern_bits(book: cv2.aruco.Dictionary, marker_id: int) -> FloatArray:
    """A marker's cells (n, n) with its dark border: 1.0 where light."""
    picture = cv2.aruco.generateImageMarker(book, marker_id, book.markerSize + 2)
    return np.asarray(picture > 127, dtype=np.float64)


def fit_pattern(
    grey: Image,
    corners_m: FloatArray,
    bits: FloatArray,
    calibration: Calibration,
    height_m: float = 0.0,
) -> FloatArray | None:
    """The corners (4, 2) in metres of the pattern that lies near ``corners_m``; None without one.

    ``grey`` (h, w) uint8; ``corners_m`` (4, 2) at ``height_m``, good to a pixel, inside the
    picture; ``bits`` (n, n) from ``pattern_bits``. O(pixels of the marker).
    """
    cells = len(bits)
    center = corners_m.mean(axis=0)
    unit_m = float(np.linalg.norm(corners_m - center, axis=1).mean())
    if not unit_m > 0.0:
        return None
    local = (corners_m - center) / unit_m
    state = np.zeros(UNKNOWNS)
    state[:6] = _affine(local, cells)
    seen_px = calibration.image_from_arena(corners_m, height_m)
    metric = _metric(seen_px.mean(axis=0), unit_m, calibration, height_m)
    if metric is None:
        return None
    cell_px = float(np.linalg.norm(np.roll(seen_px, -1, axis=0) - seen_px, axis=1).mean()) / cells
    pixels = _pixels(
        grey, seen_px, local, center, unit_m, cells, calibration, height_m, state, cell_px
    )
    if len(pixels) < LEAST_PIXELS or not settle_pattern(pixels, bits, state, metric, cell_px):
        return None
    found = _corners(state, cells)
    placed = np.asarray(center + unit_m * found)
    moved_px = np.abs(calibration.image_from_arena(placed, height_m) - seen_px).max()
    return placed if moved_px <= _MAX_MOVE_PX else None


def _metric(
    middle_px: FloatArray, unit_m: float, calibration: Calibration, height_m: float
) -> FloatArray | None:
    """J J^T (2, 2) of the plane, in units of the marker's size, by raw pixels at its middle."""
    steps = np.array([(0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, -0.5)])
    around = calibration.arena_from_image(middle_px + steps, height_m) / unit_m
    jacobian = np.column_stack([around[0] - around[1], around[2] - around[3]])
    return jacobian @ jacobian.T if np.isfinite(jacobian).all() else None


def _pixels(
    grey: Image,
    inner_px: FloatArray,
    local: FloatArray,
    center: FloatArray,
    unit_m: float,
    cells: int,
    calibration: Calibration,
    height_m: float,
    state: FloatArray,
    cell_px: float,
) -> FloatArray:
    """The marker's pixels, with their places in units of its own size around its centre."""
    rim = min(_RIM_PX / cell_px, _RIM_CELLS)
    outer = center + unit_m * local * (1.0 + 2.0 * rim / cells)
    seen = calibration.image_from_arena(outer, height_m)
    height, width = grey.shape
    ends = np.array([width - 1, height - 1])
    # A part of the rim may be missing, but nothing of the marker itself.
    if not (np.isfinite(seen).all() and (inner_px >= 0.0).all() and (inner_px <= ends).all()):
        return np.empty((0, 3))
    x0, y0 = (max(0, math.floor(v) - 1) for v in seen.min(axis=0))
    x1, y1 = np.minimum(np.ceil(seen.max(axis=0)) + 1, ends).astype(int).tolist()
    shrink = np.diag([1.0 / unit_m, 1.0 / unit_m, 1.0])
    shrink[:2, 2] = -center / unit_m
    plane = np.ascontiguousarray(shrink @ calibration.plane_from_pixel(height_m))
    return collect_pixels(
        grey, (x0, y0, x1, y1), calibration.lens, plane, state[:6], cells, rim,
        (x1 - x0 + 1) * (y1 - y0 + 1) // _MOST_PIXELS + 1,
    )  # fmt: skip


def _affine(local: FloatArray, cells: int) -> FloatArray:
    """The affine map (6,) that takes four corners nearest to the pattern's."""
    wanted = _UNIT_SQUARE * cells
    design = np.column_stack([local, np.ones(4)])
    solved = np.linalg.lstsq(design, wanted, rcond=None)[0]
    return np.ascontiguousarray(solved.T.reshape(-1))


def _corners(state: FloatArray, cells: int) -> FloatArray:
    """The pattern's corners (4, 2) in the plane."""
    turn = np.array([[state[0], state[1]], [state[3], state[4]]])
    return np.asarray(np.linalg.solve(turn, (_UNIT_SQUARE * cells - state[[2, 5]]).T).T)


_UNIT_SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
"""Top left, top right, bottom right, bottom left, y down."""


def warm_up() -> None:
    """Compile, or load, the kernels now: the first frame must not wait for seconds."""
    blank = np.zeros((32, 32), dtype=np.uint8)
    blank.setflags(write=False)
    square = np.array([(8.0, 23.0), (23.0, 23.0), (23.0, 8.0), (8.0, 8.0)])
    fit_pattern(blank, square, np.zeros((6, 6)), Calibration.from_scale(1.0, (32, 32)))

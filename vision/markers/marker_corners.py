"""A marker's corners to a few hundredths of a pixel: its four sides, fitted and intersected.

Rules and units
- Raw pixels, centres at integers. Corners run clockwise on the screen, as the detector gives
  them; a marker is darker than what surrounds it.
- Along each side, profiles across the edge give where the grey value changes (the centroid of
  the gradient); a line through these points by total least squares is the side. A line uses
  the whole side, so it is far better than looking for each corner.
- The points are undistorted before a line is fitted: a lens bends a long side by more than
  the accuracy sought. A wide lens's undistorted pixels are stretched many times at its rim, and not
  alike in all directions: lines are fitted in a frame in which the marker's corners lie as in the
  raw picture, so that a pixel's error is one of a pixel everywhere.
- A marker whose side is partly covered, or no straight edge, is refused: a corner would be
  invented otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from vision.calibration.calibration import Calibration, FloatArray
from vision.calibration.lens_model import STRAIGHT
from vision.camera.camera import Image
from vision.markers.marker_kernels import fit_sides

_ROUNDS = 3
_MIN_SEEN = 0.7
"""Share of a side's profiles that must show the edge."""

_MAX_ROUGHNESS_PX = 0.7
_MIN_SINE = 0.1
"""Of the angle between two neighbouring sides."""


@dataclass(frozen=True, slots=True, eq=False)
class RefinedQuad:
    """``corners_px`` (4, 2) undistorted; ``roughness_px``: rms distance of edge points to sides."""

    corners_px: FloatArray
    roughness_px: float


@dataclass(frozen=True, slots=True)
class Refused:
    """Why a quadrilateral is not taken for a whole, visible marker."""

    reason: str


def refine_quad(
    grey: Image, corners_px: FloatArray, cells: int, calibration: Calibration
) -> RefinedQuad | Refused:
    """The sides of one marker fitted and intersected, or why it is refused.

    ``grey`` (h, w); ``corners_px`` (4, 2) raw pixels, good to a few; ``cells`` is the number of
    cells along a side with the black border, which bounds how far inwards a profile may look.
    """
    seen_px = np.ascontiguousarray(corners_px, dtype=np.float64)
    side_px = float(np.linalg.norm(np.roll(seen_px, -1, axis=0) - seen_px, axis=1).mean())
    widest = max(1.5, 0.75 * side_px / cells)
    corners = ideal = seen_px
    roughness_px = 0.0
    for turn in range(_ROUNDS):
        # The detector may be a pixel or two off: look wide first, then close.
        reach_px = min(4.0 if turn == 0 else 3.0, widest)
        if not _inside(corners, reach_px, grey):
            return Refused("it touches the picture's edge")
        frame = _frame_at(corners, calibration)
        if frame is None:
            return Refused("it lies where the lens folds")
        lines, seen = fit_sides(grey, corners, reach_px, calibration.lens, frame)
        if seen.min() < _MIN_SEEN:
            return Refused("a side is partly hidden or has no contrast")
        found = _intersections(lines)
        if found is None:
            return Refused("two of its sides are parallel")
        ideal = moved(np.asarray(np.linalg.inv(frame), dtype=np.float64), found)
        corners = calibration.distort_points(ideal)
        if not np.abs(corners - seen_px).max() <= max(4.0, 0.15 * side_px):
            return Refused("its sides do not meet near its corners")
        roughness_px = float(np.sqrt(np.mean(lines[:, 3] ** 2)))
    if roughness_px > _MAX_ROUGHNESS_PX:
        return Refused(f"its sides are not straight ({roughness_px:.2f} px)")
    return RefinedQuad(ideal, roughness_px)


def _frame_at(corners: FloatArray, calibration: Calibration) -> FloatArray | None:
    """The homography (3, 3) that takes undistorted corners to raw ones; None where a lens folds."""
    if calibration.lens.model == STRAIGHT:
        return np.eye(3)
    ideal = calibration.undistort_points(corners)
    if not np.isfinite(ideal).all():
        return None
    # What it is exactly does not matter: its inverse leads back.
    frame = cv2.getPerspectiveTransform(ideal.astype(np.float32), corners.astype(np.float32))
    usable = np.isfinite(frame).all() and abs(float(np.linalg.det(frame))) > 0.0
    return np.ascontiguousarray(frame, dtype=np.float64) if usable else None


def moved(homography: FloatArray, points: FloatArray) -> FloatArray:
    """Points (n, 2) through a homography (3, 3)."""
    there = points @ homography[:, :2].T + homography[:, 2]
    return np.asarray(there[:, :2] / there[:, 2:])


def _intersections(lines: FloatArray) -> FloatArray | None:
    """Corner i is where side i - 1 meets side i; None where two neighbours are parallel."""
    corners = np.empty((4, 2))
    for i in range(4):
        a, b, c, _ = lines[i - 1]
        d, e, f, _ = lines[i]
        sine = a * e - b * d
        if abs(sine) < _MIN_SINE:
            return None
        corners[i] = (c * e - b * f) / sine, (a * f - c * d) / sine
    return corners


def _inside(corners: FloatArray, reach_px: float, grey: Image) -> bool:
    low, high = corners.min(axis=0) - reach_px, corners.max(axis=0) + reach_px
    height, width = grey.shape[:2]
    return bool(low.min() >= 0.0 and high[0] <= width - 1 and high[1] <= height - 1)


def warm_up() -> None:
    """Compile, or load, the kernels now: the first frame must not wait for seconds."""
    square = np.array([(8.0, 8.0), (24.0, 8.0), (24.0, 24.0), (8.0, 24.0)])
    blank = np.zeros((32, 32), dtype=np.uint8)
    blank.setflags(write=False)
    refine_quad(blank, square, 6, Calibration.from_scale(1.0, (32, 32)))

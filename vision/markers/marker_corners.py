"""A marker's corners to a few hundredths of a pixel: its four sides, fitted and intersected.

Rules and units
- Raw pixels, centres at integers. Corners run clockwise on the screen, as the detector gives them;
  a marker is darker than its surroundings.
- Profiles across each side locate its edge (the centroid of the gradient); a total least squares
  line through these points is the side, far better than a search for each corner.
- Points are undistorted before the fit. A wide lens stretches undistorted pixels unevenly, so lines
  are fitted in a frame where the corners lie as in the raw picture.
- The line follows the points that most agree on, not a cover over part of a side; a covered corner
  is where two lines meet, with a larger error. Only the cells inside reveal a cover from end to end
  (``vision.markers.marker_pattern``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Image
from vision.markers.marker_kernels import (
    APART,
    AT_EDGE,
    FITTED,
    FOLDED,
    HIDDEN,
    NO_FLOOR,
    PARALLEL,
    ROUGH,
    UNREAD,
    fit_quad,
)


@dataclass(frozen=True, slots=True, eq=False)
class RefinedQuad:
    """``corners_px`` (4, 2) undistorted; ``roughness_px``: rms distance of edge points to sides.

    ``error_px``: standard error of the worst corner, larger if much of a side is covered.
    """

    corners_px: FloatArray
    roughness_px: float
    error_px: float


_REFUSALS = {
    AT_EDGE: "it touches the picture's edge",
    FOLDED: "it lies where the lens folds",
    HIDDEN: "a side is partly hidden or has no contrast",
    PARALLEL: "two of its sides are parallel",
    APART: "its sides do not meet near its corners",
    NO_FLOOR: "it lies where no floor is seen",
    UNREAD: "its cells are not where its sides are",
}
"""Reasons why a quadrilateral is not a whole, visible marker."""


def refine_quad(
    grey: Image, corners_px: FloatArray, cells: int, calibration: Calibration
) -> RefinedQuad | str:
    """Fit and intersect the sides of one marker, or give the reason to refuse it.

    ``grey`` (h, w); ``corners_px`` (4, 2) raw pixels, good to a few; ``cells`` along a side with
    the black border.
    """
    seen_px = np.array(corners_px, dtype=np.float64, order="C")
    ideal = np.empty((4, 2))
    became, roughness_px, error_px = fit_quad(grey, seen_px, cells, calibration.lens, ideal)
    if became != FITTED:
        return why_refused(became, roughness_px)
    return RefinedQuad(ideal, roughness_px, error_px)


def why_refused(became: int, roughness_px: float) -> str:
    """Put a refusal into words."""
    if became == ROUGH:
        return f"its sides are not straight ({roughness_px:.2f} px)"
    return _REFUSALS[became]

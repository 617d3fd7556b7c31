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

from vision.markers.marker_kernels import (
    APART,
    AT_EDGE,
    FOLDED,
    HIDDEN,
    NO_FLOOR,
    PARALLEL,
    ROUGH,
    UNREAD,
)

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


def why_refused(became: int, roughness_px: float) -> str:
    """Put a refusal into words."""
    if became == ROUGH:
        return f"its sides are not straight ({roughness_px:.2f} px)"
    return _REFUSALS[became]

"""Digital circles: Sauer's test of the paper's section 3.2 (equation 14).

Rules and units
- Contours are in whole pixels; the centre is their centroid and the radius their mean distance from
  it, so the circle runs through the pixels' centres.
- Noise breaks the test, and it accepts a small octagon.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.paper.corner_kernels import is_digital_circle

SLACK_PX = 0.25
"""The paper's "threshold value": a filled disc's border pixels lie up to a pixel inside its
circle."""
FEWEST_CONTOUR_PX = 8
"""Pixels of the smallest contour that is no dot."""


@dataclass(frozen=True, slots=True)
class DigitalCircle:
    """Circle in pixels, of which a contour is the digital image."""

    center: tuple[float, float]
    radius: float


def digital_circle(contour: NDArray[np.int32], slack_px: float = SLACK_PX) -> DigitalCircle | None:
    """Circle whose digital image the closed contour (n, 2) is, or None. O(n).

    ``slack_px`` widens the half pixel of equation 14.
    """
    if len(contour) < FEWEST_CONTOUR_PX:
        return None
    xs, ys = np.ascontiguousarray(contour[:, 0]), np.ascontiguousarray(contour[:, 1])
    accepted, x_m, y_m, r = is_digital_circle(xs, ys, 0, len(xs), slack_px)
    return DigitalCircle((float(x_m), float(y_m)), float(r)) if accepted else None

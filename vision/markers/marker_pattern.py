"""A marker's place from all of its pixels: the best fit of its known pattern.

Rules and units
- After its sides (``vision.markers.marker_corners``), a marker's whole pattern, blurred, is fitted
  to the grey values by least squares (Gauss-Newton).
- The unknowns are an affine map from the arena's plane at the marker's height to the pattern's
  cells, the blur, and dark and light as planes. Perspective and lens come from the calibration.
- Pixels that disagree (dirt, a cable) weigh less; a marker unlike the pattern is refused.
- If a side is off the pattern by more than its error, or a third covered, or the marker is cut
  tightly, only the inner cells are fitted, and all must read right.
"""

from __future__ import annotations

import cv2
import numpy as np

from vision.calibration.calibration import FloatArray


def pattern_bits(book: cv2.aruco.Dictionary, marker_id: int) -> FloatArray:
    """A marker's cells (n, n) with its dark border: 1.0 for light."""
    picture = cv2.aruco.generateImageMarker(book, marker_id, book.markerSize + 2)
    return np.asarray(picture > 127, dtype=np.float64)

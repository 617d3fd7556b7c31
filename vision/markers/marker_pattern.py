"""A marker's place from all of its pixels: its known pattern, laid where it fits best.

Rules and units
- The four sides (``vision.markers.marker_corners``) say where a marker is; its inner cells have as
  many edges again. Here the whole pattern, blurred as the picture is, is fitted to the grey values
  by least squares (Gauss-Newton): with white noise no estimate of the same unknowns is better.
- The unknowns are an affine map from the arena's plane at the marker's height to the pattern's
  cells, the blur, and the dark and the light as planes over the marker, since light is uneven.
  The perspective and the lens are the calibration's and are not asked of a small marker.
- Pixels that disagree (dirt, a cable) weigh less; a picture that is not like the pattern gives
  no result, and the marker is refused.
- The inner cells' edges are a second witness of where the sides are. Where a side lies beside the
  pattern by more than its error, or a third of it is covered, or the marker is cut tightly, the
  inner cells alone are fitted, all of which must read right, and the error is that fit's own.
"""

from __future__ import annotations

import cv2
import numpy as np

from vision.calibration.calibration import FloatArray


def pattern_bits(book: cv2.aruco.Dictionary, marker_id: int) -> FloatArray:
    """A marker's cells (n, n) with its dark border: 1.0 where light."""
    picture = cv2.aruco.generateImageMarker(book, marker_id, book.markerSize + 2)
    return np.asarray(picture > 127, dtype=np.float64)

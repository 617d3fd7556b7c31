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

import cv2
import numpy as np

from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Image
from vision.markers.marker_place_kernels import place_pattern


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
    placed = np.empty((4, 2))
    near = np.array(corners_m, dtype=np.float64, order="C")
    is_there, _ = place_pattern(grey, near, bits, calibration.plane_view(height_m), placed)
    return placed if is_there else None

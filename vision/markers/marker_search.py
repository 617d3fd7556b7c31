"""Marker dictionaries, and quadrilaterals with a marker's code in a picture, unrefined.

Rules and units
- Dictionaries have OpenCV's names, ``DICT_4X4_50`` or ``DICT_APRILTAG_36h11``.
- Corners are raw pixels, centres at integers, clockwise from the upright marker's top left one.
"""

from __future__ import annotations

import difflib

import cv2
import numpy as np

from vision.calibration.calibration import FloatArray
from vision.camera.camera import Image


class MarkerError(ValueError):
    """Error for an unusable marker, dictionary or robot setting."""


def grey_of(image: Image) -> Image:
    """Picture as grey (h, w)."""
    if image.ndim == 2:
        return image
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.uint8, copy=False)


def dictionary_names() -> tuple[str, ...]:
    """Names of OpenCV's marker dictionaries, ArUco's and AprilTag's."""
    return tuple(sorted(name for name in dir(cv2.aruco) if name.startswith("DICT_")))


def dictionary_by_name(name: str) -> cv2.aruco.Dictionary:
    """Look up a dictionary; ``MarkerError`` suggests the name probably meant."""
    names = {n.upper(): n for n in dictionary_names()}
    wanted = name.strip().upper()
    wanted = wanted if wanted.startswith("DICT_") else f"DICT_{wanted}"
    if wanted not in names:
        near = difflib.get_close_matches(wanted, names, n=1)
        hint = f"; did you mean {names[near[0]]}?" if near else f": one of {', '.join(names)}"
        raise MarkerError(f"marker dictionary '{name}' is unknown{hint}")
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, names[wanted]))


def find_markers(image: Image, dictionary: str) -> list[tuple[int, FloatArray]]:
    """Find every marker of a dictionary in one picture: (id, corners (4, 2) raw pixels), unrefined.

    ``MarkerTracker`` tracks robots.
    """
    book = dictionary_by_name(dictionary)
    parameters = cv2.aruco.DetectorParameters()
    return find_with(cv2.aruco.ArucoDetector(book, parameters), grey_of(image))


def finder_of(book: cv2.aruco.Dictionary, window: int, constant: float) -> cv2.aruco.ArucoDetector:
    """Detector with one threshold window; a high constant keeps noise from becoming contours."""
    parameters = cv2.aruco.DetectorParameters()
    parameters.adaptiveThreshWinSizeMin = window
    parameters.adaptiveThreshWinSizeMax = window
    parameters.adaptiveThreshConstant = constant
    parameters.minMarkerPerimeterRate = 0.02
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
    return cv2.aruco.ArucoDetector(book, parameters)


def find_with(finder: cv2.aruco.ArucoDetector, grey: Image) -> list[tuple[int, FloatArray]]:
    """A detector's markers: (id, corners (4, 2))."""
    corners, ids, _ = finder.detectMarkers(grey)
    if ids is None or len(corners) == 0:
        return []
    quads = [np.asarray(c, dtype=np.float64).reshape(4, 2) for c in corners]
    return [(int(i), quad) for i, quad in zip(np.ravel(ids), quads, strict=True)]

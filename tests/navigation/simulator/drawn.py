"""A clock, cameras that look straight down, and small scenes for the simulated camera's tests."""

from __future__ import annotations

import cv2
import numpy as np

from navigation.simulator.picture.drawing import Appearance
from navigation.simulator.picture.pinhole import Pinhole
from planner.scene import (
    Bounds,
    FloatArray,
    PolygonRecord,
    Scene,
    SceneObject,
    Segment,
)
from vision.camera.camera import Image

PLACES = [(0.25, 0.25), (1.2, 0.95), (2.2, 1.6), (2.2, 0.2), (0.2, 1.6), (1.3, 0.55)]


class Clock:
    """Virtual time."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s

    def wait(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.now_s += seconds


# What is drawn.

PLAIN = Appearance(blur_px=0.0, noise_grey=0.0, light_fall=0.0)


def straight_down(size_px: tuple[int, int] = (400, 300), metres_per_pixel: float = 0.01) -> Pinhole:
    """No distortion, looking straight down: pixel (0, h - 1) is the place (0, 0)."""
    height_m = 2.0
    focal = height_m / metres_per_pixel
    width, height = size_px
    centre = ((width - 1) / 2, (height - 1) / 2)
    matrix = np.array([[focal, 0, centre[0]], [0, focal, centre[1]], [0, 0, 1.0]])
    position = np.array([centre[0] * metres_per_pixel, centre[1] * metres_per_pixel, height_m])
    return Pinhole(size_px, matrix, np.zeros(5), np.diag([1.0, -1.0, -1.0]), position)


def scene_of(*things: SceneObject) -> Scene:
    return Scene("m", Bounds(0, 0, 4, 3), things)


def darkness(picture: Image) -> FloatArray:
    """The part of each pixel that an obstacle covers, from its grey value."""
    return (205.0 - picture) / (205.0 - 45.0)


def square(x0: float, y0: float, side: float) -> PolygonRecord:
    c = ((x0, y0), (x0, y0 + side), (x0 + side, y0 + side), (x0 + side, y0))
    return PolygonRecord(tuple(Segment(c[i], c[(i + 1) % 4]) for i in range(4)))


def detector() -> cv2.aruco.ArucoDetector:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    return cv2.aruco.ArucoDetector(dictionary, parameters)

"""A camera with a known lens above a known arena, and pixels of its picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.calibration import Calibration
from vision.calibration.calibration_kernels import image_from_plane, plane_from_image
from vision.calibration.lens_model import LensArrays

SIZE = (640, 480)
CAMERA = np.array([[620.0, 0.0, 325.0], [0.0, 622.0, 236.0], [0.0, 0.0, 1.0]])
LENS = np.array([-0.25, 0.07, 0.001, -0.0008, 0.01])
FLIP = np.diag([1.0, -1.0, -1.0])


def pose_of(turn: tuple[float, float, float], center: tuple[float, float, float]) -> NDArray:
    rotation = cv2.Rodrigues(np.array(turn))[0] @ FLIP
    return np.column_stack([rotation, -rotation @ np.array(center)])


def overhead(lens: NDArray = LENS) -> Calibration:
    return Calibration.from_camera(SIZE, CAMERA, lens, pose_of((0.05, 0.08, 0.3), (1.0, 0.8, 2.5)))


def pixels(n: int = 200, seed: int = 0) -> NDArray:
    return np.random.default_rng(seed).uniform((0, 0), SIZE, (n, 2))


def distorted(ideal: NDArray, lens: LensArrays) -> NDArray:
    """Raw pixels (n, 2) of undistorted ones, by the kernel of calibrations."""
    return np.asarray(image_from_plane(ideal, np.eye(3), 1.0, lens))


def undistorted(raw: NDArray, lens: LensArrays) -> NDArray:
    """Undistorted pixels (n, 2) of raw ones, by the kernel of calibrations."""
    return np.asarray(plane_from_image(raw, np.eye(3), 1.0, lens))

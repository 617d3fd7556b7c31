"""The compiled loop of ``vision.calibration.calibration``: Brown's lens model inverted.

Raw and undistorted pixels, centres at integers. ``camera`` is (fx, fy, cx, cy), ``lens``
(k1, k2, p1, p2, k3).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

import planner.scene.compile_options  # noqa: F401 (chooses how kernels are compiled and kept)


@njit(cache=True, nogil=True, fastmath=False)
def undistort(
    x_px: float, y_px: float, camera: NDArray[np.float64], lens: NDArray[np.float64]
) -> tuple[float, float]:
    """One raw pixel to an undistorted one, by Newton's method on Brown's model."""
    tx, ty = (x_px - camera[2]) / camera[0], (y_px - camera[3]) / camera[1]
    k1, k2, p1, p2, k3 = lens[0], lens[1], lens[2], lens[3], lens[4]
    x, y = tx, ty
    for _ in range(20):
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))
        ex = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) - tx
        ey = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y - ty
        if abs(ex) < 1e-12 and abs(ey) < 1e-12:
            break
        a = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
        d = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
        b = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
        determinant = a * d - b * b
        if abs(determinant) < 1e-3:
            determinant = 1.0
        x -= (d * ex - b * ey) / determinant
        y -= (a * ey - b * ex) / determinant
    return x * camera[0] + camera[2], y * camera[1] + camera[3]


@njit(cache=True, nogil=True, fastmath=False)
def undistort_all(
    points: NDArray[np.float64], camera: NDArray[np.float64], lens: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Raw pixels (n, 2) to undistorted ones."""
    found = np.empty_like(points)
    for i in range(len(points)):
        found[i, 0], found[i, 1] = undistort(points[i, 0], points[i, 1], camera, lens)
    return found

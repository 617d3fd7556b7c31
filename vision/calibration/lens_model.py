"""Lens models, Brown's and OpenCV's fisheye, and the reach of each.

Rules and units
- Normalised coordinates x = X / Z, y = Y / Z of the camera, Z along its view; ``r`` their radius.
- ``brown`` (D. C. Brown, Close-range camera calibration, 1971): up to five terms in OpenCV's order
  (k1, k2, p1, p2, k3). ``fisheye`` (J. Kannala and S. S. Brandt, A generic camera model, 2006, as
  OpenCV has it): four terms (k1, k2, k3, k4); a ray at the angle theta to the view is seen at the
  radius theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
- Either is inverted only within a disc of normalised radius ``reach``. In it Brown's symmetric
  Jacobian is positive definite, so no two rays share a pixel; the fisheye's theta_d grows with
  theta. Beyond it a lens folds, or looks sideways.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

MODELS = ("brown", "fisheye")
MOST_TERMS = {"brown": 5, "fisheye": 4}
STRAIGHT, BROWN, FISHEYE = 0, 1, 2
"""Kinds of lens for kernels; ``STRAIGHT`` is Brown's model with no term."""

LEAST_STRETCH = 1.0 / 30.0
"""Least length against the picture's middle before a lens folds: 30 px become one."""
MOST_ANGLE_RAD = math.radians(89.9)
"""Largest angle to the view: a pinhole's picture has no 90 degrees; 0.1 degrees are half a
pixel."""
_MOST_RADIUS = 20.0
"""Brown's model is used no farther: 87 degrees to the view."""
_ANGLES, _DIRECTIONS = 1801, 48


class LensArrays(NamedTuple):
    """A lens for kernels.

    ``model`` is ``STRAIGHT``, ``BROWN`` or ``FISHEYE``; ``camera`` (4,) fx, fy, cx, cy in pixels;
    ``terms`` (5,), unused ones 0; ``reach`` the normalised radius up to which it can be inverted.
    """

    model: int
    camera: FloatArray
    terms: FloatArray
    reach: float


class PlaneView(NamedTuple):
    """A plane of the arena and its picture, for kernels.

    ``from_pixel`` (3, 3) leads from undistorted pixels to the plane, ``to_pixel`` back; in front of
    the camera the third coordinate has the sign of ``front``.
    """

    from_pixel: FloatArray
    to_pixel: FloatArray
    front: float
    lens: LensArrays


def lens_arrays(model: str, camera_matrix: FloatArray, terms: ArrayLike) -> LensArrays:
    """Arrays of a lens; ``camera_matrix`` (3, 3), ``terms`` of the model."""
    k = camera_matrix
    camera = np.array([k[0, 0], k[1, 1], k[0, 2], k[1, 2]])
    given = np.asarray(terms, dtype=np.float64)
    five = np.pad(given, (0, 5 - given.size))
    for array in (camera, five):
        array.setflags(write=False)
    if model == "fisheye":
        return LensArrays(FISHEYE, camera, five, math.tan(_fisheye_reach_rad(five)))
    if not five.any():
        return LensArrays(STRAIGHT, camera, five, math.inf)
    return LensArrays(BROWN, camera, five, _brown_reach(five))


def folds(lens: LensArrays) -> bool:
    """True if the lens turns back somewhere, rather than looking sideways."""
    if lens.model == FISHEYE:
        return math.atan(lens.reach) < MOST_ANGLE_RAD - 1e-9
    return lens.model == BROWN and lens.reach < _MOST_RADIUS


def _fisheye_reach_rad(terms: FloatArray) -> float:
    """Largest angle up to which theta_d grows; a step of 0.05 degrees on the safe side."""
    k1, k2, k3, k4, _ = terms
    angle = np.linspace(0.0, MOST_ANGLE_RAD, _ANGLES)
    a2 = angle * angle
    slope = 1.0 + a2 * (3.0 * k1 + a2 * (5.0 * k2 + a2 * (7.0 * k3 + a2 * 9.0 * k4)))
    return float(angle[_before_the_first(slope < LEAST_STRETCH)])


def _brown_reach(terms: FloatArray) -> float:
    """Radius of the disc in which the Jacobian's smaller eigenvalue is large enough."""
    radii = np.concatenate([np.linspace(0.0, 2.0, 401), np.linspace(2.0, _MOST_RADIUS, 361)[1:]])
    last = _before_the_first(_least_stretch(radii, terms) < LEAST_STRETCH)
    if last == len(radii) - 1:
        return _MOST_RADIUS
    finer = np.linspace(radii[last], radii[last + 1], 401)
    return float(finer[_before_the_first(_least_stretch(finer, terms) < LEAST_STRETCH)])


def _least_stretch(radii: FloatArray, terms: FloatArray) -> FloatArray:
    """Smaller eigenvalue of Brown's Jacobian, the least over all directions, (n,)."""
    k1, k2, p1, p2, k3 = terms
    turn = np.linspace(0.0, math.tau, _DIRECTIONS, endpoint=False)[:, None]
    x, y = radii * np.cos(turn), radii * np.sin(turn)
    r2 = radii * radii
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))
    xx = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    yy = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    xy = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    least = 0.5 * (xx + yy) - np.hypot(0.5 * (xx - yy), xy)
    return np.asarray(least.min(axis=0))


def _before_the_first(bad: NDArray[np.bool_]) -> int:
    return max(int(np.argmax(bad)) - 1, 0) if bad.any() else len(bad) - 1

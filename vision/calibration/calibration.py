"""Where pixels become metres: lens, homography to the arena's floor, and heights above it.

Rules and units
- Pixels are those of the raw picture, centres at integers. *Undistorted* pixels are what an
  ideal pinhole camera with the same camera matrix would see.
- The arena is in metres, x right, y up, z towards the camera; its floor is z = 0. Seen from
  above it is never mirrored: a calibration that mirrors is refused.
- ``arena_from_pixel`` is the homography from undistorted pixels to the floor.
- The lens model is Brown's with up to five terms in OpenCV's order (k1, k2, p1, p2, k3), in
  coordinates normalised by the camera matrix.
- A point at height h over p is seen where a point of the floor at c + (p - c) H / (H - h)
  would be, with c the point below the camera and H the camera's height, whatever its tilt.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from planner.scene import printable

FloatArray = NDArray[np.float64]

_MIN_STRETCH = 1e-3
"""The lens model counts as folded where its Jacobian's determinant falls below this."""


class CalibrationError(ValueError):
    """A calibration cannot be used, made or read; the message says what and where."""

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A camera over an arena.

    ``size`` (width, height) px; ``camera_matrix`` (3, 3) without skew; ``distortion`` (5,);
    ``arena_from_pixel`` (3, 3), scaled so that its last element is 1 or its norm is;
    ``camera_center_m`` (x, y, height) in the arena, None where it is unknown: then nothing
    above the floor can be placed. ``lens_rms_px`` and ``arena_rms_m`` are the residuals it
    was made with (None: none were), ``remarks`` what was left out or is weak.
    Raises ``CalibrationError`` for anything that no camera can be.
    """

    size: tuple[int, int]
    camera_matrix: FloatArray
    distortion: FloatArray
    arena_from_pixel: FloatArray
    camera_center_m: tuple[float, float, float] | None = None
    lens_rms_px: float | None = None
    arena_rms_m: float | None = None
    remarks: tuple[str, ...] = ()
    _pixel_from_arena: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        width, height = self.size
        if not (0 < width <= 65536 and 0 < height <= 65536):
            raise CalibrationError(f"size = {self.size}: must be in 1..65536 pixels")
        camera = _matrix("camera_matrix", self.camera_matrix, (3, 3))
        if not (camera[0, 0] > 0.0 and camera[1, 1] > 0.0):
            raise CalibrationError("camera_matrix: the focal lengths must be > 0")
        if np.any(camera[[0, 1, 2, 2], [1, 0, 0, 1]] != 0.0) or camera[2, 2] != 1.0:
            raise CalibrationError("camera_matrix: must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
        given = np.asarray(self.distortion, dtype=np.float64).reshape(-1)
        if given.size > 5:
            raise CalibrationError(f"distortion: {given.size} terms: must be at most 5")
        lens = _matrix("distortion", np.pad(given, (0, 5 - given.size)), (5,))
        homography = _matrix("arena_from_pixel", self.arena_from_pixel, (3, 3))
        for name, value in (
            ("camera_matrix", camera),
            ("distortion", lens),
            ("arena_from_pixel", homography),
        ):
            object.__setattr__(self, name, value)
        _refuse_fold(self)
        _refuse_mirror(self)
        inverse = np.array(np.linalg.inv(homography), dtype=np.float64)
        inverse.setflags(write=False)
        object.__setattr__(self, "_pixel_from_arena", inverse)
        center = self.camera_center_m
        if center is not None and not (
            len(center) == 3 and all(math.isfinite(v) for v in center) and center[2] > 0.0
        ):
            raise CalibrationError(
                f"camera_center_m = {center}: must be finite (x, y, height) with a height > 0"
            )

    @classmethod
    def from_scale(
        cls,
        metres_per_pixel: float,
        size: tuple[int, int],
        camera_center_m: tuple[float, float, float] | None = None,
    ) -> Calibration:
        """A picture that is a plan to scale: no lens, y up, (0, 0) at its lower left corner."""
        if not (math.isfinite(metres_per_pixel) and metres_per_pixel > 0.0):
            raise CalibrationError(f"metres_per_pixel = {metres_per_pixel}: must be > 0")
        s, height = metres_per_pixel, size[1]
        plan = np.array([[s, 0.0, 0.5 * s], [0.0, -s, (height - 0.5) * s], [0.0, 0.0, 1.0]])
        return cls(size, nominal_camera_matrix(size), np.zeros(5), plan, camera_center_m)

    @classmethod
    def from_camera(
        cls,
        size: tuple[int, int],
        camera_matrix: ArrayLike,
        distortion: ArrayLike,
        camera_from_arena: ArrayLike,
    ) -> Calibration:
        """From a camera of known lens and pose; ``camera_from_arena`` is (3, 4), [R | t]."""
        camera = np.asarray(camera_matrix, dtype=np.float64)
        pose = _matrix("camera_from_arena", camera_from_arena, (3, 4))
        center = -pose[:, :3].T @ pose[:, 3]
        pixel_from_arena = camera @ pose[:, [0, 1, 3]]
        return cls(
            size,
            camera,
            np.asarray(distortion, dtype=np.float64),
            _scaled(np.asarray(np.linalg.inv(pixel_from_arena), dtype=np.float64)),
            (float(center[0]), float(center[1]), float(center[2])),
        )

    def arena_from_image(self, points_px: ArrayLike, height_m: float = 0.0) -> FloatArray:
        """Raw pixels (n, 2) to metres (n, 2) of what is ``height_m`` above the floor."""
        floor = _apply(self.arena_from_pixel, self.undistort_points(points_px))
        if height_m == 0.0:
            return floor
        foot, shrink = self._parallax(height_m)
        return foot + (floor - foot) * shrink

    def plane_from_pixel(self, height_m: float = 0.0) -> FloatArray:
        """The homography (3, 3) from undistorted pixels to the plane at ``height_m``."""
        if height_m == 0.0:
            return self.arena_from_pixel
        foot, shrink = self._parallax(height_m)
        lift = np.diag([shrink, shrink, 1.0])
        lift[:2, 2] = foot * (1.0 - shrink)
        return np.asarray(lift @ self.arena_from_pixel)

    def image_from_arena(self, points_m: ArrayLike, height_m: float = 0.0) -> FloatArray:
        """Metres (n, 2) at ``height_m`` above the floor to raw pixels (n, 2)."""
        points = _points(points_m)
        if height_m != 0.0:
            foot, shrink = self._parallax(height_m)
            points = foot + (points - foot) / shrink
        return self.distort_points(_apply(self._pixel_from_arena, points))

    @property
    def metres_per_pixel(self) -> float:
        """The nominal scale of the floor, at the picture's centre."""
        x, y = (self.size[0] - 1) / 2.0, (self.size[1] - 1) / 2.0
        around = self.arena_from_image([(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)])
        (ax, ay), (bx, by) = (around[1] - around[0]) / 2.0, (around[3] - around[2]) / 2.0
        return math.sqrt(abs(ax * by - ay * bx))

    def undistort_points(self, points_px: ArrayLike) -> FloatArray:
        """Raw pixels (n, 2) to undistorted ones, by Newton's method on the lens model."""
        raw = _points(points_px)
        if not self.distortion.any():
            return raw.copy()
        # Imported late: a plan to scale has no lens and needs no compiled code.
        from vision.calibration.calibration_kernels import undistort_all

        k = self.camera_matrix
        camera = np.array([k[0, 0], k[1, 1], k[0, 2], k[1, 2]])
        return undistort_all(np.array(raw, order="C"), camera, self.distortion)

    def distort_points(self, points_px: ArrayLike) -> FloatArray:
        """Undistorted pixels (n, 2) to raw ones."""
        ideal = _points(points_px)
        if not self.distortion.any():
            return ideal.copy()
        return self._pixels(_lens(self._normalised(ideal), self.distortion)[0])

    def _normalised(self, pixels: FloatArray) -> FloatArray:
        k = self.camera_matrix
        return np.asarray((pixels - k[:2, 2]) / np.array([k[0, 0], k[1, 1]]))

    def _pixels(self, normalised: FloatArray) -> FloatArray:
        k = self.camera_matrix
        return np.asarray(normalised * np.array([k[0, 0], k[1, 1]]) + k[:2, 2])

    def _parallax(self, height_m: float) -> tuple[FloatArray, float]:
        """The point below the camera, and (H - h) / H."""
        center = self.camera_center_m
        if center is None:
            raise CalibrationError(
                f"height_m = {height_m}: the camera's own place is unknown, so nothing above "
                "the floor can be placed; calibrate the lens or give the camera's height"
            )
        if not height_m < center[2]:
            raise CalibrationError(
                f"height_m = {height_m}: must be below the camera at {center[2]:.3f} m"
            )
        return np.array(center[:2]), (center[2] - height_m) / center[2]


def nominal_camera_matrix(size: tuple[int, int]) -> FloatArray:
    """A stand-in for an unknown lens: the picture's centre, a focal length of its longer side."""
    width, height = size
    f = float(max(width, height))
    return np.array([[f, 0.0, (width - 1) / 2.0], [0.0, f, (height - 1) / 2.0], [0.0, 0.0, 1.0]])


def camera_center(
    camera_matrix: FloatArray, arena_from_pixel: FloatArray
) -> tuple[float, float, float]:
    """The camera's (x, y, height) in the arena, from its matrix and the floor's homography.

    Source: Zhang, A flexible new technique for camera calibration (2000): the homography is
    K [r1 r2 t] up to scale; the rotation is made orthonormal by a singular value decomposition.
    """
    columns = np.linalg.solve(camera_matrix, np.linalg.inv(arena_from_pixel))
    columns /= (np.linalg.norm(columns[:, 0]) + np.linalg.norm(columns[:, 1])) / 2.0
    if columns[2, 2] < 0.0:
        columns = -columns
    first, second, shift = columns.T
    u, _, vt = np.linalg.svd(np.stack([first, second, np.cross(first, second)], axis=1))
    center = -(u @ vt).T @ shift
    return float(center[0]), float(center[1]), float(center[2])


def _lens(
    points: FloatArray, terms: FloatArray
) -> tuple[FloatArray, tuple[FloatArray, FloatArray, FloatArray]]:
    """Brown's model on normalised points (n, 2), with the Jacobian's (xx, xy = yx, yy)."""
    k1, k2, p1, p2, k3 = terms
    x, y = points[:, 0], points[:, 1]
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))
    moved = np.empty_like(points)
    moved[:, 0] = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    moved[:, 1] = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    xx = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    yy = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    xy = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    return moved, (xx, xy, yy)


def _apply(homography: FloatArray, points: FloatArray) -> FloatArray:
    moved = points @ homography[:, :2].T + homography[:, 2]
    return np.asarray(moved[:, :2] / moved[:, 2:])


def _points(points: ArrayLike) -> FloatArray:
    array = np.asarray(points, dtype=np.float64)
    if array.size == 0:
        return np.empty((0, 2))
    if array.shape[-1] != 2:
        raise CalibrationError(f"points of shape {array.shape}: must be (n, 2)")
    return array.reshape(-1, 2)


def _matrix(name: str, value: ArrayLike, shape: Sequence[int]) -> FloatArray:
    array = np.array(value, dtype=np.float64)
    if array.shape != tuple(shape):
        raise CalibrationError(f"{name}: a shape of {array.shape}: must be {tuple(shape)}")
    if not np.isfinite(array).all():
        raise CalibrationError(f"{name}: must be finite")
    array.setflags(write=False)
    return array


def _scaled(homography: FloatArray) -> FloatArray:
    last = float(homography[2, 2])
    size = float(np.linalg.norm(homography))
    return np.asarray(homography / (last if abs(last) > 1e-6 * size else size))


def _border_of_picture(size: tuple[int, int]) -> FloatArray:
    width, height = size
    xs, ys = np.linspace(-0.5, width - 0.5, 9), np.linspace(-0.5, height - 0.5, 9)
    rim = [(x, y) for x in xs for y in (ys[0], ys[-1])] + [
        (x, y) for y in ys for x in (xs[0], xs[-1])
    ]
    return np.array(rim)


def _refuse_fold(calibration: Calibration) -> None:
    """A lens model whose Jacobian vanishes within the picture has no inverse there."""
    if not calibration.distortion.any():
        return
    rim = _border_of_picture(calibration.size)
    reached = calibration.undistort_points(rim)
    back = calibration.distort_points(reached)
    center = calibration.camera_matrix[:2, 2]
    rays = center + (reached - center) * np.linspace(0.0, 1.0, 33)[:, None, None]
    xx, xy, yy = _lens(calibration._normalised(rays.reshape(-1, 2)), calibration.distortion)[1]
    folded = bool(np.any((xx * yy - xy * xy < _MIN_STRETCH) | (xx + yy <= 0.0)))
    if folded or not np.abs(back - rim).max() < 1e-3:
        raise CalibrationError("distortion: the lens model folds within the picture")


def _refuse_mirror(calibration: Calibration) -> None:
    """The floor must be in front of the camera all over the picture, and y must point up."""
    h = calibration.arena_from_pixel
    norm = float(np.linalg.norm(h[:2, :2]))
    determinant = float(np.linalg.det(h))
    if norm == 0.0 or abs(determinant) < 1e-12 * norm * norm * abs(h[2, 2]):
        raise CalibrationError("arena_from_pixel: does not map the picture onto a plane")
    rim = calibration.undistort_points(_border_of_picture(calibration.size))
    depth = rim @ h[2, :2] + h[2, 2]
    if not (np.all(depth > 0.0) or np.all(depth < 0.0)):
        raise CalibrationError("arena_from_pixel: the floor's horizon lies within the picture")
    if determinant * depth[0] > 0.0:
        raise CalibrationError(
            "arena_from_pixel: mirrors the arena; seen from above, x must point right when y "
            "points up: check the signs of the surveyed points"
        )

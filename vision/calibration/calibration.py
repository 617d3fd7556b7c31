"""A camera's calibration: lens, homography to the arena's floor, and heights above it.

Rules and units
- Pixels are those of the raw picture, centres at integers. *Undistorted* pixels are those of an
  ideal pinhole camera with the same camera matrix.
- The arena is in metres, x right, y up, z towards the camera; its floor is z = 0. A calibration
  that mirrors the arena, seen from above, is refused.
- ``arena_from_pixel`` is the homography from undistorted pixels to the floor.
- The lens model is Brown's or OpenCV's fisheye model (``vision.calibration.lens_model``). Pixels
  that no ray within the lens's reach produces, or behind the floor's horizon, are NaN.
- A point at height h over p looks like the floor's c + (p - c) H / (H - h), with c the point below
  the camera and H its height.
"""

from __future__ import annotations

import math
import operator
import reprlib
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from planner.scene import Bounds, printable
from vision.calibration.lens_model import (
    MODELS,
    MOST_TERMS,
    STRAIGHT,
    LensArrays,
    PlaneView,
    folds,
    lens_arrays,
)

FloatArray = NDArray[np.float64]

LEAST_SHOWN = 0.5
"""Least part of a picture that a folding lens must show once; less is a wrong file."""
_AS_IT_IS = np.eye(3)
_AS_IT_IS.setflags(write=False)
"""Homography to the undistorted pixels themselves."""
_PLANES_KEPT = 64
"""Heights whose homographies are kept: more than robots have markers."""
_MOST_TILT_RAD = math.radians(45.0)
"""Most tilt, between the floor's normal and the middle of a picture with a horizon: beyond it the
camera looks along the floor."""


class CalibrationError(ValueError):
    """Error for a calibration that cannot be used, made or read."""

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A camera over an arena.

    ``size`` (width, height) px; ``camera_matrix`` (3, 3) without skew; ``distortion`` (5,) of
    ``lens_model`` ``brown``, fewer are padded, or exactly (4,) of ``fisheye``; ``arena_from_pixel``
    (3, 3), scaled to a last element or a norm of 1; ``camera_center_m`` (x, y, height) in the
    arena, or None: then nothing above the floor can be placed. ``lens_rms_px`` and ``arena_rms_m``
    are its residuals, if any, ``remarks`` its weaknesses. Raises ``CalibrationError`` for values
    that no camera can have.
    """

    size: tuple[int, int]
    camera_matrix: FloatArray
    distortion: FloatArray
    arena_from_pixel: FloatArray
    camera_center_m: tuple[float, float, float] | None = None
    lens_rms_px: float | None = None
    arena_rms_m: float | None = None
    remarks: tuple[str, ...] = ()
    lens_model: str = "brown"
    lens: LensArrays = field(init=False, repr=False, compare=False)
    _front: float = field(init=False, repr=False, compare=False)
    _pixel_from_arena: FloatArray = field(init=False, repr=False, compare=False)
    _planes: dict[float, PlaneView] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        width, height = _whole_size(self.size)
        if not (0 < width <= 65536 and 0 < height <= 65536):
            raise CalibrationError(f"size = {self.size}: must be in 1..65536 pixels")
        camera = _matrix("camera_matrix", self.camera_matrix, (3, 3))
        if not (camera[0, 0] > 0.0 and camera[1, 1] > 0.0):
            raise CalibrationError("camera_matrix: the focal lengths must be > 0")
        if np.any(camera[[0, 1, 2, 2], [1, 0, 0, 1]] != 0.0) or camera[2, 2] != 1.0:
            raise CalibrationError("camera_matrix: must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
        distortion = _terms(self.lens_model, self.distortion)
        homography = _matrix("arena_from_pixel", self.arena_from_pixel, (3, 3))
        for name, value in (
            ("camera_matrix", camera),
            ("distortion", distortion),
            ("arena_from_pixel", homography),
            ("lens", lens_arrays(self.lens_model, camera, distortion)),
        ):
            object.__setattr__(self, name, value)
        _refuse_fold(self)
        object.__setattr__(self, "_front", _front_of(self))
        inverse = np.array(np.linalg.inv(homography), dtype=np.float64)
        inverse.setflags(write=False)
        object.__setattr__(self, "_pixel_from_arena", inverse)
        floor = PlaneView(homography, inverse, self._front, self.lens)
        object.__setattr__(self, "_planes", {0.0: floor})
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
        """Calibration of a plan to scale: no lens, y up, (0, 0) at its lower left corner."""
        try:
            is_scale = math.isfinite(metres_per_pixel) and metres_per_pixel > 0.0
        except TypeError:
            is_scale = False
        if not is_scale:
            raise CalibrationError(f"metres_per_pixel = {metres_per_pixel!r}: must be > 0")
        s, height = metres_per_pixel, _whole_size(size)[1]
        plan = np.array([[s, 0.0, 0.5 * s], [0.0, -s, (height - 0.5) * s], [0.0, 0.0, 1.0]])
        return cls(size, nominal_camera_matrix(size), np.zeros(5), plan, camera_center_m)

    @classmethod
    def from_camera(
        cls,
        size: tuple[int, int],
        camera_matrix: ArrayLike,
        distortion: ArrayLike,
        camera_from_arena: ArrayLike,
        lens_model: str = "brown",
    ) -> Calibration:
        """Calibration from a camera's lens and pose; ``camera_from_arena`` is (3, 4), [R | t]."""
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
            lens_model=lens_model,
        )

    def arena_from_image(self, points_px: ArrayLike, height_m: float = 0.0) -> FloatArray:
        """Raw pixels (n, 2) to metres (n, 2) at ``height_m`` above the floor.

        NaN where the lens folds or behind the horizon.
        """
        homography = self.plane_from_pixel(height_m)
        if self.lens.model == STRAIGHT:
            return _apply(homography, _points(points_px), self._front)
        # imported late: a plan to scale needs no compiled code
        from vision.calibration.calibration_kernels import plane_from_image

        points = np.array(_points(points_px), order="C")
        return np.asarray(plane_from_image(points, homography, self._front, self.lens))

    def plane_from_pixel(self, height_m: float = 0.0) -> FloatArray:
        """The homography (3, 3) from undistorted pixels to the plane at ``height_m``."""
        return self.plane_view(height_m).from_pixel

    def image_from_arena(self, points_m: ArrayLike, height_m: float = 0.0) -> FloatArray:
        """Metres (n, 2) at ``height_m`` above the floor to raw pixels (n, 2); NaN out of sight."""
        homography = self.plane_view(height_m).to_pixel
        if self.lens.model == STRAIGHT:
            return _apply(homography, _points(points_m), self._front)
        from vision.calibration.calibration_kernels import image_from_plane

        points = np.array(_points(points_m), order="C")
        return np.asarray(image_from_plane(points, homography, self._front, self.lens))

    @property
    def metres_per_pixel(self) -> float:
        """Nominal scale of the floor, at the picture's centre."""
        x, y = (self.size[0] - 1) / 2.0, (self.size[1] - 1) / 2.0
        around = self.arena_from_image([(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)])
        (ax, ay), (bx, by) = (around[1] - around[0]) / 2.0, (around[3] - around[2]) / 2.0
        return math.sqrt(abs(ax * by - ay * bx))

    @property
    def blind(self) -> NDArray[np.bool_] | None:
        """Pixels (h, w) that show no floor to drive on, if any."""
        from vision.calibration.blind import blind_pixels

        return blind_pixels(self)

    def blind_plan(self, bounds: Bounds) -> tuple[NDArray[np.bool_], Calibration] | None:
        """Unseen part of the bounds, a plan (h, w) with its calibration; None if all is seen."""
        from vision.calibration.blind import blind_plan

        plan = blind_plan(self, bounds)
        if plan is None:
            return None
        (x, y), step = plan.first_m, plan.step_m
        size = (plan.blind.shape[1], plan.blind.shape[0])
        floor = np.array([[step, 0.0, x], [0.0, -step, y], [0.0, 0.0, 1.0]])
        return plan.blind, Calibration(size, nominal_camera_matrix(size), np.zeros(5), floor)

    def undistort_points(self, points_px: ArrayLike) -> FloatArray:
        """Raw pixels (n, 2) to undistorted ones, by Newton's method; NaN where the lens folds."""
        raw = _points(points_px)
        if self.lens.model == STRAIGHT:
            return raw.copy()
        # imported late: a plan to scale needs no compiled code
        from vision.calibration.calibration_kernels import plane_from_image

        return np.asarray(plane_from_image(np.array(raw, order="C"), _AS_IT_IS, 1.0, self.lens))

    def plane_view(self, height_m: float = 0.0) -> PlaneView:
        """The plane at ``height_m`` and its picture, for kernels."""
        known = self._planes.get(height_m)
        if known is not None:
            return known
        foot, shrink = self._parallax(height_m)
        lift = np.diag([shrink, shrink, 1.0])
        lift[:2, 2] = foot * (1.0 - shrink)
        there = lift @ self.arena_from_pixel
        back = self._pixel_from_arena @ np.linalg.inv(lift)
        for homography in (there, back):
            homography.setflags(write=False)
        if len(self._planes) >= _PLANES_KEPT:
            self._planes.clear()
        view = PlaneView(there, back, self._front, self.lens)
        self._planes[height_m] = view
        return view

    def _parallax(self, height_m: float) -> tuple[FloatArray, float]:
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
    """Stand-in for an unknown lens: the picture's centre, a focal length of its longer side."""
    width, height = size
    f = float(max(width, height))
    return np.array([[f, 0.0, (width - 1) / 2.0], [0.0, f, (height - 1) / 2.0], [0.0, 0.0, 1.0]])


def plane_pose(columns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3) and shift (3,), camera from plane, of [r1 r2 t] (3, 3) up to scale.

    Zhang, A flexible new technique for camera calibration (2000), 3.1 and appendix C: a singular
    value decomposition makes the rotation orthonormal.
    """
    columns = columns / ((np.linalg.norm(columns[:, 0]) + np.linalg.norm(columns[:, 1])) / 2.0)
    if columns[2, 2] < 0.0:
        columns = -columns
    first, second, shift = columns.T
    u, _, vt = np.linalg.svd(np.stack([first, second, np.cross(first, second)], axis=1))
    return np.asarray(u @ vt), np.asarray(shift)


def camera_center(
    camera_matrix: FloatArray, arena_from_pixel: FloatArray
) -> tuple[float, float, float]:
    """The camera's (x, y, height) in the arena, from its matrix and the floor's homography."""
    rotation, shift = plane_pose(np.linalg.solve(camera_matrix, np.linalg.inv(arena_from_pixel)))
    center = -rotation.T @ shift
    return float(center[0]), float(center[1]), float(center[2])


def _apply(homography: FloatArray, points: FloatArray, front: float) -> FloatArray:
    """Move the points; NaN behind the camera, where the third coordinate is not ``front``."""
    moved = points @ homography[:, :2].T + homography[:, 2]
    moved[~(moved[:, 2] * front > 0.0)] = np.nan
    return np.asarray(moved[:, :2] / moved[:, 2:])


def _whole_size(size: Sequence[int]) -> tuple[int, int]:
    try:
        width, height = map(operator.index, size)
    except (TypeError, ValueError):
        raise CalibrationError(f"size = {reprlib.repr(size)}: must be width and height") from None
    return width, height


def _points(points: ArrayLike) -> FloatArray:
    try:
        array = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        raise CalibrationError("points: must be numbers (n, 2)") from None
    if array.size == 0:
        return np.empty((0, 2))
    if array.shape[-1:] != (2,):
        raise CalibrationError(f"points of shape {array.shape}: must be (n, 2)")
    return array.reshape(-1, 2)


def _matrix(name: str, value: ArrayLike, shape: Sequence[int]) -> FloatArray:
    array = np.array(value, dtype=np.float64, order="C")
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


def _terms(model: str, distortion: ArrayLike) -> FloatArray:
    """Terms of the lens, checked: Brown's padded to five, the fisheye's exactly four."""
    if model not in MODELS:
        raise CalibrationError(f"lens_model: {str(model)[:24]!r}: must be {' or '.join(MODELS)}")
    given = np.asarray(distortion, dtype=np.float64).reshape(-1)
    most = MOST_TERMS[model]
    if model == "fisheye" and given.size != most:
        raise CalibrationError(f"distortion: {given.size} terms: the fisheye model has {most}")
    if given.size > most:
        raise CalibrationError(f"distortion: {given.size} terms: must be at most {most}")
    return _matrix("distortion", np.pad(given, (0, most - given.size)), (most,))


def _sample_of_picture(size: tuple[int, int]) -> FloatArray:
    """Sample pixels (n, 2), with the rim; the middle comes first."""
    width, height = size
    xs, ys = np.linspace(-0.5, width - 0.5, 33), np.linspace(-0.5, height - 0.5, 33)
    grid = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    return np.vstack([[((width - 1) / 2.0, (height - 1) / 2.0)], grid])


def _refuse_fold(calibration: Calibration) -> None:
    """Refuse a lens that does not show the picture's middle, or folds and shows too little."""
    if calibration.lens.model == STRAIGHT:
        return
    shown = np.isfinite(calibration.undistort_points(_sample_of_picture(calibration.size))[:, 0])
    share = float(shown[1:].mean())
    if not shown[0] or (folds(calibration.lens) and share < LEAST_SHOWN):
        raise CalibrationError(
            f"distortion: the lens model folds within the picture: it shows {100.0 * share:.0f} %"
            f" of it once, must show its middle and {100.0 * LEAST_SHOWN:.0f} %"
        )


def _front_of(calibration: Calibration) -> float:
    """Sign of the homography's third coordinate in front of the camera.

    Raises ``CalibrationError`` if y would not point up, or the camera looks along the floor.
    """
    h = calibration.arena_from_pixel
    norm = float(np.linalg.norm(h[:2, :2]))
    determinant = float(np.linalg.det(h))
    if norm == 0.0 or abs(determinant) < 1e-12 * norm * norm * abs(h[2, 2]):
        raise CalibrationError("arena_from_pixel: does not map the picture onto a plane")
    ideal = calibration.undistort_points(_sample_of_picture(calibration.size))
    depth = ideal[np.isfinite(ideal[:, 0])] @ h[2, :2] + h[2, 2]
    front = float(np.sign(depth[0]))
    if not np.all(depth * front > 0.0):
        k = calibration.camera_matrix
        normal = h[2] @ k
        ray = np.linalg.solve(k, np.array([*ideal[0], 1.0]))
        cosine = abs(float(normal @ ray)) / float(np.linalg.norm(normal) * np.linalg.norm(ray))
        if cosine < math.cos(_MOST_TILT_RAD):
            raise CalibrationError("arena_from_pixel: the floor's horizon lies within the picture")
    if determinant * front > 0.0:
        raise CalibrationError(
            "arena_from_pixel: mirrors the arena; seen from above, x must point right when y "
            "points up: check the signs of the surveyed points"
        )
    return front

"""Geometry of the simulated camera: a pinhole with lens distortion above the arena.

Frames: arena (metres, x right, y up, z towards the camera), camera (x right, y down, z along the
view) and image (pixels, centres at integers). Distortion follows OpenCV's model of five terms: k1,
k2, p1, p2, k3 on normalised coordinates (Brown, 1966), or its fisheye model of four terms on the
angle to the view (Kannala and Brandt, 2006). It is a second implementation, since vision's own is
judged by it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navigation.config import Config
from navigation.config.simulation import SimulatedCameraSection, SimulatedKnockSection
from planner.scene import FloatArray
from vision.calibration.calibration import Calibration

UNDISTORT_STEPS = 20
"""Newton steps when a distorted point is traced back; 4 suffice for mild lenses."""
UNDISTORT_TOLERANCE = 1e-13
SLOPE_STEP = 1e-6
TINY = 1e-300
"""Stands in for a radius of 0."""
FISHEYE_TABLE = 4001
FISHEYE_MOST_RAD = math.radians(89.95)
FISHEYE_LEAST_GROWTH = 0.02
"""A fisheye's picture ends where it shrinks a length by more than 50."""


@dataclass(frozen=True, slots=True)
class Pinhole:
    """Rays and pixels of a camera.

    ``size_px`` (w, h); ``matrix`` (3, 3); ``distortion`` (5,), or (4,) if ``lens_model`` is
    ``fisheye``; ``camera_from_arena`` (3, 3) rotation; ``position_m`` (3,) of the lens. Arrays are
    read-only.
    """

    size_px: tuple[int, int]
    matrix: FloatArray
    distortion: FloatArray
    camera_from_arena: FloatArray
    position_m: FloatArray
    lens_model: str = "brown"

    def __post_init__(self) -> None:
        for name in ("matrix", "distortion", "camera_from_arena", "position_m"):
            array = np.array(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def image_from_arena(self, points_m: FloatArray, height_m: float = 0.0) -> FloatArray:
        """Pixels (n, 2) of arena points (n, 2) at one height, or of points (n, 3).

        Points out of a fisheye's view lie on its rim.
        """
        points = np.asarray(points_m, dtype=np.float64)
        points = points.reshape(-1, points.shape[-1])
        if points.shape[1] == 2:
            points = np.column_stack([points, np.full(len(points), height_m)])
        return self.image_from_camera(self.camera_from_points(points))

    def camera_from_points(self, points_m: FloatArray) -> FloatArray:
        """Arena points (n, 3) in the camera's frame."""
        return np.asarray((points_m - self.position_m) @ self.camera_from_arena.T)

    def image_from_camera(self, in_camera: FloatArray) -> FloatArray:
        """Pixels (n, 2) of points (n, 3) of the camera's frame, as `image_from_arena`."""
        if self.lens_model == "fisheye":
            distorted = fisheye_distort(in_camera, self.distortion)
        else:
            distorted = distort(in_camera[:, :2] / in_camera[:, 2:], self.distortion)
        return np.asarray(distorted @ self.matrix[:2, :2].T + self.matrix[:2, 2])

    def rays(self, points_px: FloatArray) -> FloatArray:
        """Normalised camera coordinates (n, 2), free of distortion, of the pixels' rays.

        NaN outside a fisheye's view.
        """
        points = np.asarray(points_px, dtype=np.float64).reshape(-1, 2)
        distorted = (points - self.matrix[:2, 2]) @ np.linalg.inv(self.matrix[:2, :2]).T
        if self.lens_model == "fisheye":
            return fisheye_undistort(distorted, self.distortion)
        return undistort(distorted, self.distortion)

    def arena_from_image(self, points_px: FloatArray, height_m: float = 0.0) -> FloatArray:
        """Arena points (n, 2) at one height that pixels (n, 2) look at."""
        seen = np.column_stack([self.rays(points_px), np.ones(np.size(points_px) // 2)])
        mapped = seen @ self.plane_from_ray(height_m).T
        return np.asarray(mapped[:, :2] / mapped[:, 2:])

    def plane_from_ray(self, height_m: float) -> FloatArray:
        """Homography (3, 3) from normalised rays to the arena's plane at a height."""
        return self.sheet_from_ray(np.eye(3), np.array([0.0, 0.0, height_m]))

    def sheet_from_ray(self, arena_from_sheet: FloatArray, origin_m: FloatArray) -> FloatArray:
        """Homography (3, 3) from normalised rays to coordinates on a sheet in space.

        The sheet's x and y axes are the rotation's first two columns; its origin is at ``origin_m``
        (3,) in the arena.
        """
        x_axis, y_axis, _ = self.camera_from_arena @ arena_from_sheet.T[:, :, None]
        origin = self.camera_from_arena @ (origin_m - self.position_m)
        ray_from_sheet = np.column_stack([x_axis, y_axis, origin])
        return np.asarray(np.linalg.inv(ray_from_sheet))

    def calibration(self) -> Calibration:
        """Perfect calibration of this camera."""
        shift = -self.camera_from_arena @ self.position_m
        pose = np.column_stack([self.camera_from_arena, shift])
        return Calibration.from_camera(
            self.size_px, self.matrix, self.distortion, pose, self.lens_model
        )


def distort(undistorted: FloatArray, terms: FloatArray) -> FloatArray:
    """Distort normalised points (n, 2) by OpenCV's five terms."""
    k1, k2, p1, p2, k3 = terms
    x, y = undistorted.T
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return np.column_stack(
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    )


def undistort(distorted: FloatArray, terms: FloatArray) -> FloatArray:
    """Invert `distort` by Newton's method with numeric slopes.

    Raises ``ValueError`` without convergence: the lens folds the picture over.
    """
    points = np.array(distorted, dtype=np.float64)
    right, down = np.array([SLOPE_STEP, 0.0]), np.array([0.0, SLOPE_STEP])
    for _ in range(UNDISTORT_STEPS):
        error = distort(points, terms) - distorted
        if float(np.abs(error).max(initial=0.0)) < UNDISTORT_TOLERANCE:
            return points
        by_x = (distort(points + right, terms) - distort(points - right, terms)) / (2 * SLOPE_STEP)
        by_y = (distort(points + down, terms) - distort(points - down, terms)) / (2 * SLOPE_STEP)
        determinant = by_x[:, 0] * by_y[:, 1] - by_y[:, 0] * by_x[:, 1]
        points[:, 0] -= (by_y[:, 1] * error[:, 0] - by_y[:, 0] * error[:, 1]) / determinant
        points[:, 1] -= (by_x[:, 0] * error[:, 1] - by_x[:, 1] * error[:, 0]) / determinant
    raise ValueError("the lens distortion cannot be undone: the picture folds over")


def fisheye_distort(in_camera: FloatArray, terms: FloatArray) -> FloatArray:
    """Project points (n, 3) of the camera's frame by a fisheye, normalised (n, 2)."""
    angles, _ = _fisheye_curve(terms)
    across = np.hypot(in_camera[:, 0], in_camera[:, 1])
    angle = np.minimum(np.arctan2(across, in_camera[:, 2]), angles[-1])
    radius = _angle_seen(angle, terms)
    return np.asarray(in_camera[:, :2] * (radius / np.maximum(across, TINY))[:, None])


def fisheye_undistort(distorted: FloatArray, terms: FloatArray) -> FloatArray:
    """Invert `fisheye_distort` to rays (n, 2); NaN beyond its rim.

    A table of the curve gives the angle, then Newton's method refines it.
    """
    angles, seen = _fisheye_curve(terms)
    radius = np.hypot(distorted[:, 0], distorted[:, 1])
    angle = np.interp(radius, seen, angles)
    for _ in range(3):
        by = (_angle_seen(angle + SLOPE_STEP, terms) - _angle_seen(angle - SLOPE_STEP, terms)) / (
            2.0 * SLOPE_STEP
        )
        angle = angle - (_angle_seen(angle, terms) - radius) / by
    rays = distorted * (np.tan(angle) / np.maximum(radius, TINY))[:, None]
    rays[~(radius < seen[-1])] = np.nan
    return np.asarray(rays)


def _angle_seen(angle: FloatArray, terms: FloatArray) -> FloatArray:
    squares = angle * angle
    return np.asarray(angle * (1.0 + np.polyval([*terms[::-1], 0.0], squares)))


def _fisheye_curve(terms: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Angles to the view and their radii in the picture, up to the lens's fold or 90 degrees."""
    angles = np.linspace(0.0, FISHEYE_MOST_RAD, FISHEYE_TABLE)
    seen = _angle_seen(angles, terms)
    grows = np.diff(seen) > FISHEYE_LEAST_GROWTH * np.diff(angles)
    count = len(angles) if grows.all() else int(np.argmin(grows)) + 1
    return angles[:count], seen[:count]


def pinhole_of(config: Config, knock: SimulatedKnockSection | None = None) -> Pinhole:
    """Make the simulated camera of a configuration, after a ``knock`` if given.

    Raises ``ValueError`` without a section ``simulation``.
    """
    if config.simulation is None:
        raise ValueError("the configuration has no section 'simulation'")
    camera = config.simulation.camera
    if knock is not None:
        x, y, height = (a + b for a, b in zip(camera.position_m, knock.shift_m, strict=True))
        about_x, about_y = (a + b for a, b in zip(camera.tilt_deg, knock.tilt_deg, strict=True))
        camera = camera.model_copy(
            update={
                "position_m": (x, y, height),
                "tilt_deg": (about_x, about_y),
                "turn_deg": camera.turn_deg + knock.turn_deg,
            }
        )
    return _pinhole(camera, config.camera.size_px)


def _pinhole(camera: SimulatedCameraSection, size_px: tuple[int, int]) -> Pinhole:
    width, height = size_px
    right, down = camera.centre_offset_px
    matrix = np.array(
        [
            [camera.focal_px, 0.0, (width - 1) / 2 + right],
            [0.0, camera.focal_px, (height - 1) / 2 + down],
            [0.0, 0.0, 1.0],
        ]
    )
    about_x, about_y = (math.radians(angle) for angle in camera.tilt_deg)
    turn = math.radians(camera.turn_deg)
    looking_down = np.diag([1.0, -1.0, -1.0])
    rotation = _rotation(2, turn) @ _rotation(1, about_y) @ _rotation(0, about_x) @ looking_down
    return Pinhole(
        size_px, matrix, np.array(camera.distortion), rotation, np.array(camera.position_m),
        camera.lens_model,
    )  # fmt: skip


def _rotation(axis: int, angle_rad: float) -> FloatArray:
    """Rotation about the camera's x (0), y (1) or z (2) axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = math.cos(angle_rad)
    matrix[j, i] = math.sin(angle_rad)
    matrix[i, j] = -math.sin(angle_rad)
    return matrix

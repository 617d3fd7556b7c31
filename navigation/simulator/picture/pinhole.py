"""The simulated camera's geometry: a pinhole with lens distortion above the arena.

Frames: arena (metres, x right, y up, z towards the camera), camera (x right, y down, z along
the view) and image (pixels, centres at integers). Distortion follows OpenCV's model of five
terms: k1, k2, p1, p2, k3 on normalised coordinates (Brown, 1966).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navigation.config import Config
from navigation.config.simulation import SimulatedCameraSection
from planner.scene import FloatArray
from vision.calibration.calibration import Calibration

UNDISTORT_STEPS = 20
"""Newton steps when a distorted point is traced back; 4 suffice for mild lenses."""
UNDISTORT_TOLERANCE = 1e-13
SLOPE_STEP = 1e-6


@dataclass(frozen=True, slots=True)
class Pinhole:
    """Where pixels look.

    ``size_px`` (w, h); ``matrix`` (3, 3); ``distortion`` (5,); ``camera_from_arena`` (3, 3)
    rotation; ``position_m`` (3,) of the lens. Arrays are read-only.
    """

    size_px: tuple[int, int]
    matrix: FloatArray
    distortion: FloatArray
    camera_from_arena: FloatArray
    position_m: FloatArray

    def __post_init__(self) -> None:
        for name in ("matrix", "distortion", "camera_from_arena", "position_m"):
            array = np.array(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def image_from_arena(self, points_m: FloatArray, height_m: float = 0.0) -> FloatArray:
        """Pixels (n, 2) of arena points (n, 2) at one height, or of points (n, 3)."""
        points = np.asarray(points_m, dtype=np.float64)
        points = points.reshape(-1, points.shape[-1])
        if points.shape[1] == 2:
            points = np.column_stack([points, np.full(len(points), height_m)])
        in_camera = (points - self.position_m) @ self.camera_from_arena.T
        distorted = distort(in_camera[:, :2] / in_camera[:, 2:], self.distortion)
        return distorted @ self.matrix[:2, :2].T + self.matrix[:2, 2]

    def rays(self, points_px: FloatArray) -> FloatArray:
        """Normalised camera coordinates (n, 2), free of distortion, that pixels look along."""
        points = np.asarray(points_px, dtype=np.float64).reshape(-1, 2)
        distorted = (points - self.matrix[:2, 2]) @ np.linalg.inv(self.matrix[:2, :2]).T
        return undistort(distorted, self.distortion)

    def arena_from_image(self, points_px: FloatArray, height_m: float = 0.0) -> FloatArray:
        """Arena points (n, 2) at one height that pixels (n, 2) look at."""
        seen = np.column_stack([self.rays(points_px), np.ones(np.size(points_px) // 2)])
        mapped = seen @ self.plane_from_ray(height_m).T
        return np.asarray(mapped[:, :2] / mapped[:, 2:])

    def plane_from_ray(self, height_m: float) -> FloatArray:
        """The homography (3, 3) from normalised rays to the arena's plane at a height."""
        return self.sheet_from_ray(np.eye(3), np.array([0.0, 0.0, height_m]))

    def sheet_from_ray(self, arena_from_sheet: FloatArray, origin_m: FloatArray) -> FloatArray:
        """The homography (3, 3) from normalised rays to coordinates on a sheet in space.

        The sheet's x and y axes are the rotation's first two columns; its origin is at
        ``origin_m`` (3,) in the arena.
        """
        x_axis, y_axis, _ = self.camera_from_arena @ arena_from_sheet.T[:, :, None]
        origin = self.camera_from_arena @ (origin_m - self.position_m)
        ray_from_sheet = np.column_stack([x_axis, y_axis, origin])
        return np.asarray(np.linalg.inv(ray_from_sheet))

    def calibration(self) -> Calibration:
        """What a perfect calibration of this camera would find."""
        shift = -self.camera_from_arena @ self.position_m
        pose = np.column_stack([self.camera_from_arena, shift])
        return Calibration.from_camera(self.size_px, self.matrix, self.distortion, pose)


def distort(undistorted: FloatArray, terms: FloatArray) -> FloatArray:
    """Where a lens with OpenCV's five terms puts normalised points (n, 2)."""
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
    """The inverse of `distort`, by Newton's method with numeric slopes.

    Raises ``ValueError`` where it does not converge: the lens folds the picture over.
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


def pinhole_of(config: Config) -> Pinhole:
    """The simulated camera of a configuration that has a section ``simulation``."""
    if config.simulation is None:
        raise ValueError("the configuration has no section 'simulation'")
    return _pinhole(config.simulation.camera, config.camera.size_px)


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
        size_px, matrix, np.array(camera.distortion), rotation, np.array(camera.position_m)
    )


def _rotation(axis: int, angle_rad: float) -> FloatArray:
    """About the camera's x (0), y (1) or z (2) axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = math.cos(angle_rad)
    matrix[j, i] = math.sin(angle_rad)
    matrix[i, j] = -math.sin(angle_rad)
    return matrix

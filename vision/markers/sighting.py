"""One robot's marker in one picture: followed from its expected place, or seen where found.

Rules and units
- Poses, markers and pixels are as in `marked_robot`; a frame's rows are ``row_s`` seconds apart.
- Following fits sides and pattern at the expected place, where every cell and the light rim must
  read right.
- A marker of the wrong size, not square, or with misread cells is not a robot.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field

import numpy as np

from vision.calibration.calibration import Calibration, FloatArray
from vision.camera.camera import Image
from vision.markers.marked_robot import MarkedRobot, robot_pose
from vision.markers.marker_agreement_kernels import LEAST_READ
from vision.markers.marker_corners import why_refused
from vision.markers.marker_kernels import FITTED
from vision.markers.marker_place_kernels import follow_marker, see_marker
from vision.markers.tracking import Pose, Velocity

_UNIT_CORNERS = (-0.5 + 0.5j, 0.5 + 0.5j, 0.5 - 0.5j, -0.5 - 0.5j)
_SIZE_TOLERANCE = 0.15
_SQUARE_TOLERANCE = 0.02


@dataclass(frozen=True, slots=True)
class Sighting:
    """A robot's pose by its marker; the rest as in ``RobotPose``."""

    id: int
    pose: Pose
    corners_px: FloatArray
    residual_m: float
    error_px: float


@dataclass(frozen=True, slots=True)
class RobotMarker:
    """A robot's marker under one camera; ``bits`` (n, n) are its cells (`pattern_bits`)."""

    robot: MarkedRobot
    bits: FloatArray
    calibration: Calibration
    row_s: float
    _pixel_m: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_pixel_m", self.calibration.metres_per_pixel)

    def follow(self, grey: Image, expected: Pose, moves: Velocity) -> Sighting | None:
        """Sighting of the marker at its expected pose, if certainly there."""
        view = self.calibration.plane_view(self.robot.marker_height_m)
        corners, corners_px = np.empty((4, 2)), np.empty((4, 2))
        square = (*expected, self.robot.marker_size_m)
        read, error_px = follow_marker(grey, square, self.bits, view, corners, corners_px)
        if read < LEAST_READ:
            return None
        return self._sighting(corners, corners_px, error_px, moves, [])

    def look(
        self, grey: Image, quad_px: FloatArray, moves: Velocity, refusals: list[str]
    ) -> Sighting | None:
        """Sighting from a quadrilateral (4, 2) with the marker's code, unless impossible."""
        view = self.calibration.plane_view(self.robot.marker_height_m)
        corners, corners_px = np.empty((4, 2)), np.empty((4, 2))
        became, roughness_px, error_px = see_marker(
            grey, quad_px, self.bits, view, corners, corners_px
        )
        if became != FITTED:
            reason = why_refused(became, roughness_px)
            refusals.append(f"marker {self.robot.id}: {reason}")
            return None
        return self._sighting(corners, corners_px, error_px, moves, refusals)

    def at(self, corners_px: FloatArray, moves: Velocity, refusals: list[str]) -> Sighting | None:
        """Sighting from a marker's known corners (4, 2), unless it cannot be the robot's."""
        corners = self.calibration.arena_from_image(corners_px, self.robot.marker_height_m)
        if not np.isfinite(corners).all():
            refusals.append(f"marker {self.robot.id}: it lies where no floor is seen")
            return None
        return self._sighting(corners, np.array(corners_px), 0.0, moves, refusals)

    def _sighting(
        self,
        corners: FloatArray,
        corners_px: FloatArray,
        error_px: float,
        moves: Velocity,
        refusals: list[str],
    ) -> Sighting | None:
        corners_px.setflags(write=False)
        if self.row_s != 0.0:
            corners = self._at_one_time(corners, corners_px[:, 1], moves)
        center, turn, residual_m = nearest_square(corners)
        size_m = abs(turn)
        called, wanted_m = f"marker {self.robot.id}", self.robot.marker_size_m
        if abs(size_m - wanted_m) > _SIZE_TOLERANCE * wanted_m:
            refusals.append(f"{called}: a side of {1e3 * size_m:.1f} mm, not {1e3 * wanted_m:.1f}")
            return None
        if residual_m > _SQUARE_TOLERANCE * wanted_m:
            refusals.append(f"{called}: not square ({1e3 * residual_m:.1f} mm)")
            return None
        # a cover over part of the pattern draws its corners off a square's
        error_px = max(error_px, residual_m / self._pixel_m)
        pose = robot_pose((center.real, center.imag, cmath.phase(turn)), self.robot)
        return Sighting(self.robot.id, pose, corners_px, residual_m, error_px)

    def _at_one_time(self, corners: FloatArray, rows_px: FloatArray, moves: Velocity) -> FloatArray:
        late_s = self.row_s * (rows_px - rows_px.mean())
        right, up = (corners - corners.mean(axis=0)).T
        turn = moves.turn_rate_rad_s
        speeds = np.stack([moves.vx - turn * up, moves.vy + turn * right], axis=1)
        return np.asarray(corners - speeds * late_s[:, None], dtype=np.float64)


def nearest_square(corners: FloatArray) -> tuple[complex, complex, float]:
    """Square nearest to an upright marker's corners (4, 2): centre, side as a complex number in the
    direction ahead, and rms distance."""
    points = [complex(x, y) for x, y in corners.tolist()]
    center = sum(points) / 4.0
    pairs = [(point - center, unit) for point, unit in zip(points, _UNIT_CORNERS, strict=True)]
    turn = sum(off * unit.conjugate() for off, unit in pairs) / 2.0
    return center, turn, math.sqrt(sum(abs(off - turn * unit) ** 2 for off, unit in pairs) / 4.0)


def warm_up() -> None:
    """Compile or load the kernels: the first frame must not wait."""
    blank = np.zeros((32, 32), dtype=np.uint8)
    blank.setflags(write=False)
    plan = Calibration.from_scale(1.0, (32, 32))
    marker = RobotMarker(MarkedRobot(0, 16.0), np.zeros((6, 6)), plan, 0.0)
    square = np.array([(8.0, 8.0), (24.0, 8.0), (24.0, 24.0), (8.0, 24.0)])
    marker.look(blank, square, Velocity(), [])
    marker.follow(blank, (16.0, 16.0, 0.0), Velocity())

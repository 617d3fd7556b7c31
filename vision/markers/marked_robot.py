"""A robot with a marker on its back: both poses, and the area it hides.

- A pose is in the arena: metres, y up, heading counter-clockwise in (-pi, pi]. The marker's x axis
  runs from its top left to its top right corner (as printed upright); with ``marker_yaw_rad = 0``
  its right side is towards the robot's front.
- Pixels are raw, centres at integers; corners clockwise from the upright marker's top left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from vision.calibration.calibration import Calibration, FloatArray
from vision.markers.marker_search import MarkerError
from vision.markers.tracking import Pose, TrackLimits, wrap


@dataclass(frozen=True, slots=True)
class MarkedRobot:
    """A robot with a marker on its back.

    ``marker_size_m``: the black square's side. ``marker_height_m``: above the floor.
    ``marker_x_m``, ``marker_y_m``, ``marker_yaw_rad``: its centre and turn in the robot's frame (x
    ahead, y left).
    """

    id: int
    marker_size_m: float
    marker_height_m: float = 0.0
    marker_x_m: float = 0.0
    marker_y_m: float = 0.0
    marker_yaw_rad: float = 0.0
    limits: TrackLimits = field(default_factory=TrackLimits)

    def __post_init__(self) -> None:
        if self.id < 0:
            raise MarkerError(f"marker id = {self.id}: must be >= 0")
        if not (math.isfinite(self.marker_size_m) and self.marker_size_m > 0.0):
            raise MarkerError(f"marker_size_m = {self.marker_size_m}: must be > 0")
        if not (math.isfinite(self.marker_height_m) and self.marker_height_m >= 0.0):
            raise MarkerError(f"marker_height_m = {self.marker_height_m}: must be >= 0")


@dataclass(frozen=True, slots=True, eq=False)
class RobotPose:
    """Pose and velocity of a robot at ``captured_s``.

    ``corners_px`` (4, 2) raw pixels; ``residual_m``: the corners' rms distance from the fitted
    square. ``before_frame_s``: time from the exposure of the marker's rows to the frame's (a
    rolling shutter). ``corner_error_px``: standard error of the worst corner, larger if partly
    covered.
    """

    id: int
    x: float
    y: float
    heading_rad: float
    captured_s: float
    corners_px: FloatArray
    vx: float = 0.0
    vy: float = 0.0
    turn_rate_rad_s: float = 0.0
    residual_m: float = 0.0
    before_frame_s: float = 0.0
    corner_error_px: float = 0.0

    def at(self, time_s: float) -> Pose:
        """(x, y, heading) at another time, at constant velocity."""
        dt_s = time_s - self.captured_s
        heading = wrap(self.heading_rad + self.turn_rate_rad_s * dt_s)
        return self.x + self.vx * dt_s, self.y + self.vy * dt_s, heading


def robot_pose(marker: Pose, robot: MarkedRobot) -> Pose:
    """Robot's pose from its marker's."""
    heading = wrap(marker[2] - robot.marker_yaw_rad)
    c, s = math.cos(heading), math.sin(heading)
    x = marker[0] - c * robot.marker_x_m + s * robot.marker_y_m
    y = marker[1] - s * robot.marker_x_m - c * robot.marker_y_m
    return x, y, heading


def marker_pose(pose: Pose, robot: MarkedRobot) -> Pose:
    """Marker's pose from the robot's."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x = pose[0] + c * robot.marker_x_m - s * robot.marker_y_m
    y = pose[1] + s * robot.marker_x_m + c * robot.marker_y_m
    return x, y, wrap(pose[2] + robot.marker_yaw_rad)


def body_discs_px(
    pose: RobotPose | Pose,
    body_radius_m: float,
    calibration: Calibration,
    top_height_m: float = 0.0,
    margin_px: float = 3.0,
) -> FloatArray:
    """Discs (k, 3) of x, y, radius in raw pixels that cover a robot's body in the picture.

    The body is a cylinder from the floor to ``top_height_m``. No discs if the lens shows neither
    end whole: an unseen body is unknown ground.
    """
    x, y = (pose.x, pose.y) if isinstance(pose, RobotPose) else pose[:2]
    outline = _DISC * body_radius_m + (x, y)
    floor, top = (_seen_disc(calibration.image_from_arena(outline, h)) for h in (0.0, top_height_m))
    floor, top = floor or top, top or floor
    if floor is None or top is None:
        return np.empty((0, 3))
    # discs half a radius apart leave less than 4 % of a radius uncovered
    length = math.dist(top[:2], floor[:2])
    count = 1 if length < 0.5 else 1 + math.ceil(length / max(0.5 * min(floor[2], top[2]), 1.0))
    share = np.linspace(0.0, 1.0, count)[:, None] if count > 1 else np.ones((1, 1))
    discs = np.array(floor) * (1.0 - share) + np.array(top) * share
    discs[:, 2] = discs[:, 2] * 1.04 + margin_px
    return np.asarray(discs)


def _seen_disc(outline_px: FloatArray) -> tuple[float, float, float] | None:
    """Disc (x, y, radius) around the picture of `_DISC`; None unless all is seen."""
    x, y = outline_px[0].tolist()
    off = outline_px - outline_px[0]
    radius = math.sqrt((off * off).sum(axis=1).max())
    return None if math.isnan(radius) else (x, y, radius)


_TURNS = np.linspace(0.0, math.tau, 16, endpoint=False)
_DISC = np.vstack([[(0.0, 0.0)], np.column_stack([np.cos(_TURNS), np.sin(_TURNS)])])

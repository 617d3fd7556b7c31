"""One pose from several cameras' views of a robot's marker, each picture at its own time.

Rules and units
- Metres, radians, seconds. Each sighting makes a pose for its own time; velocity brings other
  cameras' recent sightings to it.
- Poses are weighted by the inverse of their covariance (Bar-Shalom, Estimation with applications to
  tracking and navigation, 2001, 8.3.3): errors of an edge in the picture, of the calibration and of
  the marker's height, and how far the robot may have left its velocity since.
- If two cameras see the marker farther apart than the limit, twice in a row, that is reported.
- A pose older than the last is dropped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from vision.calibration.calibration import Calibration, FloatArray
from vision.markers.marked_robot import MarkedRobot, RobotPose
from vision.markers.tracking import wrap

CORNER_PX: Final = 0.05
"""Least error of a marker's place in the picture; `python -m benchmarks.markers` measures less. A
partly covered one reports more (``RobotPose.corner_error_px``)."""
UNKNOWN_FLOOR_PX: Final = 0.25
"""Error of a calibration without a residual: chosen, a careful survey's."""
HEIGHT_M: Final = 0.002
"""Error of a marker's measured height: chosen, a ruler's."""
TOGETHER_S: Final = 0.12
"""Largest age of sightings merged: three pictures, and one late, at 30 a second."""
SETTLED: Final = 10
"""Sightings after which a track's velocity is settled."""
SPEED_M_S: Final = 0.01
"""Error of a track's velocity; the filter's figure after ten sightings."""
TURN_RAD_S: Final = 0.05


@dataclass(frozen=True, slots=True)
class _Seen:
    """A sighting, its position's covariance (2, 2) in m^2, and its heading's variance.

    ``pose`` has the velocity of the longest track: a new one's is far off.
    """

    pose: RobotPose
    covariance: FloatArray
    heading_variance: float
    count: int
    """Sightings by this camera in a row."""


class PoseFusion:
    """Fusion of the cameras' sightings into one pose for each robot.

    ``cameras`` with their ``names``; ``robots`` whose markers are searched; ``apart_m``: greatest
    distance allowed between two cameras' poses.
    """

    def __init__(
        self,
        cameras: Sequence[Calibration],
        names: Sequence[str],
        robots: Sequence[MarkedRobot],
        apart_m: float,
    ) -> None:
        self._cameras, self._names = tuple(cameras), tuple(names)
        self._robots = {robot.id: robot for robot in robots}
        self._apart_m = apart_m
        self._seen: dict[int, dict[int, _Seen]] = {i: {} for i in self._robots}
        self._last_s: dict[int, float] = {}
        self._suspects: dict[int, int] = {}
        self.contradictions: dict[int, str] = {}
        """By marker id: a sentence where two cameras see the marker in different places."""

    def take(self, camera: int, poses: Sequence[RobotPose]) -> tuple[RobotPose, ...]:
        """Take one picture's sightings; return the robots' poses at their times."""
        fused = []
        for pose in poses:
            newest = self._note(camera, pose)
            seen = self._seen[pose.id]
            others = [
                one
                for c, one in seen.items()
                if c != camera
                and _together(one.pose, newest.pose)
                and max(one.count, newest.count) >= SETTLED
            ]
            self._compare(camera, pose)
            if pose.captured_s > self._last_s.get(pose.id, -math.inf):
                self._last_s[pose.id] = pose.captured_s
                fused.append(_fused(newest, others))
        return tuple(fused)

    def _note(self, camera: int, pose: RobotPose) -> _Seen:
        seen = self._seen[pose.id]
        before = seen.get(camera)
        goes_on = before is not None and pose.captured_s - before.pose.captured_s <= TOGETHER_S
        count = 1 + (before.count if before is not None and goes_on else 0)
        longest = max(seen.values(), key=lambda one: one.count, default=None)
        if longest is not None and longest.count > count and _together(longest.pose, pose):
            of = longest.pose
            pose = replace(pose, vx=of.vx, vy=of.vy, turn_rate_rad_s=of.turn_rate_rad_s)
        seen[camera] = _Seen(pose, *self.uncertainty(camera, pose), count)
        return seen[camera]

    def forget(self, camera: int) -> None:
        """Forget a lost camera's sightings."""
        for seen in self._seen.values():
            seen.pop(camera, None)
        self.contradictions, self._suspects = {}, {}

    def uncertainty(self, camera: int, pose: RobotPose) -> tuple[FloatArray, float]:
        """Covariance (2, 2) of a sighting in m^2 and its heading's variance in rad^2."""
        calibration, robot = self._cameras[camera], self._robots[pose.id]
        place = np.array([pose.x, pose.y])
        height_m = robot.marker_height_m
        (pixel,) = calibration.image_from_arena([place], height_m)
        beside = calibration.arena_from_image(pixel + np.array([(1.0, 0.0), (0.0, 1.0)]), height_m)
        metres = (beside - place).T  # one pixel to the right, and one down
        corner_px = max(CORNER_PX, pose.corner_error_px)
        covariance = corner_px**2 * metres @ metres.T
        floor_m = calibration.arena_rms_m
        if floor_m is None:
            floor_m = UNKNOWN_FLOOR_PX * calibration.metres_per_pixel
        covariance = covariance + floor_m**2 * np.eye(2)
        center = calibration.camera_center_m
        if center is not None:
            lean = (np.array(center[:2]) - place) / (center[2] - height_m) * HEIGHT_M
            covariance = covariance + np.outer(lean, lean)
        side_m = robot.marker_size_m
        heading = corner_px**2 * float(np.square(metres).sum()) / side_m**2
        return np.asarray(covariance), heading

    def _compare(self, camera: int, pose: RobotPose) -> None:
        together = False
        for other, seen in self._seen[pose.id].items():
            away_s = pose.captured_s - seen.pose.captured_s
            if other == camera or not _together(seen.pose, pose):
                continue
            together = True
            x, y, _ = seen.pose.at(pose.captured_s)
            apart_m = math.dist((x, y), (pose.x, pose.y))
            if apart_m <= self._apart_m + _spread_m(away_s):
                self._suspects[pose.id] = 0
                self.contradictions.pop(pose.id, None)
                continue
            self._suspects[pose.id] = self._suspects.get(pose.id, 0) + 1
            if self._suspects[pose.id] >= 2:
                self.contradictions[pose.id] = (
                    f"the robot's marker {pose.id} is seen at ({pose.x:.2f}, {pose.y:.2f}) m by "
                    f"{self._names[camera]} and at ({x:.2f}, {y:.2f}) m by {self._names[other]}: "
                    f"{1000.0 * apart_m:.0f} mm apart, the limit is {1000.0 * self._apart_m:.0f}"
                )
        if not together:
            self._suspects.pop(pose.id, None)
            self.contradictions.pop(pose.id, None)


def _together(one: RobotPose, other: RobotPose) -> bool:
    return abs(one.captured_s - other.captured_s) <= TOGETHER_S


def _spread_m(away_s: float) -> float:
    return SPEED_M_S * abs(away_s) + 0.5 * away_s * away_s


def _fused(newest: _Seen, others: Sequence[_Seen]) -> RobotPose:
    pose = newest.pose
    weight = np.linalg.inv(newest.covariance)
    total, place = weight, weight @ np.array([pose.x, pose.y])
    turn_weight = 1.0 / newest.heading_variance
    turns, turn = turn_weight, 0.0
    speeds = [(np.trace(weight), pose)]
    for other in others:
        away_s = pose.captured_s - other.pose.captured_s
        x, y, heading = other.pose.at(pose.captured_s)
        left = _spread_m(away_s) ** 2 * np.eye(2)
        weight = np.linalg.inv(other.covariance + left)
        total, place = total + weight, place + weight @ np.array([x, y])
        turn_weight = 1.0 / (other.heading_variance + (TURN_RAD_S * away_s) ** 2)
        turns += turn_weight
        turn += turn_weight * wrap(heading - pose.heading_rad)
        speeds.append((np.trace(weight), other.pose))
    if len(speeds) == 1:
        return pose
    x, y = np.linalg.solve(total, place).tolist()
    share = sum(w for w, _ in speeds)
    return replace(
        pose,
        x=x,
        y=y,
        heading_rad=wrap(pose.heading_rad + turn / turns),
        vx=sum(w * one.vx for w, one in speeds) / share,
        vy=sum(w * one.vy for w, one in speeds) / share,
        turn_rate_rad_s=sum(w * one.turn_rate_rad_s for w, one in speeds) / share,
    )


def carried(pose: RobotPose, time_s: float, most_s: float = TOGETHER_S) -> RobotPose:
    """Pose at another time with its velocity kept, for ``most_s`` at most."""
    away_s = min(max(time_s - pose.captured_s, -most_s), most_s)
    x, y, heading = pose.at(pose.captured_s + away_s)
    return replace(pose, x=x, y=y, heading_rad=heading)

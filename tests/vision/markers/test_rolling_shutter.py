"""A marker that moves under a rolling shutter, rendered row by row: where it was, and when."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from tests.support.drawn.boards import rounded, sharp
from tests.vision.markers.test_markers import BENT, DICTIONARY, SIZE, marker_patch, overhead
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame, Image
from vision.markers.markers import MarkedRobot, MarkerTracker, RobotPose, marker_pose
from vision.markers.tracking import Pose, wrap

ROLLING_S = 0.02
PERIOD_S = 1.0 / 30.0
STRIP_PX = 6
BLUR_PX, MARGIN_PX = 0.7, 4
"""The blur, and the rows beside a strip that reach into it."""
ROBOT = MarkedRobot(3, 0.09, marker_height_m=0.1)


class Motion:
    """A robot that passes the middle of the picture at ``middle_s``, and may turn on its way."""

    def __init__(self, speed_m_s: float, course_rad: float, turn_rad_s: float) -> None:
        self.speed_m_s, self.course_rad, self.turn_rad_s = speed_m_s, course_rad, turn_rad_s
        self.middle_s = 0.0

    def at(self, time_s: float) -> Pose:
        way_m = self.speed_m_s * (time_s - self.middle_s)
        x = 0.36 + way_m * math.cos(self.course_rad)
        y = 0.30 + way_m * math.sin(self.course_rad)
        return x, y, wrap(0.4 + self.turn_rad_s * (time_s - self.middle_s))


def rolled(calibration: Calibration, motion: Motion, last_s: float, seed: int) -> Image:
    """The picture whose last row is exposed at ``last_s``: every strip of rows at its own time."""
    strips = []
    for top in range(0, SIZE[1], STRIP_PX):
        middle = top + 0.5 * (STRIP_PX - 1)
        time_s = last_s - ROLLING_S * (SIZE[1] - 1 - middle) / (SIZE[1] - 1)
        marker = marker_pose(motion.at(time_s), ROBOT)
        patch = marker_patch(DICTIONARY, ROBOT.id, ROBOT.marker_size_m, marker, 0.1)
        first, end = max(0, top - MARGIN_PX), min(SIZE[1], top + STRIP_PX + MARGIN_PX)
        rows = sharp(calibration, [patch], (0, first, SIZE[0], end - first), samples=3)
        blurred = cv2.GaussianBlur(rows, (0, 0), BLUR_PX)
        strips.append(blurred[top - first : top - first + STRIP_PX])
    image = np.vstack(strips)
    return rounded(image + np.random.default_rng(seed).normal(0.0, 2.0, image.shape))


def followed(
    calibration: Calibration, motion: Motion, rolling_s: float, frames: int = 8
) -> list[RobotPose]:
    tracker = MarkerTracker(calibration, [ROBOT], rolling_shutter_s=rolling_s)
    motion.middle_s = 100.0 + 0.5 * frames * PERIOD_S
    seen = []
    for number in range(frames):
        last_s = 100.0 + number * PERIOD_S
        frame = Frame(rolled(calibration, motion, last_s, number), last_s, number, "test")
        seen += tracker.update(frame)
    return seen


def errors(poses: list[RobotPose], motion: Motion) -> tuple[float, float]:
    """The largest distance (m) and angle (rad) from where the robot was at the poses' times."""
    far, turned = 0.0, 0.0
    for pose in poses:
        x, y, heading = motion.at(pose.captured_s)
        far = max(far, math.hypot(pose.x - x, pose.y - y))
        turned = max(turned, abs(wrap(pose.heading_rad - heading)))
    return far, turned


@pytest.mark.parametrize("speed_m_s", [0.3, 1.0])
@pytest.mark.parametrize("course_rad", [0.0, 0.5 * math.pi, 3.9])
@pytest.mark.parametrize("turn_rad_s", [0.0, 2.0])
def test_a_pose_is_where_the_robot_was_at_the_time_of_its_own_rows(
    speed_m_s: float, course_rad: float, turn_rad_s: float
) -> None:
    motion = Motion(speed_m_s, course_rad, turn_rad_s)
    poses = followed(BENT, motion, ROLLING_S)
    assert len(poses) >= 6
    far, turned = errors(poses[3:], motion)  # the first ones have no velocity yet
    assert far < 0.0004
    assert turned < 0.002


@pytest.mark.parametrize("speed_m_s", [0.3, 1.0])
def test_without_it_the_pose_is_off_by_what_the_robot_moved_meanwhile(speed_m_s: float) -> None:
    motion = Motion(speed_m_s, 0.0, 0.0)
    far, turned = errors(followed(overhead(), motion, 0.0)[3:], motion)
    assert far > 0.8 * speed_m_s * 0.5 * ROLLING_S
    assert turned > 0.4 * speed_m_s * ROLLING_S / SIZE[1] / 0.002 / 2.0


def test_a_pose_says_how_long_before_its_frame_it_was_exposed() -> None:
    motion = Motion(0.0, 0.0, 0.0)
    poses = followed(overhead(), motion, ROLLING_S, frames=4)
    for number, pose in enumerate(poses, start=4 - len(poses)):
        rows_after = SIZE[1] - 1 - pose.corners_px[:, 1].mean()
        assert pose.before_frame_s == pytest.approx(ROLLING_S * rows_after / (SIZE[1] - 1))
        frame_s = 100.0 + number * PERIOD_S
        assert pose.captured_s == pytest.approx(frame_s - pose.before_frame_s)

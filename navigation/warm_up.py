"""Compile every kernel before the robot may move: a first compilation takes seconds.

A small arena goes through the whole chain once: a marker and an obstacle are seen, a way past
the obstacle is planned and timed. Loaded from the kernel cache this takes about a second; the
first time on a machine it takes much longer.
"""

from __future__ import annotations

import cv2
import numpy as np

import planner
from navigation.config import Config
from navigation.eye import Body, Eye, EyeSettings
from planner.path import Path
from planner.scene import Bounds
from planner.smooth import smooth_path
from planner.trajectory import default_limits
from vision.calibration import Calibration
from vision.camera import Frame
from vision.markers import MarkedRobot, MarkerTracker, dictionary_by_name

SIZE_PX = (400, 300)
METRES_PER_PIXEL = 0.005
MARKER_PX = 40
RADIUS_M = 0.15


def warm_up(config: Config) -> None:
    """Run eye, roadmap, plan, smoothing and timing on a drawn arena of 2.0 m x 1.5 m."""
    calibration = Calibration.from_scale(METRES_PER_PIXEL, SIZE_PX)
    robot = MarkedRobot(config.robot.marker_id, MARKER_PX * METRES_PER_PIXEL)
    eye = Eye(
        calibration,
        MarkerTracker(calibration, [robot], config.robot.dictionary),
        EyeSettings(
            bounds_m=Bounds(0.0, 0.0, 2.0, 1.5),
            polarity=config.vision.polarity,
            method=config.vision.method,
            threshold=config.vision.threshold,
            driven_id=robot.id,
            bodies={robot.id: Body(RADIUS_M, 0.0)},
        ),
    )
    picture = _picture(config)
    for number in range(8):
        glimpse = eye.look(Frame(picture[number % 2], number / 30.0, number, "warm-up"))
        if glimpse.scene is None:
            continue
        roadmap = planner.build_roadmap(glimpse.scene, RADIUS_M)
        path = roadmap.plan((0.3, 0.3), (1.7, 1.2))
        if isinstance(path, Path):
            path = smooth_path(path, roadmap.path_clearance, roadmap.clearance)
            planner.time_path(path, default_limits(RADIUS_M), clearance=roadmap.clearance)


def _picture(config: Config) -> tuple[np.ndarray, np.ndarray]:
    """A floor with the robot's marker, a square and a disc; and the same with more noise."""
    noise = np.random.default_rng(0).normal(0.0, 2.0, (2, SIZE_PX[1], SIZE_PX[0]))
    picture = np.full((SIZE_PX[1], SIZE_PX[0]), 225, np.uint8)
    picture[130:180, 180:230] = 25
    cv2.circle(picture, (300, 230), 25, 25, -1)
    book = dictionary_by_name(config.robot.dictionary)
    marker = cv2.aruco.generateImageMarker(book, config.robot.marker_id, MARKER_PX)
    picture[210 : 210 + MARKER_PX, 50 : 50 + MARKER_PX] = marker
    if config.vision.polarity == "light":
        picture = 255 - picture
        picture[210 : 210 + MARKER_PX, 50 : 50 + MARKER_PX] = marker
        picture[202:210, 42:98] = picture[250:258, 42:98] = 225
    first, second = (np.clip(picture + n, 0, 255).astype(np.uint8) for n in noise)
    return first, second

"""The eye of several cameras, made from a configuration."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from navigation.config import Config
from navigation.config.sections import RobotSection
from navigation.config.several.each_camera import each_camera
from navigation.loop.seeing.eye_settings import eye_settings, marked_robots
from navigation.loop.seeing.joined.joined_eye import JoinedEye, JoinedSettings
from vision.joined.floor_plan import FloorPlan
from vision.joined.pose_fusion import PoseFusion
from vision.markers.markers import MarkerTracker
from vision.watch.camera_place import CameraPlace


def joined_eye(
    config: Config,
    plan: FloorPlan,
    driven: Sequence[RobotSection] = (),
    places: Sequence[CameraPlace] = (),
    tracker: Callable[..., MarkerTracker] = MarkerTracker,
    eye: Callable[..., JoinedEye] = JoinedEye,
) -> JoinedEye:
    """Return the eye of a configuration's cameras, whose common floor is ``plan``."""
    robots = marked_robots(config, driven)
    cameras = each_camera(config)
    trackers = [
        tracker(
            calibration,
            robots,
            config.robot.dictionary,
            one.camera.rolling_shutter_ms / 1000.0,
        )
        for calibration, one in zip(plan.cameras, cameras.values(), strict=True)
    ]
    safety, names = config.safety, tuple(cameras)
    return eye(
        plan,
        trackers,
        PoseFusion(plan.cameras, names, robots, safety.cameras_apart_m),
        eye_settings(config, driven),
        JoinedSettings(names, safety.frame_stale_s, safety.cameras_apart_m),
        places,
    )

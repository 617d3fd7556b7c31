"""Settings of the eye from a configuration. Metres, radians, seconds."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from navigation.config import Config
from navigation.config.sections import RobotSection, SafetySection
from navigation.config.values import FloorMarkerSection
from navigation.loop.seeing.eye import EyeSettings, RobotShape
from navigation.mission.traffic import REACTION_S
from planner.scene import Bounds
from vision.calibration.blind import is_shown
from vision.calibration.calibration import Calibration
from vision.markers.markers import MarkedRobot
from vision.watch.camera_place import FloorMarker, PlaceSettings


def eye_settings(config: Config, driven: Sequence[RobotSection] = ()) -> EyeSettings:
    """Settings of the eye; ``driven`` are the driven robots, by default the configured one."""
    robots = tuple(driven) or (config.robot,)
    seen = (*robots, *config.other_robots)
    return EyeSettings(
        bounds_m=Bounds(*config.arena.bounds_m),
        vision=config.vision,
        driven_ids=tuple(one.marker_id for one in robots),
        bodies={one.marker_id: RobotShape(one.radius_m, one.marker_height_m) for one in seen},
        reach_m=max((reach_m(one, config.safety) for one in driven), default=0.0),
    )


def place_settings(config: Config, one_of_several: Calibration | None = None) -> PlaceSettings:
    """Settings that watch a camera's place; one of several uses the markers it shows."""
    markers = tuple(
        FloorMarker(one.marker_id, one.place_m)
        for one in config.arena.floor_markers
        if one_of_several is None or _is_in_picture(one, one_of_several)
    )
    return PlaceSettings(
        bounds_m=Bounds(*config.arena.bounds_m),
        markers=markers,
        dictionary=config.robot.dictionary,
        limit_px=config.safety.camera_moved_px,
    )


def _is_in_picture(marker: FloorMarkerSection, calibration: Calibration) -> bool:
    if marker.place_m is None:
        return False
    reach = 0.5 * math.sqrt(2.0) * 1.25 * marker.size_m
    sides = np.array([(-reach, -reach), (reach, -reach), (reach, reach), (-reach, reach)])
    return bool(is_shown(calibration, np.array(marker.place_m) + sides).all())


def stop_s(robot: RobotSection, safety: SafetySection) -> float:
    """Longest time a robot can drive after it was last seen."""
    braking_s = robot.speed_m_s / robot.acceleration_m_s2
    return safety.pose_stale_s + safety.lease_s + REACTION_S + braking_s


def reach_m(robot: RobotSection, safety: SafetySection) -> float:
    """Longest distance it can cover in that time."""
    return robot.speed_m_s * stop_s(robot, safety)


def marked_robots(config: Config, driven: Sequence[RobotSection] = ()) -> list[MarkedRobot]:
    """Robots whose markers are sought; ``driven`` as for the eye."""
    ours = [
        MarkedRobot(
            one.marker_id,
            one.marker_size_m,
            one.marker_height_m,
            marker_yaw_rad=math.radians(one.marker_turn_deg),
        )
        for one in tuple(driven) or (config.robot,)
    ]
    others = [
        MarkedRobot(one.marker_id, one.marker_size_m, one.marker_height_m)
        for one in config.other_robots
    ]
    return [*ours, *others]

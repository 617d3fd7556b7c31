"""From a configuration to the settings of each stage: eye, planner, pilot.

Units: metres, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from firmware_protocol.wire.framing import wire_bytes
from firmware_protocol.wire.messages import Status
from navigation.config import Config, limits_of
from navigation.config.sections import RobotSection, SafetySection
from navigation.config.values import FloorMarkerSection
from navigation.loop.eye import Body, EyeSettings
from navigation.loop.planning import PlanSettings
from navigation.mission.cycle import PilotSettings
from navigation.mission.mission import Station
from navigation.mission.traffic import REACTION_S, TrafficLimits
from navigation.mission.watch import SafetyLimits
from navigation.witness import WitnessLimits
from navigation.witness.agreement import AgreementLimits
from planner.scene import Bounds
from vision.calibration.blind import is_shown
from vision.calibration.calibration import Calibration
from vision.markers.markers import MarkedRobot
from vision.watch.camera_place import FloorMarker, PlaceSettings

SETTLE_S: Final = 0.4
RETRY_S: Final = 1.0
ROBOT_GRACE_S: Final = 1.5
CORRECTIONS: Final = 3
BITS_A_BYTE: Final = 10


def stations_of(config: Config) -> tuple[Station, ...]:
    """The configured mission's stations."""
    return tuple(Station(s.x_m, s.y_m, s.heading_rad, s.dwell_s) for s in config.mission.stations)


def pilot_settings(config: Config) -> PilotSettings:
    """The pilot's numbers."""
    safety = config.safety
    return PilotSettings(
        limits=SafetyLimits(
            pose_stale_s=safety.pose_stale_s,
            frame_stale_s=safety.frame_stale_s,
            link_stale_s=safety.link_stale_s,
            max_deviation_m=safety.max_deviation_m,
            robot_radius_m=config.robot.radius_m,
            clearance_slack_m=safety.clearance_slack_m,
            latency_s=safety.latency_s,
        ),
        bounds_m=Bounds(*config.arena.bounds_m),
        goal_tolerance_m=config.mission.tolerance_m,
        goal_tolerance_rad=math.radians(config.mission.tolerance_deg),
        settle_s=SETTLE_S,
        retry_s=RETRY_S,
        robot_grace_s=ROBOT_GRACE_S,
        replan_distance_m=config.planning.replan_distance_m,
        give_up_s=safety.give_up_s,
        traffic=TrafficLimits(
            radius_m=config.robot.radius_m,
            speed_m_s=config.robot.speed_m_s,
            acceleration_m_s2=config.robot.acceleration_m_s2,
            keep_m=safety.other_robots_m,
        ),
        corrections=CORRECTIONS,
        turns_on_spot=config.robot.turns_on_spot,
    )


def witness_limits(config: Config) -> WitnessLimits:
    """What camera and wheels may differ by."""
    report_bytes = wire_bytes(Status.LAYOUT.size)
    return WitnessLimits(
        AgreementLimits(config.safety.odometry_slack_m, config.safety.odometry_error),
        report_age_s=report_bytes * BITS_A_BYTE / config.serial.baud,
    )


def plan_settings(config: Config) -> PlanSettings:
    """What every plan must keep."""
    return PlanSettings(
        radius_m=config.robot.radius_m,
        margin_m=config.planning.margin_m,
        margin=config.planning.margin,
        spacing_m=config.planning.spacing_m,
        prefer=config.planning.prefer,
        limits=limits_of(config),
    )


def eye_settings(config: Config, driven: Sequence[RobotSection] = ()) -> EyeSettings:
    """What the eye looks for; ``driven`` are the driven robots where there are several."""
    robots = tuple(driven) or (config.robot,)
    seen = (*robots, *config.other_robots)
    return EyeSettings(
        bounds_m=Bounds(*config.arena.bounds_m),
        polarity=config.vision.polarity,
        method=config.vision.method,
        threshold=config.vision.threshold,
        texture_px=config.vision.texture_px,
        driven_ids=tuple(one.marker_id for one in robots),
        bodies={one.marker_id: Body(one.radius_m, one.marker_height_m) for one in seen},
        reach_m=max((reach_m(one, config.safety) for one in driven), default=0.0),
    )


def place_settings(config: Config, one_of_several: Calibration | None = None) -> PlaceSettings:
    """What says whether the camera is where it was; of several, by the markers that it shows."""
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
    """Whether a camera shows a marker whole, however it is turned, with some white around it."""
    if marker.place_m is None:
        return False
    reach = 0.5 * math.sqrt(2.0) * 1.25 * marker.size_m
    sides = np.array([(-reach, -reach), (reach, -reach), (reach, reach), (-reach, reach)])
    return bool(is_shown(calibration, np.array(marker.place_m) + sides).all())


def stop_s(robot: RobotSection, safety: SafetySection) -> float:
    """How long a robot can drive at most after it was seen last: lease, reaction and brakes."""
    braking_s = robot.speed_m_s / robot.acceleration_m_s2
    return safety.pose_stale_s + safety.lease_s + REACTION_S + braking_s


def reach_m(robot: RobotSection, safety: SafetySection) -> float:
    """How far it can have come by then."""
    return robot.speed_m_s * stop_s(robot, safety)


def marked_robots(config: Config, driven: Sequence[RobotSection] = ()) -> list[MarkedRobot]:
    """The robots whose markers are looked for; ``driven`` as for the eye."""
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

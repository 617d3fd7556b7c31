"""Settings of planner, pilot and witness from a configuration."""

from __future__ import annotations

import math
from typing import Final

from firmware_protocol.wire.framing import wire_bytes
from firmware_protocol.wire.messages import Status
from navigation.config import Config, limits_of
from navigation.loop.planning import PlanSettings
from navigation.mission.cycle import PilotSettings
from navigation.mission.mission import Station
from navigation.mission.traffic import TrafficLimits
from navigation.mission.watch import SafetyLimits
from navigation.witness import WitnessLimits
from navigation.witness.agreement import AgreementLimits
from planner.scene import Bounds

SETTLE_S: Final = 0.4
RETRY_S: Final = 1.0
ROBOT_GRACE_S: Final = 1.5
CORRECTIONS: Final = 3
CIRCLES_S: Final = 8.0
"""Time to come nearer to a target, for a robot that turns quickly: chosen."""
BITS_A_BYTE: Final = 10


def stations_of(config: Config) -> tuple[Station, ...]:
    """Stations of the configured mission."""
    return tuple(Station(s.x_m, s.y_m, s.heading_rad, s.dwell_s) for s in config.mission.stations)


def _circles_s(config: Config) -> float:
    """Time to come nearer to a target: at least twice half a turn at a steady rate.

    If the rate is not reached, half a turn takes 2 * sqrt(pi / acceleration).
    """
    robot = config.robot
    steady_s = 2.0 * math.pi / robot.angular_rate_rad_s
    speeding_s = 4.0 * math.sqrt(math.pi / robot.angular_acceleration_rad_s2)
    return max(CIRCLES_S, steady_s, speeding_s)


def pilot_settings(config: Config) -> PilotSettings:
    """Settings of the pilot."""
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
        circles_s=_circles_s(config),
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
    """Limits on differences between camera and wheels."""
    report_bytes = wire_bytes(Status.LAYOUT.size)
    return WitnessLimits(
        AgreementLimits(config.safety.odometry_slack_m, config.safety.odometry_error),
        report_age_s=report_bytes * BITS_A_BYTE / config.serial.baud,
    )


def plan_settings(config: Config) -> PlanSettings:
    """Requirements on every plan."""
    return PlanSettings(
        radius_m=config.robot.radius_m,
        margin_m=config.planning.margin_m,
        margin=config.planning.margin,
        spacing_m=config.planning.spacing_m,
        prefer=config.planning.prefer,
        limits=limits_of(config),
    )

"""The planner's limits, from a configuration."""

from __future__ import annotations

from navigation.config.sections import Config
from planner.path import Limits


def limits_of(config: Config) -> Limits:
    """Limits as the planner takes them; metres."""
    robot, planning = config.robot, config.planning
    return Limits(
        speed=robot.speed_m_s,
        acceleration=robot.acceleration_m_s2,
        lateral_acceleration=robot.lateral_acceleration_m_s2,
        angular_rate_rad_s=robot.angular_rate_rad_s,
        angular_acceleration_rad_s2=robot.angular_acceleration_rad_s2,
        jerk=robot.jerk_m_s3,
        spacing=planning.waypoint_spacing_m,
        chord_tolerance=planning.chord_tolerance_m,
        slow_clearance=planning.slow_clearance_m,
        slow_speed=planning.slow_speed_m_s,
        turns_on_spot=robot.turns_on_spot,
        turning_radius=robot.turning_radius_m,
    )

"""Settings of the simulated robot from a configuration's section ``simulation``."""

from __future__ import annotations

from firmware_protocol.wire.drive_settings import DriveSettings
from navigation.config import Config
from navigation.config.known_robots import least_wheel_m_s
from navigation.simulator.drive_model import DriveModel, TruePose
from navigation.simulator.line_faults import FaultSpec


def drive_model_of(config: Config) -> DriveModel:
    """Drive model of the configured robot; the ideal one without a section ``simulation``."""
    if config.simulation is None:
        return DriveModel(track_m=config.robot.track_m)
    errors = config.simulation.robot
    left, right = errors.wheel_radius_error
    return DriveModel(
        track_m=config.robot.track_m * (1.0 + errors.track_error),
        lag_s=errors.motor_time_s,
        left_scale=1.0 + left,
        right_scale=1.0 + right,
        slip=errors.slip,
        ticks_per_m=errors.encoder_ticks_per_m,
        max_wheel_m_s=errors.wheel_speed_m_s,
        dead_zone_m_s=errors.dead_zone_m_s,
        stiction=errors.stiction,
        step_m_s=errors.speed_step_m_s,
    )


def drive_settings_of(config: Config) -> DriveSettings:
    """Settings of the robot's own firmware."""
    robot = config.robot
    return DriveSettings(
        track_m=robot.track_m,
        max_speed_m_s=robot.speed_m_s,
        acceleration_m_s2=robot.acceleration_m_s2,
        lateral_m_s2=robot.lateral_acceleration_m_s2,
        max_turn_rad_s=robot.angular_rate_rad_s,
        turn_acceleration_rad_s2=robot.angular_acceleration_rad_s2,
        least_wheel_m_s=least_wheel_m_s(robot.driver, robot.least_wheel_m_s),
    )


def true_start_of(config: Config) -> TruePose:
    """True pose of the simulated robot at the beginning."""
    if config.simulation is None:
        raise ValueError("the configuration has no section 'simulation'")
    start = config.simulation.start
    if start is None:
        raise ValueError("the section 'simulation' has no start")
    return TruePose(start.x_m, start.y_m, start.heading_rad)


def faults_of(config: Config) -> FaultSpec:
    """Faults of the line; raises ``FaultSpecError`` for an invalid specification."""
    return FaultSpec.parse(config.simulation.robot.faults if config.simulation else "")

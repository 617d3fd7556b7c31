"""From the configuration to the simulated robot: every error arrives where it belongs."""

from __future__ import annotations

import math

import pytest

from navigation.config import Config, parse_config
from navigation.simulator.line_faults import FaultSpecError
from navigation.simulator.settings import (
    drive_model_of,
    drive_settings_of,
    faults_of,
    true_start_of,
)

TEXT = """
arena: {bounds_m: [0, 0, 2, 2]}
camera: {source: simulated}
robot: {marker_id: 1, marker_size_m: 0.1, radius_m: 0.1, track_m: 0.2, speed_m_s: 0.25}
simulation:
  arena_text: "C (1,1) 0.1"
  start: {x_m: 0.5, y_m: 0.75, heading_deg: 270}
  robot:
    wheel_radius_error: [0.03, -0.02]
    track_error: 0.1
    slip: 0.04
    motor_time_s: 0.08
    encoder_ticks_per_m: 1000
    wheel_speed_m_s: 0.6
    dead_zone_m_s: 0.012
    stiction: 0.3
    speed_step_m_s: 0.004
    faults: drop=0.001
"""


@pytest.fixture(scope="module")
def config() -> Config:
    return parse_config(TEXT)


def test_the_drive_has_the_configured_errors(config: Config) -> None:
    model = drive_model_of(config)
    assert model.track_m == pytest.approx(0.22)
    assert (model.left_scale, model.right_scale) == (1.03, 0.98)
    assert (model.slip, model.lag_s) == (0.04, 0.08)
    assert (model.ticks_per_m, model.max_wheel_m_s) == (1000, 0.6)
    assert (model.dead_zone_m_s, model.stiction, model.step_m_s) == (0.012, 0.3, 0.004)


def test_the_firmware_is_told_the_nominal_robot(config: Config) -> None:
    settings = drive_settings_of(config)
    assert settings.track_m == 0.2
    assert settings.max_speed_m_s == 0.25


def test_the_robot_stands_where_it_starts(config: Config) -> None:
    assert true_start_of(config) == pytest.approx((0.5, 0.75, -math.pi / 2))


def test_the_line_has_the_configured_faults(config: Config) -> None:
    assert faults_of(config).drop == 0.001


def test_a_fault_that_is_none_is_refused() -> None:
    with pytest.raises(FaultSpecError, match="bite"):
        faults_of(parse_config(TEXT.replace("drop=0.001", "bite=1")))


def test_without_a_simulation_the_robot_is_ideal_and_stands_nowhere() -> None:
    real = TEXT.split("simulation:")[0].replace("simulated", "0, metres_per_pixel: 0.002")
    config = parse_config(real + "serial: {port: /dev/null}\n")
    assert drive_model_of(config).track_m == 0.2
    assert (drive_model_of(config).left_scale, drive_model_of(config).right_scale) == (1.0, 1.0)
    with pytest.raises(ValueError, match="no section 'simulation'"):
        true_start_of(config)

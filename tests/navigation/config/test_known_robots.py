"""What a configuration may ask of each known robot, and what `clearway init --robot` writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from navigation.cli.setup.check import file_problems
from navigation.cli.setup.starter_values import demo_values, real_values
from navigation.config import Config, ConfigError, load_config
from navigation.config.known_robots import CLEARWAY, KNOWN_ROBOTS
from navigation.config.load import parse_config
from navigation.config.reference import starter_yaml
from navigation.simulator.settings import drive_settings_of

NAMES = (CLEARWAY, *KNOWN_ROBOTS)


def loaded(values: dict[str, Any]) -> Config:
    return parse_config(starter_yaml(values, "test"), "test", Path())


@pytest.mark.parametrize("name", NAMES)
def test_the_first_configuration_of_each_robot_loads_and_fits_together(name: str) -> None:
    config = loaded(demo_values(name))
    assert config.robot.driver == name
    assert list(file_problems(config)) == []
    real = loaded(real_values(name))
    assert real.robot == config.robot
    assert real.serial.baud == config.serial.baud


@pytest.mark.parametrize("name", tuple(KNOWN_ROBOTS))
def test_the_section_holds_the_robot_s_true_dimensions_and_keeps_its_limits(name: str) -> None:
    known, robot = KNOWN_ROBOTS[name], loaded(real_values(name)).robot
    assert robot.track_m == known.track_m
    assert robot.radius_m >= known.radius_m
    assert robot.speed_m_s < known.speed_m_s <= known.wheel_m_s
    assert robot.angular_rate_rad_s * robot.track_m / 2 < known.wheel_m_s
    assert robot.marker_size_m <= robot.radius_m * 2**0.5


@pytest.mark.parametrize("name", tuple(KNOWN_ROBOTS))
@pytest.mark.parametrize(
    ("key", "factor", "words"),
    [
        ("speed_m_s", 1.3, "robot.speed_m_s: must be <= {speed:g}, the {title}'s, not "),
        ("angular_rate_rad_s", 6.0, "the {title}'s wheels at {wheel:g} m/s, not "),
        ("radius_m", 0.9, "robot.radius_m: must be >= {radius:g}, the {title}'s body, not "),
    ],
)
def test_what_the_robot_cannot_do_is_refused(
    name: str, key: str, factor: float, words: str
) -> None:
    known, values = KNOWN_ROBOTS[name], demo_values(name)
    values["robot"][key] *= factor
    with pytest.raises(ConfigError) as error:
        loaded(values)
    expected = words.format(
        speed=known.speed_m_s, wheel=known.wheel_m_s, radius=known.radius_m, title=known.title
    )
    assert expected in str(error.value)


def test_an_address_is_for_robots_behind_a_driver() -> None:
    values = real_values("waveshare")
    values["serial"]["port"] = "socket://192.168.4.1:3333"
    assert loaded(values).serial.port.startswith("socket:")
    ours = real_values()
    ours["serial"]["port"] = "socket://192.168.4.1:3333"
    with pytest.raises(ConfigError, match=r"an address needs a robot\.driver"):
        loaded(ours)


def test_a_model_is_for_robots_that_do_not_say_it_themselves() -> None:
    values = demo_values("waveshare")
    assert loaded(values).robot.model == "ugv01"
    for model in KNOWN_ROBOTS["waveshare"].models:
        values["robot"]["model"] = model
        assert loaded(values).robot.model == model
    for name in (CLEARWAY, "create2"):
        values = demo_values(name)
        values["robot"]["model"] = "ugv01"
        with pytest.raises(
            ConfigError, match=rf"no model for robot\.driver '{name}': leave it out"
        ):
            loaded(values)


def test_an_unknown_driver_is_refused_with_those_that_there_are(tmp_path: Path) -> None:
    file = tmp_path / "x.yaml"
    file.write_text(starter_yaml(demo_values("create2"), "x").replace("create2", "roomba"))
    with pytest.raises(ConfigError, match=r"robot\.driver"):
        load_config(file, {})


def test_a_robot_without_a_watchdog_is_known_as_one() -> None:
    assert {name for name, known in KNOWN_ROBOTS.items() if known.watchdog_s is None} == {
        "create2",
        "epuck2",
    }


@pytest.mark.parametrize("name", NAMES)
def test_wheels_are_driven_in_pulses_where_their_driver_does_not_see_to_it(name: str) -> None:
    chosen = drive_settings_of(loaded(demo_values(name))).least_wheel_m_s
    assert chosen == {"create2": 0.0, "turtlebot3": 0.02}.get(name, 0.01)
    values = demo_values(name)
    values["robot"]["least_wheel_m_s"] = 0.04
    assert drive_settings_of(loaded(values)).least_wheel_m_s == 0.04


def test_a_least_speed_that_is_the_robot_s_highest_is_refused() -> None:
    values = demo_values("epuck2")
    values["robot"]["least_wheel_m_s"] = values["robot"]["speed_m_s"]
    with pytest.raises(ConfigError, match=r"robot\.least_wheel_m_s: must be < 0\.1"):
        loaded(values)


@pytest.mark.parametrize("name", NAMES)
def test_a_simulated_wheel_that_no_pulse_sets_turning_is_found(name: str) -> None:
    values = demo_values(name)
    values["robot"]["least_wheel_m_s"] = 0.02
    values["simulation"]["robot"] = {"dead_zone_m_s": 0.018, "stiction": 0.2}
    ((where, told),) = file_problems(loaded(values))
    assert where == ("robot", "least_wheel_m_s")
    assert told.startswith("must be >= 0.0216, at which the simulated wheels begin to turn")
    values["robot"]["least_wheel_m_s"] = 0.022
    assert list(file_problems(loaded(values))) == []

"""Files and variables of the environment: what is missing, what overrides what."""

from __future__ import annotations

from pathlib import Path

import pytest

from navigation.config import ConfigError, load_config, parse_config
from tests.navigation.config.texts import GOOD, problems_of, the_problem

# Files and the environment.


def test_a_missing_file_is_a_configuration_error(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no\.yaml: No such file") as caught:
        load_config(tmp_path / "no.yaml", {})
    assert caught.value.exit_code == 78


def test_a_file_that_is_not_text_is_a_configuration_error(tmp_path: Path) -> None:
    file = tmp_path / "picture.yaml"
    file.write_bytes(b"arena: \xff\xd8\xff")
    with pytest.raises(ConfigError, match="is not UTF-8 text"):
        load_config(file, {})


def test_relative_files_are_meant_from_the_configuration(tmp_path: Path) -> None:
    file = tmp_path / "run.yaml"
    text = GOOD.replace('arena_text: "C (1,1) 0.2"', "arena: maps/a.txt")
    file.write_text(text.replace("simulated", "simulated\n  calibration: /abs/c.yaml"))
    config = load_config(file, {})
    assert config.simulation is not None
    assert config.simulation.arena == tmp_path / "maps" / "a.txt"
    assert config.camera.calibration == Path("/abs/c.yaml")


def test_the_environment_overrides_the_file() -> None:
    environment = {
        "CLEARWAY_SERIAL__PORT": "/dev/ttyUSB0",
        "CLEARWAY_SIMULATION__START__X_M": "0.5",
        "CLEARWAY_MISSION__STATIONS": "[{x_m: 1, y_m: 1.5}]",
        "CLEARWAY_DEBUG": "1",
        "OTHER__THING": "1",
    }
    config = parse_config(GOOD, environment=environment)
    assert config.serial.port == "/dev/ttyUSB0"
    assert config.simulation is not None
    assert config.simulation.start.x_m == 0.5
    assert config.mission.stations[0].y_m == 1.5


STATIONS = GOOD + "mission: {stations: [{x_m: 1, y_m: 1}, {x_m: 2, y_m: 1.5}]}\n"


def test_an_override_reaches_an_entry_of_a_list() -> None:
    config = parse_config(STATIONS, environment={"CLEARWAY_MISSION__STATIONS__1__X_M": "1.5"})
    assert [station.x_m for station in config.mission.stations] == [1.0, 1.5]
    config = parse_config(STATIONS, environment={"CLEARWAY_ARENA__BOUNDS_M__2": "2.5"})
    assert config.arena.bounds_m == (0.0, 0.0, 2.5, 1.8)


@pytest.mark.parametrize("entry", ["2", "9", "first"])
def test_an_override_of_an_entry_that_a_list_does_not_have_is_an_error(entry: str) -> None:
    problems = problems_of(STATIONS, **{f"CLEARWAY_MISSION__STATIONS__{entry.upper()}__X_M": "1"})
    assert len(problems) == 1
    assert problems[0][0].startswith("mission.stations")


def test_an_override_with_one_underscore_only_is_not_ignored() -> None:
    with pytest.raises(ConfigError) as caught:
        parse_config(GOOD, "run.yaml", None, {"CLEARWAY_SERIAL_PORT": "/dev/ttyUSB0"})
    assert str(caught.value) == (
        "environment CLEARWAY_SERIAL_PORT: sets nothing; did you mean CLEARWAY_SERIAL__PORT?"
    )


def test_the_program_s_own_variables_are_no_overrides() -> None:
    own = {"CLEARWAY_DEBUG": "1", "CLEARWAY_REAL_DATA": "x", "CLEARWAY_FAIL_ON_SKIP": "1"}
    assert parse_config(GOOD, environment=own) == parse_config(GOOD)


def test_a_wrong_override_is_told_by_the_variable() -> None:
    with pytest.raises(ConfigError) as caught:
        parse_config(GOOD, "run.yaml", None, {"CLEARWAY_SERIAL__BAUD": "fast"})
    assert str(caught.value) == (
        "environment CLEARWAY_SERIAL__BAUD: serial.baud: must be a whole number, not 'fast'"
    )


def test_a_misspelt_override_is_an_error_too() -> None:
    key, message = the_problem(GOOD, CLEARWAY_SERIEL__BAUD="9600")
    assert (key, message) == ("seriel", "unknown key; did you mean 'serial'?")


def test_an_override_that_is_not_yaml_is_an_error() -> None:
    key, _ = the_problem(GOOD, CLEARWAY_MISSION__STATIONS="[")
    assert key == "mission.stations"


def test_an_override_may_mend_the_file() -> None:
    text = GOOD.replace("radius_m: 0.09", "radius_m: -1")
    config = parse_config(text, environment={"CLEARWAY_ROBOT__RADIUS_M": "0.1"})
    assert config.robot.radius_m == 0.1


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("CLEARWAY_FOO", "1", "sets nothing: the sections are arena, camera,"),
        ("CLEARWAY_ROBOT", "{}", "sets nothing: name a key of the section, as in CLEARWAY_ROBOT__"),
        ("CLEARWAY_VISION", "hello", "as in CLEARWAY_VISION__POLARITY"),
    ],
)
def test_a_variable_that_names_no_key_is_an_error(name: str, value: str, told: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_config(GOOD, "run.yaml", None, {name: value})
    assert told in str(caught.value)
    assert name in str(caught.value)

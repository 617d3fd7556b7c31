"""Configurations: every error at its place, all at once; overrides; what must fit together."""

from __future__ import annotations

import math
from typing import get_args

import cv2
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from navigation.config import ConfigError, limits_of, parse_config
from navigation.config.checks import dictionary_size
from navigation.config.marks import read_document
from navigation.config.sections import Dictionary
from navigation.config.values import wrapped_rad
from tests.navigation.config.texts import GOOD, problems_of, text_of_error, the_problem


def test_the_shortest_configuration_loads_with_its_defaults() -> None:
    config = parse_config(GOOD)
    assert config.camera.size_px == (1280, 960)
    assert config.robot.speed_m_s == 0.3
    assert config.mission.stations == ()
    assert config.planning.spacing_m is None


def test_an_error_shows_file_line_column_the_line_and_a_caret() -> None:
    told = text_of_error(GOOD.replace("radius_m: 0.09", "radius_m: -3"))
    assert told == (
        "run.yaml:8:13: robot.radius_m: must be > 0, not -3\n      radius_m: -3\n                ^~"
    )


@pytest.mark.parametrize("length", [0, 40, 300, 3000])
def test_of_a_long_line_only_what_stands_around_the_mistake_is_shown(length: int) -> None:
    """And the caret stands under it there too."""
    line = f"  radius_m: [{'1, ' * length}wide{', 1' * length}]"
    told = text_of_error(GOOD.replace("  radius_m: 0.09", line))
    assert max(map(len, told.splitlines())) < 160
    deep = "arena: {bounds_m: [0, 0, " + "[" * length + "wide" + "]" * length + ", 1.8]}"
    told = text_of_error(GOOD.replace("arena:\n  bounds_m: [0, 0, 2.4, 1.8]", deep))
    shown, caret = told.splitlines()[1:3]
    assert max(map(len, told.splitlines())) < 160
    assert shown[caret.index("^")] in "[w"


def test_the_caret_stands_under_the_place_whatever_it_is() -> None:
    told = text_of_error(GOOD.replace("[0, 0, 2.4, 1.8]", "[0, 0, wide, 1.8]")).splitlines()
    assert told[0].startswith("run.yaml:2:20: arena.bounds_m[2]: ")
    caret = told[2].index("^")
    assert told[1][caret : caret + 4] == "wide"
    assert told[2].count("~") == 3


def test_all_errors_are_told_at_once_in_the_order_of_the_file() -> None:
    text = GOOD.replace("source:", "sauce:").replace("0.09", "zero").replace("[0,", "[x,")
    text += "serial: {baud: 9600.5}\nsafety: {lease_s: 0.1}\n"
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "run.yaml")
    assert [problem.key for problem in caught.value.problems] == [
        "arena.bounds_m[0]",
        "camera.sauce",
        "robot.marker_size_m",
        "robot.radius_m",
        "serial.baud",
        "safety.lease_s",
    ]
    assert str(caught.value).startswith("run.yaml: 6 errors\n")


def test_a_misspelt_key_is_corrected_and_not_also_called_missing() -> None:
    assert the_problem(GOOD.replace("marker_id", "maker_id")) == (
        "robot.maker_id",
        "unknown key; did you mean 'marker_id'?",
    )


def test_a_key_in_the_wrong_section_is_told_its_home() -> None:
    key, message = the_problem(GOOD.replace("source: simulated", "source: simulated\n  baud: 9"))
    assert (key, message) == ("camera.baud", "unknown key here; did you mean 'serial.baud'?")


def test_a_key_like_no_other_is_told_what_there_is() -> None:
    _, message = the_problem(GOOD + "xyzzy: 1\n")
    assert message.startswith("unknown key; the keys here are arena, camera, ")


def test_a_missing_key_is_told_with_its_meaning_at_its_section() -> None:
    text = GOOD.replace("  marker_id: 7\n", "")
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "run.yaml")
    (problem,) = caught.value.problems
    assert problem.key == "robot.marker_id"
    assert problem.message == "is missing: the number of the marker on the robot"
    assert problem.mark is not None
    assert problem.mark.line == 5


def test_a_missing_section_is_told_at_the_beginning() -> None:
    told = text_of_error(GOOD.replace("arena:\n  bounds_m: [0, 0, 2.4, 1.8]\n", ""))
    assert told.startswith("run.yaml:1:1: arena: is missing: the free space\n")


@pytest.mark.parametrize(
    ("old", "new", "key", "message"),
    [
        ("marker_id: 7", "marker_id: -1", "robot.marker_id", "must be >= 0, not -1"),
        ("marker_id: 7", "marker_id: 7.0", "robot.marker_id", "must be a whole number, not 7.0"),
        ("marker_id: 7", "marker_id: '7'", "robot.marker_id", "must be a whole number, not '7'"),
        ("marker_id: 7", "marker_id: true", "robot.marker_id", "must be a whole number, not true"),
        ("marker_id: 7", "marker_id:", "robot.marker_id", "must be a whole number, not empty"),
        ("radius_m: 0.09", "radius_m: .nan", "robot.radius_m", "must be a finite number, not nan"),
        ("radius_m: 0.09", "radius_m: .inf", "robot.radius_m", "must be a finite number, not inf"),
        ("radius_m: 0.09", "radius_m: [1]", "robot.radius_m", "must be a number, not a list"),
        ("source: simulated", "source: -1", "camera.source", "must be a camera's number >= 0"),
        ("source: simulated", "source: true", "camera.source",
         "must be 'simulated', a camera's number, or a device, file or address"),
        ("[0, 0, 2.4, 1.8]", "[0, 0, 2.4]", "arena.bounds_m[3]", "is missing"),
        ("[0, 0, 2.4, 1.8]", "5", "arena.bounds_m", "must be a list, not 5"),
    ],
)  # fmt: skip
def test_wrong_values_are_told_with_what_must_be(
    old: str, new: str, key: str, message: str
) -> None:
    told_key, told = the_problem(GOOD.replace(old, new))
    assert told_key == key
    assert told.startswith(message)


def test_a_wrong_word_is_told_the_words_and_the_nearest() -> None:
    _, message = the_problem(GOOD + "mission: {order: bist}\n")
    assert message == "must be 'fixed' or 'best', not 'bist'; did you mean 'best'?"


@pytest.mark.parametrize("word", ["dark", "light"])
def test_each_polarity_is_accepted(word: str) -> None:
    assert parse_config(GOOD + f"vision: {{polarity: {word}}}").vision.polarity == word


@pytest.mark.parametrize("value", ["clearance", "length", "balanced", 0, 0.25, 1])
def test_preferences_are_words_or_numbers_up_to_one(value: str | float) -> None:
    assert parse_config(GOOD + f"planning: {{prefer: {value}}}").planning.prefer == value


@pytest.mark.parametrize("value", ["fast", -0.1, 1.1, "true", "[1]"])
def test_other_preferences_are_refused(value: str | float) -> None:
    key, message = the_problem(GOOD + f"planning: {{prefer: {value}}}")
    assert key == "planning.prefer"
    assert message.startswith("must be 'clearance', 'length', 'balanced' or a number in 0..1")


# What spans keys and sections.


@pytest.mark.parametrize(
    ("change", "key", "message"),
    [
        (("2.4, 1.8]", "0, 1.8]"), "arena.bounds_m", "must be [x_min"),
        (("marker_size_m: 0.09", "marker_size_m: 0.2"), "robot.marker_size_m", "must be <= 0.1273"),
        (("x_m: 0.2", "x_m: 0.05"), "simulation.start.x_m", "must be in 0.09..2.31"),
        (("marker_id: 7", "marker_id: 50"), "robot.marker_id", "must be < 50 in DICT_4X4_50"),
        (("source: simulated", "source: 0"), "camera", "needs a calibration"),
        (('arena_text: "C (1,1) 0.2"', "seed: 3"), "simulation", "needs an arena"),
    ],
)
def test_what_does_not_fit_together_is_told(
    change: tuple[str, str], key: str, message: str
) -> None:
    told_key, told = the_problem(GOOD.replace(*change))
    assert told_key == key
    assert told.startswith(message)


@pytest.mark.parametrize(
    ("addition", "key"),
    [
        ("mission: {stations: [{x_m: 1, y_m: 1}, {x_m: 9, y_m: 1}]}", "mission.stations[1].x_m"),
        ("planning: {spacing_m: 0.18}", "planning.spacing_m"),
        ("planning: {slow_speed_m_s: 0.4}", "planning.slow_speed_m_s"),
        ("safety: {lease_s: 0.1}", "safety.lease_s"),
        ("vision: {method: fixed}", "vision.method"),
        ("vision: {threshold: 10}", "vision.threshold"),
        ("other_robots: [{marker_id: 7, marker_size_m: 0.05, radius_m: 0.1}]",
         "other_robots[0].marker_id"),
        ("other_robots: [{marker_id: 8, marker_size_m: 0.5, radius_m: 0.1}]",
         "other_robots[0].marker_size_m"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_told_at_its_key(addition: str, key: str) -> None:
    assert the_problem(GOOD + addition)[0] == key


def test_simulated_parts_need_the_section() -> None:
    keys = [key for key, _ in problems_of(GOOD.split("simulation:")[0])]
    assert sorted(keys) == ["camera.source", "serial.port"]


def test_a_station_needs_room_for_the_body_not_only_for_its_centre() -> None:
    fits = GOOD + "mission: {stations: [{x_m: 2.31, y_m: 0.09}]}"
    assert parse_config(fits).mission.stations[0].x_m == 2.31
    assert the_problem(fits.replace("2.31", "2.32"))[0] == "mission.stations[0].x_m"


def test_a_configuration_cannot_be_changed() -> None:
    config = parse_config(GOOD)
    with pytest.raises(ValueError, match="frozen"):
        config.robot.radius_m = 1.0  # type: ignore[misc]


@given(st.floats(-1e6, 1e6))
def test_headings_come_out_in_the_half_open_circle(degrees: float) -> None:
    wrapped = wrapped_rad(degrees)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(math.radians(degrees)), abs=1e-6)
    assert math.sin(wrapped) == pytest.approx(math.sin(math.radians(degrees)), abs=1e-6)


def test_minus_180_degrees_is_plus_pi() -> None:
    assert wrapped_rad(-180) == math.pi


@pytest.mark.parametrize("name", get_args(Dictionary))
def test_each_dictionary_is_opencv_s_with_its_size(name: str) -> None:
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    assert dictionary_size(name) == len(dictionary.bytesList)


def test_the_planner_s_limits_are_the_configuration_s() -> None:
    config = parse_config(GOOD + "planning: {waypoint_spacing_m: 0.07, slow_speed_m_s: 0.1}\n")
    limits = limits_of(config)
    assert (limits.speed, limits.spacing, limits.slow_speed) == (0.3, 0.07, 0.1)
    assert limits.turns_on_spot
    assert limits.turning_radius == 0.0


def test_a_turning_radius_reaches_the_planner_and_is_no_wider_than_the_arena() -> None:
    text = GOOD.replace("radius_m: 0.09", "radius_m: 0.09\n  turning_radius_m: 0.2")
    assert text != GOOD
    assert limits_of(parse_config(text)).turning_radius == 0.2
    in_millimetres = text.replace("turning_radius_m: 0.2", "turning_radius_m: 200")
    ((where, told),) = problems_of(in_millimetres)
    assert where == "robot.turning_radius_m"
    assert told.startswith("must be <= ")
    assert told.endswith("the arena's longer side, not 200")
    ((where, told),) = problems_of(text.replace("turning_radius_m: 0.2", "turning_radius_m: -0.2"))
    assert (where, told) == ("robot.turning_radius_m", "must be >= 0, not -0.2")


def test_the_text_s_defaults_survive_pyyaml_as_well() -> None:
    """A configuration is plain YAML: PyYAML's own reader sees the same data."""
    assert yaml.safe_load(GOOD) == read_document(GOOD).data


def test_a_misspelt_key_hides_nothing_that_is_wrong_across_sections() -> None:
    text = GOOD + "planning: {slow_speed_m_s: 2.0, pefer: length}\n"
    assert dict(problems_of(text)) == {
        "planning.pefer": "unknown key; did you mean 'prefer'?",
        "planning.slow_speed_m_s": "must be <= 0.3, robot.speed_m_s, not 2",
    }


def test_a_preference_misspelt_is_guessed() -> None:
    key, told = the_problem(GOOD + "planning: {prefer: balansed}\n")
    assert key == "planning.prefer"
    assert told.endswith("not 'balansed'; did you mean 'balanced'?")


def test_a_token_that_is_refused_is_not_shown() -> None:
    told = text_of_error(GOOD + "dashboard:\n  token: short-secret\n")
    assert "dashboard.token" in told
    assert "at least 16 characters" in told
    assert "secret" not in told


def test_a_knock_ends_after_it_begins() -> None:
    text = GOOD + "  camera: {knocks: [{from_s: 4}, {from_s: 9, until_s: 3}]}\n"
    assert the_problem(text) == (
        "simulation.camera.knocks[1].until_s",
        "must be > 9, its from_s, not 3",
    )


@pytest.mark.parametrize(
    ("marker", "key", "message"),
    [
        ("marker_id: 7", "marker_id", "7 is a robot's or another floor marker's"),
        ("marker_id: 20", "marker_id", "20 is a robot's or another floor marker's"),
        ("marker_id: 50", "marker_id", "must be < 50 in DICT_4X4_50, not 50"),
        ("heading_deg: 5, marker_id: 21", "heading_deg", "needs place_m beside it"),
    ],
)
def test_floor_markers_are_told_apart_and_a_heading_has_a_place(
    marker: str, key: str, message: str
) -> None:
    lines = f"  floor_markers: [{{size_m: 0.1, marker_id: 20}}, {{size_m: 0.1, {marker}}}]\n"
    text = GOOD.replace("[0, 0, 2.4, 1.8]\n", f"[0, 0, 2.4, 1.8]\n{lines}")
    assert the_problem(text) == (f"arena.floor_markers[1].{key}", message)


def test_an_obstacle_vanishes_after_it_appears() -> None:
    text = GOOD + "  obstacles: [{record: 'C (1,1) 0.1', from_s: 9, until_s: 3}]\n"
    assert the_problem(text) == (
        "simulation.obstacles[0].until_s",
        "must be > 9, its from_s, not 3",
    )

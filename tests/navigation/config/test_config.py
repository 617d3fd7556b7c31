"""Configurations: every error at its place, all at once; overrides; what must fit together."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, get_args

import cv2
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from navigation.config import ConfigError, limits_of, load_config, parse_config
from navigation.config.checks import dictionary_size
from navigation.config.marks import read_document
from navigation.config.sections import Dictionary
from navigation.config.values import wrapped_rad

GOOD = """\
arena:
  bounds_m: [0, 0, 2.4, 1.8]
camera:
  source: simulated
robot:
  marker_id: 7
  marker_size_m: 0.09
  radius_m: 0.09
simulation:
  arena_text: "C (1,1) 0.2"
  start: {x_m: 0.2, y_m: 0.2}
"""


def _problems(text: str, **environment: str) -> list[tuple[str, str]]:
    """(key, message) of every problem."""
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "run.yaml", None, environment)
    return [(problem.key, problem.message) for problem in caught.value.problems]


def _the_problem(text: str, **environment: str) -> tuple[str, str]:
    (problem,) = _problems(text, **environment)
    return problem


def _text_of_error(text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "run.yaml")
    return str(caught.value)


def test_the_shortest_configuration_loads_with_its_defaults() -> None:
    config = parse_config(GOOD)
    assert config.camera.size_px == (1280, 960)
    assert config.robot.speed_m_s == 0.3
    assert config.mission.stations == ()
    assert config.planning.spacing_m is None


def test_an_error_shows_file_line_column_the_line_and_a_caret() -> None:
    told = _text_of_error(GOOD.replace("radius_m: 0.09", "radius_m: -3"))
    assert told == (
        "run.yaml:8:13: robot.radius_m: must be > 0, not -3\n      radius_m: -3\n                ^~"
    )


@pytest.mark.parametrize("length", [0, 40, 300, 3000])
def test_of_a_long_line_only_what_stands_around_the_mistake_is_shown(length: int) -> None:
    """And the caret stands under it there too."""
    line = f"  radius_m: [{'1, ' * length}wide{', 1' * length}]"
    told = _text_of_error(GOOD.replace("  radius_m: 0.09", line))
    assert max(map(len, told.splitlines())) < 160
    deep = "arena: {bounds_m: [0, 0, " + "[" * length + "wide" + "]" * length + ", 1.8]}"
    told = _text_of_error(GOOD.replace("arena:\n  bounds_m: [0, 0, 2.4, 1.8]", deep))
    shown, caret = told.splitlines()[1:3]
    assert max(map(len, told.splitlines())) < 160
    assert shown[caret.index("^")] in "[w"


def test_the_caret_stands_under_the_place_whatever_it_is() -> None:
    told = _text_of_error(GOOD.replace("[0, 0, 2.4, 1.8]", "[0, 0, wide, 1.8]")).splitlines()
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
    assert _the_problem(GOOD.replace("marker_id", "maker_id")) == (
        "robot.maker_id",
        "unknown key; did you mean 'marker_id'?",
    )


def test_a_key_in_the_wrong_section_is_told_its_home() -> None:
    key, message = _the_problem(GOOD.replace("source: simulated", "source: simulated\n  baud: 9"))
    assert (key, message) == ("camera.baud", "unknown key here; did you mean 'serial.baud'?")


def test_a_key_like_no_other_is_told_what_there_is() -> None:
    _, message = _the_problem(GOOD + "xyzzy: 1\n")
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
    told = _text_of_error(GOOD.replace("arena:\n  bounds_m: [0, 0, 2.4, 1.8]\n", ""))
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
    told_key, told = _the_problem(GOOD.replace(old, new))
    assert told_key == key
    assert told.startswith(message)


def test_a_wrong_word_is_told_the_words_and_the_nearest() -> None:
    _, message = _the_problem(GOOD + "mission: {order: bist}\n")
    assert message == "must be 'fixed' or 'best', not 'bist'; did you mean 'best'?"


@pytest.mark.parametrize("word", ["dark", "light"])
def test_each_polarity_is_accepted(word: str) -> None:
    assert parse_config(GOOD + f"vision: {{polarity: {word}}}").vision.polarity == word


@pytest.mark.parametrize("value", ["clearance", "length", "balanced", 0, 0.25, 1])
def test_preferences_are_words_or_numbers_up_to_one(value: str | float) -> None:
    assert parse_config(GOOD + f"planning: {{prefer: {value}}}").planning.prefer == value


@pytest.mark.parametrize("value", ["fast", -0.1, 1.1, "true", "[1]"])
def test_other_preferences_are_refused(value: str | float) -> None:
    key, message = _the_problem(GOOD + f"planning: {{prefer: {value}}}")
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
    told_key, told = _the_problem(GOOD.replace(*change))
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
    assert _the_problem(GOOD + addition)[0] == key


def test_simulated_parts_need_the_section() -> None:
    keys = [key for key, _ in _problems(GOOD.split("simulation:")[0])]
    assert sorted(keys) == ["camera.source", "serial.port"]


def test_a_station_needs_room_for_the_body_not_only_for_its_centre() -> None:
    fits = GOOD + "mission: {stations: [{x_m: 2.31, y_m: 0.09}]}"
    assert parse_config(fits).mission.stations[0].x_m == 2.31
    assert _the_problem(fits.replace("2.31", "2.32"))[0] == "mission.stations[0].x_m"


# The YAML itself.


def test_a_key_that_stands_twice_is_an_error_at_the_second() -> None:
    told = _text_of_error(GOOD + "camera: {source: 0}\n")
    assert told.startswith(
        "run.yaml:12:1: the key 'camera' stands here a second time, first in line 3"
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("# only a comment\n", "is empty"),
        ("- 1\n- 2\n", "must be sections"),
        ("arena: [1, 2\ncamera: 3\n", "not YAML: "),
        ("arena: {a: b: c}\n", "not YAML: "),
        ("a: \x00\n", "not YAML: the character '\\x00' is not allowed"),
        ("a: &x [*x]\n", "an alias inside itself"),
        ("? [1, 2]\n: 3\n", "a key must be a word"),
        ("3: 4\n", "a key must be a word"),
        ("a: *nowhere\n", "not YAML: found undefined alias"),
        ("a: !!python/object:os.system {}\n", ""),
        ("\ta: 1\n", "not YAML: "),
        ("a: 1\n---\nb: 2\n", "not YAML: "),
        ("a: !!timestamp x\n", ""),
        ("a: !!binary x\n", ""),
    ],
)
def test_what_is_not_a_configuration_at_all_is_a_clear_error(text: str, message: str) -> None:
    messages = [told for _, told in _problems(text)]
    assert any(message in told for told in messages)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001),
        ("1.5E3", 1500.0),
        ("0x10", 16),
        ("010", 10),
        ("1_000", "1_000"),
        ("on", "on"),
        ("no", "no"),
        ("12:30", "12:30"),
        ("2026-01-01", "2026-01-01"),
        ("true", True),
        ("~", None),
        ("'3'", "3"),
        (".5", 0.5),
        ("-.inf", -math.inf),
    ],
)
def test_scalars_are_those_of_yaml_1_2(text: str, value: object) -> None:
    assert read_document(text).data == value


def test_an_anchor_may_be_used_again() -> None:
    assert read_document("a: &p [1, 2]\nb: *p\n").data == {"a": [1, 2], "b": [1, 2]}


_SCALARS = (
    st.none()
    | st.booleans()
    | st.integers(-(10**9), 10**9)
    | st.floats(allow_nan=False)
    | st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Zl", "Zp")))
)
_TREES = st.recursive(
    _SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.from_regex(r"[a-z]{1,5}x", fullmatch=True), inner, max_size=3)
    ),
    max_leaves=12,
)


@given(_TREES)
def test_what_json_writes_is_read_back_with_a_mark_for_every_value(tree: Any) -> None:
    import json

    document = read_document(json.dumps(tree, ensure_ascii=False) if _finite(tree) else "{}")
    if not _finite(tree):
        return
    assert document.defects == []
    assert document.data == tree
    assert set(document.values) == set(_locations(tree, ()))


def _finite(tree: Any) -> bool:
    if isinstance(tree, dict):
        return all(_finite(v) for v in tree.values())
    if isinstance(tree, list):
        return all(_finite(v) for v in tree)
    return not isinstance(tree, float) or math.isfinite(tree)


def _locations(tree: Any, at: tuple[str | int, ...]) -> list[tuple[str | int, ...]]:
    inner: list[tuple[str | int, Any]] = []
    if isinstance(tree, dict):
        inner = list(tree.items())
    elif isinstance(tree, list):
        inner = list(enumerate(tree))
    return [at, *(where for key, value in inner for where in _locations(value, (*at, key)))]


@given(st.text())
def test_no_text_does_anything_but_load_or_raise_a_configuration_error(text: str) -> None:
    with pytest.raises(ConfigError):
        parse_config(text)


@given(
    st.sampled_from(GOOD.split()), st.sampled_from(["", "[", "{", "x: ", "- ", "&a ", "1", "\t"])
)
def test_a_damaged_configuration_loads_or_is_refused_with_a_place(word: str, put: str) -> None:
    told = _attempt(GOOD.replace(word, put, 1))
    assert told is None or (told.problems and all(problem.message for problem in told.problems))


def _attempt(text: str) -> ConfigError | None:
    try:
        parse_config(text, "run.yaml")
    except ConfigError as error:
        return error
    return None


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
    problems = _problems(STATIONS, **{f"CLEARWAY_MISSION__STATIONS__{entry.upper()}__X_M": "1"})
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
    key, message = _the_problem(GOOD, CLEARWAY_SERIEL__BAUD="9600")
    assert (key, message) == ("seriel", "unknown key; did you mean 'serial'?")


def test_an_override_that_is_not_yaml_is_an_error() -> None:
    key, _ = _the_problem(GOOD, CLEARWAY_MISSION__STATIONS="[")
    assert key == "mission.stations"


def test_an_override_may_mend_the_file() -> None:
    text = GOOD.replace("radius_m: 0.09", "radius_m: -1")
    config = parse_config(text, environment={"CLEARWAY_ROBOT__RADIUS_M": "0.1"})
    assert config.robot.radius_m == 0.1


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
    ((where, told),) = _problems(in_millimetres)
    assert where == "robot.turning_radius_m"
    assert told.startswith("must be <= ")
    assert told.endswith("the arena's longer side, not 200")
    ((where, told),) = _problems(text.replace("turning_radius_m: 0.2", "turning_radius_m: -0.2"))
    assert (where, told) == ("robot.turning_radius_m", "must be >= 0, not -0.2")


def test_the_text_s_defaults_survive_pyyaml_as_well() -> None:
    """A configuration is plain YAML: PyYAML's own reader sees the same data."""
    assert yaml.safe_load(GOOD) == read_document(GOOD).data


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


def test_a_misspelt_key_hides_nothing_that_is_wrong_across_sections() -> None:
    text = GOOD + "planning: {slow_speed_m_s: 2.0, pefer: length}\n"
    assert dict(_problems(text)) == {
        "planning.pefer": "unknown key; did you mean 'prefer'?",
        "planning.slow_speed_m_s": "must be <= 0.3, robot.speed_m_s, not 2",
    }


def test_a_preference_misspelt_is_guessed() -> None:
    key, told = _the_problem(GOOD + "planning: {prefer: balansed}\n")
    assert key == "planning.prefer"
    assert told.endswith("not 'balansed'; did you mean 'balanced'?")


def test_a_token_that_is_refused_is_not_shown() -> None:
    told = _text_of_error(GOOD + "dashboard:\n  token: short-secret\n")
    assert "dashboard.token" in told
    assert "at least 16 characters" in told
    assert "secret" not in told


def test_an_obstacle_vanishes_after_it_appears() -> None:
    text = GOOD + "  obstacles: [{record: 'C (1,1) 0.1', from_s: 9, until_s: 3}]\n"
    assert _the_problem(text) == (
        "simulation.obstacles[0].until_s",
        "must be > 9, its from_s, not 3",
    )

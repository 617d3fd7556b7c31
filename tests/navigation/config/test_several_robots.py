"""Several robots in one configuration: each as if it were alone, and doubles are refused."""

import json
import pickle
from typing import Any

import pytest
from pydantic import BaseModel

from navigation.config import Config, parse_config
from navigation.config.sections import (
    CameraEntry,
    CameraSection,
    RobotEntry,
    RobotSection,
    SerialSection,
)
from navigation.config.several.each_robot import each_robot, settled
from tests.navigation.config.texts import problems_of, the_problem

FLEET = """\
arena:
  bounds_m: [0, 0, 2.4, 1.8]
camera:
  source: simulated
robot:
  marker_id: 0
  marker_size_m: 0.09
  radius_m: 0.09
  speed_m_s: 0.3
robots:
  - {name: ada, marker_id: 1, speed_m_s: 0.2}
  - {name: bob, marker_id: 2, port: /dev/ttyUSB1, baud: 9600}
mission:
  robots:
    - {name: ada, stations: [{x_m: 2.0, y_m: 0.3}]}
    - {name: bob, stations: [{x_m: 0.4, y_m: 0.3}]}
simulation:
  arena_text: "C (1,1) 0.2"
  starts:
    - {name: ada, x_m: 0.2, y_m: 0.2}
    - {name: bob, x_m: 2.0, y_m: 1.5}
recording:
  journal: kept/journal
"""


def test_each_robot_is_the_default_with_what_differs() -> None:
    robots = each_robot(parse_config(FLEET))
    assert list(robots) == ["ada", "bob"]
    ada, bob = robots["ada"], robots["bob"]
    assert (ada.robot.marker_id, ada.robot.speed_m_s, ada.robot.radius_m) == (1, 0.2, 0.09)
    assert (bob.robot.marker_id, bob.robot.speed_m_s) == (2, 0.3)
    assert (ada.serial.port, ada.serial.baud) == ("simulated", 115_200)
    assert (bob.serial.port, bob.serial.baud) == ("/dev/ttyUSB1", 9600)
    assert [(s.x_m, s.y_m) for s in ada.mission.stations] == [(2.0, 0.3)]
    assert ada.simulation is not None
    assert ada.simulation.start is not None
    assert ada.simulation.start.x_m == 0.2
    assert str(bob.recording.journal) == "kept/journal.bob"


def test_simulated_robots_have_errors_of_their_own() -> None:
    robots = each_robot(parse_config(FLEET)).values()
    seeds = [one.simulation.seed for one in robots if one.simulation is not None]
    assert len(set(seeds)) == 2


def test_a_list_with_one_robot_is_that_robot_alone() -> None:
    text = FLEET.replace("  - {name: bob, marker_id: 2, port: /dev/ttyUSB1, baud: 9600}\n", "")
    text = text.replace("    - {name: bob, stations: [{x_m: 0.4, y_m: 0.3}]}\n", "")
    text = text.replace("    - {name: bob, x_m: 2.0, y_m: 1.5}\n", "")
    config = settled(parse_config(text))
    assert config.robots == ()
    assert (config.robot.marker_id, config.robot.speed_m_s) == (1, 0.2)
    assert len(config.mission.stations) == 1
    assert str(config.recording.journal) == "kept/journal"


@pytest.mark.parametrize(
    ("change", "key", "message"),
    [
        (
            ("name: bob, marker_id: 2", "name: ada, marker_id: 2"),
            "robots[1].name",
            "'ada' is the name of robots[0] already",
        ),
        (
            ("bob", "zones"),
            "robots[1].name",
            "'zones': journal.zones keeps the changes of zones",
        ),
        (
            ("marker_id: 2", "marker_id: 1"),
            "robots[1].marker_id",
            "1 is robots[0] (ada)'s already",
        ),
        (
            ("marker_id: 1,", "marker_id: 1, port: /dev/ttyUSB1,"),
            "robots[1].port",
            "'/dev/ttyUSB1' is the port of robots[0] (ada) already: each needs its own",
        ),
        (
            ("x_m: 0.4, y_m: 0.3", "x_m: 2.1, y_m: 0.3"),
            "mission.robots[1].stations[0]",
            "the goals of ada and bob are 0.1 m apart: must be >= 0.18, both radii together",
        ),
        (
            ("x_m: 2.0, y_m: 1.5", "x_m: 0.2, y_m: 0.3"),
            "simulation.starts[1]",
            "the starts of ada and bob are 0.1 m apart: must be >= 0.18, both radii together",
        ),
        (
            ("- {name: bob, x_m", "- {name: ada, x_m"),
            "simulation.starts[1].name",
            "'ada' is the name of simulation.starts[0] already",
        ),
        (
            ("- {name: bob, stations", "- {name: ada, stations"),
            "mission.robots[1].name",
            "'ada' is the name of mission.robots[0] already",
        ),
        (
            ("    - {name: ada, x_m: 0.2, y_m: 0.2}\n", ""),
            "simulation.starts",
            "needs the start of ada",
        ),
        (
            ("mission:\n", "mission:\n  stations: [{x_m: 1.5, y_m: 0.3}]\n"),
            "mission.stations",
            "are one robot's: with several use mission.robots, by name, or tasks",
        ),
        (
            ("speed_m_s: 0.2}", "track_m: 0.3}"),
            "robots[0].track_m",
            "must be <= 0.18, the body's width, not 0.3",
        ),
        (
            ("recording:", "tasks: [{x_m: 1.5, y_m: 0.3}]\nrecording:"),
            "tasks",
            "1 tasks for 0 robots without stations of their own: one for each at most",
        ),
        (
            ("marker_id: 2", "marker_id: 2, driver: epuck"),
            "robots[1].driver",
            "must be 'clearway', 'create2', 'turtlebot3', 'epuck2' or 'waveshare', not 'epuck'; "
            "did you mean 'epuck2'?",
        ),
        (
            ("marker_id: 2", "marker_id: 2, driver: epuck2, speed_m_s: 0.2"),
            "robots[1].speed_m_s",
            "must be <= 0.128, the e-puck2's, not 0.2",
        ),
        (
            ("marker_id: 2", "marker_id: 2, driver: epuck2"),
            "robot.speed_m_s",
            "for bob: must be <= 0.128, the e-puck2's, not 0.3",
        ),
        (
            ("marker_id: 2", "marker_id: 2, model: ugv01"),
            "robots[1].model",
            "'ugv01' is no model for robot.driver 'clearway': leave it out",
        ),
        (
            ("marker_id: 2", "marker_id: 2, dictionary: DICT_5X5_50"),
            "robots[1].dictionary",
            "must be DICT_4X4_50, as robot.dictionary, not DICT_5X5_50: a picture is searched for "
            "one family",
        ),
    ],
)
def test_what_does_not_fit_is_said_at_its_place(
    change: tuple[str, str], key: str, message: str
) -> None:
    assert change[0] in FLEET
    assert (key, message) in problems_of(FLEET.replace(*change))


def test_a_mission_of_a_robot_that_there_is_not_names_those_there_are() -> None:
    text = FLEET.replace("{name: bob, stations", "{name: bop, stations")
    assert the_problem(text) == (
        "mission.robots[1].name",
        "'bop' is none of robots: ada, bob",
    )


def test_a_goal_outside_the_arena_is_said_for_each_robot() -> None:
    key, message = the_problem(FLEET.replace("x_m: 0.4, y_m: 0.3", "x_m: 2.39, y_m: 1.0"))
    assert key == "mission.robots[1].stations[0].x_m"
    assert "0.09..2.31" in message


REAL_PORTS = """\
arena:
  bounds_m: [0, 0, 2.4, 1.8]
camera:
  source: /dev/video0
  calibration: lens.yaml
robot: {marker_id: 0, marker_size_m: 0.07, radius_m: 0.07}
robots:
  - {name: ada, marker_id: 1, port: /dev/ttyUSB1}
  - {name: bob, marker_id: 2, port: /dev/ttyUSB2}
"""


def test_robots_that_each_have_a_port_need_no_default_and_no_simulation() -> None:
    robots = each_robot(parse_config(REAL_PORTS))
    assert [one.serial.port for one in robots.values()] == ["/dev/ttyUSB1", "/dev/ttyUSB2"]


def test_a_robot_that_is_simulated_still_needs_a_simulation() -> None:
    needs = "'simulated' needs a section 'simulation'"
    without = REAL_PORTS.replace(", port: /dev/ttyUSB2", "")
    assert the_problem(without) == ("serial.port", needs)
    simulated = REAL_PORTS.replace("/dev/ttyUSB2", "simulated")
    assert the_problem(simulated) == ("robots[1].port", needs)


def test_a_default_that_every_robot_overrides_is_not_checked_with_other_keys() -> None:
    """A floor marker may have the number of the default, whose track is wider than its body."""
    text = REAL_PORTS.replace("radius_m: 0.07}", "radius_m: 0.07, track_m: 0.2, speed_m_s: 0.05}")
    text = text.replace("port:", "radius_m: 0.12, speed_m_s: 0.2, port:")
    text = text.replace("2.4, 1.8]", "2.4, 1.8]\n  floor_markers: [{marker_id: 0, size_m: 0.1}]")
    assert [one.robot.track_m for one in each_robot(parse_config(text)).values()] == [0.2, 0.2]


def test_a_default_that_does_not_fit_to_one_robot_s_own_values_is_said_with_its_name() -> None:
    text = REAL_PORTS.replace("marker_id: 2", "marker_id: 2, radius_m: 0.06")
    text = text.replace("radius_m: 0.07}", "radius_m: 0.07, track_m: 0.13}")
    assert the_problem(text) == (
        "robot.track_m",
        "for bob: must be <= 0.12, the body's width, not 0.13",
    )


def test_a_default_that_fits_no_robot_is_said_once() -> None:
    text = REAL_PORTS.replace("radius_m: 0.07}", "radius_m: 0.07, track_m: 0.2}")
    assert the_problem(text) == ("robot.track_m", "must be <= 0.14, the body's width, not 0.2")


def test_an_address_is_refused_at_the_robot_whose_port_it_is() -> None:
    told = "an address needs a robot.driver other than 'clearway'"
    text = REAL_PORTS.replace("/dev/ttyUSB2", "socket://10.0.0.7:5000")
    assert the_problem(text) == ("robots[1].port", told)


def test_a_default_port_that_nobody_uses_may_be_anything() -> None:
    text = REAL_PORTS + "serial: {port: 'socket://10.0.0.7:5000'}\n"
    assert len(parse_config(text).robots) == 2


KEYS = {
    "marker_id": 7,
    "marker_size_m": 0.08,
    "marker_height_m": 0.05,
    "radius_m": 0.2,
    "driver": "waveshare",
    "model": "ugv_rover",
    "dictionary": "DICT_4X4_50",
    "marker_turn_deg": 90.0,
    "speed_m_s": 0.25,
    "acceleration_m_s2": 0.4,
    "lateral_acceleration_m_s2": 0.3,
    "jerk_m_s3": 4.0,
    "angular_rate_rad_s": 1.5,
    "angular_acceleration_rad_s2": 5.0,
    "track_m": 0.14,
    "least_wheel_m_s": 0.015,
    "turns_on_spot": True,
    "turning_radius_m": 0.1,
}
"""A value for every key of `robot`."""


def test_every_key_of_robot_is_one_robot_s_own_where_its_entry_has_it() -> None:
    assert KEYS.keys() == RobotSection.model_fields.keys()
    own = ", ".join(f"{key}: {json.dumps(value)}" for key, value in KEYS.items())
    text = FLEET.replace("{name: ada, marker_id: 1, speed_m_s: 0.2}", f"{{name: ada, {own}}}")
    text = text.replace("{name: ada, x_m: 0.2, y_m: 0.2}", "{name: ada, x_m: 0.3, y_m: 0.3}")
    robots = each_robot(parse_config(text))
    assert robots["ada"].robot.model_dump() == KEYS
    assert robots["bob"].robot == parse_config(FLEET).robot.model_copy(update={"marker_id": 2})


@pytest.mark.parametrize(
    ("entry", "sections", "left_out"),
    [
        (RobotEntry, (RobotSection, SerialSection), set()),
        (CameraEntry, (CameraSection,), {"metres_per_pixel"}),
    ],
)
def test_an_entry_has_the_limits_of_the_section_whose_keys_it_may_have(
    entry: type[BaseModel], sections: tuple[type[BaseModel], ...], left_out: set[str]
) -> None:
    """Each key is optional, and else what it is in its section."""
    whole = Config.model_json_schema()["$defs"]
    mine = whole[entry.__name__]["properties"]
    assert mine.keys() == {"name"} | {k for one in sections for k in one.model_fields} - left_out
    for section in sections:
        for key, schema in whole[section.__name__]["properties"].items():
            held = [limits_in(way) for way in mine[key].get("anyOf", ())] if key in mine else ()
            for way in schema.get("anyOf", [schema]) if held else ():
                assert limits_in(way) in held, key


def limits_in(schema: dict[str, Any]) -> dict[str, Any]:
    words = ("title", "default", "description")
    return {key: value for key, value in schema.items() if key not in words}


def test_entries_survive_the_way_to_another_process() -> None:
    config = parse_config(FLEET)
    assert pickle.loads(pickle.dumps(config)) == config

"""Several cameras in one configuration: each as if it were alone, and what cannot be is refused."""

from typing import Any

import pytest
import yaml

from navigation.config import parse_config
from navigation.config.reference import json_schema
from navigation.config.several.each_camera import each_camera
from tests.navigation.config.texts import the_problem

TWO = """\
arena:
  bounds_m: [0, 0, 2.4, 1.8]
camera:
  source: /dev/video0
  calibration: left.yaml
  rate_hz: 20
cameras:
  - {name: left}
  - {name: right, source: /dev/video1, calibration: right.yaml, exposure_ms: 5}
robot:
  marker_id: 0
  marker_size_m: 0.09
  radius_m: 0.09
serial:
  port: /dev/ttyUSB0
"""
SIMULATED = """\
arena:
  bounds_m: [0, 0, 2.4, 1.8]
camera:
  source: simulated
cameras:
  - {name: left}
  - {name: right}
robot:
  marker_id: 0
  marker_size_m: 0.09
  radius_m: 0.09
simulation:
  arena_text: "C (1,1) 0.2"
  start: {x_m: 0.3, y_m: 0.3}
  cameras:
    - {name: right, position_m: [1.8, 0.9, 2.5]}
"""


def test_each_camera_is_the_default_with_what_differs() -> None:
    cameras = each_camera(parse_config(TWO))
    assert list(cameras) == ["left", "right"]
    left, right = cameras["left"].camera, cameras["right"].camera
    assert (left.source, str(left.calibration), left.exposure_ms) == (
        "/dev/video0", "left.yaml", "auto",
    )  # fmt: skip
    assert (right.source, str(right.calibration), right.exposure_ms) == (
        "/dev/video1", "right.yaml", 5.0,
    )  # fmt: skip
    assert left.rate_hz == right.rate_hz == 20.0


def test_one_camera_is_as_it_was() -> None:
    text = SIMULATED.replace("cameras:\n  - {name: left}\n  - {name: right}\n", "", 1)
    alone = parse_config(text[: text.index("  cameras:")])
    assert each_camera(alone) == {}
    assert alone.camera.source == "simulated"


def test_simulated_cameras_hang_where_they_are_said_to_with_noise_of_their_own() -> None:
    cameras = each_camera(parse_config(SIMULATED))
    left, right = cameras["left"].simulation, cameras["right"].simulation
    assert left is not None
    assert right is not None
    assert left.camera.position_m == (1.155, 0.975, 2.5)
    assert right.camera.position_m == (1.8, 0.9, 2.5)
    assert left.seed != right.seed


@pytest.mark.parametrize(
    ("was", "now", "sentence"),
    [
        ("{name: right, source", "{name: left, source", "'left' is the name of cameras[0] already"),
        ("/dev/video1", "/dev/video0", "'/dev/video0' is the source of cameras[0] already"),
        ("right.yaml", "left.yaml", "'left.yaml' is the calibration of cameras[0] already"),
        ("  - {name: left}\n", "", "one camera is written as 'camera'"),
        ("  calibration: left.yaml\n", "", "'left' needs a calibration of its own"),
    ],
)
def test_what_cannot_be_two_cameras_is_refused(was: str, now: str, sentence: str) -> None:
    assert sentence in the_problem(TWO.replace(was, now))[1]


def test_a_simulated_camera_that_there_is_not_is_refused() -> None:
    text = SIMULATED.replace("{name: right, position_m", "{name: back, position_m")
    assert "'back' is none of cameras: left, right" in the_problem(text)[1]


def test_floor_markers_of_several_cameras_need_a_place() -> None:
    line = next(one for one in SIMULATED.splitlines(keepends=True) if "bounds_m:" in one)
    text = SIMULATED.replace(
        line, line + "  floor_markers:\n    - {marker_id: 40, size_m: 0.1}\n", 1
    )
    assert "floor marker 40 needs a place_m" in the_problem(text)[1]
    placed = text.replace("size_m: 0.1}", "size_m: 0.1, place_m: [-0.2, 0.9]}", 1)
    assert parse_config(placed).arena.floor_markers[0].place_m == (-0.2, 0.9)


def test_a_knock_of_one_simulated_camera_ends_after_it_begins() -> None:
    text = SIMULATED.replace("2.5]}", "2.5], knocks: [{from_s: 3, until_s: 2}]}", 1)
    place, sentence = the_problem(text)[:2]
    assert "must be > 3, its from_s" in sentence
    assert "cameras" in str(place)


def test_several_robots_may_have_several_cameras() -> None:
    robots = "robots:\n  - {name: a, marker_id: 1}\n  - {name: b, marker_id: 2}\n"
    text = SIMULATED.replace(
        "simulation:\n",
        robots + "simulation:\n  starts:\n"
        "    - {name: a, x_m: 0.3, y_m: 0.3}\n    - {name: b, x_m: 2, y_m: 1}\n",
    )
    config = parse_config(text)
    assert (len(config.robots), len(config.cameras)) == (2, 2)


EACH_NAMES_ITS_SOURCE = TWO.replace("  source: /dev/video0\n", "").replace(
    "{name: left}", "{name: left, source: /dev/video0}"
)


def test_cameras_that_each_name_a_source_need_no_default() -> None:
    cameras = each_camera(parse_config(EACH_NAMES_ITS_SOURCE))
    assert [one.camera.source for one in cameras.values()] == ["/dev/video0", "/dev/video1"]


def test_a_camera_without_a_source_needs_the_default() -> None:
    key, message = the_problem(EACH_NAMES_ITS_SOURCE.replace(", source: /dev/video0", ""))
    assert key == "camera.source"
    assert message.startswith("is missing")


def accepts(schema: Any, data: Any) -> bool:
    """True if the data has what a JSON Schema requires; other limits are not looked at."""
    if "$ref" in schema:
        return accepts(json_schema()["$defs"][schema["$ref"].rpartition("/")[2]], data)
    if isinstance(data, list):
        inside = all(accepts(schema.get("items", {}), one) for one in data)
        return inside and len(data) >= schema.get("minItems", 0)
    if not isinstance(data, dict):
        return True
    known = schema.get("properties", {})
    return (
        all(key in data for key in schema.get("required", ()))
        and all(accepts(known.get(key, {}), value) for key, value in data.items())
        and ("anyOf" not in schema or any(accepts(one, data) for one in schema["anyOf"]))
    )


def test_the_schema_for_editors_requires_a_source_where_the_program_does() -> None:
    one_camera = TWO[: TWO.index("cameras:")] + TWO[TWO.index("robot:") :]
    no_camera = EACH_NAMES_ITS_SOURCE.replace("camera:\n  calibration: left.yaml\n", "")
    for text, is_right in (
        (TWO, True),
        (one_camera, True),
        (EACH_NAMES_ITS_SOURCE, True),
        (no_camera.replace("  rate_hz: 20\n", ""), True),
        (EACH_NAMES_ITS_SOURCE.replace(", source: /dev/video0", ""), False),
        (one_camera.replace("  source: /dev/video0\n", ""), False),
        (one_camera.replace("  source: /dev/video0\n", "") + "cameras: []\n", False),
    ):
        assert accepts(json_schema(), yaml.safe_load(text)) == is_right

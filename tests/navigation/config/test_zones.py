"""Zones in a configuration: each becomes the planner's, and a wrong one is refused."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from navigation.config import ConfigError, parse_config
from navigation.config.several.each_robot import settled
from navigation.config.zones import ZoneSection
from navigation.config.zones.in_words import as_written, as_yaml, in_words
from planner.formats.mask_files import load_mask
from planner.zones.areas import BandArea, CircleArea, MaskArea, PolygonArea
from planner.zones.zone import Zone
from tests.navigation.config.test_several_robots import FLEET
from tests.navigation.config.texts import GOOD, problems_of, the_problem

ALL_KINDS = """\
zones:
  - name: desk
    kind: keep_out
    polygon: [[0.5, 0.5], [1, 0.5], [1, 1]]
  - {name: bend, kind: slow, circle: [1.2, 0.9, 0.3], speed_m_s: 0.1}
  - {name: alley, kind: one_way, line: [[0, 1], [2, 1]], width_m: 0.4}
  - {name: road, kind: lane, line: [[0, 0.2], [2, 0.2]], width_m: 0.3, cost: 0.4}
  - {name: door, kind: wait, circle: [2, 1, 0.2]}
"""
MASK_YAML = "image: mask.pgm\nresolution: 0.2\norigin: [0, 0, 0]\nmode: scale\n" \
    "occupied_thresh: 0.65\nfree_thresh: 0.0\nnegate: 0\n"  # fmt: skip


def write_mask(folder: Path, *, occupied: bool = True) -> Path:
    """A mask of 4 x 4 cells of 0.2 m; the lower left one is the zone."""
    folder.mkdir(exist_ok=True)
    cells = bytearray([255] * 16)
    if occupied:
        cells[12] = 0
    (folder / "mask.pgm").write_bytes(b"P5 4 4 255\n" + bytes(cells))
    file = folder / "mask.yaml"
    file.write_text(MASK_YAML)
    return file


def with_zones(*lines: str) -> str:
    return GOOD + "zones:\n" + "".join(f"  - {line}\n" for line in lines)


def test_every_kind_becomes_the_planners_zone() -> None:
    zones = [one.zone() for one in parse_config(GOOD + ALL_KINDS).zones]
    assert zones == [
        Zone("desk", "keep_out", PolygonArea(((0.5, 0.5), (1.0, 0.5), (1.0, 1.0)))),
        Zone("bend", "slow", CircleArea((1.2, 0.9), 0.3), speed=0.1),
        Zone("alley", "one_way", BandArea(((0.0, 1.0), (2.0, 1.0)), 0.4)),
        Zone("road", "lane", BandArea(((0.0, 0.2), (2.0, 0.2)), 0.3), cost=0.4),
        Zone("door", "wait", CircleArea((2.0, 1.0), 0.2)),
    ]


@pytest.mark.parametrize(
    ("zone", "key", "says"),
    [
        ("{name: a, kind: keep_out}", "zones[0]", "no area"),
        (
            "{name: a, kind: keep_out, circle: [1, 1, 1], polygon: [[0, 0], [1, 0], [0, 1]]}",
            "zones[0]",
            "polygon and circle",
        ),
        ("{name: a, kind: slow, circle: [1, 1, 0.5]}", "zones[0]", "needs a speed"),
        (
            "{name: a, kind: slow, circle: [1, 1, 0.5], speed_m_s: 0.009}",
            "zones[0].speed_m_s",
            "must be >= 0.01",
        ),
        ("{name: a, kind: lane, circle: [1, 1, 0.5]}", "zones[0]", "needs a line"),
        ("{name: a, kind: one_way, line: [[0, 0], [1, 0]]}", "zones[0]", "given together"),
        ("{name: a, kind: keep_in, circle: [1, 1, 0.5]}", "zones[0].kind", "did you mean"),
        ("{name: a, kind: keep_out, circle: [9, 9, 1]}", "zones[0]", "outside the arena"),
        ("{name: a, kind: keep_out, circle: [1, 1, 1], robots: [ada]}", "zones[0].robots", "ada"),
        (
            "{name: a, kind: keep_out, polygon: [[0, 0], [1, 1], [1, 0], [0, 1]]}",
            "zones[0]",
            "cross",
        ),
    ],
)
def test_a_wrong_zone_is_refused_in_one_sentence(zone: str, key: str, says: str) -> None:
    where, sentence = the_problem(with_zones(zone))
    assert where == key
    assert says in sentence
    assert "\n" not in sentence


def test_a_line_has_at_most_100_places() -> None:
    line = [[0.01 * k, 1.0] for k in range(101)]
    zone = {"name": "a", "kind": "lane", "line": line, "width_m": 0.1}
    where, sentence = the_problem(GOOD + yaml.safe_dump({"zones": [zone]}))
    assert where == "zones[0].line"
    assert "100" in sentence
    assert parse_config(GOOD + yaml.safe_dump({"zones": [{**zone, "line": line[:100]}]})).zones


def test_a_circle_that_reaches_into_the_arena_is_taken() -> None:
    assert parse_config(with_zones("{name: a, kind: keep_out, circle: [-0.9, 1, 1]}")).zones
    assert problems_of(with_zones("{name: a, kind: keep_out, circle: [-1.1, 1, 1]}"))


def test_two_zones_of_one_name_are_refused() -> None:
    one = "{name: a, kind: keep_out, circle: [1, 1, 0.2]}"
    assert the_problem(with_zones(one, one)) == (
        "zones[1].name",
        "'a' is the name of zones[0] already",
    )


def test_robots_of_a_zone_have_to_be_in_the_list() -> None:
    zones = "zones:\n  - {name: a, kind: wait, circle: [1, 1, 0.2], robots: [ada, eve]}\n"
    assert the_problem(FLEET + zones) == ("zones[0].robots", "'eve' is none of robots: ada, bob")
    assert parse_config(FLEET + zones.replace(", eve", "")).zones[0].robots == ("ada",)


def test_a_robot_is_named_once_in_a_zone() -> None:
    robots = "robots: [bob, ada, bob]"
    zones = f"zones:\n  - {{name: a, kind: wait, circle: [1, 1, 0.2], {robots}}}\n"
    sentence = "'bob' is robots[0] and robots[2]: must be named once"
    assert the_problem(FLEET + zones) == ("zones[0].robots", sentence)


def test_a_robot_of_a_list_of_one_keeps_the_zones_that_are_for_it() -> None:
    one = GOOD.replace("  start:", "  starts: [{name: ada, x_m: 0.2, y_m: 0.2}]\n  #").replace(
        "simulation:", "robots: [{name: ada, marker_id: 1}]\nsimulation:"
    )
    all_robots = "{name: a, kind: wait, circle: [1, 1, 0.2]}"
    for_ada = "{name: b, kind: wait, circle: [1, 1, 0.2], robots: [ada]}"
    config = settled(parse_config(one + f"zones:\n  - {all_robots}\n  - {for_ada}\n"))
    assert [(zone.name, zone.robots) for zone in config.zones] == [("a", ()), ("b", ())]
    assert config.zones[1].zone().robots == ()


def test_each_of_several_robots_has_the_zones_that_are_for_it() -> None:
    from navigation.config.several.each_robot import each_robot

    zones = "zones:\n  - {name: a, kind: wait, circle: [1, 1, 0.2], robots: [ada]}\n"
    robots = each_robot(parse_config(FLEET + zones))
    assert [len(robots[name].zones) for name in ("ada", "bob")] == [1, 0]


def test_a_mask_is_read_beside_the_configuration(tmp_path: Path) -> None:
    write_mask(tmp_path)
    text = with_zones("{name: a, kind: keep_out, mask: mask.yaml}")
    config = parse_config(text, "run.yaml", tmp_path)
    area = config.zones[0].zone().area
    assert isinstance(area, MaskArea)
    assert len(area.objects) == 1
    (tmp_path / "mask.pgm").unlink()  # it was read: what holds does not change with the file
    assert config.zones[0].zone().area == area


def test_a_mask_s_picture_may_be_png_and_has_to_be_whole(tmp_path: Path) -> None:
    file = write_mask(tmp_path)
    file.write_text(file.read_text().replace("mask.pgm", "mask.png"))
    picture = tmp_path / "mask.png"
    text = with_zones("{name: a, kind: keep_out, mask: mask.yaml}")
    cells = cv2.imread(str(tmp_path / "mask.pgm"), cv2.IMREAD_UNCHANGED)
    clear = np.dstack([cells, cells, cells, np.full_like(cells, 255)])
    clear[0, 0] = (0, 0, 0, 0)  # transparent is unknown, and no zone
    expected = MaskArea(load_mask(write_mask(tmp_path / "pgm")).objects, str(file))
    for image in (cells, cells.astype(np.uint16) * 257, clear):
        cv2.imwrite(str(picture), image)
        assert parse_config(text, "run.yaml", tmp_path).zones[0].zone().area == expected
    whole = picture.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 0xFF
    jpeg = cv2.imencode(".jpg", cells)[1].tobytes()
    for damaged in (*(whole[:end] for end in range(len(whole))), bytes(flipped), jpeg):
        picture.write_bytes(damaged)
        with pytest.raises(ConfigError, match=r"mask\.png: "):
            parse_config(text, "run.yaml", tmp_path)


def test_an_unreadable_mask_is_named(tmp_path: Path) -> None:
    text = with_zones("{name: a, kind: keep_out, mask: mask.yaml}")
    file = tmp_path / "mask.yaml"
    for content in (None, "image: none.pgm\nresolution: 0.2\norigin: [0, 0, 0]\n", "nonsense"):
        if content is not None:
            file.write_text(content)
        with pytest.raises(ConfigError) as caught:
            parse_config(text, "run.yaml", tmp_path)
        (problem,) = caught.value.problems
        assert problem.key == "zones[0]"
        assert str(tmp_path) in problem.message
    write_mask(tmp_path, occupied=False)
    with pytest.raises(ConfigError, match=r"mask\.yaml: has no occupied cell"):
        parse_config(text, "run.yaml", tmp_path)


def test_a_zone_is_said_in_a_line() -> None:
    assert [in_words(one) for one in parse_config(GOOD + ALL_KINDS).zones] == [
        "keep-out zone 'desk': polygon of 3 corners",
        "slow zone 'bend': circle of 0.3 m around (1.2, 0.9) m, 0.1 m/s",
        "one-way zone 'alley': band 0.4 m wide from (0, 1) to (2, 1) m",
        "lane 'road': band 0.3 m wide from (0, 0.2) to (2, 0.2) m, cost 0.4",
        "no-waiting zone 'door': circle of 0.2 m around (2, 1) m",
    ]


def test_a_list_that_was_written_is_read_back(tmp_path: Path) -> None:
    mask = f"  - {{name: m, kind: keep_out, mask: {write_mask(tmp_path)}}}\n"
    zones = parse_config(GOOD + ALL_KINDS + mask).zones
    assert parse_config(GOOD + as_yaml([*map(as_written, zones)])).zones == zones
    assert [ZoneSection.model_validate(as_written(one)) for one in zones] == list(zones)
    assert yaml.safe_load(as_yaml(())) == {"zones": []}


def test_all_zones_together_have_at_most_2000_places() -> None:
    turns = [0.001 * math.tau * k for k in range(700)]
    polygon = [[1.0 + 0.2 * math.cos(turn), 1.0 + 0.2 * math.sin(turn)] for turn in turns]
    zones = [{"name": f"a{n}", "kind": "wait", "polygon": polygon} for n in range(3)]
    where, sentence = the_problem(GOOD + yaml.safe_dump({"zones": zones}))
    assert (where, "2100" in sentence, "2000" in sentence) == ("zones", True, True)
    assert parse_config(GOOD + yaml.safe_dump({"zones": zones[:2]})).zones

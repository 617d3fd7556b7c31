"""The README's moving picture: small, playing by itself, and drawn by the code as it is."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

import planner
from benchmarks.figures.film import MOST_BYTES, Film, film_svg

ROOT = Path(__file__).parents[3]
SVG = "{http://www.w3.org/2000/svg}"


def test_the_readme_shows_a_small_picture_that_plays_by_itself() -> None:
    assert 'src="docs/pictures/run.svg"' in (ROOT / "README.md").read_text()
    file = ROOT / "docs/pictures/run.svg"
    assert file.stat().st_size < MOST_BYTES
    root = ET.parse(file).getroot()
    assert not list(root.iter(f"{SVG}script"))
    assert len(list(root.iter(f"{SVG}animateTransform"))) == 2


def test_a_film_moves_the_robot_from_the_track_s_begin_to_its_end() -> None:
    scene = planner.read_scene_text("#@ clearway.scene/1\n#@ units m\n#@ bounds given 0 0 4 3\n")
    roadmap = planner.build_roadmap(scene, radius=0.2)
    path = roadmap.plan((0.5, 0.5), (3.5, 2.5))
    assert isinstance(path, planner.Path)
    times = np.linspace(10.0, 20.0, 101)
    part = (times - 10.0) / 10.0
    track = np.column_stack((times, 0.5 + 3.0 * part, 0.5 + 2.0 * part, np.full(101, 0.588)))
    film = Film(scene, roadmap, [(10.0, path)], track, [(0.5, 0.5), (3.5, 2.5)], 0.2)

    root = ET.fromstring(film_svg(film))
    moves, turns = root.iter(f"{SVG}animateTransform")
    places = [[float(v) for v in one.split(",")] for one in moves.attrib["values"].split(";")]
    assert places[0][0] < places[-1][0]
    assert places[0][1] > places[-1][1]  # y points up in the arena and down on the screen
    assert set(turns.attrib["values"].split(";")) == {"-34"}
    for one in root.iter():
        if "keyTimes" in one.attrib and "values" in one.attrib:
            keys = [float(key) for key in one.attrib["keyTimes"].split(";")]
            assert keys == sorted(keys)
            assert len(keys) == len(one.attrib["values"].split(";"))
            assert keys[0] == 0.0
            assert keys[-1] <= 1.0

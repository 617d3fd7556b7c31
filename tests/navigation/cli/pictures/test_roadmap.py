"""`clearway roadmap`: the suffix says the format, and what comes out can be read."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import networkx as nx
import pytest

from navigation.cli.main import run


@pytest.fixture
def arena(tmp_path: Path) -> Path:
    path = tmp_path / "arena.txt"
    path.write_text("#@ clearway.scene/1\n#@ units m\n#@ bounds given 0 0 10 8\nC (5,4) 1.5\n")
    return path


def roadmap(*arguments: object) -> int:
    return run(["roadmap", *map(str, arguments)])


def test_the_suffix_chooses_the_format(arena, tmp_path, capsys):
    said = {}
    for suffix in ("graphml", "geojson", "json"):
        assert roadmap(arena, "--radius", 0.3, "-o", tmp_path / f"r.{suffix}") == 0
        out = capsys.readouterr().out
        assert f"r.{suffix}: " in out
        said[suffix] = [
            int(number) for number in re.findall(r"(\d+) (?:points|lines|nodes|edges)", out)
        ]
    graph = nx.read_graphml(tmp_path / "r.graphml")
    linked = nx.node_link_graph(json.loads((tmp_path / "r.json").read_text()), edges="edges")
    assert nx.is_isomorphic(graph, linked)
    features = json.loads((tmp_path / "r.geojson").read_text())["features"]
    kinds = Counter(f["geometry"]["type"] for f in features)
    assert set(kinds) == {"Point", "MultiLineString"}
    parts = [graph.number_of_nodes(), graph.number_of_edges()]
    assert said == {
        "graphml": parts,
        "json": parts,
        "geojson": [kinds["Point"], kinds["MultiLineString"], *parts],
    }


def test_a_picture_of_the_roadmap_can_be_drawn(arena, tmp_path):
    svg = tmp_path / "r.svg"
    assert roadmap(arena, "--radius", 0.3, "-o", tmp_path / "r.json", "--render", svg) == 0
    assert 'id="roadmap"' in svg.read_text()


def test_a_graph_in_pixels_says_that_nav2_takes_metres(arena, tmp_path, capsys):
    source = tmp_path / "picture.txt"
    source.write_text(arena.read_text().replace("units m", "units px"))
    for suffix, said in (("geojson", True), ("json", False)):
        assert roadmap(source, "--radius", 0.3, "-o", tmp_path / f"r.{suffix}") == 0
        assert (
            "Nav2, LIF and Open-RMF take coordinates as metres" in capsys.readouterr().out
        ) is said
    assert roadmap(arena, "--radius", 0.3, "-o", tmp_path / "r.geojson") == 0
    assert "Nav2" not in capsys.readouterr().out
    assert "date_generated" in json.loads((tmp_path / "r.geojson").read_text())


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (
            ("--radius", "0.3", "-o", "r.txt"),
            "must end in .graphml, .geojson, .json, .lif, .yaml or .yml",
        ),
        (("--radius", "0.3", "-o", "r"), "must end in"),
        (("--radius", "0", "-o", "r.json"), "> 0"),
        (("--radius", "0.3"), "--output"),
        (("-o", "r.json"), "--radius"),
        (("--radius", "0.3", "--spacing", "1", "-o", "r.json"), "< 2 radius"),
        (("--radius", "5", "-o", "r.geojson"), "no edges"),
        (("--radius", "0.3", "-o", "r.json", "--render", "r.jpg"), ".svg or .png"),
        (("--radius", "0.3", "-o", "no/where/r.json"), "there is no directory"),
    ],
)
def test_wrong_usage_is_exit_code_2_and_one_sentence(
    arena, tmp_path, capsys, monkeypatch, arguments, what
):
    monkeypatch.chdir(tmp_path)
    assert roadmap(arena, *arguments) == 2
    captured = capsys.readouterr()
    assert what in captured.err
    assert captured.err.count("\n") == 1


def test_the_obstacles_can_be_written_as_a_ros_map_that_plans_alike(arena, tmp_path, capsys):
    file = tmp_path / "map.yaml"
    out = ("-o", tmp_path / "r.json")
    assert roadmap(arena, "--radius", 0.3, *out, "--map", file, "--resolution", 0.02) == 0
    ends = ["--start", "1,4", "--goal", "9,4", "--radius", "0.3", "--prefer", "length"]
    capsys.readouterr()
    lengths = []
    for source in (arena, file):
        assert run(["plan", str(source), *ends, "--format", "json"]) == 0
        lengths.append(json.loads(capsys.readouterr().out)["length"])
    assert lengths[0] <= lengths[1] <= lengths[0] + 0.05


def test_a_ros_map_of_a_picture_is_refused_in_one_sentence(tmp_path, capsys):
    scene = tmp_path / "px.txt"
    scene.write_text("C (50,40) 15\n")
    out = ("-o", tmp_path / "r.json", "--map", tmp_path / "map.yaml")
    assert roadmap(scene, "--radius", 3, *out) == 2
    assert "metres" in capsys.readouterr().err

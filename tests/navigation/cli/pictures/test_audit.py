"""The command audits a graph of any format, in three forms, and draws it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from navigation.cli.main import run
from planner import RouteEdge, RouteGraph, RouteNode, save_graph
from tests.support.oracles.nav2_graph import load_graph as load_as_nav2

PLACES = ((1, 1.0, 1.0), (2, 5.0, 1.0), (3, 5.0, 4.0), (4, 1.0, 4.0))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A room of 6 m x 5 m with a pillar, unknown cells in one corner, and a mask with a zone."""
    cells = np.full((50, 60), 254, np.uint8)
    cells[20:30, 25:35] = 0
    cells[:5, :5] = 205
    write_map(tmp_path, "room", cells, "trinary")
    mask = np.full((50, 60), 254, np.uint8)
    mask[36:44, 28:32] = 0  # on the lower edge, y from 0.6 to 1.4
    mask[0:2, 0:60] = 128  # slow there: no zone
    write_map(tmp_path, "mask", mask, "scale")
    slow = np.full((50, 60), 255, np.uint8)
    slow[30:50, 20:40] = 127  # half as fast in x from 2 to 4, y below 2
    write_map(tmp_path, "slow", slow, "scale")
    nodes = tuple(RouteNode(*row, frame="map") for row in PLACES)
    edges = []
    for k, (a, b) in enumerate(((1, 2), (2, 3), (3, 4), (4, 1))):
        edges += [RouteEdge(10 + k, a, b), RouteEdge(20 + k, b, a)]
    good = RouteGraph(nodes, tuple(edges), "nav2", {"type": "FeatureCollection"})
    save_graph(good, tmp_path / "good.geojson")
    crossing = RouteEdge(30, 1, 3)
    save_graph(RouteGraph(nodes, (*edges, crossing), "nav2"), tmp_path / "bad.geojson")
    return tmp_path


def write_map(folder: Path, name: str, cells: np.ndarray, mode: str) -> None:
    rows, columns = cells.shape
    (folder / f"{name}.pgm").write_bytes(b"P5\n%d %d\n255\n" % (columns, rows) + cells.tobytes())
    (folder / f"{name}.yaml").write_text(
        f"image: {name}.pgm\nmode: {mode}\nresolution: 0.1\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n"
        f"occupied_thresh: {1.0 if mode == 'scale' else 0.65}\n"
        f"free_thresh: {0.0 if mode == 'scale' else 0.25}\n"
    )


def asked(folder: Path, graph: str, *arguments: object) -> int:
    words = ["audit", folder / graph, "--map", folder / "room.yaml", "--radius", 0.3, *arguments]
    return run([str(word) for word in words])


def test_a_sound_graph_ends_with_0(folder, capsys):
    assert asked(folder, "good.geojson") == 0
    out = capsys.readouterr().out
    assert "4 nodes, 8 edges, robot radius 0.3 m: 0 unsafe, 0 errors, 0 warnings" in out
    assert "least clearance 0.707 m: edge 12 at (1, 4)" in out  # unknown: (0.5, 4.5)


def test_an_unsafe_graph_ends_with_3_and_says_where(folder, capsys):
    assert asked(folder, "bad.geojson") == 3
    out = capsys.readouterr().out
    assert re.search(
        r"unsafe:  edge 30 at \(2\.\d+, \d\.\d+\) runs 1\.25 m through an obstacle", out
    )
    assert "Move its nodes, or lead it round the obstacle." in out


def test_json_has_what_the_design_names(folder, capsys):
    assert asked(folder, "bad.geojson", "--format", "json") == 3
    answer = json.loads(capsys.readouterr().out)
    assert answer["schema"] == "clearway.audit/1"
    assert answer["status"] == "unsafe"
    (one,) = answer["findings"]
    assert one.keys() >= {"id", "kind", "severity", "edge", "node", "at", "value", "limit", "cure"}
    assert (one["kind"], one["edge"], one["node"]) == ("edge_in_obstacle", "30", None)
    assert one["value"] == pytest.approx(1.25, abs=1e-5)
    assert len(answer["edges"]) == 9
    assert answer["edges"][0]["clearance"] == pytest.approx(1.0)
    assert answer["edges"][0]["keepout_distance"] is None


def test_annotations_for_github_are_one_line_each(folder, capsys):
    assert asked(folder, "bad.geojson", "--format", "github") == 3
    first, last = capsys.readouterr().out.splitlines()
    assert re.match(
        r"::error file=[^,:]+bad\.geojson,title=edge_in_obstacle%3A30::edge 30 at", first
    )
    assert last.endswith("::1 unsafe, 0 errors, 0 warnings")


def test_a_keep_out_mask_of_nav2_is_a_zone(folder, capsys):
    assert asked(folder, "good.geojson", "--keepout", folder / "mask.yaml") == 3
    out = capsys.readouterr().out
    assert re.search(r"edge 10 at \((2\.8|3\.2), 1\) runs 0\.4 m through a keep-out zone", out)
    assert "2 unsafe" in out


def test_a_speed_mask_of_nav2_limits_edges(folder, capsys):
    from planner import load_graph

    graph = load_graph(folder / "good.geojson")
    edges = tuple(replace(e, speed_percent=80.0) if e.id == 10 else e for e in graph.edges)
    save_graph(replace(graph, edges=edges), folder / "fast.geojson")
    assert asked(folder, "fast.geojson", "--speed", folder / "slow.yaml") == 0
    out = capsys.readouterr().out
    assert "0 unsafe, 1 errors" in out
    assert "edge 10 at (3, 1) runs 2 m through an area with a limit of 50 %" in out
    scale = ("--speed-filter", "m/s", 0.0, 0.01)
    assert asked(folder, "fast.geojson", "--speed", folder / "slow.yaml", *scale) == 0
    assert "0 errors" in capsys.readouterr().out
    faster = (*scale, "--max-speed", 1.0)
    assert asked(folder, "fast.geojson", "--speed", folder / "slow.yaml", *faster) == 0
    assert "a limit of 0.5 m/s: its own limit is 80 %" in capsys.readouterr().out


def test_passing_and_turns_are_reported_when_asked_for(folder, capsys):
    wide = ("--radius", 0.4, "--passing", "--turning-radius", 4.5)
    assert asked(folder, "good.geojson", *wide) == 0
    out = capsys.readouterr().out
    # the upper left node is 0.707 m from the corner of the unknown cells at (0.5, 4.5)
    assert re.search(r"edge 1\d at \S+ \S+ is in a stretch of 0\.\d+ m on which two robots", out)
    assert "node 2 at (5, 1) has a turn from edge 10 to edge 11 of a radius of 3 m at most" in out


def test_the_coverage_is_in_the_text_and_in_json(folder, capsys):
    assert asked(folder, "good.geojson", "--reach", 0.5) == 0
    text = capsys.readouterr().out
    assert asked(folder, "good.geojson", "--reach", 0.5, "--format", "json") == 0
    answer = json.loads(capsys.readouterr().out)
    share = answer["coverage"]["covered"]
    assert f"within 0.5 m of the graph: {share:.0%} of the free space" in text
    assert 0.4 < share < 0.9
    assert answer["coverage"]["connected_pairs"] == 1.0
    assert answer["frame"] is None
    assert answer["repair"] is None


def test_a_graph_of_another_frame_is_offered_its_transform(folder, capsys):
    from planner import load_graph

    graph = load_graph(folder / "good.geojson")
    nodes = tuple(replace(n, x=n.x / 0.1, y=(5.0 - n.y) / 0.1) for n in graph.nodes)
    save_graph(replace(graph, nodes=nodes), folder / "pixels.geojson")
    assert asked(folder, "pixels.geojson", "--format", "json") == 3
    answer = json.loads(capsys.readouterr().out)
    assert answer["frame"]["scale"] == 0.1
    assert answer["frame"]["named"].startswith("pixels")
    assert answer["frame"]["after"] == 1.0
    assert answer["frame"]["sure"] is False  # y up or down, the room is the same
    assert asked(folder, "pixels.geojson") == 3
    assert "the graph is not in the map's frame: 0 % of its length" in capsys.readouterr().out


def test_a_repaired_graph_is_written_and_decides_the_exit_code(folder, capsys):
    assert asked(folder, "bad.geojson", "--repair", folder / "fixed.geojson") == 0
    out = capsys.readouterr().out
    assert "repair:  0 nodes moved, 1 edges led round: nothing unsafe is left" in out
    assert "1 unsafe" in out
    assert asked(folder, "fixed.geojson") == 0
    assert load_as_nav2((folder / "fixed.geojson").read_text())
    capsys.readouterr()
    small = ("--radius", 1.6, "--format", "json", "--repair", folder / "no.geojson")
    assert asked(folder, "bad.geojson", *small) == 3
    answer = json.loads(capsys.readouterr().out)
    assert answer["repair"]["safe"] is False
    assert answer["repair"]["unsolved"][0].keys() == {"id", "reason"}


def test_a_goal_that_no_path_reaches_ends_with_3(folder, capsys):
    assert asked(folder, "good.geojson", "--goal", "3,1.5") == 0
    assert asked(folder, "good.geojson", "--goal", "0.1,0.1") == 3
    assert (
        "goal (0.1, 0.1) at (0.1, 0.1) cannot be reached from the graph: "
        in capsys.readouterr().out
    )


def test_other_formats_and_standard_input_give_the_same(folder, capsys, monkeypatch):
    from planner import load_graph

    graph = load_graph(folder / "bad.geojson")
    for name in ("bad.lif", "bad.yaml", "bad.graphml", "bad.json"):
        save_graph(graph, folder / name)
        assert asked(folder, name) == 3
        assert "runs 1.25 m through an obstacle" in capsys.readouterr().out
    assert load_as_nav2((folder / "bad.geojson").read_text())


def test_the_picture_shows_the_finding_in_its_colour(folder):
    for name in ("audit.svg", "audit.png"):
        assert asked(folder, "bad.geojson", "--render", folder / name) == 3
    root = ElementTree.parse(folder / "audit.svg").getroot()
    text = " ".join(root.itertext())
    assert "unsafe (1)" in text
    assert "runs 1.25 m through" in text
    pixels = cv2.imread(str(folder / "audit.png")).astype(int)
    red = np.abs(pixels - (78, 28, 214)).sum(axis=2) < 30
    assert np.count_nonzero(red) > 500


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("none.geojson",), r"none.geojson: No such file"),
        (("room.yaml",), r"room.yaml: has no levels: must have one"),
        (("room.pgm",), r"room.pgm: not a text file"),
        (("good.geojson", "--keepout", "none.yaml"), r"none.yaml: No such file"),
        (
            ("good.geojson", "--keepout", "good.geojson"),
            r"good.geojson:1:1: a ROS map needs the key",
        ),
        (("good.geojson", "--speed", "none.yaml"), r"none.yaml: No such file"),
        (
            ("good.geojson", "--speed", "slow.yaml", "--speed-filter", "percent", "100", "0"),
            r"--speed-filter: 100 0: must be finite, and the multiplier not 0",
        ),
        (("good.geojson", "--turning-radius", "0"), r"'0': must be a finite number > 0"),
        (("good.geojson", "--reach", "x"), r"'x': must be a finite number > 0"),
        (("good.geojson", "--repair", "good.geojson"), r"would overwrite good.geojson"),
        (("good.geojson", "--repair", "no/a.json"), r"there is no directory no"),
        (("good.geojson", "--frame", "L2"), r"frame 'L2': the graph has no node in it"),
        (("good.geojson", "--radius", "-1"), r"'-1': must be a finite number > 0"),
        (("good.geojson", "--goal", "1"), r"must be X,Y or X,Y,DEG"),
        (("good.geojson", "--render", "a.gif"), r"must end in .svg or .png"),
        (("good.geojson", "-o", "good.geojson"), r"would overwrite good.geojson, which is read"),
        (("good.geojson", "--format", "xml"), r"'xml' is not one of"),
    ],
)
def test_wrong_input_is_exit_code_2_and_one_sentence(
    folder, capsys, monkeypatch, arguments, sentence
):
    monkeypatch.chdir(folder)
    assert (
        run(["audit", *arguments[:1], "--map", "room.yaml", "--radius", "0.3", *arguments[1:]]) == 2
    )
    err = capsys.readouterr().err
    assert re.search(sentence, err)
    assert err.count("\n") == 1


def test_a_file_that_was_cut_is_named_with_line_and_column(folder, capsys):
    text = (folder / "good.geojson").read_text()
    (folder / "cut.geojson").write_text(text[: len(text) // 2])
    assert asked(folder, "cut.geojson") == 2
    assert re.search(r"cut\.geojson:\d+:\d+: not JSON", capsys.readouterr().err)

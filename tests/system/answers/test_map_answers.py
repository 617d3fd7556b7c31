"""What `plan` answers on grid maps, and the graphs that `clearway roadmap` writes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest

from tests.support.oracles.brute_clearance import (
    distances,
    walk,
)
from tests.support.pictures import call, save
from tests.system.answers.asked import RADIUS, _no_constant, extract, plan

# Maps.

ROS_ROWS = [
    "##########",
    "#........#",
    "#...##...#",
    "#...##...#",
    "#........#",
    "##########",
]


@pytest.fixture
def ros_map(tmp_path: Path) -> Path:
    shade = np.array([[0 if c == "#" else 254 for c in row] for row in ROS_ROWS], np.uint8)
    save(tmp_path, "map.pgm", shade)
    file = tmp_path / "map.yaml"
    file.write_text(
        "image: map.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    return file


def test_a_ros_map_is_planned_in_metres_with_its_origin(ros_map: Path) -> None:
    """The free inside is x in [-0.5, 3.5], y in [2.5, 4.5]; the block x 1..2, y 3..4."""
    answer = plan(ros_map, "-0.2,3.5", "3.2,3.5", radius=0.1)
    assert (answer["status"], answer["units"]) == ("ok", "m")
    middle = min(answer["path"], key=lambda p: abs(p[0] - 1.5))
    assert abs(middle[1] - 3.5) > 0.5 + 0.1
    assert 0.1 <= answer["min_clearance"] <= 0.25 + 1e-9
    blocked = plan(ros_map, "-0.2,3.5", "3.2,3.5", radius=0.26)
    assert blocked["widest_radius"] == pytest.approx(0.25, rel=1e-6)
    assert "obstacle" in plan(ros_map, "1.5,3.5", "3,3", radius=0.1)["reason"]


def test_a_movingai_map_has_its_cell_centres_at_integers_and_no_diagonal_gaps(
    tmp_path: Path,
) -> None:
    file = tmp_path / "small.map"
    file.write_text("type octile\nheight 4\nwidth 6\nmap\n......\n..@...\n...@..\n......\n")
    answer = plan(file, "0,0", "5,3", radius=0.3)
    assert (answer["status"], answer["units"]) == ("ok", "cells")
    scene = {
        "bounds": [-0.5, -0.5, 5.5, 3.5],
        "objects": [
            {"records": [_square(2.0, 1.0)], "holes": []},
            {"records": [_square(3.0, 2.0)], "holes": []},
        ],
    }
    least = distances(walk(answer["path"], 0.01), scene).min()
    assert answer["min_clearance"] == pytest.approx(least, abs=0.006)
    shut = tmp_path / "shut.map"
    shut.write_text("type octile\nheight 3\nwidth 3\nmap\n..@\n.@.\n@..\n")
    assert plan(shut, "0,0", "2,2", radius=0.01)["status"] == "unreachable"


def _square(x: float, y: float) -> dict[str, Any]:
    corners = [[x + dx, y + dy] for dx, dy in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
    ends = corners[1:] + corners[:1]
    edges = [{"kind": "segment", "from": a, "to": b} for a, b in zip(corners, ends, strict=True)]
    return {"type": "L", "edges": edges}


# Roadmap.


@pytest.fixture
def exported(folder: Path, tmp_path: Path) -> Path:
    for suffix in ("graphml", "geojson", "json"):
        told = call("roadmap", folder / "zoo.png", "--radius", "9", "-o", tmp_path / f"r.{suffix}")
        assert (told.code, told.err) == (0, "")
        assert str(tmp_path / f"r.{suffix}") in told.out
    return tmp_path


def test_the_exported_graphs_are_the_same_and_keep_the_radius(exported: Path, folder: Path) -> None:
    scene = extract(folder / "zoo.png")
    xml = nx.read_graphml(exported / "r.graphml")
    link = nx.node_link_graph(json.loads((exported / "r.json").read_text()), edges="edges")
    assert len(xml) == len(link) > 4
    assert xml.number_of_edges() == link.number_of_edges() > 4
    for _, _, data in link.edges(data=True):
        assert data["clearance"] >= RADIUS
        assert data["length"] > 0.0
    for _, data in link.nodes(data=True):
        there = distances(np.array([[data["x"], data["y"]]]), scene)[0]
        assert data["clearance"] == pytest.approx(there, abs=0.02)
    for _, _, data in xml.edges(data=True):
        assert float(data["clearance"]) >= RADIUS


def test_the_geojson_is_a_route_graph_of_points_and_directed_lines(exported: Path) -> None:
    data = json.loads((exported / "r.geojson").read_text(), parse_constant=_no_constant)
    assert data["type"] == "FeatureCollection"
    kinds = [f["geometry"]["type"] for f in data["features"]]
    nodes = {f["properties"]["id"] for f in data["features"] if f["geometry"]["type"] == "Point"}
    lines = [f["properties"] for f in data["features"] if f["geometry"]["type"] != "Point"]
    assert len(nodes) == kinds.count("Point") > 4
    assert lines
    for line in lines:
        assert line["startid"] in nodes
        assert line["endid"] in nodes
    ways = {(line["startid"], line["endid"]) for line in lines}
    assert all((b, a) in ways for a, b in ways)

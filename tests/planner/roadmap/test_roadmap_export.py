"""Other programs get the same graph; for Nav2 straight pieces that are safe to drive."""

from __future__ import annotations

import json
import math

import networkx as nx
import numpy as np
import pytest

from planner.formats.scene_io import read_scene_text
from planner.roadmap.roadmap import Roadmap, build_roadmap
from planner.roadmap.roadmap_export import ExchangeError, as_text
from tests.support.oracles.nav2_graph import NoValidGraphError, load_graph

SCENE = (
    "#@ clearway.scene/1\n#@ units m\n#@ bounds given 0 0 10 8\n"
    "L 4 (2,2)(2,3)(3,3)(3,2)\nC (6,4) 1\nS (4,6) (8,6.5)\n"
)


@pytest.fixture(scope="module")
def roadmap() -> Roadmap:
    return build_roadmap(read_scene_text(SCENE), 0.3)


def strict(text: str) -> dict:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


def test_node_link_json_holds_the_graph(roadmap):
    graph = nx.node_link_graph(strict(as_text(roadmap, ".json")), edges="edges")
    assert set(graph.nodes) == set(roadmap.graph.nodes)
    assert {frozenset(e) for e in graph.edges} == {frozenset(e) for e in roadmap.graph.edges}
    for n, data in roadmap.graph.nodes(data=True):
        assert (graph.nodes[n]["x"], graph.nodes[n]["y"]) == data["pos"]
        assert graph.nodes[n]["clearance"] == data["clearance"]
    for u, v, data in roadmap.graph.edges(data=True):
        np.testing.assert_array_equal(graph[u][v]["polyline"], data["polyline"])
        assert graph[u][v]["length"] == data["length"]
    assert graph.graph == {"radius": 0.3, "spacing": roadmap.spacing, "units": "m"}


def test_graphml_is_read_back_by_networkx(roadmap):
    graph = nx.parse_graphml(as_text(roadmap, ".graphml"), node_type=int)
    assert nx.is_isomorphic(graph, roadmap.graph)
    for u, v, data in roadmap.graph.edges(data=True):
        assert graph[u][v]["clearance"] == data["clearance"]
        points = [tuple(map(float, p.split(","))) for p in graph[u][v]["polyline"].split()]
        np.testing.assert_array_equal(points, data["polyline"])


def test_geojson_follows_the_rules_of_nav2s_route_server(roadmap):
    document = strict(as_text(roadmap, ".geojson", frame="arena"))
    assert document["type"] == "FeatureCollection"
    nodes = [f for f in document["features"] if f["geometry"]["type"] == "Point"]
    edges = [f for f in document["features"] if f["geometry"]["type"] == "MultiLineString"]
    assert len(nodes) + len(edges) == len(document["features"])
    numbers = [f["properties"]["id"] for f in document["features"]]
    assert len(set(numbers)) == len(numbers)
    assert all(isinstance(n, int) and 0 <= n < 2**32 for n in numbers)
    assert all(n["properties"]["frame"] == "arena" for n in nodes)
    ends = {(e["properties"]["startid"], e["properties"]["endid"]) for e in edges}
    assert all((b, a) in ends for a, b in ends), "every way has its way back"
    assert {n for pair in ends for n in pair} <= {n["properties"]["id"] for n in nodes}
    for feature in document["features"]:
        for value in feature["properties"]["metadata"].values():
            assert isinstance(value, float)


def test_every_straight_piece_for_nav2_keeps_the_robots_radius(roadmap):
    document = strict(as_text(roadmap, ".geojson"))
    place = {
        f["properties"]["id"]: f["geometry"]["coordinates"]
        for f in document["features"]
        if f["geometry"]["type"] == "Point"
    }
    for feature in document["features"]:
        if feature["geometry"]["type"] == "Point":
            continue
        a, b = (place[feature["properties"][k]] for k in ("startid", "endid"))
        assert feature["geometry"]["coordinates"] == [[a, b]]
        assert feature["properties"]["cost"] == pytest.approx(math.dist(a, b))
        for t in np.linspace(0, 1, 9):
            x, y = a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])
            box = math.hypot(max(2 - x, 0, x - 3), max(2 - y, 0, y - 3))
            disc = math.hypot(x - 6, y - 4) - 1
            along = min(max(((x - 4) * 4 + (y - 6) * 0.5) / 16.25, 0), 1)
            bar = math.hypot(x - 4 - 4 * along, y - 6 - 0.5 * along)
            assert min(box, disc, bar, x, y, 10 - x, 8 - y) >= 0.3 - 1e-9


def test_route_server_finds_ways_over_the_graph_and_back(roadmap):
    nodes = load_graph(as_text(roadmap, ".geojson", frame="arena"))
    assert {node.frame for node in nodes.values()} == {"arena"}
    graph = nx.DiGraph()
    for node in nodes.values():
        assert node.metadata["clearance"] >= 0.3
        for edge in node.leaving:
            graph.add_edge(node.number, edge.end.number, weight=edge.cost)
            assert edge.cost == pytest.approx(math.dist((node.x, node.y), (edge.end.x, edge.end.y)))
            assert edge.metadata["clearance"] >= 0.3
            assert edge.overridable
    here, there = (
        min(nodes.values(), key=lambda n, p=p: math.dist((n.x, n.y), p)).number
        for p in ((1.0, 1.0), (9.0, 7.0))
    )
    forth = nx.dijkstra_path_length(graph, here, there)
    assert forth == pytest.approx(nx.dijkstra_path_length(graph, there, here))
    assert 10.0 <= forth < 14.0


@pytest.mark.parametrize(
    ("old", "new"),
    [('"startid": ', '"startid": 99'), ('"id": ', '"id": -'), ('"Point"', '"Polygon"')],
)
def test_reader_for_route_graphs_refuses_what_the_server_would(roadmap, old, new):
    text = as_text(roadmap, ".geojson")
    assert load_graph(text)
    with pytest.raises(NoValidGraphError):
        load_graph(text.replace(old, new))


@pytest.mark.parametrize("form", ["graphml", "node-link"])
def test_nothing_is_lost_on_the_way_through_a_file(roadmap, form):
    if form == "graphml":
        graph = nx.parse_graphml(as_text(roadmap, ".graphml"), node_type=int)
        owners = lambda text: tuple(int(o) for o in text.split())  # noqa: E731
        line = lambda text: [[float(v) for v in p.split(",")] for p in text.split()]  # noqa: E731
    else:
        graph = nx.node_link_graph(strict(as_text(roadmap, ".json")), edges="edges")
        owners, line = tuple, list
    assert set(graph.nodes) == set(roadmap.graph.nodes)
    for n, data in roadmap.graph.nodes(data=True):
        node = graph.nodes[n]
        assert ((node["x"], node["y"]), node["clearance"]) == (data["pos"], data["clearance"])
        assert owners(node["owners"]) == data["owners"]
    for u, v, data in roadmap.graph.edges(data=True):
        edge = graph[u][v]
        assert (edge["length"], edge["clearance"]) == (data["length"], data["clearance"])
        assert owners(edge["owners"]) == data["owners"]
        np.testing.assert_array_equal(line(edge["polyline"]), data["polyline"])


def test_geojson_connects_what_the_roadmap_connects(roadmap):
    document = strict(as_text(roadmap, ".geojson"))
    graph = nx.DiGraph()
    for feature in document["features"]:
        if feature["geometry"]["type"] == "Point":
            graph.add_node(feature["properties"]["id"])
        else:
            p = feature["properties"]
            graph.add_edge(p["startid"], p["endid"])
    parts = nx.number_strongly_connected_components(graph)
    assert parts == nx.number_connected_components(roadmap.graph)


def test_a_roadmap_without_edges_is_refused_for_nav2_and_empty_elsewhere():
    tight = build_roadmap(read_scene_text(SCENE), 5.0)
    assert tight.graph.number_of_edges() == 0
    with pytest.raises(ExchangeError, match="no edges"):
        as_text(tight, ".geojson")
    assert strict(as_text(tight, ".json"))["edges"] == []
    assert nx.parse_graphml(as_text(tight, ".graphml")).number_of_edges() == 0


def test_no_edge_of_a_nav2_graph_has_the_length_0():
    """Nodes at one place are one, and vertices at one place, too."""
    roadmap = build_roadmap(read_scene_text(SCENE), 0.3)
    graph = roadmap.graph
    u, v, data = next(iter(graph.edges(data=True)))
    twin, line = max(graph) + 1, np.array(data["polyline"])
    graph.add_node(twin, **graph.nodes[u])
    graph.remove_edge(u, v)
    doubled = data | {"polyline": np.repeat(line, 2, axis=0)}
    graph.add_edge(twin, v, **doubled)
    here = np.array([graph.nodes[u]["pos"]] * 2)
    graph.add_edge(u, twin, **(data | {"polyline": here, "length": 0.0}))
    text = as_text(roadmap, ".geojson")
    lengths = [
        feature["properties"]["metadata"]["length"]
        for feature in strict(text)["features"]
        if feature["geometry"]["type"] == "MultiLineString"
    ]
    assert min(lengths) > 0.0
    nodes = load_graph(text)
    reached, waiting = set(), [next(iter(nodes))]
    while waiting:
        node = waiting.pop()
        if node not in reached:
            reached.add(node)
            waiting += [edge.end.number for edge in nodes[node].leaving]
    assert reached == set(nodes)


def test_a_nav2_graph_says_its_crs_and_the_date_that_it_is_given(roadmap):
    document = strict(as_text(roadmap, ".geojson", generated="2026-11-23T07:00:00+00:00"))
    assert document["crs"]["properties"]["name"].startswith("urn:ogc:def:crs:")
    assert document["date_generated"] == "2026-11-23T07:00:00+00:00"
    assert "date_generated" not in strict(as_text(roadmap, ".geojson"))


@pytest.mark.parametrize(
    ("name", "suffix"),
    [("r.graphml", ".graphml"), ("r.GeoJSON", ".geojson"), ("r.json", ".json")],
)
def test_a_roadmap_saves_itself_by_the_suffix(roadmap, tmp_path, name, suffix):
    roadmap.save(tmp_path / name)
    assert (tmp_path / name).read_text() == as_text(roadmap, suffix)


def test_a_file_that_cannot_be_is_refused(roadmap, tmp_path):
    with pytest.raises(ExchangeError, match=r"suffix '.dot': must be one of .graphml, .geojson, "):
        roadmap.save(tmp_path / "r.dot")
    with pytest.raises(ExchangeError, match="No such file or directory"):
        roadmap.save(tmp_path / "none" / "r.json")


def test_networkx_writes_the_plain_graph_and_reads_it_back(roadmap, tmp_path):
    plain = roadmap.to_networkx()
    nx.write_graphml(plain, tmp_path / "r.graphml")
    again = nx.read_graphml(tmp_path / "r.graphml", node_type=int)
    assert dict(again.nodes(data=True)) == dict(plain.nodes(data=True))
    assert again.graph["units"] == "m"
    assert len(again.edges) == len(roadmap.graph.edges)

"""Every format keeps what it was given, and refuses what it cannot read in one sentence."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
import yaml

from planner.graph_files.graph_io import (
    READERS,
    graph_text,
    load_graph,
    read_graph,
    save_graph,
)
from planner.graph_files.route_graph import ExchangeError, RouteEdge, RouteGraph, RouteNode
from tests.planner.graph_files.documents import GRAPHML, LIF, NAV2, NODE_LINK, RMF, TEXTS
from tests.support.oracles.nav2_graph import load_graph as load_as_nav2


@pytest.mark.parametrize("form", READERS)
def test_reading_writing_and_reading_again_gives_an_equal_graph(form):
    graph = read_graph(TEXTS[form], "file")
    assert graph.format == form
    again = read_graph(graph_text(graph, form), "again")
    assert again == graph
    assert graph_text(again, form) == graph_text(graph, form)


def test_a_nav2_graph_is_written_as_it_was_up_to_the_order():
    written = json.loads(graph_text(read_graph(TEXTS["nav2"], "f"), "nav2"))
    assert written == NAV2


def test_a_lif_is_written_as_it_was_up_to_the_order():
    assert json.loads(graph_text(read_graph(TEXTS["lif"], "f"), "lif")) == LIF


def test_an_open_rmf_graph_is_written_as_it_was():
    written = yaml.safe_load(graph_text(read_graph(RMF, "f"), "rmf"))
    given = yaml.safe_load(RMF)
    given["levels"]["L1"]["vertices"][0][0] = 1e-3  # "1e-3" is text to YAML 1.1
    assert written == given


def test_what_the_formats_know_is_read():
    nav2 = read_graph(TEXTS["nav2"], "f")
    assert nav2.frames == ("hall", "map")
    assert (nav2.edges[0].cost, nav2.edges[0].length) == (3.5, 7.7)
    assert (nav2.edges[0].speed_percent, nav2.edges[0].speed_m_s) == (85.0, 0.4)
    assert not nav2.edges[0].both_ways
    lif = read_graph(TEXTS["lif"], "f")
    assert [(n.id, n.x, n.y, n.frame) for n in lif.nodes] == [
        ("a", 1.0, 2.5, "m1"),
        ("b", -1.0, 0.0, ""),
    ]
    assert lif.edges[0].speed_m_s == 0.5
    rmf = read_graph(RMF, "f")
    assert [n.id for n in rmf.nodes] == ["L1/0", "L1/1", "2/0"]
    assert rmf.frames == ("L1", "2")
    assert (rmf.edges[0].start, rmf.edges[0].speed_m_s) == ("L1/0", 0.5)
    link = read_graph(TEXTS["node-link"], "f")
    assert link.edges[0].line == ((1.0, 2.0), (2.0, 2.0), (3.0, 4.0))
    assert (link.nodes[1].x, link.nodes[1].frame) == (3.0, "hall")
    ml = read_graph(GRAPHML, "f")
    assert [edge.both_ways for edge in ml.edges] == [False, True]
    assert ml.edges[0].length == 5.0
    assert ml.edges[1].fields["weight"] == 1.5


def random_graph(seed: int) -> RouteGraph:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 9))
    nodes = tuple(
        RouteNode(f"n {k}", *rng.normal(0.0, 10.0 ** rng.integers(-6, 7), 2).tolist(), "hall")
        for k in range(count)
    )
    edges = []
    for k in range(int(rng.integers(0, 12))):
        a, b = rng.integers(0, count, 2).tolist()
        edges.append(
            RouteEdge(
                f"e<{k}>",
                f"n {a}",
                f"n {b}",
                bool(rng.integers(2)),
                cost=float(rng.random()),
                length=float(rng.random()),
                speed_m_s=float(rng.random()),
            )
        )
    return RouteGraph(nodes, tuple(edges), "graphml")


@pytest.mark.parametrize("form", READERS)
@pytest.mark.parametrize("seed", range(8))
def test_places_directions_and_speeds_survive_every_format(form, seed):
    graph = random_graph(seed)
    read = read_graph(graph_text(graph, form), "f")
    place = {n.id: (n.x, n.y) for n in graph.nodes}
    after = {n.id: (n.x, n.y) for n in read.nodes}
    assert sorted(after.values()) == sorted(place.values())
    assert set(read.frames) == {"hall"}

    def ways(edges, at):
        for e in edges:
            yield at[e.start], at[e.end], e.speed_m_s
            if e.both_ways:
                yield at[e.end], at[e.start], e.speed_m_s

    assert sorted(ways(read.edges, after)) == sorted(ways(graph.edges, place))
    if form not in ("lif", "rmf"):  # these have no costs
        assert {e.cost for e in read.edges} == {e.cost for e in graph.edges}


def test_a_bent_edge_becomes_straight_ones_with_nodes_at_its_bends():
    graph = read_graph(TEXTS["node-link"], "f")
    nodes = load_as_nav2(graph_text(graph, "nav2"))
    assert sorted((n.x, n.y) for n in nodes.values()) == [(1.0, 2.0), (2.0, 2.0), (3.0, 4.0)]
    (first,) = (n for n in nodes.values() if (n.x, n.y) == (1.0, 2.0))
    (leg,) = first.leaving
    assert (leg.end.x, leg.end.y) == (2.0, 2.0)
    assert (leg.end.leaving[0].end.x, leg.end.leaving[0].end.y) == (3.0, 4.0)


def test_networkx_reads_what_is_written():
    graph = read_graph(GRAPHML.replace(' directed="false"', ""), "f")
    read = nx.parse_graphml(graph_text(graph, "graphml"))
    assert read.nodes["a&b"]["y"] == -2.5e-3
    link = json.loads(graph_text(graph, "node-link"))
    assert nx.node_link_graph(link, edges="edges").number_of_edges() == 2


def test_an_open_rmf_lane_keeps_a_vertex_that_is_missing():
    text = "levels: {L1: {vertices: [[0, 0]], lanes: [[0, 7]]}}"
    graph = read_graph(text, "f")
    assert read_graph(graph_text(graph, "rmf"), "f") == graph
    stray = replace(graph, edges=(RouteEdge("e", "L1/0", "L2/0"),))
    with pytest.raises(ExchangeError, match="must be a vertex of level 'L1'"):
        graph_text(stray, "rmf")


@pytest.mark.parametrize("form", READERS)
def test_an_empty_graph_is_written_and_read(form):
    graph = RouteGraph()
    read = read_graph(graph_text(graph, form), "f")
    assert (read.nodes, read.edges, read.format) == ((), (), form)


def test_files_are_chosen_by_suffix_and_recognised_by_content(tmp_path: Path):
    graph = random_graph(0)
    suffixes = (".geojson", ".lif", ".yaml", ".graphml", ".json")
    forms = ("nav2", "lif", "rmf", "graphml", "node-link")
    for suffix, form in zip(suffixes, forms, strict=True):
        save_graph(graph, tmp_path / f"g{suffix}")
        (tmp_path / f"g{suffix}").rename(tmp_path / "file")
        assert load_graph(tmp_path / "file").format == form
    with pytest.raises(ExchangeError, match=r"suffix '.dot': must be one of .graphml"):
        save_graph(graph, tmp_path / "g.dot")
    with pytest.raises(ExchangeError, match="No such file"):
        load_graph(tmp_path / "none.json")


def changed(document: dict, path: list, value: object) -> str:
    copy = json.loads(json.dumps(document))
    inner = copy
    for key in path[:-1]:
        inner = inner[key]
    if value is None:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    return json.dumps(copy)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "f: is empty: must hold a route graph"),
        ("null", "f: None: must be an object of keys and values"),
        ("just words", "must be an object of keys and values"),
        ("{", "f:1:2: not JSON"),
        ("a: [1", "not YAML"),
        ("<a", "f:1:1: not XML"),
        ("<!DOCTYPE x><graphml/>", "must have none"),
        ("<graphml/>", "0 graphs: must be GraphML with one graph"),
        ("{}", "f: no route graph: must have features"),
        ('{"features": 3}', "f: features: 3: must be a list"),
        ('{"features": [3]}', r"f: features\[0\]: 3: must be an object"),
        ('{"nodes": [], "edges": [], "directed": NaN}', "NaN: must be a finite number"),
        ('{"nodes": [], "edges": [' + "1" * 5000 + "]}", "not JSON"),
        ("[" * 100_000, "f: not YAML|f: .*must be an object"),
        ('{"nodes":' + "[" * 100_000, "f: nested too deeply"),
        (
            changed(NAV2, ["features", 0, "properties", "id"], 1.5),
            r"f: features\[0\].properties.id: 1.5: must be a whole number or a string",
        ),
        (
            changed(NAV2, ["features", 0, "properties", "id"], None),
            r"f: features\[0\].properties: has no id: must have one",
        ),
        (
            changed(NAV2, ["features", 1, "geometry", "coordinates"], [1e300, 2]),
            r"geometry.coordinates\[0\]: 1e\+300: must be a finite number within \+-1e\+12",
        ),
        (
            changed(NAV2, ["features", 2, "properties", "endid"], None),
            r"f: features\[2\].properties: has no endid",
        ),
        (
            changed(NAV2, ["features", 2, "geometry", "coordinates", 0, 1], [3]),
            r"coordinates\[0\]\[1\]: list: must be \[x, y\]",
        ),
        (
            changed(LIF, ["layouts", 0, "nodes", 0, "nodePosition", "x"], "wide"),
            r"f: layouts\[0\].nodes\[0\].nodePosition.x: 'wide': must be a finite number",
        ),
        (
            changed(LIF, ["layouts", 0, "edges", 0, "edgeId"], None),
            r"f: layouts\[0\].edges\[0\]: has no edgeId",
        ),
        ("levels: {L1: {vertices: [[1]]}}", r"f: levels.L1.vertices\[0\]: list: must be \[x, y\]"),
        (
            "levels: {L1: {vertices: [[.nan, 2]]}}",
            r"f: levels.L1.vertices\[0\]\[0\]: nan: must be a finite number",
        ),
        (
            "levels: {L1: {lanes: [[0, a]]}}",
            r"f: levels.L1.lanes\[0\]\[1\]: 'a': must be the number of a vertex",
        ),
        (
            changed(NODE_LINK, ["nodes", 0, "x"], None),
            r"f: nodes\[0\]: has no x: must have one",
        ),
        (
            changed(NODE_LINK, ["links", 0, "polyline", 1], ["a", "b"]),
            r"f: links\[0\].polyline\[1\]\[0\]: 'a': must be a finite number",
        ),
        (GRAPHML.replace(">-2.5e-3<", ">far<"), "f: node 0.y: 'far': must be of type double"),
        (GRAPHML.replace(">-2.5e-3<", ">inf<"), "f: node 0.y: inf: must be a finite number"),
        (GRAPHML.replace('key="ok"', 'key="no"'), "f: edge 0: the key 'no' is not declared"),
        (GRAPHML.replace("<node id=\"c\">", "<node>"), "f: node 1: has no id"),
        (GRAPHML.replace('target="c"', ""), "f: edge 0: must have a source and a target"),
    ],
)  # fmt: skip
def test_a_bad_file_is_refused_in_one_sentence(text, sentence):
    with pytest.raises(ExchangeError, match=sentence) as refused:
        read_graph(text, "f")
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 240


def test_bytes_that_are_no_text_are_refused(tmp_path: Path):
    (tmp_path / "g.json").write_bytes(b"{\xff}")
    with pytest.raises(ExchangeError, match="not a text file: byte 1 is not UTF-8"):
        load_graph(tmp_path / "g.json")

"""Repaired graphs are safe by brute force, keep what they had, or say why not."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import planner
from planner import RouteEdge, RouteGraph, RouteNode, Scene
from planner.graph_files.graph_io import graph_text, read_graph
from planner.graph_repair.fresh_ids import FreshIds
from tests.support.scenes.uneven_hall import CELL, hall

HALL = Scene.from_polygons([[(4, 4), (6, 4), (6, 6), (4, 6)]], bounds=(0, 0, 10, 10))
NODES = ((1, 2.0, 5.0), (2, 8.0, 5.0), (3, 8.0, 8.0), (4, 2.0, 8.0))


def through(form="nav2", **more):
    """A ring of which the first edges, there and back, run through the pillar."""
    nodes = tuple(RouteNode(*row, fields=node_fields(form)) for row in NODES)
    edges = []
    for k, (a, b) in enumerate(((1, 2), (2, 3), (3, 4), (4, 1))):
        edges += [RouteEdge(10 + k, a, b, **more), RouteEdge(20 + k, b, a, **more)]
    return RouteGraph(nodes, tuple(edges), form)


def node_fields(form):
    return {"type": "Feature", "properties": {"metadata": {"note": 1}}} if form == "nav2" else {}


def samples(graph):
    """Points along all edges, as robots drive them."""
    at = {}
    for node in graph.nodes:
        at.setdefault(node.id, (node.x, node.y))
    for edge in graph.edges:
        line = [at[edge.start], *edge.line[1:-1], at[edge.end]] if graph.bends else None
        line = np.array(line or [at[edge.start], at[edge.end]])
        for a, b in pairwise(line):
            yield a + np.linspace(0.0, 1.0, 400)[:, None] * (b - a)


def to_pillar(points):
    off = np.maximum(np.abs(points - 5.0) - 1.0, 0.0)
    return np.hypot(*off.T)


def test_an_edge_through_an_obstacle_becomes_a_chain_that_keeps_its_id():
    graph = through(cost=6.0, speed_percent=50.0)
    graph = replace(
        graph,
        edges=tuple(replace(e, length=6.0 if e.id % 10 in (0, 2) else 3.0) for e in graph.edges),
    )
    done = planner.repair(graph, HALL, 0.5)
    assert done.audit.safe
    assert (done.moved, done.unsolved, done.frame_fit) == ((), {}, None)
    assert done.detours == ("10", "20")
    assert min(to_pillar(p).min() for p in samples(done.graph)) >= 0.5 - 1e-6
    assert done.graph.nodes[:4] == graph.nodes
    assert done.graph.edges[1:8] != graph.edges[1:8]  # the edge back is led round, too
    assert [e for e in done.graph.edges[:8] if e.id not in (10, 20)] == [
        e for e in graph.edges if e.id not in (10, 20)
    ]
    ids = [one.id for one in (*done.graph.nodes, *done.graph.edges)]
    assert len(set(ids)) == len(ids)
    # the chain leads from node 1 to 2, in order, and its parts add up
    for first, start, end in ((10, 1, 2), (20, 2, 1)):
        chain = [next(e for e in done.graph.edges if e.id == first)]
        while chain[-1].end != end:
            chain.append(
                next(
                    e
                    for e in done.graph.edges[8:]
                    if e.start == chain[-1].end and e.end != chain[-1].start
                )
            )
        assert chain[0].start == start
        assert all(e.speed_percent == 50.0 for e in chain)
        at = {n.id: np.array((n.x, n.y)) for n in done.graph.nodes}
        lengths = [float(np.hypot(*(at[e.end] - at[e.start]))) for e in chain]
        assert [e.length for e in chain] == pytest.approx(lengths)
        assert sum(e.cost for e in chain) == pytest.approx(sum(lengths))
        assert 6.0 < sum(lengths) < 9.0
    assert planner.audit(done.graph, HALL, 0.5).findings == ()


def test_both_directions_share_the_new_nodes():
    done = planner.repair(through(), HALL, 0.5)
    new = {node.id for node in done.graph.nodes[4:]}
    for node in new:
        assert sum(e.start == node for e in done.graph.edges) == 2
        assert sum(e.end == node for e in done.graph.edges) == 2


def test_an_edge_that_may_bend_gets_a_line():
    nodes = tuple(RouteNode(*row) for row in NODES[:2])
    bent = RouteGraph(nodes, (RouteEdge("e", 2, 1, True, fields={"name": "x"}),), "node-link")
    done = planner.repair(bent, HALL, 0.5)
    assert done.audit.safe
    (edge,) = done.graph.edges
    assert (edge.id, edge.start, edge.end, edge.both_ways) == ("e", 2, 1, True)
    assert edge.fields == {"name": "x"}
    assert edge.line[0] == (8.0, 5.0)
    assert edge.line[-1] == (2.0, 5.0)
    assert min(to_pillar(p).min() for p in samples(done.graph)) >= 0.5 - 1e-6
    assert done.graph.nodes == nodes


@pytest.mark.parametrize(
    ("place", "nearest"),
    [((5.0, 3.8), 0.3), ((5.0, 5.2), 1.3), ((0.3, 2.0), 0.2), ((-3.0, 2.0), 3.5)],
)
def test_a_node_moves_to_about_the_nearest_free_place(place, nearest):
    graph = through()
    joined = (RouteEdge(50, 9, 4), RouteEdge(51, 4, 9))
    graph = replace(
        graph,
        nodes=(*graph.nodes, RouteNode(9, *place, fields={"type": "Feature", "properties": {}})),
        edges=(*graph.edges[2:4], *graph.edges[4:8], *joined),
    )
    done = planner.repair(graph, HALL, 0.5)
    assert done.audit.safe
    (move,) = done.moved
    assert (move.node, move.before) == (9, place)
    way = math.dist(move.before, move.after)
    assert nearest - 1e-6 <= way <= 1.5 * nearest + 1e-6
    assert (done.graph.nodes[4].x, done.graph.nodes[4].y) == move.after


def test_zones_are_kept_out_of_and_nodes_at_one_place_stay_together():
    zones = Scene.from_polygons([[(1.5, 1.5), (3.5, 1.5), (3.5, 3.5), (1.5, 3.5)]])
    places = ((1, 2.5, 2.0), (2, 2.5, 2.0), (3, 8.0, 2.0), (4, 2.0, 8.0))
    nodes = tuple(RouteNode(*row) for row in places)
    edges = (RouteEdge(10, 1, 3), RouteEdge(11, 3, 2), RouteEdge(12, 2, 4), RouteEdge(13, 4, 1))
    done = planner.repair(RouteGraph(nodes, edges, "nav2"), HALL, 0.3, keepout=zones)
    assert done.audit.safe
    one, two = done.graph.nodes[:2]
    assert (one.x, one.y) == (two.x, two.y) != (2.5, 2.0)
    off = [np.hypot(*np.maximum(np.abs(p - 2.5) - 1.0, 0.0).T).min() for p in samples(done.graph)]
    assert min(off) >= 0.3 - 1e-6


def test_what_cannot_be_repaired_says_why_and_stays():
    walled = Scene.from_polygons([[(6, 0), (6.5, 0), (6.5, 10), (6, 10)]], bounds=(0, 0, 10, 10))
    graph = through()
    done = planner.repair(graph, walled, 0.5)
    assert not done.audit.safe
    left = {one.name for one in done.audit.of("unsafe")}
    assert left == {"10", "20", "12", "22"}
    assert set(done.unsolved) == {one.id for one in done.audit.of("unsafe")}
    assert all("no path from" in reason for reason in done.unsolved.values())
    assert done.graph.edges == graph.edges
    full = Scene.from_polygons([[(0, 0), (10, 0), (10, 10), (0, 10)]], bounds=(0, 0, 10, 10))
    nowhere = planner.repair(graph, full, 0.5)
    assert "there is no free place on the map" in set(nowhere.unsolved.values())
    assert nowhere.graph == graph


def test_a_sound_graph_is_returned_as_it_is_and_an_empty_one_too():
    sound = replace(through(), edges=through().edges[2:4])
    assert planner.repair(sound, HALL, 0.5).graph is sound
    assert planner.repair(RouteGraph(), HALL, 0.5).unsolved == {}


def test_a_graph_of_another_frame_is_transformed_if_that_is_sure():
    from planner.roadmap.roadmap_export import straight_graph

    scene = hall()
    sound = straight_graph(planner.build_roadmap(scene, 0.3, least_branch=1.0))
    pixels = tuple(replace(n, x=(n.x + 3.0) / CELL, y=(14.0 - n.y) / CELL) for n in sound.nodes)
    edges = tuple(replace(e, line=(), length=None) for e in sound.edges)
    done = planner.repair(replace(sound, nodes=pixels, edges=edges), scene, 0.3)
    assert done.frame_fit is not None
    assert done.audit.safe
    np.testing.assert_allclose(
        [(n.x, n.y) for n in done.graph.nodes], [(n.x, n.y) for n in sound.nodes], atol=1e-9
    )
    room = Scene.from_polygons([], bounds=(0, 0, 8, 8))
    ring = [(1, 1), (7, 1), (7, 7), (1, 7)]
    far = RouteGraph(
        tuple(RouteNode(k, x - 50.0, y - 50.0) for k, (x, y) in enumerate(ring)),
        tuple(RouteEdge(10 + k, k, (k + 1) % 4) for k in range(4)),
        "nav2",
    )
    kept = planner.repair(far, room, 0.3)
    assert kept.graph is far
    assert "transform it first" in next(iter(kept.unsolved.values()))


@pytest.mark.parametrize("form", ["nav2", "lif", "rmf", "graphml", "node-link"])
def test_every_format_keeps_its_ids_through_repair_writing_and_reading(form):
    given = read_graph(graph_text(through(), form), "graph")
    done = planner.repair(given, HALL, 0.5)
    assert done.audit.safe
    again = read_graph(graph_text(done.graph, form), "graph")
    assert [n.id for n in again.nodes] == [n.id for n in done.graph.nodes]
    assert [e.id for e in again.edges] == [e.id for e in done.graph.edges]
    assert planner.audit(again, HALL, 0.5).safe
    assert [n.id for n in again.nodes][: len(given.nodes)] == [n.id for n in given.nodes]
    assert {e.id for e in given.edges} <= {e.id for e in again.edges}


def test_only_the_frame_that_the_map_shows_is_repaired():
    graph = through()
    upstairs = (RouteNode(8, 5.0, 5.0, "up"), RouteNode(9, 5.0, 9.0, "up"))
    edges = (RouteEdge(80, 8, 9), RouteEdge(81, 4, 8))
    both = replace(graph, nodes=graph.nodes + upstairs, edges=graph.edges + edges)
    done = planner.repair(both, HALL, 0.5, frame="map")
    assert done.audit.safe
    assert done.graph.nodes[4:6] == upstairs
    assert done.graph.edges[8:10] == edges


def test_fresh_ids_are_not_taken():
    graph = RouteGraph((RouteNode("a", 0, 0), RouteNode("a.1", 0, 0)), (RouteEdge("b", "a", "a"),))
    ids = FreshIds(graph)
    assert ids.node(0, "a") == "a.2"
    assert ids.node(0, "a") == "a.3"
    assert ids.edge(graph.edges[0]) == "b.1"
    assert ids.edge(RouteEdge(None, "a", "a")) is None


@pytest.mark.parametrize("seed", range(5))
def test_random_graphs_are_safe_by_samples_after_repair(seed):
    rng = np.random.default_rng(seed)
    circles = np.c_[rng.uniform(1, 9, (7, 2)), rng.uniform(0.3, 0.9, 7)]
    scene = Scene.from_polygons(circles=circles.tolist(), bounds=(0, 0, 10, 10))
    places = rng.uniform(0, 10, (14, 2)).tolist()
    nodes = tuple(RouteNode(k, *place) for k, place in enumerate(places))
    pairs = [rng.choice(14, 2, replace=False).tolist() for _ in range(16)]
    graph = RouteGraph(nodes, tuple(RouteEdge(50 + k, *p) for k, p in enumerate(pairs)), "nav2")
    done = planner.repair(graph, scene, 0.25)
    unsolved = {one.name for one in done.audit.of("unsafe")}
    for edge, points in zip(done.graph.edges, samples(done.graph), strict=True):
        if edge.name in unsolved:
            continue
        gaps = np.hypot(*(points[:, None] - circles[:, :2]).transpose(2, 0, 1)) - circles[:, 2]
        walls = np.minimum(points, 10 - points).min()
        assert min(gaps.min(), walls) >= 0.25 - 1e-6

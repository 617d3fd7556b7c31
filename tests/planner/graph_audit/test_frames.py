"""A graph of another frame is found, and the transform puts its nodes back where they were."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import planner
from planner import FrameFit, RouteEdge, RouteGraph, RouteNode, Scene
from planner.formats.grid_maps import GridPose, map_scene
from tests.support.scenes.uneven_hall import CELL, hall


@pytest.fixture(scope="module")
def scene() -> Scene:
    return hall()


@pytest.fixture(scope="module")
def sound(scene) -> RouteGraph:
    """The roadmap's graph, straight edges in both directions."""
    from planner.roadmap.roadmap_export import straight_graph

    return straight_graph(planner.build_roadmap(scene, 0.3, least_branch=1.0))


def moved(graph: RouteGraph, change) -> RouteGraph:
    points = np.array([(n.x, n.y) for n in graph.nodes])
    places = change(points).tolist()
    nodes = tuple(replace(n, x=x, y=y) for n, (x, y) in zip(graph.nodes, places, strict=True))
    edges = tuple(replace(e, line=(), length=None) for e in graph.edges)
    return replace(graph, nodes=nodes, edges=edges)


def turned(points, degrees):
    a = math.radians(degrees)
    return points @ np.array([[math.cos(a), math.sin(a)], [-math.sin(a), math.cos(a)]])


FRAMES = {
    "pixels from the map's upper left corner, y down": lambda p: (
        np.c_[p[:, 0] + 3.0, 14.0 - p[:, 1]] / CELL
    ),
    "pixels from the map's lower left corner": lambda p: (p - (-3.0, 2.0)) / CELL,
    "millimetres": lambda p: p * 1000.0,
    "centimetres": lambda p: p * 100.0,
    "metres from the map's lower left corner": lambda p: p - (-3.0, 2.0),
    "y down": lambda p: p * (1.0, -1.0),
    "x and y swapped": lambda p: p[:, ::-1],
    "a half turn": lambda p: -p,
    "a quarter turn": lambda p: turned(p, 90.0),
}


@pytest.mark.parametrize("name", FRAMES)
def test_a_named_frame_is_found_exactly(scene, sound, name):
    lost = moved(sound, FRAMES[name])
    found = planner.audit(lost, scene, 0.3)
    fit = found.frame_fit
    assert fit is not None
    assert fit.named == name
    assert fit.sure
    assert fit.before < 0.7
    assert fit.after == 1.0
    points = np.array([(n.x, n.y) for n in sound.nodes])
    places = np.array([(n.x, n.y) for n in lost.nodes])
    np.testing.assert_allclose(fit.placed(places), points, atol=1e-6)
    (one,) = [f for f in found.findings if f.kind == "graph_wrong_frame"]
    assert (one.severity, one.subject, one.id) == ("error", "graph", "graph_wrong_frame")
    assert name in str(one)
    assert planner.audit(fit.apply(lost), scene, 0.3).safe


@pytest.mark.parametrize("seed", range(6))
def test_any_shift_turn_and_mirror_is_undone(scene, sound, seed):
    rng = np.random.default_rng(seed)
    sign = (1.0, float(rng.choice((-1.0, 1.0))))
    angle, shift = rng.uniform(-180, 180), rng.uniform(-30, 30, 2)
    lost = moved(sound, lambda p: turned(p * sign, angle) + shift)
    fit = planner.audit(lost, scene, 0.3).frame_fit
    assert fit is not None
    assert fit.after >= 0.95
    points = np.array([(n.x, n.y) for n in sound.nodes])
    places = np.array([(n.x, n.y) for n in lost.nodes])
    off = np.hypot(*(fit.placed(places) - points).T).mean()
    assert off < 0.3 or not fit.sure


def test_sound_graphs_and_graphs_with_some_bad_edges_are_not_lost(scene, sound):
    assert planner.audit(sound, scene, 0.3).frame_fit is None
    rng = np.random.default_rng(1)
    bad = []
    for k in range(12):
        a, b = rng.choice(len(sound.nodes), 2, replace=False).tolist()
        bad.append(RouteEdge(9000 + k, sound.nodes[a].id, sound.nodes[b].id))
    worse = replace(sound, edges=(*sound.edges, *bad))
    found = planner.audit(worse, scene, 0.3)
    assert not found.safe
    assert found.frame_fit is None


def test_what_no_frame_mends_is_not_offered_one():
    tight = map_scene(np.ones((40, 40), bool), GridPose(CELL, 0.0, 0.0, 0.0))
    nodes = tuple(RouteNode(k, float(k), 0.5) for k in range(5))
    graph = RouteGraph(nodes, tuple(RouteEdge(10 + k, k, k + 1) for k in range(4)), "nav2")
    assert planner.audit(graph, tight, 0.1).frame_fit is None
    open_hall = Scene.from_polygons([], bounds=(0, 0, 10, 10))
    few = replace(graph, edges=graph.edges[:2])
    far = moved(few, lambda p: p + 100.0)
    assert planner.audit(far, open_hall, 0.1).frame_fit is None  # two edges fit anywhere
    at_one = moved(graph, lambda p: p * 0.0 - 5.0)
    assert planner.audit(at_one, open_hall, 0.1).frame_fit is None
    assert planner.audit(RouteGraph(), open_hall, 0.1).frame_fit is None


def test_a_symmetric_room_has_several_answers_and_none_is_sure():
    room = Scene.from_polygons([], bounds=(0, 0, 8, 8))
    nodes = tuple(RouteNode(k, x, y) for k, (x, y) in enumerate([(1, 1), (7, 1), (7, 7), (1, 7)]))
    edges = tuple(RouteEdge(10 + k, k, (k + 1) % 4) for k in range(4))
    ring = RouteGraph(nodes, edges, "nav2")
    fit = planner.audit(moved(ring, lambda p: p - 100.0), room, 0.3).frame_fit
    assert fit is not None
    assert fit.after == 1.0
    # turned by a quarter the ring is the same, but its nodes are elsewhere
    assert not fit.sure
    assert fit.runner_up == pytest.approx(1.0, abs=0.02)


def test_a_fit_transforms_lines_and_lengths_and_says_what_it_does():
    nodes = (RouteNode("a", 0.0, 0.0), RouteNode("b", 100.0, 0.0))
    edge = RouteEdge("e", "a", "b", line=((0.0, 0.0), (50.0, 20.0), (100.0, 0.0)), length=110.0)
    graph = RouteGraph(nodes, (edge,), "node-link")
    fit = FrameFit(0.01, 0.5 * math.pi, True, (2.0, 3.0), 0.1, 1.0, 0.5)
    put = fit.apply(graph)
    # mirrored, then turned to the left, then shifted
    np.testing.assert_allclose(put.edges[0].line, [(2.0, 3.0), (2.2, 3.5), (2.0, 4.0)])
    assert put.edges[0].length == pytest.approx(1.1)
    assert (put.nodes[1].x, put.nodes[1].y) == pytest.approx((2.0, 4.0))
    assert str(fit) == "mirror y, scale by 0.01, turn by 90 degrees, shift by (2, 3)"
    assert fit.sure
    assert not replace(fit, runner_up=0.99).sure
    only = fit.apply(graph, lambda node: node.id == "a")
    assert only.nodes[1] == graph.nodes[1]
    assert only.edges == graph.edges

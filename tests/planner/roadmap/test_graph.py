"""The roadmap's graph: nothing of a chain is lost, and no node only passes from edge to edge."""

from __future__ import annotations

import math

import networkx as nx
import numpy as np
import pytest

import planner
from planner.formats.scene_io import read_scene_text
from planner.roadmap.graph import lay_strands
from planner.scene import Bounds, CircleRecord, Scene
from tests.support.scenes.planner_scenes import (
    hand_made,
    random_scene,
    scene_of,
    slow_distance,
    with_hole,
)

EVERYWHERE = Bounds(-1e6, -1e6, 1e6, 1e6)


@pytest.mark.parametrize("name", list(hand_made()))
def test_graph_holds_every_chain_it_keeps_from_end_to_end(name: str) -> None:
    roadmap = planner.build_roadmap(hand_made()[name], 3.0)
    chains = roadmap.clipped.chains
    kept = [c for s in lay_strands(roadmap.clipped.chains, roadmap.kept) for c, _ in s.chains]
    assert len(set(kept)) == len(kept)
    total = sum(data["length"] for _, _, data in roadmap.graph.edges(data=True))
    # chords that would be narrower than their edge are halved, and so a little longer
    assert total == pytest.approx(chains.length[kept].sum(), rel=2e-3)


@pytest.mark.parametrize("mode", ["exact", "paper"])
def test_a_roadmap_without_chains_is_an_empty_graph(mode: str) -> None:
    bare = Scene("px", Bounds(0.0, 0.0, 100.0, 60.0), ())
    roadmap = planner.build_roadmap(bare, 3.0 if mode == "paper" else 40.0, mode=mode)
    assert roadmap.graph.number_of_nodes() == 0
    assert roadmap.graph.number_of_edges() == 0


def test_a_ring_around_a_circle_is_whole() -> None:
    wall = with_hole(CircleRecord((80.0, 60.0), 55.0), CircleRecord((80.0, 60.0), 48.0))
    graph = planner.build_roadmap(scene_of(wall, CircleRecord((80.0, 60.0), 20.0)), 4.0).graph
    inner = [n for n, data in graph.nodes(data=True) if math.dist(data["pos"], (80, 60)) < 48.0]
    ring = graph.subgraph(inner)
    assert len(nx.cycle_basis(ring)) == 1
    # between the circles of radius 20 and 48 the way runs at radius 34
    around = sum(data["length"] for _, _, data in ring.edges(data=True))
    assert around == pytest.approx(math.tau * 34, rel=0.01)


@pytest.mark.parametrize("seed", range(12))
def test_only_halving_nodes_have_two_edges(seed: int) -> None:
    rng = np.random.default_rng(seed)
    roadmap = planner.build_roadmap(random_scene(rng), float(rng.uniform(1.5, 6.0)))
    graph = roadmap.graph
    for n, degree in graph.degree():
        if degree != 2 or n >= len(roadmap.clipped.chains.node_xy):
            continue
        # a node of a closed way without a junction, which has to begin somewhere
        part = nx.node_connected_component(graph, n)
        assert all(d == 2 for _, d in graph.degree(part))


@pytest.mark.parametrize("seed", range(20))
def test_an_edges_polyline_is_as_long_and_as_wide_as_it_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene, radius = random_scene(rng), float(rng.uniform(1.5, 8.0))
    roadmap = planner.build_roadmap(scene, radius)
    for u, v, data in roadmap.graph.edges(data=True):
        line = data["polyline"]
        ends = {tuple(np.round(line[i], 6)) for i in (0, -1)}
        assert ends == {tuple(np.round(roadmap.graph.nodes[n]["pos"], 6)) for n in (u, v)}
        assert data["length"] == pytest.approx(np.hypot(*np.diff(line, axis=0).T).sum())
        least = roadmap.path_clearance(line).distance
        assert least >= max(radius * (1.0 - 1e-7), data["clearance"] * (1.0 - 1.01e-4))
        assert least <= data["clearance"] + 1e-9


def test_a_halved_edge_is_as_wide_as_its_own_half() -> None:
    """Both halves of a single link, of which one is narrow, were told to be narrow."""
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n"
        "L 4 (182.33,40.35)(182.37,41.89)(178.42,24.03)(189.28,29.47)\nP (357.31,107.29)\n"
    )
    roadmap = planner.build_roadmap(scene, 11.261981799457654)
    halves = [n for n in roadmap.graph if n >= len(roadmap.clipped.chains.node_xy)]
    assert halves
    for _, _, data in roadmap.graph.edges(halves, data=True):
        parts = zip(data["polyline"], data["polyline"][1:], strict=False)
        share = np.linspace(0.0, 1.0, 200)[:, None]
        least = slow_distance(scene, np.concatenate([a + share * (b - a) for a, b in parts])).min()
        assert data["clearance"] == pytest.approx(least, rel=1e-4)


@pytest.mark.parametrize("seed", range(20))
def test_a_node_belongs_to_what_it_is_equidistant_to(seed: int) -> None:
    """Junctions were said to belong to all objects along their edges."""
    rng = np.random.default_rng(seed)
    scene = random_scene(rng)
    graph = planner.build_roadmap(scene, float(rng.uniform(1.5, 8.0))).graph
    alone = [scene_of(o, bounds=EVERYWHERE) for o in scene.objects]
    for _, data in graph.nodes(data=True):
        x, y = data["pos"]
        b = scene.bounds
        away = [min(x - b.x_min, b.x_max - x, y - b.y_min, b.y_max - y)]
        away += [slow_distance(one, np.array([(x, y)]))[0] for one in alone]
        near = [i - 1 for i, d in enumerate(away) if d <= data["clearance"] + 1e-4]
        assert data["owners"] == tuple(near)


@pytest.mark.parametrize("name", list(hand_made()))
def test_counting_agrees_with_the_graph(name: str) -> None:
    for radius in (1.5, 4.0):
        roadmap = planner.build_roadmap(hand_made()[name], radius)
        counts = dict(roadmap.counts)
        assert counts["roadmap_nodes"] == roadmap.graph.number_of_nodes()
        assert counts["roadmap_edges"] == roadmap.graph.number_of_edges()

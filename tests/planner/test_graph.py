"""The roadmap's graph: nothing of a chain is lost, and no node only passes from edge to edge."""

from __future__ import annotations

import math

import networkx as nx
import numpy as np
import pytest

import planner
from planner.graph import lay_strands
from planner.scene import CircleRecord
from tests.support.planner_scenes import hand_made, random_scene, scene_of, with_hole


@pytest.mark.parametrize("name", list(hand_made()))
def test_graph_holds_every_chain_it_keeps_from_end_to_end(name: str) -> None:
    roadmap = planner.build_roadmap(hand_made()[name], 3.0)
    chains = roadmap.chains
    kept = [c for s in lay_strands(chains, 3.0) for c, _ in s.chains]
    assert len(set(kept)) == len(kept)
    total = sum(data["length"] for _, _, data in roadmap.graph.edges(data=True))
    assert total == pytest.approx(chains.length[kept].sum())


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
        if degree != 2 or n >= len(roadmap.chains.node_xy):
            continue
        # a node of a closed way without a junction, which has to begin somewhere
        part = nx.node_connected_component(graph, n)
        assert all(d == 2 for _, d in graph.degree(part))


@pytest.mark.parametrize("name", list(hand_made()))
def test_counting_agrees_with_the_graph(name: str) -> None:
    for radius in (1.5, 4.0):
        roadmap = planner.build_roadmap(hand_made()[name], radius)
        counts = dict(roadmap.counts)
        assert counts["roadmap_nodes"] == roadmap.graph.number_of_nodes()
        assert counts["roadmap_edges"] == roadmap.graph.number_of_edges()

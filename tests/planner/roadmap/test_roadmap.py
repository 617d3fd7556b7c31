"""The roadmap's graph, its exact clearances, and what it refuses."""

from __future__ import annotations

import itertools
import math

import networkx as nx
import numpy as np
import pytest

import planner
from planner.scene import Scene, primitive_kernels
from tests.support.scenes.planner_scenes import (
    box,
    hand_made,
    random_scene,
    scene_of,
    slow_distance,
    slow_inside,
)


@pytest.mark.parametrize("name", list(hand_made()))
def test_graph_keeps_the_radius_and_its_clearances_are_exact(name: str) -> None:
    scene = hand_made()[name]
    graph = planner.build_roadmap(scene, 4.0).graph
    for _, data in graph.nodes(data=True):
        place = np.array([data["pos"]])
        assert data["clearance"] == pytest.approx(slow_distance(scene, place)[0], abs=1e-7)
        assert not slow_inside(scene, place)[0]
    for u, v, data in graph.edges(data=True):
        line = data["polyline"]
        ends = {tuple(line[0]), tuple(line[-1])}
        assert ends == {graph.nodes[u]["pos"], graph.nodes[v]["pos"]}
        assert data["clearance"] >= 4.0
        assert slow_distance(scene, line).min() == pytest.approx(data["clearance"], abs=1e-6)
        assert data["length"] == pytest.approx(np.hypot(*np.diff(line, axis=0).T).sum())
        assert data["geometry"][0].start == tuple(line[0])
        assert data["geometry"][-1].end == tuple(line[-1])


@pytest.mark.parametrize("seed", range(10))
def test_places_on_edges_are_on_the_bisector_of_their_pieces(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = random_scene(rng)
    radius = float(rng.uniform(2.0, 8.0))
    roadmap = planner.build_roadmap(scene, radius)
    chains = roadmap.chains
    one = [
        primitive_kernels.distance(
            roadmap.borders.kind, roadmap.borders.data, int(side), *chains.points[i]
        )
        for i in np.flatnonzero(chains.proved)
        for side in chains.pieces[i]
    ]
    rho = np.repeat(chains.rho[chains.proved], 2)
    assert np.abs(np.array(one) - rho).max() <= 1e-9 * 160
    assert slow_distance(scene, chains.points) == pytest.approx(chains.rho, abs=1e-6)
    wide = (chains.rho >= radius) & (chains.pieces[:, 0] >= 0)
    assert chains.proved[wide].mean() > 0.9


def test_inside_of_a_u_and_of_a_room_keep_their_branches() -> None:
    for name, place in (("U", (70, 60)), ("room of one wall", (80, 60))):
        graph = planner.build_roadmap(hand_made()[name], 4.0).graph
        nearest = min(math.dist(d["pos"], place) for _, d in graph.nodes(data=True))
        assert nearest < 35
        assert nx.number_connected_components(graph) == 1


def test_corners_of_an_empty_arena_leave_no_spurs() -> None:
    graph = planner.build_roadmap(scene_of(), 4.0).graph
    assert max(dict(graph.degree()).values()) <= 2


def test_paper_mode_omits_edges_within_one_object() -> None:
    scene = hand_made()["U"]
    paper = planner.build_roadmap(scene, 4.0, mode="paper")
    valid = paper.agvd.valid
    owner = paper.agvd.generators.owner
    pairs = owner[paper.agvd.ordinary.edges[valid, :2]]
    assert (pairs[:, 0] != pairs[:, 1]).all()
    assert paper.counts["generators"] == len(paper.agvd.generators.sites)


def test_generators_are_on_the_borders_and_closer_than_the_spacing() -> None:
    for scene in hand_made().values():
        roadmap = planner.build_roadmap(scene, 3.0)
        borders = roadmap.borders
        sites = roadmap.agvd.generators.sites
        assert borders.distances(sites)[0].max() < 1e-9
        assert roadmap.spacing < 6.0


@pytest.mark.parametrize("radius", [0.0, -3.0, math.nan, math.inf])
def test_a_radius_that_is_none_is_refused(radius: float) -> None:
    with pytest.raises(ValueError, match=f"radius = {radius}: must be > 0 and finite"):
        planner.build_roadmap(scene_of(), radius)


@pytest.mark.parametrize("spacing", [8.0, 0.0, -1.0, math.nan, math.inf])
def test_a_spacing_of_two_radii_or_none_is_refused(spacing: float) -> None:
    with pytest.raises(ValueError, match="spacing"):
        planner.build_roadmap(scene_of(), 4.0, spacing=spacing)


def test_too_many_generators_are_refused_before_they_are_made() -> None:
    with pytest.raises(ValueError, match="GB of memory: must be at most"):
        planner.build_roadmap(scene_of(), 1e-9)


def test_clearance_is_signed() -> None:
    roadmap = planner.build_roadmap(scene_of(box(60, 40, 100, 80)), 4.0)
    assert roadmap.clearance([(80, 60), (50, 60), (-3, 60)]) == pytest.approx([-20, 10, -2.5])


@pytest.mark.parametrize("seed", range(5))
def test_path_clearance_is_that_of_the_densest_sampling(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene: Scene = random_scene(rng)
    line = rng.uniform(5, 115, (4, 2))
    found = planner.build_roadmap(scene, 5.0).path_clearance(line)
    t = np.linspace(0.0, 1.0, 4000)[:, None]
    dense = np.concatenate([a + t * (b - a) for a, b in itertools.pairwise(line)])
    sampled = slow_distance(scene, dense).min()
    assert found.distance <= sampled + 1e-9
    assert found.distance >= sampled - 0.03
    assert slow_distance(scene, np.array([found.at]))[0] == pytest.approx(found.distance, abs=1e-7)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_scaling_the_arena_scales_the_roadmap(factor: float) -> None:
    from planner.scene import Bounds

    def scaled(k: float) -> Scene:
        return scene_of(
            box(60 * k, 40 * k, 100 * k, 80 * k), bounds=Bounds(0.0, 0.0, 160 * k, 120 * k)
        )

    one = planner.build_roadmap(scaled(1.0), 5.0)
    other = planner.build_roadmap(scaled(factor), 5.0 * factor)
    assert one.counts["roadmap_edges"] == other.counts["roadmap_edges"]
    assert sum(d for _, _, d in other.graph.edges(data="length")) == pytest.approx(
        factor * sum(d for _, _, d in one.graph.edges(data="length")), rel=1e-6
    )

"""Short dead ends that a caller asks to leave out, against networkx on the same graph."""

from __future__ import annotations

import math
import random
from types import SimpleNamespace
from typing import Any

import networkx as nx
import numpy as np
import pytest

import planner
from planner.fleet.on_roadmap import roadmap_for
from planner.formats.grid_maps import grid_scene
from planner.roadmap.curves import curves_of
from planner.roadmap.graph import without_short_branches
from planner.scene import Scene
from tests.support.scenes.planner_scenes import hand_made

Graph = nx.MultiGraph


def multigraph(chains: Any, kept: list[int]) -> Graph:
    graph: Graph = nx.MultiGraph()
    for c in kept:
        u, v = chains.ends[c].tolist()
        graph.add_edge(u, v, key=c, length=float(chains.length[c]))
    return graph


def dead_ends(graph: Graph) -> list[tuple[float, list[tuple[int, int, int]], int]]:
    """Length, edges and far end of what leads from each tip to the next node that forks or ends."""
    found = []
    for tip in [n for n, degree in graph.degree() if degree == 1]:
        row, total, here, last = [], 0.0, tip, None
        while True:
            ((u, v, key, data),) = [
                e for e in graph.edges(here, keys=True, data=True) if e[2] != last
            ]
            row.append((u, v, key))
            total, here, last = total + data["length"], v, key
            if graph.degree(here) != 2:
                break
        found.append((total, row, here))
    return found


def pruned(graph: Graph, least: float) -> tuple[Graph, list[float]]:
    """The slow way: the shortest of all dead ends goes, and all are looked for again."""
    graph, lengths = graph.copy(), []
    while True:
        short = [d for d in dead_ends(graph) if d[0] < least and graph.degree(d[2]) > 2]
        if not short:
            return graph, lengths
        total, row, _ = min(short, key=lambda d: d[0])
        graph.remove_edges_from(row)
        graph.remove_nodes_from([n for n in list(graph) if graph.degree(n) == 0])
        lengths.append(total)


def random_chains(seed: int) -> Any:
    """A random multigraph with loops, parallel edges and several parts, as chains."""
    rng = random.Random(seed)
    nodes, edges = rng.randint(2, 14), rng.randint(1, 22)
    ends = np.array([[rng.randrange(nodes), rng.randrange(nodes)] for _ in range(edges)])
    length = np.array([rng.uniform(0.01, 1.0) for _ in range(edges)])
    xy = np.array([[rng.uniform(0, 9), rng.uniform(0, 9)] for _ in range(nodes)])
    return SimpleNamespace(ends=ends, length=length, node_xy=xy)


@pytest.mark.parametrize("seed", range(300))
def test_what_is_left_is_what_networkx_leaves(seed: int) -> None:
    chains = random_chains(seed)
    everything = list(range(len(chains.length)))
    least = random.Random(seed).choice([0.2, 0.7, 1.5, 50.0])
    kept, left_out = without_short_branches(chains, everything, 1.0, least)
    before = multigraph(chains, everything)
    expected, lengths = pruned(before, least)
    assert set(kept) == {key for *_, key in expected.edges(keys=True)}
    assert sorted(left_out) == pytest.approx(sorted(lengths))


@pytest.mark.parametrize("seed", range(100))
def test_no_loop_and_no_only_connection_is_lost(seed: int) -> None:
    chains = random_chains(1000 + seed)
    everything = list(range(len(chains.length)))
    kept, _ = without_short_branches(chains, everything, 1.0, 1e9)
    before, after = multigraph(chains, everything), multigraph(chains, kept)
    assert nx.number_connected_components(before) == nx.number_connected_components(after)

    def loops(graph: Graph) -> int:
        parts = nx.number_connected_components(graph)
        return int(graph.number_of_edges() - graph.number_of_nodes() + parts)

    assert loops(before) == loops(after)
    for part in nx.connected_components(after):
        tips = [n for n in part if after.degree(n) == 1]
        # a part without a loop is a single way from tip to tip
        has_loop = after.subgraph(part).number_of_edges() >= len(part)
        assert len(tips) == (0 if has_loop else 2)


@pytest.fixture(scope="module")
def noisy() -> Scene:
    """A room whose walls have notches, with two blocks in it."""
    rng = np.random.default_rng(7)
    cells = np.zeros((80, 120), dtype=np.bool_)
    cells[[0, -1], :] = cells[:, [0, -1]] = True
    cells[30:50, 25:45] = cells[20:60, 75:90] = True
    cells[1:9, 1:119:9] = True
    cells[71:79, 1:119:7] = True
    cells[1:79, 1:119] |= rng.random((78, 118)) < 0.001
    return grid_scene(cells)


def test_the_graph_counts_and_the_picture_agree_and_the_remark_counts(noisy: Scene) -> None:
    whole = planner.build_roadmap(noisy, 1.0)
    short = planner.build_roadmap(noisy, 1.0, least_branch=12.0)
    graph = multigraph(whole.clipped.chains, list(whole.kept))
    expected, lengths = pruned(graph, 12.0)
    assert lengths
    assert {key for *_, key in expected.edges(keys=True)} == set(short.kept)
    ends = dead_ends(multigraph(short.clipped.chains, list(short.kept)))
    assert all(total >= 12.0 for total, _, _ in ends)
    assert short.counts["roadmap_edges"] == short.graph.number_of_edges()
    assert short.counts["roadmap_edges"] < whole.counts["roadmap_edges"]
    lines, fewer = curves_of(whole), curves_of(short)
    assert lines is not None
    assert fewer is not None
    assert len(fewer.first) < len(lines.first)
    said = (
        f"left out {len(lengths)} dead ends of the roadmap shorter than 12 cells: the longest has "
        f"{max(lengths):.3g} cells"
    )
    assert short.remarks == (*whole.remarks, said)


def test_paths_into_a_dead_end_that_was_left_out_are_as_before(noisy: Scene) -> None:
    whole = planner.build_roadmap(noisy, 1.0)
    short = planner.build_roadmap(noisy, 1.0, least_branch=1e6)
    # between two teeth of the upper and of the lower wall
    for start in ((5.5, 3.0), (95.0, 4.0)):
        for goal in ((32.0, 76.0), (60.0, 40.0)):
            here, there = whole.plan(start, goal), short.plan(start, goal)
            assert isinstance(here, planner.Path)
            assert isinstance(there, planner.Path)
            assert np.array_equal(here.points, there.points)


def test_robots_give_way_in_dead_ends_that_were_left_out(noisy: Scene) -> None:
    short = planner.build_roadmap(noisy, 1.0, least_branch=1e6)
    whole = roadmap_for(short, 1.0)
    assert whole.kept == planner.build_roadmap(noisy, 1.0).kept
    assert len(whole.kept) > len(short.kept)
    assert roadmap_for(whole, 1.0) is whole


def test_an_updated_roadmap_leaves_out_as_much(noisy: Scene) -> None:
    short = planner.build_roadmap(noisy, 1.0, least_branch=12.0)
    smaller = noisy.replace_object(len(noisy.objects) - 1)
    again = planner.build_roadmap(smaller, 1.0, least_branch=12.0)
    assert short.updated(smaller).counts == pytest.approx(again.counts, rel=0.02)
    assert short.updated(smaller).least_branch == 12.0


@pytest.mark.parametrize("name", list(hand_made()))
def test_nothing_is_left_out_unasked(name: str) -> None:
    roadmap = planner.build_roadmap(hand_made()[name], 3.0)
    assert not [r for r in roadmap.remarks if "dead end" in r]
    asked = planner.build_roadmap(hand_made()[name], 3.0, least_branch=0.001)
    assert asked.kept == roadmap.kept
    said = "no dead end of the roadmap is shorter than 0.001 px: none was left out"
    assert asked.remarks == (*roadmap.remarks, said)


@pytest.mark.parametrize("wrong", [-1.0, math.nan, math.inf])
def test_no_other_number_is_a_length(noisy: Scene, wrong: float) -> None:
    with pytest.raises(ValueError, match=r"least_branch = .*: must be >= 0 and finite"):
        planner.build_roadmap(noisy, 1.0, least_branch=wrong)

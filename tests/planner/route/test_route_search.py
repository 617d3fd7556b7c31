"""Routes over the chains: as cheap as networkx's, the k cheapest in order, laid without gaps."""

from __future__ import annotations

import itertools

import networkx as nx
import numpy as np
import pytest

import planner
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray
from planner.search import route_search_kernels
from planner.search.chain_graph_kernels import GateCosts, Gates
from planner.search.chain_search import WORK, Network, attach, cheapest_routes, widest_gap
from tests.support.scenes.planner_scenes import box, hand_made, random_scene, scene_of


def _stations(roadmap: Roadmap, rng: np.random.Generator) -> list[tuple[float, float]]:
    places = rng.uniform(0.0, 119.0, (200, 2))
    places = places[roadmap.clearance(places) >= roadmap.radius]
    return [(float(x), float(y)) for x, y in places]


def _costs(network: Network, gates: Gates, floor: float) -> GateCosts:
    """Node and cost of both ways over each gate, infinity below the floor."""
    return route_search_kernels.gates_of(gates, network.chains.ends, floor)


def _graph(network: Network, start: Gates, goal: Gates, floor: float) -> nx.MultiGraph:
    """The chains not below the floor, "s" and "g" joined to them over their gates."""
    chains = network.chains
    graph = nx.MultiGraph()
    graph.add_nodes_from(["s", "g"])
    for c, (u, v) in enumerate(chains.ends.tolist()):
        if chains.clearance[c] >= floor:
            graph.add_edge(u, v, weight=float(network.graph.total[c]))
    for name, gates in (("s", start), ("g", goal)):
        for node, cost in zip(*_costs(network, gates, floor), strict=True):
            if np.isfinite(cost):
                graph.add_edge(name, int(node), weight=float(cost))
    return graph


def _inside(network: Network, start: Gates, goal: Gates, floor: float) -> float:
    """What the cheapest way within one chain costs, its links added up one by one."""
    best = np.inf
    chains = network.chains
    for (c, i), p in zip(start.where.tolist(), start.price, strict=True):
        for (d, j), q in zip(goal.where.tolist(), goal.price, strict=True):
            if c != d or min(p[2], q[2]) < floor:
                continue
            links = range(min(i, j), max(i, j) + 1)
            if min((chains.gap[k] for k in links), default=np.inf) < floor:
                continue
            at, to = (network.graph.cost[:i].sum() + p[0] * network.graph.cost[i],
                      network.graph.cost[:j].sum() + q[0] * network.graph.cost[j])  # fmt: skip
            best = min(best, p[1] + q[1] + abs(at - to))
    return float(best)


def _length(line: FloatArray) -> float:
    return float(np.hypot(*np.diff(line, axis=0).T).sum())


def _pairs(places: list[tuple[float, float]]) -> list[tuple[tuple[float, float], ...]]:
    return list(zip(places[::2], places[1::2], strict=False))


@pytest.mark.parametrize("seed", range(25))
def test_the_first_route_is_as_cheap_as_networkx_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    roadmap = planner.build_roadmap(random_scene(rng), float(rng.uniform(1.5, 6.0)))
    need = roadmap.radius
    network = Network.of(roadmap.chains, need, 0.0)
    for a, b in _pairs(_stations(roadmap, rng)[:12]):
        start, goal = (attach(roadmap.borders, network, p, need) for p in (a, b))
        graph = _graph(network, start, goal, need)
        best = _inside(network, start, goal, need)
        if nx.has_path(graph, "s", "g"):
            best = min(best, nx.dijkstra_path_length(graph, "s", "g"))
        found, _ = cheapest_routes(roadmap.borders, network, start, goal, need, 4)
        assert (len(found) > 0) == np.isfinite(best)
        if len(found):
            # costs are lengths here: those of the curves, which the line's chords cut short
            length = _length(found.points[: found.begin[1]])
            assert 0.97 * best <= length <= best * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_the_widest_way_is_the_widest_of_all_thresholds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    roadmap = planner.build_roadmap(random_scene(rng), 2.0)
    network = Network.of(roadmap.chains, 2.0, 0.0)
    for a, b in _pairs(_stations(roadmap, rng)[:8]):
        start, goal = (attach(roadmap.borders, network, p, 2.0) for p in (a, b))
        wide = widest_gap(network, start, goal)
        if wide >= 2.0:
            keep = wide * (1 - 1e-12)
            assert len(cheapest_routes(roadmap.borders, network, start, goal, keep, 1)[0]) == 1
        over = max(wide, 0.0) * (1 + 1e-9) + 1e-9
        assert len(cheapest_routes(roadmap.borders, network, start, goal, over, 1)[0]) == 0


@pytest.mark.parametrize("seed", range(10))
def test_the_k_cheapest_routes_are_those_of_a_search_of_all(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes = [
        box(20 + 45 * i, 20 + 45 * j, 38 + 45 * i, 40 + 45 * j) for i in range(3) for j in (0, 1)
    ]
    keep = rng.permutation(6)[:4]
    roadmap = planner.build_roadmap(scene_of(*(boxes[i] for i in keep)), 2.0)
    network = Network.of(roadmap.chains, 2.0, 0.0)
    for a, b in _pairs(_stations(roadmap, rng)[:6]):
        start, goal = (attach(roadmap.borders, network, p, 2.0) for p in (a, b))
        if len(start.where) > 1 or len(goal.where) > 1 or start.where[0, 0] == goal.where[0, 0]:
            continue
        graph = _graph(network, start, goal, 2.0)
        # a way that enters a chain's end and walks back past the station is no way of its own
        chains = network.chains
        mine = [int(start.where[0, 0]), int(goal.where[0, 0])]
        for c in set(mine):
            u, v = chains.ends[c].tolist()
            graph.remove_edge(u, v, _key(graph, u, v, float(network.graph.total[c])))
        costs = sorted(
            sum(graph.edges[step]["weight"] for step in way)
            for way in nx.all_simple_edge_paths(graph, "s", "g")
        )
        for wanted in (1, 3, 8):
            found, work = cheapest_routes(roadmap.borders, network, start, goal, 2.0, wanted)
            assert work <= WORK
            assert len(found.after(1, 10**9)) == len(found) - 1
            lengths = [_length(found.points[i:j]) for i, j in itertools.pairwise(found.begin)]
            assert len(lengths) == min(wanted, len(costs))
            assert lengths == pytest.approx(costs[: len(lengths)], rel=0.01)
        assert len(costs) > 4


@pytest.mark.parametrize("dearest", [1.0, 1.1, 1.25, 2.0])
def test_a_limit_on_the_cost_leaves_out_dearer_routes_and_no_others(dearest: float) -> None:
    fewer, spared = 0, 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        roadmap = planner.build_roadmap(random_scene(rng), 2.0)
        network = Network.of(roadmap.chains, 2.0, 0.0)
        for a, b in _pairs(_stations(roadmap, rng)[:8]):
            gates = [attach(roadmap.borders, network, p, 2.0) for p in (a, b)]
            every, work = cheapest_routes(roadmap.borders, network, *gates, 2.0, 12)
            found, less = cheapest_routes(
                roadmap.borders, network, *gates, 2.0, 12, dearest=dearest
            )
            n = len(found)
            assert np.array_equal(found.begin, every.begin[: n + 1])
            assert np.array_equal(found.points, every.points[: found.begin[-1]])
            lengths = [_length(every.points[i:j]) for i, j in itertools.pairwise(every.begin)]
            # lengths of chords, which are a little shorter than the costs
            assert all(length <= 1.01 * dearest * lengths[0] for length in lengths[:n])
            assert all(length >= 0.97 * dearest * lengths[0] for length in lengths[n:])
            fewer += n < len(every)
            spared += work - less
    assert fewer > 5
    assert spared > 0


def _key(graph: nx.MultiGraph, u: int, v: int, weight: float) -> int:
    return next(k for k, d in graph[u][v].items() if d["weight"] == weight)


@pytest.mark.parametrize("name", list(hand_made()))
def test_laid_routes_have_no_gap_and_know_what_is_beside_them(name: str) -> None:
    roadmap = planner.build_roadmap(hand_made()[name], 2.0)
    rng = np.random.default_rng(7)
    network = Network.of(roadmap.chains, 2.0, 0.0)
    longest = float(roadmap.chains.step.max()) * (1 + 1e-9)
    for a, b in _pairs(_stations(roadmap, rng)[:10]):
        start, goal = (attach(roadmap.borders, network, p, 2.0) for p in (a, b))
        found, _ = cheapest_routes(roadmap.borders, network, start, goal, 2.0, 4)
        for i, j in itertools.pairwise(found.begin):
            line, pairs = found.points[i:j], found.pairs[i:j]
            assert tuple(line[0]) == a
            assert tuple(line[-1]) == b
            steps = np.hypot(*np.diff(line, axis=0).T)
            assert (steps > 0.0).all()
            known = pairs[:-1, 0] >= 0
            assert (steps[known] <= longest).all()
            middle = 0.5 * (line[:-1] + line[1:])[known]
            for place, step, pair in zip(middle, steps[known], pairs[:-1][known], strict=True):
                away = [_foot(roadmap, int(p), place) for p in pair]
                # beside the link's middle both pieces are as near, but for the curve's bulge
                assert abs(np.hypot(*away[0]) - np.hypot(*away[1])) <= 0.5 * step + 1e-9
                across = away[0] - away[1]
            k = int(np.flatnonzero(known)[0]) if known.any() else -1
            if k >= 0:
                along = line[k + 1] - line[k]
                here = 0.5 * (line[k] + line[k + 1])
                left, right = (_foot(roadmap, int(p), here) for p in pairs[k])
                across = left - right
                assert along[0] * across[1] - along[1] * across[0] >= -1e-9


def _foot(roadmap: Roadmap, piece: int, place: FloatArray) -> FloatArray:
    """From a place to the nearest point of a piece."""
    from planner.scene import primitive_kernels

    b = roadmap.borders
    return np.array(primitive_kernels.foot(b.kind, b.data, piece, *place)) - place

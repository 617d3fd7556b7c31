"""Coverage: shares of the free space, against areas that are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import planner
from planner import RouteEdge, RouteGraph, RouteNode, Scene, measure_coverage

HALL = Scene.from_polygons([], bounds=(0, 0, 30, 10))
LANE = RouteGraph(
    (RouteNode(1, 5.0, 5.0), RouteNode(2, 25.0, 5.0)),
    (RouteEdge(3, 1, 2), RouteEdge(4, 2, 1)),
    "nav2",
)
DIVIDED = Scene.from_polygons([[(9.8, 0), (10.2, 0), (10.2, 10), (9.8, 10)]], bounds=(0, 0, 30, 10))


def measured(graph, scene, radius=0.25, **more):
    return measure_coverage(planner.audit(graph, scene, radius), scene, **more)


def test_the_share_within_reach_is_the_area_around_the_lane():
    done = measured(LANE, HALL, reach=2.0)
    free = (30 - 0.5) * (10 - 0.5)
    assert done.free_area == pytest.approx(free, rel=0.02)
    assert done.covered == pytest.approx((20 * 4 + math.pi * 4) / free, rel=0.05)
    assert done.reach == 2.0
    assert done.farthest == pytest.approx(math.hypot(4.75, 4.75), rel=0.1)
    assert measured(LANE, HALL).reach == 2.5
    assert measured(LANE, HALL, reach=50.0).covered == 1.0


def test_behind_a_wall_nothing_is_within_reach():
    left = replace(LANE, nodes=(RouteNode(1, 9.0, 2.0), RouteNode(2, 9.0, 8.0)))
    done = measured(left, DIVIDED, reach=100.0)
    share = 9.3 / (9.3 + 19.3)  # between 0.25 and 9.55, and between 10.45 and 29.75
    assert done.covered == pytest.approx(share, abs=0.02)
    assert done.farthest is None
    assert done.region_share == pytest.approx(share, abs=0.02)
    assert done.share_per_node == pytest.approx(0.5 * done.region_share)


def test_an_unsafe_edge_serves_nobody_but_safe_nodes_do():
    through = replace(LANE, nodes=(RouteNode(1, 5.0, 5.0), RouteNode(2, 15.0, 5.0)))
    done = measured(through, DIVIDED, reach=1.0)
    free = (9.3 + 19.3) * 9.5
    assert done.covered == pytest.approx(2 * math.pi / free, rel=0.15)
    assert done.region_share == 1.0


def test_an_unsafe_node_serves_nobody():
    """Against samples of an almost empty hall, in which robots drive straight to the graph."""
    half, radius, reach = 0.05, 0.25, 2.0
    corners = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    posts = [np.array(place) for place in ((5.0, 5.0), (22.0, 3.0))]
    hall = Scene.from_polygons([(post + corners).tolist() for post in posts], bounds=(0, 0, 30, 10))
    nodes = (
        RouteNode(1, 10.0, 5.0),
        RouteNode(2, 14.0, 5.0),
        RouteNode("safe", 17.0, 8.0),
        RouteNode("in a post", 5.0, 5.0),
        RouteNode("near a post", 22.25, 3.0),
        RouteNode("near the wall", 27.0, 9.9),
    )
    edges = (
        RouteEdge(7, 1, 2),
        RouteEdge(8, "near the wall", "safe"),
        RouteEdge(9, "in a post", "in a post"),
    )
    graph = RouteGraph(nodes, edges, "nav2")

    samples = np.random.default_rng(3).uniform((radius, radius), (29.75, 9.75), (100_000, 2))
    for post in posts:
        outside = np.maximum(np.abs(samples - post) - half, 0.0)
        samples = samples[np.hypot(*outside.T) >= radius]
    to_edge = samples - np.clip(samples, (10.0, 5.0), (14.0, 5.0))
    far = np.minimum(np.hypot(*to_edge.T), np.hypot(*(samples - (17.0, 8.0)).T))
    done = measured(graph, hall, radius, reach=reach)
    assert done.covered == pytest.approx((far <= reach).mean(), abs=0.01)
    assert done.farthest == pytest.approx(far.max(), rel=0.09)

    unsafe = RouteGraph(nodes[3:], edges[2:], "nav2")
    assert measured(unsafe, hall, radius, reach=reach).covered == 0.0
    keepout = Scene.from_polygons([[(9, 4), (15, 4), (15, 6), (9, 6)]], bounds=(0, 0, 30, 10))
    kept_out = measure_coverage(planner.audit(graph, hall, radius, keepout=keepout), hall, reach)
    alone = RouteGraph(nodes[2:3], (), "nav2")
    assert kept_out.covered == measured(alone, hall, radius, reach=reach).covered > 0.0


def test_distances_to_nodes_and_connected_pairs_are_those_of_swagger():
    one = replace(LANE, nodes=(RouteNode(1, 15.0, 5.0),), edges=())
    done = measured(one, HALL)
    assert done.farthest_to_node == pytest.approx(math.hypot(14.75, 4.75), abs=0.3)
    # mean distance to the centre of a rectangle of 29.5 x 9.5, by fine sampling
    xs = [(k + 0.5) * 29.5 / 400 - 14.75 for k in range(400)]
    ys = [(k + 0.5) * 9.5 / 200 - 4.75 for k in range(200)]
    mean = sum(math.hypot(x, y) for x in xs for y in ys) / (len(xs) * len(ys))
    assert done.mean_to_node == pytest.approx(mean, rel=0.02)
    assert done.connected_pairs == 0.0
    assert measured(LANE, HALL).connected_pairs == 1.0
    chain = RouteGraph(
        tuple(RouteNode(k, 3.0 + k, 5.0) for k in range(4)),
        tuple(RouteEdge(10 + k, k, k + 1) for k in range(3)),
        "nav2",
    )
    assert measured(chain, HALL).connected_pairs == pytest.approx(6 / 12)


def test_nothing_covers_nothing():
    empty = measured(RouteGraph(), HALL)
    assert (empty.covered, empty.region_share, empty.mean_to_node) == (0.0, 0.0, None)
    assert empty.share_per_node == empty.connected_pairs == 0.0
    full = Scene.from_polygons([[(0, 0), (30, 0), (30, 10), (0, 10)]], bounds=(0, 0, 30, 10))
    solid = measured(LANE, full)
    assert (solid.free_area, solid.covered, solid.farthest) == (0.0, 0.0, None)
    outside = replace(LANE, nodes=(RouteNode(1, -500.0, 5.0), RouteNode(2, 1e9, 5.0)))
    assert measured(outside, HALL).covered == 0.0
    with pytest.raises(ValueError, match=r"reach = 0\.0: must be > 0 and finite"):
        measured(LANE, HALL, reach=0.0)


def test_large_maps_are_counted_in_larger_cells():
    wide = Scene.from_polygons([], bounds=(0, 0, 3000, 1000))
    done = measured(LANE, wide, reach=1000.0)
    assert done.cell == pytest.approx(math.sqrt(3e6 / 60_000))
    # a quarter of a disc of 1000 m, which the map's upper border just touches
    assert done.covered == pytest.approx(math.pi / 4 * 1e6 / 3e6, rel=0.1)

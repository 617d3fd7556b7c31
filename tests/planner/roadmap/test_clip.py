"""Chains that are too narrow in places: their wide parts are in the graph, and nothing else."""

from __future__ import annotations

import math
from dataclasses import replace

import networkx as nx
import numpy as np
import pytest
from scipy import ndimage

import planner
from planner.formats.scene_io import read_scene_text
from planner.roadmap.clip import Clipped
from planner.roadmap.graph import without_spurs
from planner.scene import Bounds, CircleRecord, Scene
from tests.support.scenes.planner_scenes import (
    box,
    hand_made,
    polygon,
    random_scene,
    scene_of,
    slow_distance,
    slow_inside,
)

EIGHT = np.ones((3, 3))
PINCHED = scene_of(
    polygon([(0.0, 0.0), (600.0, 0.0), (300.0, 20.0)]),
    polygon([(0.0, 60.0), (600.0, 60.0), (300.0, 40.0)]),
    bounds=Bounds(0.0, 0.0, 600.0, 60.0),
)
"""A corridor 60 wide that two walls narrow gently to 20 in its middle."""


def _judge(scene: Scene, radius: float) -> int:
    """One part of the graph for each room at the radius, by grid cells; how many rooms."""
    b = scene.bounds
    xs, ys = np.meshgrid(np.arange(b.x_min, b.x_max), np.arange(b.y_min, b.y_max))
    places = np.c_[xs.ravel(), ys.ravel()]
    distance = slow_distance(scene, places)
    distance[slow_inside(scene, places)] *= -1.0
    distance = distance.reshape(xs.shape)
    # what is joined a cell inside the radius is joined, and nothing that is not a cell outside
    sure = ndimage.label(distance >= radius + 1.0, structure=EIGHT)[0].ravel()
    maybe = ndimage.label(distance >= radius - 1.0, structure=EIGHT)[0].ravel()
    graph = planner.build_roadmap(scene, radius).graph
    covered: set[int] = set()
    part_of: dict[int, int] = {}
    for number, nodes in enumerate(nx.connected_components(graph)):
        at = np.rint(np.array([graph.nodes[n]["pos"] for n in nodes]) - places[0]).astype(int)
        columns, rows = np.clip(at, 0, np.array(xs.shape[::-1]) - 1).T
        cells = (rows * xs.shape[1] + columns).tolist()
        (room,) = {int(maybe[c]) for c in cells}
        assert room, "a node where the robot cannot stand"
        covered.add(room)
        for part in {int(sure[c]) for c in cells} - {0}:
            assert part_of.setdefault(part, number) == number, "two parts in one room"
    rooms = {int(room) for room in maybe[sure > 0]}
    assert rooms <= covered
    return len(rooms)


@pytest.mark.parametrize("name", list(hand_made()))
def test_each_room_of_a_hand_made_scene_has_one_part_of_the_graph(name: str) -> None:
    for radius in (1.5, 4.0, 9.0, 20.0):
        _judge(hand_made()[name], radius)


def test_each_room_of_a_random_scene_has_one_part_of_the_graph() -> None:
    rooms = 0
    for seed in range(30):
        rng = np.random.default_rng(seed + 700)
        rooms += _judge(random_scene(rng), float(rng.uniform(1.5, 12.0)))
    assert rooms > 30  # there are scenes of several rooms


@pytest.mark.parametrize("radius", [10.5, 15.0, 20.0, 24.0])
def test_both_ends_of_a_pinched_corridor_are_in_the_graph(radius: float) -> None:
    graph = planner.build_roadmap(PINCHED, radius).graph
    assert nx.number_connected_components(graph) == 2
    # the walls fall by 20 in 300
    reach = (30.0 - radius * math.hypot(1.0, 20.0 / 300.0)) * 300.0 / 20.0
    cuts = [n for n, data in graph.nodes(data=True) if data["clearance"] < radius + 1e-9]
    at = sorted(graph.nodes[n]["pos"] for n in cuts)
    assert at == [pytest.approx((reach, 30.0)), pytest.approx((600.0 - reach, 30.0))]
    assert all(graph.degree(n) == 1 for n in cuts)
    assert all(graph.nodes[n]["clearance"] >= radius * (1.0 - 1e-12) for n in cuts)


@pytest.mark.parametrize("prefer", ["length", "balanced", "clearance"])
def test_stations_on_the_wide_end_of_a_narrow_chain_are_planned_between(prefer: str) -> None:
    roadmap = planner.build_roadmap(PINCHED, 15.0)
    for a, b in (((215.0, 30.0), (40.0, 30.0)), ((25.0, 35.0), (220.0, 30.0))):
        path = roadmap.plan(a, b, prefer=prefer, via=[(160.0, 30.0)])
        assert isinstance(path, planner.Path)
        assert path.min_clearance >= 15.0
    assert isinstance(roadmap.plan((220.0, 30.0), (380.0, 30.0), prefer=prefer), planner.NoPath)


def test_the_parts_of_a_chain_are_the_chain() -> None:
    for seed in range(20):
        rng = np.random.default_rng(seed + 40)
        scene, radius = random_scene(rng), float(rng.uniform(1.5, 9.0))
        roadmap = planner.build_roadmap(scene, radius)
        cut, whole = roadmap.clipped.chains, roadmap.chains
        # a place slid onto the bisector makes the line through it a little longer
        assert cut.length.sum() == pytest.approx(whole.length.sum(), rel=1e-3)
        assert cut.length.sum() >= whole.length.sum() * (1.0 - 1e-12)
        assert (cut.clearance[roadmap.clipped.wide] >= radius - 1e-9 * 160.0).all()
        ends = np.c_[cut.first[:-1], cut.first[1:] - 1]
        assert cut.points[ends] == pytest.approx(cut.node_xy[cut.ends], abs=1e-6)
        assert cut.rho[ends] == pytest.approx(cut.node_rho[cut.ends], abs=1e-6)


def test_an_update_has_the_same_parts_as_a_new_roadmap() -> None:
    """A corridor is pinched, and opened again."""
    bounds = PINCHED.bounds
    post = box(290.0, 15.0, 310.0, 55.0)
    for other in (CircleRecord((120.0, -30.0), 55.0), CircleRecord((450.0, -10.0), 30.0)):
        few = [*(o.records[0] for o in PINCHED.objects), other]
        roadmap = planner.build_roadmap(scene_of(*few, bounds=bounds), 14.0)
        for objects in ([*few, post], few, few[:-1]):
            scene = scene_of(*objects, bounds=bounds)
            roadmap = roadmap.updated(scene)
            anew = planner.build_roadmap(scene, 14.0)
            lengths = [
                sorted(data["length"] for *_, data in made.graph.edges(data=True))
                for made in (roadmap, anew)
            ]
            assert lengths[0] == pytest.approx(lengths[1], rel=1e-6)
            assert dict(roadmap.counts) == dict(anew.counts) | {
                name: roadmap.counts[name] for name in ("generators", "voronoi_vertices")
            }


def test_which_of_equally_long_ends_stays_hangs_on_no_rounding() -> None:
    """A square room is left with one of its four diagonals: not with whichever came first."""
    clipped = planner.build_roadmap(scene_of(bounds=Bounds(0.0, 0.0, 100.0, 100.0)), 9.0).clipped
    chains, kept = clipped.chains, set()
    for seed in range(20):
        rng = np.random.default_rng(seed)
        order, number = rng.permutation(len(chains)), rng.permutation(len(chains.node_xy))
        back = np.argsort(number)
        other = replace(
            chains,
            ends=number[chains.ends[order]],
            length=chains.length[order] * (1.0 + 1e-12 * rng.normal(size=len(chains))),
            node_xy=chains.node_xy[back],
            node_rho=chains.node_rho[back],
        )
        (left,) = without_spurs(Clipped(other, clipped.wide[order]), 9.0)
        places = np.round(other.node_xy[other.ends[left]], 6).tolist()
        kept.add(tuple(tuple(place) for place in sorted(places)))
    assert len(kept) == 1


def test_the_centre_of_an_arc_inside_another_object_is_no_place_to_stand() -> None:
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n#@ object 0\n"
        "C (157.94,66.83) 43.16\n#@ object 1\n"
        "A 2 (157.1294,100.8238)(151.9287,72.0626)\n#@ arc 1 152.556346 86.799889 14.750695 cw\n"
    )
    graph = planner.build_roadmap(scene, 13.77).graph
    inside = [n for n, d in graph.nodes(data=True) if math.dist(d["pos"], (157.94, 66.83)) < 43]
    assert inside == []


ASTRAY = {
    "crescent in a corner": (
        10.9,
        "P (76.608,20.370)\n#@ object 1\n"
        "L 4 (-8.478,13.324)(-26.687,90.717)(-25.400,90.245)(-7.536,14.320)\n"
        "#@ arc 1 41.197543256 65.850300138 72.295824436 cw\n"
        "#@ arc 3 41.197543256 65.850300138 70.924371348 ccw\n",
    ),
}


@pytest.mark.parametrize("name", list(ASTRAY))
def test_no_part_of_the_graph_ends_in_a_gap_that_is_none(name: str) -> None:
    radius, text = ASTRAY[name]
    head = "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n#@ object 0\n"
    _judge(read_scene_text(head + text), radius)

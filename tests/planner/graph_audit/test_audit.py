"""Edges are measured exactly, and each kind of fault is found where it is and nowhere else."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import planner
from planner import RouteEdge, RouteGraph, RouteNode, Scene
from planner.borders.ground import Ground
from planner.formats.grid_maps import GridPose, map_scene
from planner.graph_audit.findings import KINDS
from planner.graph_audit.unknown_lengths import length_in_cells

HALL = Scene.from_polygons([[(4, 4), (6, 4), (6, 6), (4, 6)]], bounds=(0, 0, 10, 10))
"""A square pillar in the middle of a square room."""
RING = ((1, 2.0, 2.0), (2, 8.0, 2.0), (3, 8.0, 8.0), (4, 2.0, 8.0))


def ring(**changes: Any) -> RouteGraph:
    """Four nodes round the pillar, joined one after the other in both directions."""
    nodes = tuple(RouteNode(*row) for row in RING)
    edges = []
    for k, (a, b) in enumerate(((1, 2), (2, 3), (3, 4), (4, 1))):
        edges += [RouteEdge(10 + k, a, b), RouteEdge(20 + k, b, a)]
    return replace(RouteGraph(nodes, tuple(edges), "nav2"), **changes)


def with_edges(*edges: RouteEdge, nodes: tuple[RouteNode, ...] = ()) -> RouteGraph:
    graph = ring()
    return replace(graph, nodes=graph.nodes + nodes, edges=graph.edges + edges)


def kinds(found: planner.GraphAudit) -> list[tuple[str, str]]:
    return [(one.kind, one.name) for one in found.findings]


def test_a_sound_graph_has_no_finding():
    found = planner.audit(ring(), HALL, 0.5)
    assert found.findings == ()
    assert found.safe
    np.testing.assert_array_equal(found.clearances, 2.0)


# --- measures, against cells one by one ---------------------------------------------------------


def clip(a, b, low, high):
    """Part (0..1, 0..1) of the segment a b in a rectangle, by Liang and Barsky; None if outside."""
    t0, t1 = 0.0, 1.0
    for axis in range(2):
        d = b[axis] - a[axis]
        if d == 0.0:
            if not low[axis] <= a[axis] <= high[axis]:
                return None
            continue
        u, v = sorted(((low[axis] - a[axis]) / d, (high[axis] - a[axis]) / d))
        t0, t1 = max(t0, u), min(t1, v)
    return (t0, t1) if t0 <= t1 else None


def to_rectangle(p, low, high):
    return math.hypot(*(max(lo - v, 0.0, v - hi) for v, lo, hi in zip(p, low, high, strict=True)))


def to_segment(p, a, b):
    d = b - a
    t = np.clip((p - a) @ d / max(d @ d, 1e-300), 0.0, 1.0)
    return float(np.hypot(*(p - a - t * d)))


def brute(cells, a, b, walls=None):
    """Clearance of a segment to rectangles, and its length in them."""
    gap, inside = np.inf, 0.0
    for low, high in cells:
        part = clip(a, b, low, high)
        if part is not None:
            gap, inside = 0.0, inside + (part[1] - part[0]) * float(np.hypot(*(b - a)))
            continue
        corners = [np.array((x, y)) for x in (low[0], high[0]) for y in (low[1], high[1])]
        gap = min(gap, to_rectangle(a, low, high), to_rectangle(b, low, high))
        gap = min([gap, *(to_segment(c, a, b) for c in corners)])
    if walls is not None:
        gap = min(
            [gap, *(min(p[k] - walls[0][k], walls[1][k] - p[k]) for p in (a, b) for k in (0, 1))]
        )
    return gap, inside


def random_grid(seed: int):
    """A random map of 24 x 18 cells of 0.25 m, and its occupied and unknown cells as rectangles."""
    rng = np.random.default_rng(seed)
    kind = np.zeros((18, 24), np.int8)
    for _ in range(9):
        r, c = rng.integers(0, 17), rng.integers(0, 23)
        kind[r : r + rng.integers(1, 4), c : c + rng.integers(1, 4)] = rng.integers(1, 3)
    scene = map_scene(kind > 0, GridPose(0.25, -1.0, 2.0, 0.0), (), kind == 2)

    def rectangles(which):
        rows, columns = np.nonzero(which)
        low = np.stack([-1.0 + 0.25 * columns, 2.0 + 0.25 * (17 - rows)], axis=1)
        return list(zip(low, low + 0.25, strict=True))

    return rng, scene, rectangles(kind > 0), rectangles(kind == 2)


@pytest.mark.parametrize("seed", range(12))
def test_clearances_and_lengths_are_those_of_all_cells_one_by_one(seed):
    rng, scene, solid, unknown = random_grid(seed)
    walls = np.array((-1.0, 2.0)), np.array((5.0, 6.5))
    places = rng.uniform(walls[0], walls[1], (16, 2))
    nodes = tuple(RouteNode(k, *place) for k, place in enumerate(places.tolist()))
    edges = tuple(RouteEdge(100 + k, 2 * k, 2 * k + 1) for k in range(8))
    found = planner.audit(RouteGraph(nodes, edges, "nav2"), scene, 0.3)
    named = {(one.kind, one.name): one for one in found.findings}
    for k in range(8):
        a, b = places[2 * k], places[2 * k + 1]
        gap, inside = brute(solid, a, b, walls)
        _, unseen = brute(unknown, a, b)
        assert found.clearances[k] == pytest.approx(gap, abs=1e-9)
        name = str(100 + k)
        least = 1e-5 * math.dist(a, b)
        one = named.get(("edge_in_unknown", name))
        assert (one.value if one else 0.0) == pytest.approx(unseen, abs=least)
        one = named.get(("edge_in_obstacle", name))
        assert (one.value if one else 0.0) == pytest.approx(
            inside - unseen, abs=4e-3 * math.dist(a, b)
        )
        near = ("edge_near_obstacle", name) in named
        assert near == (gap < 0.3 and inside <= least)
        if near:
            assert named["edge_near_obstacle", name].value == pytest.approx(gap, abs=1e-9)
            x, y = named["edge_near_obstacle", name].at
            at = np.array((x, y))
            assert brute(solid, at, at, walls)[0] == pytest.approx(gap, abs=1e-9)
    for k, place in enumerate(places):
        gap, _ = brute(solid, place, place, walls)
        bad = {one.kind for one in found.findings if one.subject == "node" and one.name == str(k)}
        bad &= {"node_in_obstacle", "node_in_unknown", "node_near_obstacle"}
        assert bool(bad) == (gap < 0.3)


@pytest.mark.parametrize("yaw", [0.0, 0.4, math.pi / 2, -2.5])
def test_the_length_in_unknown_cells_turns_with_the_map(yaw):
    rng, scene, _, unknown = random_grid(5)
    cells = scene.unknown
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    x, y = turn @ (cells.x, cells.y)
    turned = replace(cells, x=float(x), y=float(y), yaw_rad=yaw)
    line = rng.uniform((-2, 1), (6, 8), (5, 2))
    wanted = sum(brute(unknown, a, b)[1] for a, b in pairwise(line))
    assert wanted > 0.1
    assert length_in_cells(turned, line @ turn.T) == pytest.approx(wanted, abs=1e-9)


def test_the_length_inside_round_borders_is_a_chord():
    scene = Scene.from_polygons(circles=[(5, 5, 2)], bounds=(0, 0, 10, 10))
    ground = Ground.of(scene, bounds=True)
    lines = [np.array([(1.0, 5.0 + h), (9.0, 5.0 + h)]) for h in (0.0, 1.0, -1.9, 1.999)]
    wanted = [2 * math.sqrt(4 - h * h) for h in (0.0, 1.0, 1.9, 1.999)]
    np.testing.assert_allclose(ground.lengths_inside(lines), wanted, atol=1e-5)
    wholly = [np.array([(4.5, 5.0), (5.5, 5.0)])]
    np.testing.assert_allclose(ground.lengths_inside(wholly), [1.0], atol=1e-9)
    np.testing.assert_array_equal(ground.clearances(wholly)[0], [0.0])


def test_a_keep_out_zone_is_judged_beside_the_map_and_its_bounds_are_none():
    zones = Scene.from_polygons([[(4, 1.8), (5, 1.8), (5, 3), (4, 3)]], bounds=(3, 1, 5, 3))
    found = planner.audit(ring(), HALL, 0.5, keepout=zones)
    assert kinds(found) == [("edge_in_keepout", "10"), ("edge_in_keepout", "20")]
    assert found.findings[0].value == pytest.approx(1.0)
    assert found.zone_clearances is not None
    assert found.zone_clearances[2] == 3.0
    empty = Scene.from_polygons([], bounds=(0, 0, 1, 1))
    assert planner.audit(ring(), HALL, 0.5, keepout=empty).safe
    near = planner.audit(ring(), HALL, 0.5, keepout=Scene.from_polygons(circles=[(5, 3, 0.6)]))
    assert kinds(near) == [("edge_near_keepout", "10"), ("edge_near_keepout", "20")]
    assert near.findings[0].value == pytest.approx(0.4)


def test_an_edge_without_length_is_judged_as_its_node():
    graph = with_edges(RouteEdge(5, 9, 9), nodes=(RouteNode(9, 5.0, 5.0),))
    found = planner.audit(graph, HALL, 0.5)
    assert {("node_in_obstacle", "9"), ("edge_without_length", "5")} <= set(kinds(found))
    assert not any(kind.startswith("edge_near") for kind, _ in kinds(found))


# --- each kind, planted in a sound graph --------------------------------------------------------


def far(number: int, x: float, y: float) -> RouteNode:
    return RouteNode(number, x, y)


PLANTED = [
    ((RouteEdge(5, 1, 3), RouteEdge(6, 3, 1)), (),
     {("edge_in_obstacle", "5"), ("edge_in_obstacle", "6")}),
    ((RouteEdge(5, 1, 9), RouteEdge(6, 9, 1)), (far(9, 0.25, 1.0),),
     {("edge_near_obstacle", "5"), ("edge_near_obstacle", "6"), ("node_near_obstacle", "9")}),
    ((RouteEdge(5, 1, 9), RouteEdge(6, 9, 1)), (far(9, -1.0, 2.0),),
     {("edge_off_map", "5"), ("edge_off_map", "6"), ("node_off_map", "9")}),
    ((), (far(9, 5.0, 5.0),), {("node_in_obstacle", "9"), ("node_alone", "9")}),
    ((RouteEdge(5, 1, 99),), (), {("edge_without_node", "5")}),
    ((), (far(1, 3.0, 2.0),), {("node_id_taken", "1"), ("node_alone", "1"),
                               ("edge_passes_node", "10")}),
    ((RouteEdge(10, 1, 9), RouteEdge(6, 9, 1)), (far(9, 1.0, 1.0),), {("edge_id_taken", "10")}),
    ((RouteEdge(5, 1, 2),), (), {("edge_doubled", "5")}),
    ((RouteEdge(5, 1, 1),), (), {("edge_without_length", "5")}),
    ((RouteEdge(5, 1, 9),), (far(9, 1.0, 1.0),), {("node_dead_end", "9"), ("graph_in_parts", "")}),
    ((RouteEdge(5, 9, 1),), (far(9, 1.0, 1.0),),
     {("node_unreachable", "9"), ("graph_in_parts", "")}),
    ((RouteEdge(5, 1, 8), RouteEdge(6, 8, 9), RouteEdge(7, 9, 8)),
     (far(8, 1.0, 1.0), far(9, 1.0, 3.0)),
     {("node_without_return", "8"), ("node_without_return", "9"), ("graph_in_parts", "")}),
    ((RouteEdge(5, 8, 9), RouteEdge(6, 9, 8)), (far(8, 5.0, 1.0), far(9, 5.0, 3.0)),
     {("edges_cross", "10"), ("node_unreachable", "8"), ("node_unreachable", "9"),
      ("graph_in_parts", "")}),
    ((RouteEdge(5, 9, 4), RouteEdge(6, 4, 9)), (far(9, 2.0, 2.0),), {("node_doubled", "9")}),
    ((RouteEdge(5, 1, 9, length=1.0), RouteEdge(6, 9, 1)), (far(9, 1.0, 1.0),),
     {("length_too_short", "5")}),
    ((RouteEdge(5, 1, 9, length=1.5), RouteEdge(6, 9, 1)), (far(9, 1.0, 1.0),),
     {("length_too_long", "5")}),
    ((RouteEdge(5, 1, 9, length=1.4142), RouteEdge(6, 9, 1)), (far(9, 1.0, 1.0),), set()),
    ((RouteEdge(5, 1, 9, line=((2.0, 2.0), (1.2, 1.0))), RouteEdge(6, 9, 1)), (far(9, 1.0, 1.0),),
     {("line_beside_node", "5")}),
    ((RouteEdge(5, 1, 9, line=((2.0, 2.0), (1.0, 2.0), (1.0, 1.0))), RouteEdge(6, 9, 1)),
     (far(9, 1.0, 1.0),), {("line_not_straight", "5")}),
    ((RouteEdge(5, 1, 9, fields={"vehicleTypeEdgeProperties": [{"trajectory": {"degree": 2}}]}),
      RouteEdge(6, 9, 1, fields={"vehicleTypeEdgeProperties": [{"vehicleTypeId": "v"}]})),
     (far(9, 1.0, 1.0),), {("edge_has_trajectory", "5")}),
]  # fmt: skip


@pytest.mark.parametrize(("edges", "nodes", "wanted"), PLANTED)
def test_what_is_planted_is_found_and_nothing_else(edges, nodes, wanted):
    found = planner.audit(with_edges(*edges, nodes=nodes), HALL, 0.5)
    assert set(kinds(found)) == wanted
    assert len(found.findings) == len(wanted)


def test_every_kind_is_planted_in_a_test():
    planted = {kind for _, _, wanted in PLANTED for kind, _ in wanted}
    elsewhere = {"edge_in_unknown", "node_in_unknown", "goal_unreachable", "graph_wrong_frame"}
    elsewhere |= {"edge_too_fast", "edge_without_passing", "turn_too_tight", "edge_bends_tightly"}
    zones = {kind for kind in KINDS if kind.endswith("keepout")}
    assert planted | elsewhere | zones == set(KINDS)


@pytest.mark.parametrize("seed", range(4))
def test_moving_and_turning_all_changes_no_finding(seed):
    rng = np.random.default_rng(seed)
    angle, shift = rng.uniform(0, math.tau), rng.uniform(-1000, 1000, 2)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    pillar = Scene.from_polygons([[(4, 4), (6, 4), (6, 6), (4, 6)]])
    corners = np.array([(4, 4), (6, 4), (6, 6), (4, 6)]) @ turn.T + shift
    for edges, nodes, _ in PLANTED:
        graph = with_edges(*edges, nodes=nodes)
        moved = []
        for node in graph.nodes:
            x, y = turn @ (node.x, node.y) + shift
            moved.append(replace(node, x=float(x), y=float(y)))
        lines = [
            tuple(
                (float(x), float(y)) for x, y in np.array(edge.line).reshape(-1, 2) @ turn.T + shift
            )
            for edge in graph.edges
        ]
        both = zip(graph.edges, lines, strict=True)
        other = replace(
            graph, nodes=tuple(moved), edges=tuple(replace(e, line=line) for e, line in both)
        )
        before = planner.audit(graph, pillar, 0.5)
        after = planner.audit(other, Scene.from_polygons([corners]), 0.5)
        # of two edges that cross the first is named, whichever way the map lies
        assert sorted(kinds(after)) == sorted(kinds(before))
        np.testing.assert_allclose(after.clearances, before.clearances, atol=1e-9)


def test_a_goal_is_reached_or_it_is_said_why_not():
    cell = Scene.from_polygons(
        [[(8, 8), (8, 10), (8.2, 10), (8.2, 8.2), (10, 8.2), (10, 8)]], bounds=(0, 0, 10, 10)
    )
    graph = replace(ring(), nodes=tuple(RouteNode(n, x * 0.8, y * 0.8) for n, x, y in RING))
    found = planner.audit(graph, cell, 0.3, goals=[(5.0, 5.0), (9.0, 9.0)])
    (one,) = found.findings
    assert (one.kind, one.subject, one.at) == ("goal_unreachable", "goal", (9.0, 9.0))
    assert found.safe
    assert "cannot be reached" in str(one)


def test_a_graph_whose_edges_bend_is_measured_along_its_lines():
    line = ((2.0, 2.0), (2.0, 8.0), (8.0, 8.0))
    nodes = (RouteNode("a", 2.0, 2.0), RouteNode("b", 8.0, 8.0))
    bent = RouteGraph(nodes, (RouteEdge(None, "b", "a", True, line),), "node-link")
    found = planner.audit(bent, HALL, 0.5)
    assert found.findings == ()
    assert found.clearances.tolist() == [2.0]
    straight = planner.audit(replace(bent, format="nav2"), HALL, 0.5)
    assert ("edge_in_obstacle", "b-a") in kinds(straight)


def test_our_own_roadmaps_are_sound():
    from planner.roadmap.roadmap_export import bent_graph, straight_graph

    roadmap = planner.build_roadmap(HALL, 0.5)
    assert planner.audit(straight_graph(roadmap), HALL, 0.5).findings == ()
    bent = planner.audit(bent_graph(roadmap), HALL, 0.5)
    assert bent.findings == ()


# --- degenerate input ---------------------------------------------------------------------------


def test_an_empty_graph_and_a_single_node_are_audited():
    assert planner.audit(RouteGraph(), HALL, 0.5).findings == ()
    one = planner.audit(RouteGraph((RouteNode(1, 2.0, 2.0),)), HALL, 0.5)
    assert kinds(one) == [("node_alone", "1")]
    nowhere = RouteGraph((), (RouteEdge(1, 2, 3),))
    assert kinds(planner.audit(nowhere, HALL, 0.5)) == [("edge_without_node", "1")] * 2


def test_large_coordinates_and_maps_without_obstacles_are_audited():
    wide = Scene.from_polygons([], bounds=(-1e12, -1e12, 1e12, 1e12))
    graph = ring(nodes=tuple(RouteNode(n, x * 1e11, y * 1e11) for n, x, y in RING))
    assert planner.audit(graph, wide, 0.5).safe
    apart = ring(nodes=tuple(RouteNode(n, x + 1e12, y) for n, x, y in RING))
    found = planner.audit(apart, HALL, 0.5)
    assert {one.kind for one in found.findings} >= {"node_off_map", "edge_off_map"}
    assert all(math.isfinite(one.value or 0.0) for one in found.findings)


def test_a_thousand_edges_between_the_same_nodes_are_one_line():
    edges = tuple(RouteEdge(100 + k, 1 + k % 2, 2 - k % 2) for k in range(1000))
    graph = RouteGraph(tuple(RouteNode(*row) for row in RING[:2]), edges, "nav2")
    found = planner.audit(graph, HALL, 0.5)
    assert [one.kind for one in found.findings] == ["edge_doubled"] * 998
    assert len({one.id for one in found.findings}) == 998


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"radius": 0.0}, "radius = 0.0: must be > 0 and finite"),
        ({"radius": math.nan}, "radius = nan: must be > 0"),
        ({"goals": [(1.0, math.inf)]}, r"goals\[0\] = \(1, inf\): must be finite"),
        ({"frame": "L7"}, "frame 'L7': the graph has no node in it: must be one of 'map'"),
    ],
)
def test_senseless_requests_are_refused(options, sentence):
    with pytest.raises(ValueError, match=sentence):
        planner.audit(ring(), HALL, **{"radius": 0.5, **options})


def test_of_several_frames_one_is_audited():
    graph = ring()
    upstairs = (RouteNode(9, 5.0, 5.0, "up"),)
    lift = RouteEdge(5, 1, 9)
    both = replace(graph, nodes=graph.nodes + upstairs, edges=(*graph.edges, lift))
    with pytest.raises(ValueError, match="the graph has the frames 'map', 'up': name the map's"):
        planner.audit(both, HALL, 0.5)
    assert planner.audit(both, HALL, 0.5, frame="map").findings == ()


def test_ids_of_findings_are_unique_and_stay():
    graph = with_edges(RouteEdge(5, 1, 3), RouteEdge(5, 3, 1), RouteEdge(6, 1, 3))
    first, again = (planner.audit(graph, HALL, 0.5) for _ in range(2))
    assert [one.id for one in first.findings] == [one.id for one in again.findings]
    assert len({one.id for one in first.findings}) == len(first.findings)

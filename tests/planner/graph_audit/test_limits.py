"""Speed limits, narrow stretches and tight turns: measured as by hand, and nowhere else."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import planner
from planner import RouteEdge, RouteGraph, RouteNode, Scene, SpeedLevel

OPEN = Scene.from_polygons([], bounds=(0, 0, 20, 20))
CORRIDOR = Scene.from_polygons(
    [
        [(4, 0), (10, 0), (10, 4.4), (4, 4.4)],
        [(4, 5.6), (10, 5.6), (10, 10), (4, 10)],
    ],
    bounds=(0, 0, 14, 10),
)
"""Two rooms joined by a corridor, 6 m long and 1.2 m wide."""


def graph(places, pairs, form="nav2", **more):
    nodes = tuple(RouteNode(k, float(x), float(y)) for k, (x, y) in enumerate(places))
    edges = tuple(RouteEdge(100 + k, a, b, **more) for k, (a, b) in enumerate(pairs))
    return RouteGraph(nodes, edges, form)


def of_kind(found, kind):
    return [one for one in found.findings if one.kind == kind]


# --- speed --------------------------------------------------------------------------------------


def test_an_edge_is_too_fast_for_the_length_that_it_runs_through_a_slower_area():
    area = Scene.from_polygons([[(3, 0), (8, 0), (8, 20), (3, 20)]], bounds=(0, 0, 20, 20))
    both = graph([(1, 1), (11, 1), (11, 5), (1, 5)], [(0, 1), (1, 0), (2, 3)], speed_percent=80.0)
    found = planner.audit(both, OPEN, 0.2, speed=[SpeedLevel(area, 50.0)])
    fast = of_kind(found, "edge_too_fast")
    assert [one.name for one in fast] == ["100", "101", "102"]
    assert [one.value for one in fast] == pytest.approx([5.0] * 3, abs=1e-4)
    assert fast[0].severity == "error"
    assert "through an area with a limit of 50 %: its own limit is 80 %" in str(fast[0])
    assert found.safe
    for limit in (80.0, 81.0):
        other = planner.audit(both, OPEN, 0.2, speed=[SpeedLevel(area, limit)])
        assert of_kind(other, "edge_too_fast") == []
    beside = replace(both, edges=(RouteEdge(5, 1, 2, speed_percent=80.0),))
    assert not of_kind(
        planner.audit(beside, OPEN, 0.2, speed=[SpeedLevel(area, 50.0)]), "edge_too_fast"
    )


def test_limits_in_different_units_are_compared_by_the_robots_largest_speed():
    area = Scene.from_polygons([[(3, 0), (8, 0), (8, 20), (3, 20)]])
    places, pairs = [(1, 1), (11, 1)], [(0, 1)]
    percent = graph(places, pairs, speed_percent=80.0)
    metres = graph(places, pairs, speed_m_s=0.8)
    for one, level in (
        (percent, SpeedLevel(area, None, 0.5)),
        (metres, SpeedLevel(area, 50.0)),
    ):
        found = [
            bool(of_kind(planner.audit(one, OPEN, 0.2, speed=[level], **more), "edge_too_fast"))
            for more in ({}, {"max_speed_m_s": 1.0}, {"max_speed_m_s": 0.6})
        ]
        # 80 % of 0.6 m/s is less than 0.5 m/s, and 0.8 m/s is all the more than half of 0.6
        assert found == [False, True, one is metres]
    without = graph(places, pairs)
    assert not of_kind(
        planner.audit(without, OPEN, 0.2, speed=[SpeedLevel(area, 50.0)]), "edge_too_fast"
    )
    with pytest.raises(ValueError, match=r"max_speed_m_s = 0\.0: must be > 0"):
        planner.audit(percent, OPEN, 0.2, max_speed_m_s=0.0)


# --- passing ------------------------------------------------------------------------------------


def test_a_corridor_is_one_stretch_over_its_nodes_and_as_long_as_it_is_narrow():
    places = [(2, 5), (6, 5), (8, 5), (12, 5)]
    pairs = [(0, 1), (1, 0), (1, 2), (2, 1), (2, 3), (3, 2)]
    both = graph(places, pairs)
    (one,) = of_kind(planner.audit(both, CORRIDOR, 0.4, passing=True), "edge_without_passing")
    # before the corner at (4, 5.6) two robots still need sqrt(0.8^2 - 0.6^2) m
    assert one.value == pytest.approx(6.0 + 2 * math.sqrt(0.8**2 - 0.6**2), abs=1e-3)
    assert (one.severity, one.limit) == ("warning", 0.8)
    assert "edges 100, 102, 104" in str(one)
    assert not of_kind(planner.audit(both, CORRIDOR, 0.3, passing=True), "edge_without_passing")
    assert not of_kind(planner.audit(both, CORRIDOR, 0.4), "edge_without_passing")
    one_way = replace(both, edges=both.edges[::2])
    assert not of_kind(planner.audit(one_way, CORRIDOR, 0.4, passing=True), "edge_without_passing")
    undirected = replace(
        one_way, format="node-link", edges=tuple(replace(e, both_ways=True) for e in one_way.edges)
    )
    (again,) = of_kind(planner.audit(undirected, CORRIDOR, 0.4, passing=True), one.kind)
    assert again.value == pytest.approx(one.value, abs=1e-6)


def test_a_wide_middle_divides_a_stretch_and_a_zone_narrows_like_a_wall():
    pillars = Scene.from_polygons(
        circles=[(5, 6, 0.5), (5, 4, 0.5), (10, 6, 0.5), (10, 4, 0.5)], bounds=(0, 0, 15, 10)
    )
    both = graph([(1, 5), (14, 5)], [(0, 1), (1, 0)])
    found = of_kind(planner.audit(both, pillars, 0.4, passing=True), "edge_without_passing")
    half = math.sqrt(1.3**2 - 1.0)  # centres within 0.5 + 0.8 of the line's points
    assert [one.value for one in found] == pytest.approx([2 * half] * 2, abs=1e-4)
    empty = Scene.from_polygons([], bounds=(0, 0, 15, 10))
    zones = replace(pillars, bounds_given=False)
    again = of_kind(
        planner.audit(both, empty, 0.4, keepout=zones, passing=True), "edge_without_passing"
    )
    assert [one.value for one in again] == pytest.approx([2 * half] * 2, abs=1e-4)


@pytest.mark.parametrize("seed", range(4))
def test_parts_below_a_clearance_are_those_of_dense_samples(seed):
    from planner.borders.ground import Ground

    rng = np.random.default_rng(seed)
    circles = np.c_[rng.uniform(0, 10, (12, 2)), rng.uniform(0.2, 0.9, 12)].tolist()
    ground = Ground.of(Scene.from_polygons(circles=circles, bounds=(0, 0, 10, 10)), bounds=True)
    lines = [rng.uniform(0, 10, (int(rng.integers(2, 5)), 2)) for _ in range(9)]
    level = 0.4
    owner, begin, end = ground.parts_below(lines, level)
    for k, line in enumerate(lines):
        steps = np.hypot(*np.diff(line, axis=0).T)
        total = steps.sum()
        along = np.linspace(0.0, total, 4001)
        piece = np.minimum(np.searchsorted(np.cumsum(steps), along), len(steps) - 1)
        before = np.concatenate([[0.0], np.cumsum(steps)])[piece]
        part = ((along - before) / steps[piece])[:, None]
        points = line[piece] + part * (line[piece + 1] - line[piece])
        x, y = points.T
        gap = np.min([x, y, 10 - x, 10 - y], axis=0)
        for cx, cy, r in circles:
            gap = np.minimum(gap, np.hypot(x - cx, y - cy) - r)
        own = owner == k
        inside = ((along[:, None] >= begin[own]) & (along[:, None] <= end[own])).any(axis=1)
        # a part shorter than a thousandth of a piece may be missed
        assert (inside != (gap < level)).mean() < 0.003


# --- turns --------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [20.0, 60.0, 90.0, 140.0])
def test_a_turn_is_too_tight_where_no_arc_fits_on_the_shorter_edge(angle):
    turned = math.radians(angle)
    places = [(8, 10), (10, 10), (10 + 3 * math.cos(turned), 10 + 3 * math.sin(turned))]
    both = graph(places, [(0, 1), (1, 2)])
    widest = 2.0 / math.tan(0.5 * turned)
    fits = planner.audit(both, OPEN, 0.2, turning_radius=0.999 * widest)
    assert not of_kind(fits, "turn_too_tight")
    (one,) = of_kind(
        planner.audit(both, OPEN, 0.2, turning_radius=1.001 * widest), "turn_too_tight"
    )
    assert one.value == pytest.approx(widest)
    assert (one.name, one.severity, one.subject) == ("1", "error", "node")
    assert "from edge 100 to edge 101" in str(one)


def test_an_arc_that_cuts_into_an_obstacle_is_too_tight_and_direction_counts():
    inner = Scene.from_polygons(
        [[(0, 10.5), (9.5, 10.5), (9.5, 20), (0, 20)]], bounds=(0, 0, 20, 20)
    )
    ways = graph([(2, 10), (10, 10), (10, 18)], [(0, 1), (1, 2)])
    # the arc comes (sqrt(2) - 1) R closer to the corner, which is 0.5 sqrt(2) away
    limit = (0.5 * math.sqrt(2) - 0.3) / (math.sqrt(2) - 1)
    assert not of_kind(
        planner.audit(ways, inner, 0.3, turning_radius=limit - 0.02), "turn_too_tight"
    )
    assert of_kind(planner.audit(ways, inner, 0.3, turning_radius=limit + 0.02), "turn_too_tight")
    apart = replace(ways, edges=(RouteEdge(1, 0, 1), RouteEdge(2, 2, 1)))  # no robot turns
    assert not of_kind(planner.audit(apart, inner, 0.3, turning_radius=3.0), "turn_too_tight")


def test_turning_back_counts_only_where_there_is_no_other_edge():
    line = graph([(2, 10), (10, 10), (18, 10)], [(0, 1), (1, 0), (1, 2), (2, 1)])
    found = of_kind(planner.audit(line, OPEN, 0.2, turning_radius=0.5), "turn_too_tight")
    assert [one.name for one in found] == ["0", "2"]
    assert not of_kind(planner.audit(line, OPEN, 0.2), "turn_too_tight")


@pytest.mark.parametrize("count", [7, 40])
def test_a_polyline_along_a_circle_has_bends_of_its_radius(count):
    turns = np.linspace(0.0, 0.5 * math.pi, count)
    line = [(2.0, 4.0), *((9 + 6 * math.sin(t), 10 - 6 * math.cos(t)) for t in turns), (15.0, 18.0)]
    nodes = (RouteNode("a", *line[0]), RouteNode("b", *line[-1]))
    bent = RouteGraph(nodes, (RouteEdge("e", "a", "b", True, tuple(line)),), "node-link")
    # pieces of the polygon's length take the tangents of both ends
    chord = 12 * math.sin(0.25 * math.pi / (count - 1))
    radius = chord / (2 * math.tan(0.25 * math.pi / (count - 1)))
    fits = planner.audit(bent, OPEN, 0.2, turning_radius=0.99 * radius)
    assert not of_kind(fits, "edge_bends_tightly")
    found = of_kind(
        planner.audit(bent, OPEN, 0.2, turning_radius=1.02 * radius), "edge_bends_tightly"
    )
    assert len(found) == count - 2
    assert found[0].value == pytest.approx(radius, rel=1e-6)
    assert "must be" in str(found[0])


def test_senseless_radii_are_refused():
    for wrong in (-1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match=r"turning_radius = \S+: must be >= 0 and finite"):
            planner.audit(RouteGraph(), OPEN, 0.2, turning_radius=wrong)

"""The preference for clearance finds the widest way: no wider robot makes the journey."""

from __future__ import annotations

import math

import numpy as np
import pytest

from planner.formats.scene_io import read_scene_text
from planner.path import NoPath, Path
from planner.roadmap.roadmap import build_roadmap
from tests.support.scenes.planner_scenes import random_scene, slow_distance

WALL_AND_POST = read_scene_text(
    "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n"
    "S (110,1) (182,90)\nP (166,149)\n"
)


@pytest.mark.parametrize("radius", [8.1, 20.0, 30.0, 33.0])
def test_a_station_beside_the_narrowest_place_of_its_chain_leaves_by_the_wide_side(radius):
    """The start itself, 33.5 from the post, is the narrowest place; the gap beside is 30.6."""
    path = build_roadmap(WALL_AND_POST, radius).plan((160, 116), (216, 211), prefer="clearance")
    assert isinstance(path, Path)
    assert path.min_clearance == pytest.approx(np.hypot(6.0, 33.0), abs=1e-9)


@pytest.mark.parametrize("seed", range(30))
def test_no_wider_robot_makes_the_journey_than_along_the_widest_way(seed):
    rng = np.random.default_rng(seed + 9000)
    scene = random_scene(rng)
    b = scene.bounds
    places = rng.uniform([b.x_min, b.y_min], [b.x_max, b.y_max], (200, 2))
    places = places[slow_distance(scene, places) >= 3.0][:4]
    roadmap = build_roadmap(scene, 3.0)
    for start, goal in (places[:2], places[2:]):
        widest = roadmap.plan(start, goal, prefer="clearance")
        if isinstance(widest, NoPath):
            continue
        wider = build_roadmap(scene, widest.min_clearance * 1.01)
        assert isinstance(wider.plan(start, goal, prefer="clearance"), NoPath)


@pytest.mark.parametrize("radius", [3.0, 5.0, 8.0])
@pytest.mark.parametrize("gap", [0.0, 1e-6, 1e-3, 0.1])
def test_a_way_around_inside_an_arc_ends_behind_where_it_began(gap, radius):
    """A wall stands before the end of a C: the bisector of the two runs all around in the C.

    The turns at its ends lie back to back, and were taken for two that sampling had swapped.
    """
    first, last = 0.6, math.tau - gap / 60.0
    ends = [(200.0 + 60.0 * math.cos(a), 150.0 + 60.0 * math.sin(a)) for a in (first, last)]
    (ax, ay), (bx, by) = ends
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n"
        f"#@ object 0\nA 2 ({ax!r},{ay!r})({bx!r},{by!r})\n#@ arc 1 200.0 150.0 60.0 cw\n"
        "#@ object 1\nS (260.0,150.0) (250.0,152.0)\n"
    )
    path = build_roadmap(scene, radius).plan((20, 20), (200, 150), prefer="clearance")
    assert isinstance(path, Path)
    # in the mouth, from the wall's tip to the C's other end
    assert path.min_clearance == pytest.approx(0.5 * np.hypot(ax - 250.0, ay - 152.0), rel=1e-5)

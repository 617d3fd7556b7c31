"""Refusals: the widest robot against a slow search, the place, the units, the time."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
import pytest

import planner
from planner.formats.scene_io import read_scene_text
from planner.path import NoPath, Path
from planner.roadmap.roadmap import DENSER_BY
from planner.scene import Bounds, Scene, SegmentRecord
from tests.support.oracles.visibility_oracle import shortest_length
from tests.support.scenes.planner_scenes import (
    box,
    hand_made,
    random_scene,
    scene_of,
    slow_distance,
)

NEAR = 2e-3


def _refusals(seed: int) -> tuple[Scene, float, tuple, tuple, NoPath] | None:
    """A random scene, and two places a big robot can stand but not travel between."""
    rng = np.random.default_rng(seed)
    scene, radius = random_scene(rng), float(rng.uniform(4.0, 14.0))
    b = scene.bounds
    places = rng.uniform([b.x_min, b.y_min], [b.x_max, b.y_max], (300, 2))
    places = places[slow_distance(scene, places) >= radius][:12]
    roadmap = planner.build_roadmap(scene, radius)
    for i in range(0, len(places) - 1, 2):
        start, goal = tuple(places[i].tolist()), tuple(places[i + 1].tolist())
        answer = roadmap.plan(start, goal)
        if isinstance(answer, NoPath) and "inside" not in answer.reason:
            return scene, radius, start, goal, answer
    return None


@pytest.mark.parametrize("seed", range(20))
def test_widest_robot_fits_and_a_wider_one_does_not_by_a_slow_search(seed: int) -> None:
    found = _refusals(seed + 4000)
    if found is None:
        return
    scene, radius, start, goal, answer = found
    assert shortest_length(scene, radius, start, goal) == math.inf
    if answer.widest_radius is None:
        least = 0.5 * radius / DENSER_BY
        assert shortest_length(scene, 1.01 * least, start, goal) == math.inf
        return
    widest = answer.widest_radius
    assert shortest_length(scene, widest * (1.0 - NEAR), start, goal) < math.inf
    assert shortest_length(scene, widest * (1.0 + NEAR), start, goal) == math.inf
    at = np.array([[answer.bottleneck.x, answer.bottleneck.y]])
    assert slow_distance(scene, at)[0] == pytest.approx(0.5 * answer.bottleneck.width, rel=NEAR)
    assert answer.bottleneck.width == pytest.approx(2.0 * widest)


def test_a_gap_far_narrower_than_the_spacing_is_found_all_the_same() -> None:
    scene = scene_of(box(60, -20, 70, 50), box(60, 55, 70, 140))
    answer = planner.build_roadmap(scene, 9.0).plan((30, 52), (100, 52))
    assert answer.widest_radius == pytest.approx(2.5, rel=NEAR)


def test_a_crack_that_no_robot_is_told_of_is_not_called_a_wall() -> None:
    """One wall ends 0.112 before another: less than what the generators tell from nothing."""
    scene = scene_of(
        SegmentRecord((118.28939931719505, 104.03623547572262), (160.9, 106.3)),
        SegmentRecord((135.98377362930526, 96.98863429096563), (73.37365939694864, 121.5)),
    )
    answer = planner.build_roadmap(scene, 4.2647610137002925).plan(
        (129.7658674154851, 113.02401820757375), (34.407603159698084, 8.47242326641766)
    )
    assert isinstance(answer, NoPath)
    assert answer.widest_radius is None
    told = float(answer.reason.rsplit("no gap wider than ", 1)[1].split()[0])
    tip, a, b = (
        np.array(p)
        for p in (
            scene.objects[0].records[0].start,
            scene.objects[1].records[0].start,
            scene.objects[1].records[0].end,
        )
    )
    (ux, uy), (vx, vy) = b - a, tip - a
    across = abs(ux * vy - uy * vx) / math.hypot(ux, uy)
    assert across == pytest.approx(0.1121, abs=1e-4)
    assert told > across


def test_a_margin_counts_against_the_widest_robot() -> None:
    answer = planner.build_roadmap(hand_made()["wall with a door"], 8.0).plan(
        (20, 60), (140, 60), margin=2.0
    )
    assert answer.bottleneck.width == pytest.approx(18.0, rel=1e-6)
    assert answer.widest_radius == pytest.approx(7.0, rel=1e-6)


@pytest.mark.parametrize("units", ["px", "m", "cells"])
def test_every_length_of_a_reason_has_its_units(units: str) -> None:
    door = replace(hand_made()["wall with a door"], units=units)
    narrow = planner.build_roadmap(door, 12.0).plan((20, 60), (140, 60))
    assert f"is 24 {units} wide throughout" in narrow.reason
    assert f"the widest is 18 {units} wide at (80, 59)" in narrow.reason
    near = planner.build_roadmap(door, 12.0).plan((75, 60), (140, 60))
    assert f" {units} from obstacle" in near.reason
    assert near.reason.endswith(f"12 {units}")
    wall = replace(hand_made()["wall to wall"], units=units)
    walled = planner.build_roadmap(wall, 12.0).plan((20, 60), (140, 60))
    assert walled.reason.endswith(f"no gap wider than 3 {units}")


def test_of_several_legs_the_one_that_cannot_be_is_named() -> None:
    answer = planner.build_roadmap(hand_made()["wall with a door"], 12.0).plan(
        (20, 60), (20, 100), via=[(30, 20), (140, 20)]
    )
    assert answer.reason.startswith("no path from station 1 (30, 20) to station 2 (140, 20)")


def test_a_refusal_takes_no_longer_than_a_denser_roadmap() -> None:
    rng = np.random.default_rng(1)
    bounds = Bounds(0.0, 0.0, 2000.0, 1000.0)
    boxes = [box(x, y, x + 20, y + 20) for x, y in rng.uniform(30, 950, (150, 2))]
    scene = scene_of(*boxes, box(990, -10, 1010, 500), box(990, 501, 1010, 1010), bounds=bounds)
    roadmap = planner.build_roadmap(scene, 9.0)
    assert isinstance(roadmap.plan((15, 500), (15, 510)), Path)
    began_s = time.process_time()
    planner.build_roadmap(scene, 9.0, spacing=9.0 / DENSER_BY)
    build_s = time.process_time() - began_s
    began_s = time.process_time()
    answer = roadmap.plan((15, 500), (1500, 500))
    took_s = time.process_time() - began_s
    assert isinstance(answer, NoPath)
    # the second opinion is bounded by a count that takes about 0.2 s
    assert took_s <= 2.0 * build_s + 1.0


@pytest.mark.parametrize("margin", [0.0, 0.7])
@pytest.mark.parametrize("via", [(), ((200.0, 291.0),)])
def test_a_station_too_near_a_border_leaves_the_widest_robot_told(via, margin):
    """A smaller robot stands there and makes the journey; one a little wider does not."""
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\nC (200,150) 40\n"
    )
    stations = {"start": (9.9, 150.0), "goal": (350.0, 150.0), "via": via, "margin": margin}
    no = planner.build_roadmap(scene, 10.0).plan(**stations)
    assert isinstance(no, NoPath)
    assert "the start (9.9, 150)" in no.reason or "station 1 (200, 291)" in no.reason
    least = 9.0 if via else 9.9
    assert no.widest_radius == pytest.approx(least - margin, abs=1e-9)
    assert no.bottleneck is not None
    assert no.bottleneck.width == pytest.approx(2.0 * least, abs=1e-9)
    assert isinstance(
        planner.build_roadmap(scene, no.widest_radius * (1 - 1e-9)).plan(**stations), Path
    )
    assert isinstance(
        planner.build_roadmap(scene, no.widest_radius * 1.001).plan(**stations), NoPath
    )


def test_no_robot_is_told_where_another_station_lies_in_an_obstacle():
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\nC (200,150) 40\n"
    )
    no = planner.build_roadmap(scene, 10.0).plan((9.9, 150.0), (200.0, 160.0))
    assert isinstance(no, NoPath)
    assert "inside obstacle 0" in no.reason
    assert no.widest_radius is None


def test_the_widest_robot_is_not_judged_by_the_far_side_of_the_link_it_leaves_by():
    """Past a wall's end before the right bound: its distance from there is 35.2 px."""
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ units px\n#@ bounds given 0 0 400 300\n"
        "L 5 (218.7,115.4)(201,121.1)(190.5,127.7)(183.7,104.8)(220.1,28.1)\n"
        "S (216.3,55.7) (364.8,85)\n"
        "L 8 (291.2,244)(244.9,211.5)(266,181.5)(274.9,187.8)(260.1,208.8)(288.6,228.8)"
        "(303.4,207.8)(312.3,214.1)\n"
    )
    for radius in (17.65, 18.0, 18.5, 19.0, 20.0):
        no = planner.build_roadmap(scene, radius).plan((294.66, 176.73), (331.78, 39.24))
        assert isinstance(no, NoPath)
        assert no.widest_radius == pytest.approx(17.6, abs=1e-6)


def test_a_stay_at_a_place_too_near_a_border_leaves_the_widest_robot_told() -> None:
    scene = scene_of(SegmentRecord((80.0, -0.5), (80.0, 40.0)))
    answer = planner.build_roadmap(scene, 20.2).plan((60, 20), (60, 20))
    assert isinstance(answer, NoPath)
    assert answer.widest_radius == pytest.approx(20.0)
    assert answer.bottleneck.width == pytest.approx(40.0)

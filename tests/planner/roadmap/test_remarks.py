"""Objects that touch, cross, nest or coincide are accepted, and it is said that they do."""

from __future__ import annotations

import math

import pytest

import planner
from planner.scene import Arc, CircleRecord, PointRecord, PolygonRecord, Segment, SegmentRecord
from tests.support.scenes.planner_scenes import bay, box, hand_made, scene_of, stadium, with_hole

EXPECTED = {
    "touching boxes": ("obstacles 0 and 1 touch or cross",),
    "boxes that share a corner": ("obstacles 0 and 1 touch or cross",),
    "crossing boxes": ("obstacles 0 and 1 touch or cross",),
    "nested boxes": ("obstacle 1 lies inside obstacle 0",),
    "coincident boxes": ("obstacles 0 and 1 coincide",),
    "crossing segments": ("obstacles 0 and 1 touch or cross",),
    "wall to wall": ("obstacle 0 touches or crosses the bounds",),
    "lattice of boxes": (),
    "lattice of points": (),
    "concentric circles": (),
    "U": (),
    "box out of bounds": (
        "obstacle 0 touches or crosses the bounds",
        "obstacle 1 touches or crosses the bounds",
    ),
    "empty": ("the scene has no objects: the roadmap is that of the empty bounds",),
}


@pytest.mark.parametrize("name", list(EXPECTED))
def test_what_meets_in_a_scene_is_remarked(name: str) -> None:
    assert planner.build_roadmap(hand_made()[name], 1.5).remarks == EXPECTED[name]


def test_round_borders_that_touch_cross_or_nest_are_told_apart() -> None:
    ring = with_hole(CircleRecord((40.0, 60.0), 30.0), CircleRecord((40.0, 60.0), 24.0))
    scene = scene_of(
        ring,
        CircleRecord((40.0, 60.0), 5.0),
        CircleRecord((80.0, 60.0), 10.0),
        CircleRecord((100.0, 60.0), 15.0),
        stadium(135, 145, 60, 10),
        stadium(138, 142, 60, 4),
    )
    assert planner.build_roadmap(scene, 1.5).remarks == (
        "obstacles 0 and 2 touch or cross",
        "obstacles 2 and 3 touch or cross",
        "obstacle 5 lies inside obstacle 4",
    )


def test_what_stands_in_a_bay_is_not_inside_it() -> None:
    scene = scene_of(bay(70, 60, 35, 0.9, 6), PointRecord((70.0, 60.0)))
    assert planner.build_roadmap(scene, 1.5).remarks == ()


def test_objects_beyond_the_bounds_are_remarked() -> None:
    scene = scene_of(box(200, 10, 220, 30), SegmentRecord((20.0, 20.0), (40.0, 40.0)))
    assert planner.build_roadmap(scene, 1.5).remarks == ("obstacle 0 lies outside the bounds",)


def test_an_empty_roadmap_is_remarked_with_the_width_that_was_asked_for() -> None:
    remarks = planner.build_roadmap(hand_made()["one box"], 60.0).remarks
    assert remarks == ("the roadmap is empty: no passage is 120 px wide",)


def test_many_remarks_are_counted() -> None:
    scene = scene_of(*(box(10, 10, 40, 40) for _ in range(6)))
    remarks = planner.build_roadmap(scene, 1.5).remarks
    assert len(remarks) == 9
    assert remarks[-1] == "and 7 more pairs of obstacles that meet or nest"


def test_a_flat_arc_inside_the_bounds_does_not_reach_them_with_the_rest_of_its_circle() -> None:
    lid = Arc((40.0, 60.0), (80.0, 60.0), (60.0, 160.0), math.hypot(20.0, 100.0), ccw=False)
    floor = Segment((80.0, 60.0), (40.0, 60.0))
    scene = scene_of(PolygonRecord((lid, floor)))
    assert scene.bounds.y_max < 160.0
    assert planner.build_roadmap(scene, 1.5).remarks == ()

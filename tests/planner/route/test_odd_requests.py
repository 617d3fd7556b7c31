"""What nobody should ask the planner, and what it answers: one clear sentence."""

from __future__ import annotations

import math

import numpy as np
import pytest

import planner
from planner.scene import SegmentRecord
from tests.support.scenes.planner_scenes import box, scene_of

ARENA = scene_of(box(60, 40, 100, 80))
HALVED = scene_of(SegmentRecord((80.0, -0.5), (80.0, 119.5)))
"""Two halves with a wall between."""


@pytest.fixture(scope="module")
def roadmap() -> planner.Roadmap:
    return planner.build_roadmap(ARENA, 4.0)


@pytest.mark.parametrize("wanted", [math.inf, math.nan, 10**400, -1, 0.5, "two", None])
def test_alternatives_are_a_whole_number(roadmap: planner.Roadmap, wanted: object) -> None:
    with pytest.raises(ValueError, match=r"alternatives = .*: must be a whole number >= 0"):
        roadmap.plan((20, 20), (140, 100), alternatives=wanted)  # type: ignore[arg-type]


@pytest.mark.parametrize("wanted", [1_000_001, 1e308])
def test_more_alternatives_than_can_be_are_refused(roadmap: planner.Roadmap, wanted: int) -> None:
    with pytest.raises(ValueError, match="must be at most 1000000"):
        roadmap.plan((20, 60), (140, 60), alternatives=wanted)


def test_more_alternatives_than_there_are_are_those_there_are(roadmap: planner.Roadmap) -> None:
    path = roadmap.plan((20, 60), (140, 60), alternatives=1_000_000)
    few = roadmap.plan((20, 60), (140, 60), alternatives=50)
    assert isinstance(path, planner.Path)
    assert isinstance(few, planner.Path)
    assert len(path.alternatives) == len(few.alternatives) >= 1


@pytest.mark.parametrize("huge", [10**400, -(10**400)])
def test_numbers_beyond_all_floats_are_refused(roadmap: planner.Roadmap, huge: int) -> None:
    for ask in (
        lambda: roadmap.plan((huge, 20), (140, 100)),
        lambda: roadmap.plan((20, 20), (140, 100), margin=huge),
        lambda: roadmap.plan((20, 20), (140, 100), prefer=huge),
        lambda: planner.build_roadmap(ARENA, huge),
        lambda: planner.build_roadmap(ARENA, 4.0, spacing=huge),
    ):
        with pytest.raises(ValueError, match="must be"):
            ask()


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_the_clearance_of_no_place_is_refused(roadmap: planner.Roadmap, bad: float) -> None:
    for ask in (roadmap.clearance, roadmap.path_clearance):
        with pytest.raises(ValueError, match="must be finite"):
            ask(np.array([(20.0, 20.0), (bad, 30.0)]))


def test_a_refusal_is_no_way_to_stay_on(roadmap: planner.Roadmap) -> None:
    refused = roadmap.plan((80, 60), (140, 100))
    assert isinstance(refused, planner.NoPath)
    path = roadmap.plan((20, 20), (140, 100), near=refused)
    assert isinstance(path, planner.Path)
    plain = roadmap.plan((20, 20), (140, 100))
    assert isinstance(plain, planner.Path)
    assert np.array_equal(path.points, plain.points)


@pytest.mark.parametrize("order", ["fixed", "best"])
def test_the_station_that_is_out_of_reach_is_named(order: str) -> None:
    halved = planner.build_roadmap(HALVED, 4.0)
    vias = [(60, 30), (140, 60), (30, 90)]
    told = halved.plan((20, 20), (40, 100), via=vias, order=order)  # type: ignore[arg-type]
    assert isinstance(told, planner.NoPath)
    assert "station 2 (140, 60)" in told.reason
    told = halved.plan((20, 20), (120, 100), via=[(60, 30), (30, 90)], order=order)  # type: ignore[arg-type]
    assert isinstance(told, planner.NoPath)
    assert "the goal (120, 100)" in told.reason
    # of two stations both are known by name
    told = halved.plan((20, 20), (120, 100))
    assert isinstance(told, planner.NoPath)
    assert told.reason.startswith("no path from (20, 20) to (120, 100)")

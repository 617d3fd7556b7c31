"""Where everything touches, crosses or lies on one line: paths are as wide as they say."""

from __future__ import annotations

import numpy as np
import pytest

import planner
from planner.path import NoPath, Path
from planner.scene import Bounds
from tests.support.scenes.grid_scenes import Tally, judge
from tests.support.scenes.planner_scenes import polygon, scene_of


@pytest.mark.parametrize("first", range(0, 200, 25))
def test_no_path_is_nearer_than_it_says_or_leads_out_of_a_solid(first: int) -> None:
    tally = Tally()
    for seed in range(first, first + 25):
        judge(seed, tally)
    assert (tally.exceptions, tally.below, tally.wrong, tally.in_solid) == ([], [], [], [])
    assert tally.paths > 20


def test_both_lobes_of_a_bow_tie_are_solid() -> None:
    """They have no area together, and a robot was let stand in them."""
    tie = polygon([(2.0, 2.0), (6.0, 6.0), (6.0, 2.0), (2.0, 6.0)])
    roadmap = planner.build_roadmap(scene_of(tie, bounds=Bounds(0.0, 0.0, 8.0, 8.0)), 0.2)
    for lobe in ((2.75, 4.0), (5.25, 4.0)):
        assert roadmap.clearance([lobe])[0] < 0.0
        answer = roadmap.plan(lobe, (4.0, 7.0))
        assert isinstance(answer, NoPath)
        assert "lies inside obstacle 0" in answer.reason
    assert isinstance(roadmap.plan((4.0, 1.0), (4.0, 7.0)), Path)


def test_the_search_for_other_paths_ends_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    boxes = [
        polygon([(x, y), (x + 0.5, y), (x + 0.5, y + 0.5), (x, y + 0.5)])
        for x, y in rng.uniform(0.5, 7.0, (30, 2)).tolist()
    ]
    roadmap = planner.build_roadmap(scene_of(*boxes, bounds=Bounds(0.0, 0.0, 8.0, 8.0)), 0.05)
    places = rng.uniform(0.1, 7.9, (200, 2))
    start, *_, goal = places[roadmap.clearance(places) > 0.06]
    plain = roadmap.plan(start, goal, alternatives=40)
    monkeypatch.setattr("planner.route.route.WORK", 2_000)
    bounded = roadmap.plan(start, goal, alternatives=40)
    assert isinstance(plain, Path)
    assert isinstance(bounded, Path)
    assert plain.remarks == ()
    assert len(plain.alternatives) == 40
    assert any("reached its limit" in remark for remark in bounded.remarks)
    assert len(bounded.alternatives) < 40
    np.testing.assert_array_equal(plain.points, bounded.points)

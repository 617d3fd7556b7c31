"""Tasks for robots: the best of all permutations, over paths that there are."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from planner import assign_tasks, build_roadmap
from planner.motion.trajectory import default_limits
from planner.scene import Bounds
from planner.zones.areas import CircleArea
from planner.zones.zone import Zone
from tests.support.scenes.planner_scenes import box, scene_of

WALL = scene_of(box(0.9, 0.0, 1.1, 1.6), bounds=Bounds(0, 0, 2, 2))
SPLIT = scene_of(box(0.9, 0.0, 1.1, 2.0), bounds=Bounds(0, 0, 2, 2))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("objective", ["sum", "last"])
def test_no_permutation_is_better(seed: int, objective: str) -> None:
    rng = np.random.default_rng(seed)
    robots = rng.uniform((0.15, 0.15), (0.75, 1.85), (int(rng.integers(1, 5)), 2))
    tasks = rng.uniform((1.25, 0.15), (1.85, 1.85), (int(rng.integers(1, 5)), 2))
    found = assign_tasks(build_roadmap(WALL, radius=0.1), robots, tasks, objective=objective)
    times = found.durations_s
    few = min(len(robots), len(tasks))
    every = [
        [times[i, j] for i, j in zip(who, which, strict=True)]
        for who in itertools.combinations(range(len(robots)), few)
        for which in itertools.permutations(range(len(tasks)), few)
    ]
    worth = sum if objective == "sum" else max
    taken = [times[i, j] for i, j in enumerate(found.tasks) if j is not None]
    assert len(taken) == few
    assert worth(taken) == pytest.approx(min(map(worth, every)))
    assert found.total_s == pytest.approx(sum(taken))
    assert found.last_s == max(taken)
    assert sorted([*found.left_over, *(j for j in found.tasks if j is not None)]) == list(
        range(len(tasks))
    )


def test_the_time_is_that_of_the_path_around_the_wall_not_of_the_straight_line() -> None:
    # as the crow flies the first robot is nearer to the task
    robots, tasks = [(0.75, 0.2), (0.5, 1.8)], [(1.25, 0.6)]
    found = assign_tasks(build_roadmap(WALL, radius=0.1), robots, tasks)
    assert math.dist(robots[0], tasks[0]) < math.dist(robots[1], tasks[0])
    assert found.tasks == (None, 0)


def test_a_task_behind_a_wall_is_left_over() -> None:
    found = assign_tasks(
        build_roadmap(SPLIT, radius=0.1), [(0.3, 0.3), (0.3, 1.0)], [(0.5, 1.5), (1.5, 1.5)]
    )
    assert found.tasks in ((0, None), (None, 0))
    assert found.left_over == (1,)
    assert np.isinf(found.durations_s[:, 1]).all()


def test_a_robot_may_keep_its_place_where_a_zone_forbids_goals() -> None:
    """A plan of the fleet allows it too."""
    wait = Zone("desk", "wait", CircleArea((0.3, 0.3), 0.1))
    found = assign_tasks(
        build_roadmap(WALL, radius=0.1), [(0.5, 1.8), (0.3, 0.3)], [(0.3, 0.3)], zones=[[wait]] * 2
    )
    assert found.durations_s[1, 0] == 0.0
    assert np.isinf(found.durations_s[0, 0])
    assert found.tasks == (None, 0)


def test_a_slow_robot_gets_the_near_task_for_the_last_arrival() -> None:
    limits = [default_limits(0.1), default_limits(0.05)]
    found = assign_tasks(
        build_roadmap(scene_of(bounds=Bounds(0, 0, 4, 2)), radius=0.1),
        [(0.5, 1.0), (0.5, 0.5)], [(1.0, 0.5), (3.5, 1.0)], limits=limits, objective="last",
    )  # fmt: skip
    assert found.tasks == (1, 0)


def test_nobody_and_nothing() -> None:
    roadmap = build_roadmap(WALL, radius=0.1)
    assert assign_tasks(roadmap, [], [(0.5, 0.5)]).left_over == (0,)
    assert assign_tasks(roadmap, [(0.5, 0.5)], []).tasks == (None,)
    with pytest.raises(ValueError, match="objective"):
        assign_tasks(roadmap, [], [], objective="first")  # type: ignore[arg-type]

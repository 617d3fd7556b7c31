"""New goals while others drive: promises are kept, and nobody touches anybody across the change."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planner import FleetSchedule, NoFleetPlan, build_roadmap
from planner.fleet.execution import releases
from planner.scene import Bounds
from planner.zones.areas import CircleArea
from planner.zones.zone import Zone
from tests.planner.fleet.test_on_roadmap import random_task
from tests.support.oracles.fleet_judge import least_gap
from tests.support.scenes.planner_scenes import box, scene_of

ALCOVE = scene_of(
    box(0, 0, 3, 0.35), box(0, 0.65, 1.3, 1), box(1.7, 0.65, 3, 1), bounds=Bounds(0, 0, 3, 1)
)


class Driven:
    """Robots driven by releases alone, each piece as long as chance will, across new schedules."""

    def __init__(self, schedule: FleetSchedule, rng: np.random.Generator) -> None:
        self.rng, self.now_s = rng, 0.0
        self.schedule = schedule
        count = len(schedule.plan.tracks)
        self.passed, self.sent = [0] * count, [0] * count
        self.driving = [False] * count
        self.rows = [[(0.0, *track[0, 1:])] for track in schedule.plan.tracks]

    def drive(self, steps: int) -> bool:
        """So many beginnings and ends of pieces; whether anybody could still move."""
        for _ in range(steps):
            allowed = releases(self.schedule.plan, self.passed)
            can = [i for i, r in enumerate(allowed) if self.driving[i] or r.row > self.passed[i]]
            if not can:
                self.send()
                return False
            i = int(self.rng.choice(can))
            self.now_s += float(self.rng.uniform(0.1, 3.0))
            place = self.schedule.plan.tracks[i][self.passed[i] + self.driving[i], 1:]
            self.rows[i].append((self.now_s, *place))
            self.passed[i] += self.driving[i]
            self.driving[i] = not self.driving[i]
        self.send()
        return True

    def send(self) -> None:
        """Give each robot waypoints ahead, as many as chance will."""
        for i, release in enumerate(releases(self.schedule.plan, self.passed)):
            least = max(self.sent[i], self.passed[i] + self.driving[i])
            self.sent[i] = int(self.rng.integers(least, max(release.row, least) + 1))

    def take(self, new: FleetSchedule) -> None:
        """The new schedule from here on; what was sent must be the same in it."""
        for i, (old, track) in enumerate(
            zip(self.schedule.plan.tracks, new.plan.tracks, strict=True)
        ):
            sent = without_stands(old[self.passed[i] : self.sent[i] + 1, 1:])
            before = without_stands(old[self.passed[i] : self.passed[i] + 2, 1:])
            assert sent == without_stands(track[: new.sent[i] + 1, 1:])
            if i not in new.changed:
                assert without_stands(old[self.passed[i] :, 1:]) == without_stands(track[:, 1:])
            begun = 0
            if self.driving[i] and len(before) == 1:
                # it stands: of that a new schedule knows nothing
                self.driving[i] = False
            if self.driving[i]:
                target = old[self.passed[i] + 1, 1:].tolist()
                while track[begun + 1, 1:].tolist() != target:
                    begun += 1
            self.passed[i], self.sent[i] = begun, max(new.sent[i], begun + self.driving[i])
        self.schedule = new


def without_stands(rows: Any) -> list[list[float]]:
    """Places, each once where the track stands."""
    kept: list[list[float]] = []
    for place in rows.tolist():
        if not kept or kept[-1] != place:
            kept.append(place)
    return kept


@pytest.mark.parametrize("seed", range(14))
def test_goals_at_any_time_keep_all_promises_and_all_apart(seed: int) -> None:
    roadmap, _, starts, goals, radii, rng = random_task(seed)
    driven = Driven(FleetSchedule.parked(roadmap, starts, radii), rng)
    at = [tuple(start) for start in starts]
    asked = [*enumerate(goals), *enumerate(starts)]
    for robot, goal in asked:
        new = driven.schedule.with_goals({robot: goal}, driven.passed, driven.sent)
        if isinstance(new, NoFleetPlan):
            # the place where another is to park is the only reason in these arenas
            assert "their goals are" in new.reason
            continue
        at[robot] = tuple(goal)
        driven.take(new)
        driven.drive(int(rng.integers(0, 30)))
    while driven.drive(1):
        pass
    for rows, place in zip(driven.rows, at, strict=True):
        assert rows[-1][1:] == pytest.approx(place, abs=1e-6)
    assert least_gap([np.array(rows) for rows in driven.rows], radii) >= -1e-7


def test_a_parked_robot_steps_aside_into_the_niche_and_comes_back() -> None:
    roadmap = build_roadmap(ALCOVE, radius=0.1)
    schedule = FleetSchedule.parked(roadmap, [(0.3, 0.5), (1.5, 0.5)])
    new = schedule.with_goals({0: (2.7, 0.5)})
    assert isinstance(new, FleetSchedule), new
    assert new.changed == (0, 1)
    assert new.plan.tracks[1][:, 2].max() > 0.6
    assert new.plan.tracks[1][-1, 1:].tolist() == [1.5, 0.5]
    assert least_gap(new.plan.tracks, new.radii) >= -1e-7


def test_a_robot_out_of_the_way_stays() -> None:
    roadmap = build_roadmap(ALCOVE, radius=0.1)
    schedule = FleetSchedule.parked(roadmap, [(0.3, 0.5), (1.5, 0.86)])
    new = schedule.with_goals({0: (2.7, 0.5)})
    assert isinstance(new, FleetSchedule)
    assert new.changed == (0,)
    assert len(new.plan.tracks[1]) == 1


def test_a_robot_parked_in_a_zone_hinders_no_plan_of_others_that_step_aside() -> None:
    scene = scene_of(
        box(0, 0, 3, 0.35), box(0, 0.65, 1.3, 1), box(1.7, 0.65, 3, 1), bounds=Bounds(0, 0, 4, 1)
    )
    desk = Zone("desk", "keep_out", CircleArea((3.7, 0.2), 0.1))
    places = [(0.3, 0.5), (1.5, 0.5), (3.7, 0.2)]
    schedule = FleetSchedule.parked(build_roadmap(scene, radius=0.1), places, zones=[[desk]] * 3)
    new = schedule.with_goals({0: (2.7, 0.5)})
    assert isinstance(new, FleetSchedule), new
    assert new.changed == (0, 1)


def test_a_goal_where_another_parks_is_refused_with_both_names() -> None:
    roadmap = build_roadmap(ALCOVE, radius=0.1)
    schedule = FleetSchedule.parked(roadmap, [(0.3, 0.5), (1.5, 0.5)])
    refused = schedule.with_goals({0: (1.6, 0.5)})
    assert isinstance(refused, NoFleetPlan)
    assert refused.blocking == (0, 1)
    assert "0.1 apart" in refused.reason


def test_two_that_stand_on_each_others_goals_have_a_plan_together_and_none_alone() -> None:
    roadmap = build_roadmap(ALCOVE, radius=0.1)
    schedule = FleetSchedule.parked(roadmap, [(0.3, 0.5), (2.7, 0.5)])
    for robot, goal in ((0, (2.7, 0.5)), (1, (0.3, 0.5))):
        assert isinstance(schedule.with_goals({robot: goal}), NoFleetPlan)
    new = schedule.with_goals({0: (2.7, 0.5), 1: (0.3, 0.5)})
    assert isinstance(new, FleetSchedule), new
    assert [track[-1, 1:].tolist() for track in new.plan.tracks] == [[2.7, 0.5], [0.3, 0.5]]
    assert least_gap(new.plan.tracks, new.radii) >= -1e-7


def test_goals_that_others_drive_across_are_added_at_once_and_keep_what_was_sent() -> None:
    roadmap = build_roadmap(ALCOVE, radius=0.1)
    schedule = FleetSchedule.parked(roadmap, [(0.3, 0.5), (2.7, 0.5), (1.5, 0.86)])
    first = schedule.with_goals({2: (1.0, 0.5)})
    assert isinstance(first, FleetSchedule)
    sent = [0, 0, len(first.plan.tracks[2]) - 1]
    new = first.with_goals({0: (2.7, 0.5), 1: (0.3, 0.5)}, sent=sent)
    assert isinstance(new, FleetSchedule), new
    kept = new.plan.tracks[2][: new.sent[2] + 1, 1:]
    assert kept[-1].tolist() == [1.0, 0.5]
    assert all(row >= new.sent[waiting] for _, _, waiting, row in new.plan.dependencies)
    assert least_gap(new.plan.tracks, new.radii) >= -1e-7


def test_a_goal_in_a_wall_names_the_robot() -> None:
    schedule = FleetSchedule.parked(build_roadmap(ALCOVE, radius=0.1), [(0.3, 0.5)])
    refused = schedule.with_goals({0: (1.0, 0.2)})
    assert isinstance(refused, NoFleetPlan)
    assert refused.blocking == (0,)


def test_who_was_not_allowed_to_drive_cannot_have_been_sent() -> None:
    roadmap = build_roadmap(ALCOVE, radius=0.1)
    schedule = FleetSchedule.parked(roadmap, [(0.3, 0.5), (2.7, 0.5)])
    new = schedule.with_goals({0: (1.5, 0.86)})
    assert isinstance(new, FleetSchedule)
    new = new.with_goals({1: (0.3, 0.5)})
    assert isinstance(new, FleetSchedule)
    last = [len(track) - 1 for track in new.plan.tracks]
    with pytest.raises(ValueError, match="sent"):
        new.with_goals({0: (2.0, 0.5)}, [0, 0], last)
    with pytest.raises(ValueError, match="robot = 2"):
        new.with_goals({2: (2.0, 0.5)})


@pytest.mark.parametrize(
    ("places", "said"),
    [([], "a robot"), ([(0.3, 0.5), (0.4, 0.5)], "0.1 apart"), ([(1.0, 0.3)], "clearance")],
)
def test_robots_that_cannot_stand_there_are_named(places: Any, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        FleetSchedule.parked(build_roadmap(ALCOVE, radius=0.1), places)

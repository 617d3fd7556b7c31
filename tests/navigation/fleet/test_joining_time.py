"""Driving robots get no more waypoints while others' goals are planned: that has to be short."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import planner
from navigation.fleet.joining import LEAST_SHARE_S, TIME_LIMIT_S, join_promises
from navigation.fleet.planning import plan_promises
from navigation.fleet.request import Driving, FleetAnswer, FleetRequest, Traveller
from navigation.mission.mission import Station
from planner.fleet.fleet_plan import NoFleetPlan
from planner.fleet.schedule import FleetSchedule
from planner.motion.trajectory import default_limits
from tests.navigation.fleet.test_fleet_promises import KEEP_M, RADIUS_M, scene_of, travellers

EMPTY = scene_of("#@ clearway.scene/1\n#@ units m\nC (1.9,1.5) 0.02\n")


class HardGoals:
    """A clock, and searches for new goals that each take all their time and find nothing."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 0.0
        self.limits_s: list[float] = []

        def search(_: FleetSchedule, goals: dict[int, Any], **how: Any) -> NoFleetPlan:
            self.limits_s.append(how["time_limit_s"])
            self.now_s += how["time_limit_s"]
            return NoFleetPlan("no plan was found", tuple(goals) * 2, proved=False)

        monkeypatch.setattr(FleetSchedule, "with_goals", search)

    def __call__(self) -> float:
        return self.now_s


def join(clock: Any, count: int) -> FleetAnswer:
    roadmap = planner.build_roadmap(EMPTY, RADIUS_M)
    drives = Traveller("a", (0.2, 0.8, 0.0), Station(1.8, 0.8), RADIUS_M, default_limits(RADIUS_M))
    before = plan_promises(roadmap, EMPTY, FleetRequest(1, 1, (drives,)), KEEP_M)
    x = np.linspace(0.3, 1.7, count)
    asking = travellers(np.column_stack([x, 0 * x + 0.2]), np.column_stack([x, 0 * x + 1.4]))
    driving = (Driving(before.promises["a"], 1, 3, drives.limits),)
    return join_promises(roadmap, EMPTY, FleetRequest(2, 1, asking, driving=driving), KEEP_M, clock)


@pytest.mark.parametrize("count", [1, 2, 6])
def test_all_goals_together_have_the_time_of_one(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = HardGoals(monkeypatch)
    answer = join(clock, count)
    assert answer.refused.keys() == {f"r{k}" for k in range(count)}
    assert len(clock.limits_s) == count + (count > 1)
    assert clock.now_s <= 1.2 * TIME_LIMIT_S
    assert max(clock.limits_s) <= 1.01 * min(clock.limits_s), "each has its share"


def test_time_that_others_did_not_need_is_the_next_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, find = HardGoals(monkeypatch), FleetSchedule.with_goals

    def search(schedule: FleetSchedule, goals: dict[int, Any], **how: Any) -> NoFleetPlan:
        begun_s = clock.now_s
        found = find(schedule, goals, **how)
        clock.now_s = begun_s + (0.001 if len(clock.limits_s) < 3 else clock.limits_s[-1])
        assert isinstance(found, NoFleetPlan)
        return found

    monkeypatch.setattr(FleetSchedule, "with_goals", search)
    join(clock, 3)
    assert clock.limits_s[2] > 1.9 * clock.limits_s[0]
    assert clock.now_s <= 1.2 * TIME_LIMIT_S


def test_each_goal_has_some_time_however_late_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = HardGoals(monkeypatch)
    find = FleetSchedule.with_goals

    def search(schedule: FleetSchedule, goals: dict[int, Any], **how: Any) -> Any:
        found = find(schedule, goals, **how)
        clock.now_s += TIME_LIMIT_S
        return found

    monkeypatch.setattr(FleetSchedule, "with_goals", search)
    join(clock, 3)
    assert clock.limits_s[1:] == [LEAST_SHARE_S] * 3

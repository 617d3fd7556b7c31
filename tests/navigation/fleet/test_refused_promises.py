"""A refusal names the robots that it depends on, and no others."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

import planner
from navigation.fleet.joining import join_promises
from navigation.fleet.planning import Attempt, in_the_way, plan_promises
from navigation.fleet.refusals import because_of
from navigation.fleet.request import Driving, FleetRequest, Taken, Traveller
from navigation.mission.mission import Station
from planner.motion.trajectory import default_limits
from planner.zones.areas import PolygonArea
from planner.zones.zone import Zone
from tests.navigation.fleet.test_fleet_promises import KEEP_M, RADIUS_M, scene_of, travellers

DESK = Zone("desk", "keep_out", PolygonArea(((0.1, 1.2), (0.5, 1.2), (0.5, 1.5), (0.1, 1.5))))
GATE = scene_of(
    "#@ clearway.scene/1\n#@ units m\n"
    "L 4 (0.90,0.00) (0.90,0.70) (1.10,0.70) (1.10,0.00)\n"
    "L 4 (0.90,1.00) (0.90,1.60) (1.10,1.60) (1.10,1.00)\n"
)
"""A wall with a gap of 0.3 m in its middle."""
IN_THE_GATE = Taken("lost", 1.0, 0.85, RADIUS_M)
FAR = Taken("far", 1.8, 0.2, RADIUS_M)


def bound_for(goal: tuple[float, float]) -> tuple[Traveller, ...]:
    """One traveller, from the left to this goal, around the desk."""
    (one,) = travellers(np.array([(0.3, 0.3)]), np.array([goal]))
    return (replace(one, zones=(DESK,)),)


def parked(x_m: float, y_m: float) -> Traveller:
    station = Station(x_m, y_m, 0.0)
    return Traveller("idle", (x_m, y_m, 0.0), station, RADIUS_M, default_limits(RADIUS_M))


@pytest.mark.parametrize("taken", [(), (FAR,), (IN_THE_GATE, FAR)])
@pytest.mark.parametrize("idle", [(), (parked(1.8, 1.4),)])
def test_a_goal_in_a_zone_is_refused_for_the_zone_whoever_is_around(
    taken: tuple[Taken, ...], idle: tuple[Traveller, ...]
) -> None:
    roadmap = planner.build_roadmap(GATE, RADIUS_M)
    request = FleetRequest(1, 1, bound_for((0.3, 1.35)), taken, idle=idle)
    assert plan_promises(roadmap, GATE, request, KEEP_M).refused == {
        "r0": "r0: no path even alone: the goal (0.3, 1.35) is in keep-out zone 'desk'"
    }


def test_of_the_robots_around_only_the_one_in_the_only_gap_is_named() -> None:
    roadmap = planner.build_roadmap(GATE, RADIUS_M)
    request = FleetRequest(1, 1, bound_for((1.7, 0.9)), (FAR, IN_THE_GATE))
    why = plan_promises(roadmap, GATE, request, KEEP_M).refused["r0"]
    assert why.startswith("r0: no path even alone: no path from (0.3, 0.3) to (1.7, 0.9) is ")
    assert why.endswith(", because lost is in the way")


@pytest.mark.parametrize(("pace_s", "said"), [(0.0, ", because lost is in the way"), (0.1, "")])
def test_a_cause_that_takes_too_long_to_find_is_not_named(pace_s: float, said: str) -> None:
    roadmap, ticks = planner.build_roadmap(GATE, RADIUS_M), itertools.count()
    attempt = Attempt(
        roadmap, GATE, bound_for((1.7, 0.9)), (FAR, IN_THE_GATE), KEEP_M,
        clock=lambda: pace_s * next(ticks),
    )  # fmt: skip
    assert in_the_way(attempt) == said


def test_two_that_cannot_pass_each_other_are_named_without_one_far_away() -> None:
    scene = scene_of(
        "#@ clearway.scene/1\n#@ units m\n"
        "L 4 (0.00,0.00) (0.00,0.70) (2.00,0.70) (2.00,0.00)\n"
        "L 4 (0.00,0.90) (0.00,1.20) (2.00,1.20) (2.00,0.90)\n"
    )
    ends = np.array([(0.2, 0.8), (1.8, 0.8)])
    request = FleetRequest(1, 1, travellers(ends, ends[::-1]), (Taken("far", 1.0, 1.4, RADIUS_M),))
    refused = plan_promises(planner.build_roadmap(scene, RADIUS_M), scene, request, KEEP_M).refused
    assert refused["r1"].startswith("r0 and r1: ")
    assert not any("far" in why for why in refused.values())


@pytest.mark.parametrize(
    ("goal", "end"), [((0.3, 1.35), "zone 'desk'"), ((1.4, 0.9), "because lost is in the way")]
)
def test_while_others_drive_a_refusal_names_the_same_robots(
    goal: tuple[float, float], end: str
) -> None:
    roadmap = planner.build_roadmap(GATE, RADIUS_M)
    a = Traveller("a", (1.8, 1.4, 0.0), Station(1.8, 0.9), RADIUS_M, default_limits(RADIUS_M))
    before = plan_promises(roadmap, GATE, FleetRequest(1, 1, (a,)), KEEP_M)
    drives = Driving(before.promises["a"], 1, 3, a.limits)
    request = FleetRequest(2, 1, bound_for(goal), (FAR, IN_THE_GATE), driving=(drives,))
    answer = join_promises(roadmap, GATE, request, KEEP_M)
    assert answer.cannot == ""
    assert answer.refused.keys() == {"r0"}
    assert answer.refused["r0"].endswith(end)


def test_robots_that_block_only_together_are_named_together() -> None:
    def is_refused(left: list[str]) -> bool:
        return {"a", "c"} <= set(left)

    assert because_of(["a", "b", "c", "a", "d"], is_refused) == ", because a and c are in the way"
    assert because_of(["a", "b"], is_refused) == ""
    assert because_of([], lambda left: pytest.fail(f"asked for {left}")) == ""

"""Several robots among obstacles: no contact with each other or a wall, whoever they are."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from planner import FleetPlan, NoFleetPlan, build_roadmap, plan_fleet
from planner.fleet.ground.zone_edges import usable_edges
from planner.fleet.schedule import FleetSchedule
from planner.motion.trajectory import default_limits
from planner.roadmap.roadmap import Roadmap
from planner.scene import Bounds, CircleRecord, Scene, SceneObject
from planner.zones.areas import BandArea, CircleArea
from planner.zones.rules import rules_for
from planner.zones.zone import Zone
from planner.zones.zone_ground import ZoneGround
from tests.support.oracles.fleet_judge import delayed, least_gap
from tests.support.scenes.planner_scenes import box, scene_of, slow_distance

CORRIDOR = scene_of(box(0, 0, 3, 0.35), box(0, 0.65, 3, 1), bounds=Bounds(0, 0, 3, 1))
ALCOVE = scene_of(
    box(0, 0, 3, 0.35), box(0, 0.65, 1.3, 1), box(1.7, 0.65, 3, 1), bounds=Bounds(0, 0, 3, 1)
)
ENDS = [(0.2, 0.5), (2.8, 0.5)]


def judge(plan: Any, scene: Scene, starts: Any, goals: Any, radii: Any, speeds: Any) -> FleetPlan:
    """Starts, goals, speeds, other robots and walls, without the planner's own checks."""
    assert isinstance(plan, FleetPlan), plan
    for track, start, goal, radius, speed in zip(
        plan.tracks, starts, goals, radii, speeds, strict=True
    ):
        assert not track.flags.writeable
        assert track[0].tolist() == pytest.approx([0.0, start[0], start[1]], abs=1e-6)
        assert track[-1, 1:].tolist() == pytest.approx([goal[0], goal[1]], abs=1e-6)
        for (t, x, y), (u, v, w) in itertools.pairwise(track.tolist()):
            assert u >= t
            assert math.hypot(v - x, w - y) <= speed * (u - t) * (1.0 + 1e-6) + 1e-9
        dense = [
            a + share * (b - a)
            for a, b in itertools.pairwise(track[:, 1:])
            for share in (0.0, 0.25, 0.5, 1.0)
        ]
        places = np.array(dense or [track[0, 1:]])
        b = scene.bounds
        inside = np.minimum(
            (places - (b.x_min, b.y_min)).min(axis=1), ((b.x_max, b.y_max) - places).min(axis=1)
        )
        assert inside.min() >= radius - 1e-6
        if scene.objects:
            assert slow_distance(scene, places).min() >= radius - 1e-6
    assert least_gap(plan.tracks, radii) >= -1e-7
    return plan


def random_task(seed: int) -> tuple[Any, ...]:
    rng = np.random.default_rng(seed)
    objects = tuple(
        SceneObject(i, (CircleRecord(tuple(rng.uniform((0.5, 0.5), (2.5, 1.5))),
                                     float(rng.uniform(0.05, 0.2))),))
        for i in range(rng.integers(0, 6))
    )  # fmt: skip
    scene = Scene("m", Bounds(0.0, 0.0, 3.0, 2.0), objects)
    count = int(rng.integers(2, 9))
    radii = [0.08] * count if seed % 2 else rng.uniform(0.05, 0.12, count).tolist()
    roadmap = build_roadmap(scene, radius=0.08)

    def drawn() -> list[tuple[float, float]]:
        found: list[tuple[float, float]] = []
        while len(found) < count:
            place = tuple(rng.uniform((0.0, 0.0), (3.0, 2.0)).tolist())
            size = radii[len(found)]
            apart = all(
                math.dist(place, p) > size + r + 0.01 for p, r in zip(found, radii, strict=False)
            )
            if apart and roadmap.clearance([place])[0] > 1.05 * size:
                found.append(place)
        return found

    return roadmap, scene, drawn(), drawn(), radii, rng


@pytest.mark.parametrize("seed", range(12))
def test_robots_cross_random_arenas_without_a_contact(seed: int) -> None:
    roadmap, scene, starts, goals, radii, rng = random_task(seed)
    plan = plan_fleet(roadmap, starts, goals, radii)
    judge(plan, scene, starts, goals, radii, [2.0 * r for r in radii])
    if not plan.remarks:
        driven = delayed(plan.tracks, plan.dependencies, rng, 5.0)
        assert least_gap(driven, radii) >= -1e-7


def test_two_meet_in_a_corridor_with_one_niche() -> None:
    roadmap = build_roadmap(ALCOVE, radius=0.1)
    plan = plan_fleet(roadmap, ENDS, ENDS[::-1])
    judge(plan, ALCOVE, ENDS, ENDS[::-1], [0.1, 0.1], [0.2, 0.2])
    assert max(track[:, 2].max() for track in plan.tracks) > 0.6


def test_two_cannot_pass_in_a_corridor_without_one() -> None:
    """In a short one: the work to prove it grows with the square of the length."""
    corridor = scene_of(box(0, 0, 1.6, 0.35), box(0, 0.65, 1.6, 1), bounds=Bounds(0, 0, 1.6, 1))
    ends = [(0.2, 0.5), (1.4, 0.5)]
    plan = plan_fleet(build_roadmap(corridor, radius=0.1), ends, ends[::-1], time_limit_s=120.0)
    assert isinstance(plan, NoFleetPlan)
    assert plan.proved
    assert plan.blocking == (0, 1)


CROSSING = scene_of(
    box(-1.2, -1.2, -0.12, -0.12), box(0.12, -1.2, 1.2, -0.12), box(-1.2, 0.12, -0.12, 1.2),
    box(0.12, 0.12, 1.2, 1.2), bounds=Bounds(-1.2, -1.2, 1.2, 1.2),
)  # fmt: skip
QUEUED = [(a * d, b * d) for a, b in ((1, 0), (0, 1), (-1, 0), (0, -1)) for d in (1.08, 0.86)]


@pytest.mark.parametrize("order", ["straight on", "turned around", "any"])
def test_eight_robots_pass_a_crossing_as_wide_as_one(order: str) -> None:
    goals = {
        "straight on": [QUEUED[(k + 4) % 8] for k in range(8)],
        "turned around": [QUEUED[((k + 4) % 8) ^ 1] for k in range(8)],
        "any": [QUEUED[k] for k in np.random.default_rng(1).permutation(8)],
    }[order]
    plan = plan_fleet(build_roadmap(CROSSING, radius=0.1), QUEUED, goals, time_limit_s=120.0)
    judge(plan, CROSSING, QUEUED, goals, [0.1] * 8, [0.2] * 8)
    assert plan.remarks == ()
    driven = delayed(plan.tracks, plan.dependencies, np.random.default_rng(0), 5.0)
    assert least_gap(driven, [0.1] * 8) >= -1e-7


def test_a_goal_in_a_wall_names_its_robot_and_why() -> None:
    plan = plan_fleet(build_roadmap(CORRIDOR, radius=0.1), ENDS, [(0.6, 0.5), (2.0, 0.1)])
    assert isinstance(plan, NoFleetPlan)
    assert plan.blocking == (1,)
    assert "alone" in plan.reason


def test_a_goal_in_a_keep_out_zone_names_the_robot_the_goal_and_the_zone() -> None:
    desk = Zone("desk", "keep_out", CircleArea((2.0, 0.5), 0.1))
    zones = [[desk]] * 3
    starts, goals = [*ENDS, (1.5, 0.5)], [ENDS[0], (2.0, 0.5), (1.5, 0.5)]
    plan = plan_fleet(build_roadmap(CORRIDOR, radius=0.1), starts, goals, zones=zones)
    assert isinstance(plan, NoFleetPlan)
    assert plan.blocking == (1,)
    assert plan.reason == (
        "robot 1: no path even alone: the goal (2, 0.5) is in keep-out zone 'desk'"
    )


def test_a_robot_that_is_to_stay_where_a_zone_forbids_goals_hinders_only_those_it_blocks() -> None:
    for kind in ("keep_out", "wait"):
        around = Zone("drawn later", kind, CircleArea((1.5, 0.86), 0.1))
        roadmap, starts = build_roadmap(ALCOVE, radius=0.1), [(0.3, 0.5), (1.5, 0.86)]
        goals, zones = [(2.7, 0.5), (1.5, 0.86)], [[], [around]]
        plan = plan_fleet(roadmap, starts, goals, zones=zones)
        judge(plan, ALCOVE, starts, goals, [0.1, 0.1], [0.2, 0.2])
        assert len(plan.tracks[1]) == 1


def test_starts_that_overlap_are_refused_with_distance_and_need() -> None:
    plan = plan_fleet(
        build_roadmap(CORRIDOR, radius=0.1), [(0.5, 0.5), (0.62, 0.5)], ENDS, [0.1, 0.05]
    )
    assert isinstance(plan, NoFleetPlan)
    assert plan.blocking == (0, 1)
    assert "0.12 apart" in plan.reason
    assert "0.15" in plan.reason


def test_a_larger_robot_takes_no_way_that_is_too_narrow() -> None:
    # a wall with a narrow gap below and a wide one above
    scene = scene_of(box(0.95, 0.3, 1.05, 1.2), bounds=Bounds(0, 0, 2, 2))
    starts, goals, radii = [(0.4, 0.5), (0.4, 1.0)], [(1.6, 0.5), (1.6, 1.0)], [0.1, 0.25]
    plan = plan_fleet(build_roadmap(scene, radius=0.1), starts, goals, radii)
    judge(plan, scene, starts, goals, radii, [0.2, 0.5])


def test_speeds_are_each_robots_own() -> None:
    scene = scene_of(bounds=Bounds(0, 0, 2, 2))
    roadmap = build_roadmap(scene, radius=0.1)
    starts, goals = [(0.3, 0.5), (0.3, 1.5)], [(1.7, 0.5), (1.7, 1.5)]
    limits = [replace(default_limits(0.1), speed=speed) for speed in (0.1, 0.5)]
    plan = judge(
        plan_fleet(roadmap, starts, goals, limits=limits), scene, starts, goals,
        [0.1, 0.1], [0.1, 0.5],
    )  # fmt: skip
    assert plan.arrivals_s[0] >= 14.0 - 1e-6
    assert plan.arrivals_s[1] < 4.0


def test_no_robots_and_headings_and_input_types() -> None:
    roadmap = build_roadmap(ALCOVE, radius=0.1)
    assert plan_fleet(roadmap, [], []).tracks == ()
    starts, goals = np.array([[0.2, 0.5, 1.0]]), np.array([[2.8, 0.5, 0.0]])
    starts.setflags(write=False)
    one = plan_fleet(roadmap, starts, goals, radii=0.1)
    other = plan_fleet(roadmap, [(0.2, 0.5)], [[2.8, 0.5]])
    assert one.tracks[0].tolist() == other.tracks[0].tolist()


def test_an_edge_through_a_one_way_zone_that_is_thinner_than_a_step_is_used_in_its_direction() -> (
    None
):
    thin = Zone("thin", "one_way", BandArea(((0.42, 0.7), (0.02, 0.3)), 0.02))
    places = np.array([(0.0, 0.5), (0.44, 0.5)])
    edges = np.array([(0, 1), (1, 0)])
    usable = usable_edges(places, edges, rules_for([thin], CORRIDOR, 0.1), places)
    assert usable.tolist() == [False, True]


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"starts": [(0.0, float("nan"))]}, "starts"),
        ({"goals": [(1.0,)]}, "goals"),
        ({"goals": []}, "goals"),
        ({"radii": [0.1, 0.1]}, "radii"),
        ({"radii": 0.0}, "radii"),
        ({"limits": []}, "limits"),
        ({"limits": [replace(default_limits(0.1), speed=0.0)]}, "limits"),
    ],
)
def test_input_that_makes_no_sense_is_named(changed: dict[str, Any], said: str) -> None:
    roadmap = build_roadmap(CORRIDOR, radius=0.1)
    request = {"starts": ENDS[:1], "goals": ENDS[1:]}
    with pytest.raises(ValueError, match=said):
        plan_fleet(roadmap, **{**request, **changed})


class WorkClock:
    """Seconds by the work done: a path takes 20 ms, a place beside a piece of a line 50 ns."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 0.0
        plan, directions = Roadmap.plan, ZoneGround.directions

        def slow_plan(roadmap: Roadmap, *places: Any, **how: Any) -> Any:
            self.now_s += 0.02
            return plan(roadmap, *places, **how)

        def slow_directions(one: ZoneGround, points: Any) -> Any:
            assert isinstance(one.zone.area, BandArea)
            self.now_s += 5e-8 * len(points) * len(one.zone.area.line)
            return directions(one, points)

        monkeypatch.setattr(Roadmap, "plan", slow_plan)
        monkeypatch.setattr(ZoneGround, "directions", slow_directions)

    def __call__(self) -> float:
        return self.now_s


def winding(name: str, y: float) -> Zone:
    x = np.linspace(0.2, 2.8, 40)
    line = np.column_stack([x, y + 0.05 * np.sin(20.0 * x)])
    return Zone(name, "one_way", BandArea(tuple(map(tuple, line.tolist())), 0.1))


@pytest.mark.parametrize("share", [0.2, 0.6, 0.9])
def test_a_time_limit_is_kept_among_long_winding_zones(
    share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    roadmap = build_roadmap(Scene.from_polygons([], bounds=(0, 0, 3, 2)), radius=0.08)
    clock = WorkClock(monkeypatch)
    zones = [[winding("a", 0.8), winding("b", 1.2)]] * 2
    starts, goals = [(0.5, 0.2), (2.0, 0.2)], [(1.0, 1.8), (2.5, 1.8)]
    asked: dict[str, Any] = {"zones": zones, "clock": clock, "improve": 0}
    assert plan_fleet(roadmap, starts, goals, time_limit_s=1e6, **asked)
    limit_s = share * clock.now_s
    begun_s = clock.now_s
    plan = plan_fleet(roadmap, starts, goals, time_limit_s=limit_s, **asked)
    assert clock.now_s - begun_s <= 1.2 * limit_s
    assert isinstance(plan, NoFleetPlan)
    assert not plan.proved
    assert f"no plan was found within {limit_s:.3g} s" in plan.reason


def test_new_goals_keep_the_time_limit_among_long_winding_zones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    roadmap = build_roadmap(Scene.from_polygons([], bounds=(0, 0, 3, 2)), radius=0.08)
    clock = WorkClock(monkeypatch)
    zones = [[winding("a", 0.8), winding("b", 1.2)]] * 2
    parked = FleetSchedule.parked(roadmap, [(0.5, 0.2), (2.0, 0.2)], zones=zones)
    goals = {0: (1.0, 1.8), 1: (2.5, 1.8)}
    for some in ({0: goals[0]}, goals):
        begun_s = clock.now_s
        assert parked.with_goals(some, time_limit_s=1e6, clock=clock)
        whole_s = clock.now_s - begun_s
        for share in (0.3, 0.8):
            begun_s, limit_s = clock.now_s, share * whole_s
            found = parked.with_goals(some, time_limit_s=limit_s, clock=clock)
            assert isinstance(found, NoFleetPlan)
            assert "no plan was found within" in found.reason
            assert clock.now_s - begun_s <= 1.2 * limit_s

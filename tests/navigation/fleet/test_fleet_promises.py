"""Promises keep robots apart whatever the delays: an independent judge drives them at random."""

import math
from itertools import combinations

import numpy as np
import pytest

import planner
from navigation.fleet.planning import plan_promises
from navigation.fleet.releases import Held, release_of
from navigation.fleet.request import FleetAnswer, FleetRequest, Taken, Traveller
from navigation.mission.mission import Station
from planner.formats.scene_io import read_scene_text
from planner.motion.trajectory import default_limits
from planner.scene import Bounds, FloatArray, Scene

RADIUS_M = 0.08
KEEP_M = 0.03
BOUNDS = Bounds(0.0, 0.0, 2.0, 1.6)
ARENA = """#@ clearway.scene/1
#@ units m
L 4 (0.60,0.60) (0.60,0.90) (0.90,0.90) (0.90,0.60)
C (1.4,0.9) 0.12
"""


def scene_of(text: str = ARENA) -> Scene:
    return read_scene_text(text, "arena").with_bounds(BOUNDS)


def places(rng: np.random.Generator, roadmap: planner.Roadmap, count: int) -> FloatArray:
    """Random places in free space, no two bodies nearer than 5 cm."""
    found: list[FloatArray] = []
    while len(found) < count:
        place = rng.uniform((0.1, 0.1), (1.9, 1.5))
        free = roadmap.clearance(place[None])[0] > RADIUS_M + 0.02
        if free and all(math.dist(place, other) > 2 * RADIUS_M + 0.05 for other in found):
            found.append(place)
    return np.array(found)


def travellers(starts: FloatArray, goals: FloatArray) -> tuple[Traveller, ...]:
    limits = default_limits(RADIUS_M)
    return tuple(
        Traveller(f"r{i}", (*start, 0.0), Station(*goal), RADIUS_M, limits)
        for i, (start, goal) in enumerate(zip(starts.tolist(), goals.tolist(), strict=True))
    )


def drive_at_random(answer: FleetAnswer, rng: np.random.Generator) -> float:
    """Let robots drive what they may, each as late as chance has it; the least gap of bodies.

    A robot that moves is anywhere on its piece meanwhile: all of what others stand on or move
    along at the same time is looked at, in 9 parts a piece.
    """
    held = {name: Held(promise) for name, promise in answer.promises.items()}
    names = sorted(held)
    least_m = math.inf
    share = np.linspace(0.0, 1.0, 9)[:, None]
    for _ in range(10_000):
        free = [n for n in names if release_of(n, held).targets > held[n].executed]
        if not free:
            break
        moving = [n for n in free if rng.random() < rng.choice([0.1, 0.5, 1.0])] or free[:1]
        pieces = {}
        for name in names:
            points = held[name].promise.points
            a = points[held[name].executed]
            b = points[held[name].executed + 1] if name in moving else a
            pieces[name] = a + share * (b - a)
        for one, other in combinations(names, 2):
            apart = np.hypot(*(pieces[one][:, None] - pieces[other][None]).transpose(2, 0, 1))
            least_m = min(least_m, float(apart.min()) - 2 * RADIUS_M)
        for name in moving:
            held[name].executed += 1
    assert all(one.is_finished for one in held.values()), "some wait for ever"
    return least_m


@pytest.mark.parametrize("seed", range(6))
def test_no_two_robots_touch_and_all_arrive_however_late_each_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = scene_of()
    roadmap = planner.build_roadmap(scene, RADIUS_M)
    count = int(rng.integers(2, 6))
    request = FleetRequest(
        1, 1, travellers(places(rng, roadmap, count), places(rng, roadmap, count))
    )
    answer = plan_promises(roadmap, scene, request, KEEP_M)
    assert not answer.refused
    for _ in range(5):
        assert drive_at_random(answer, rng) > 0.0
    for promise in answer.promises.values():
        assert len(promise.points) == len(promise.targets) + 1
        assert roadmap.path_clearance(promise.points).distance >= RADIUS_M
        assert promise.targets[-1].stops


def test_a_goal_that_another_robot_stands_on_is_refused_by_name_and_the_others_drive() -> None:
    scene = scene_of()
    roadmap = planner.build_roadmap(scene, RADIUS_M)
    starts, goals = np.array([(0.3, 0.3), (1.7, 0.3)]), np.array([(0.3, 1.3), (1.7, 1.3)])
    request = FleetRequest(4, 2, travellers(starts, goals), (Taken("parked", 0.3, 1.25, RADIUS_M),))
    answer = plan_promises(roadmap, scene, request, KEEP_M)
    assert answer.refused == {"r0": "parked is at its goal"}
    assert set(answer.promises) == {"r1"}
    assert (answer.id, answer.scene_revision) == (4, 2)


def test_a_taken_place_is_kept_clear_of() -> None:
    scene = scene_of()
    roadmap = planner.build_roadmap(scene, RADIUS_M)
    taken = Taken("lost", 1.0, 0.3, 0.2)
    request = FleetRequest(
        1, 1, travellers(np.array([(0.3, 0.3)]), np.array([(1.7, 0.3)])), (taken,)
    )
    (promise,) = plan_promises(roadmap, scene, request, KEEP_M).promises.values()
    off = np.hypot(*(promise.points - (taken.x_m, taken.y_m)).T)
    assert off.min() >= taken.radius_m + RADIUS_M


def test_a_robot_that_is_at_its_goal_has_one_target_there() -> None:
    scene = scene_of()
    roadmap = planner.build_roadmap(scene, RADIUS_M)
    here = np.array([(0.3, 0.3)])
    answer = plan_promises(roadmap, scene, FleetRequest(1, 1, travellers(here, here)), KEEP_M)
    (promise,) = answer.promises.values()
    assert [(t.x_m, t.y_m, t.stops) for t in promise.targets] == [(0.3, 0.3, True)]


def test_robots_that_stand_nearer_than_they_keep_apart_still_get_away() -> None:
    scene = scene_of()
    roadmap = planner.build_roadmap(scene, RADIUS_M)
    starts = np.array([(0.3, 0.3), (0.3 + 2 * RADIUS_M + 0.004, 0.3)])
    goals = np.array([(1.7, 1.3), (0.3, 1.3)])
    answer = plan_promises(roadmap, scene, FleetRequest(1, 1, travellers(starts, goals)), KEEP_M)
    assert set(answer.promises) == {"r0", "r1"}

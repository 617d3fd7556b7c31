"""Nobody touches anybody and nobody waits for ever, whatever goals, delays and deaths there are."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import planner
from navigation.fleet.planning import LESS_ROOM
from navigation.mission.mission import State
from planner.scene import CircleRecord, SceneObject
from tests.support.robots.obedient_fleet import HALL, KEEP_M, ONE_WAY, RADIUS_M, Fleet

ISLANDS = """#@ clearway.scene/1
#@ units m
L 4 (0.60,0.60) (0.60,0.90) (0.90,0.90) (0.90,0.60)
C (1.4,0.9) 0.12
"""
ARENAS = (HALL, ONE_WAY, ISLANDS)
STALLS_A_STEP = 0.006
DIES_A_STEP = 0.0004
LATE_A_STEP = 0.02
BUSY_S = 25.0
ENDS_S = 120.0
GOING = (State.PLANNING, State.DRIVING, State.HOLDING)
Place = tuple[float, float]


def free_places(rng: np.random.Generator, roadmap: planner.Roadmap, count: int) -> list[Place]:
    """Places with room for a body each, no two nearer than 5 cm."""
    found: list[Place] = []
    while len(found) < count:
        x, y = (float(v) for v in rng.uniform((0.1, 0.1), (1.9, 1.5)))
        free = roadmap.clearance(np.array([(x, y)]))[0] > RADIUS_M + 0.02
        if free and all(math.dist((x, y), other) > 2 * RADIUS_M + 0.05 for other in found):
            found.append((x, y))
    return found


class Chance:
    """What happens to a fleet: goals at any time, stalls, delays and deaths."""

    def __init__(self, seed: int, least: int, most: int) -> None:
        self.rng = np.random.default_rng(seed)
        arena = ARENAS[seed % len(ARENAS)]
        empty = Fleet(arena, {})
        count = int(self.rng.integers(least, most + 1))
        starts = free_places(self.rng, empty.roadmap, count)
        names = [f"r{i}" for i in range(count)]
        self.fleet = Fleet(
            arena,
            dict(zip(names, starts, strict=True)),
            late=int(self.rng.integers(1, 4)),
            patient=True,
        )
        self.goals = dict(zip(names, free_places(self.rng, empty.roadmap, count), strict=True))
        self.asks_s = {name: float(self.rng.uniform(0.0, 10.0)) for name in names}
        self.asks_s |= dict.fromkeys(names[: count // 2 + 1], 0.0)

    def step(self) -> None:
        """One cycle."""
        fleet, rng = self.fleet, self.rng
        for name, one in fleet.robots.items():
            asks = fleet.now_s >= self.asks_s.get(name, math.inf)
            if one.dead or (asks and one.state is not State.HOLDING):
                self.asks_s.pop(name, None)
                if not one.dead:
                    one.go(self.goals[name])
            busy = one.state in (State.PLANNING, State.DRIVING) and fleet.now_s < BUSY_S
            if busy and rng.random() < STALLS_A_STEP:
                until_s = fleet.now_s + float(rng.uniform(0.3, 8.0))
                one.hold(until_s, float(rng.random()))
                one.brakes = int(rng.integers(0, 3))
                one.hidden_until_s = until_s if rng.random() < 0.4 else -math.inf
            if busy and rng.random() < DIES_A_STEP:
                one.hold(math.inf, float(rng.random()))
                one.dead = True
            if busy and rng.random() < LATE_A_STEP:
                one.late_until_s = fleet.now_s + float(rng.uniform(0.0, 4.0))
        fleet.step()

    def run(self) -> None:
        """Until all that live are there, or for so long that they never will."""
        living = [one for one in self.fleet.robots.values() if not one.dead]
        while self.fleet.now_s < ENDS_S and (
            self.asks_s or any(one.state in GOING for one in living if not one.dead)
        ):
            self.step()

    def late(self) -> list[str]:
        """Who lives, is not at its goal, and could be with as much room as bodies keep at least."""
        robots = self.fleet.robots
        late = [n for n, one in robots.items() if not one.dead and one.state is not State.DONE]
        return late if late and self._could_arrive() else []

    def _could_arrive(self) -> bool:
        robots, scene = self.fleet.robots, self.fleet.scene
        dead = [one.place for one in robots.values() if one.dead]
        first = 1 + max(thing.id for thing in scene.objects)
        bodies = [
            SceneObject(first + i, (CircleRecord(place, RADIUS_M),)) for i, place in enumerate(dead)
        ]
        roadmap = planner.build_roadmap(
            replace(scene, objects=(*scene.objects, *bodies)), radius=RADIUS_M
        )
        living = [name for name, one in robots.items() if not one.dead]
        plan = planner.plan_fleet(
            roadmap,
            [robots[n].place for n in living],
            [self.goals[n] for n in living],
            RADIUS_M + 0.5 * LESS_ROOM * KEEP_M,
        )
        return isinstance(plan, planner.FleetPlan) or not plan.proved


def judge(chance: Chance) -> None:
    """Run it; the test fails where bodies overlap or somebody never arrives."""
    chance.run()
    assert chance.fleet.least_gap_m > -0.003
    assert chance.late() == []


@pytest.mark.parametrize("seed", [*range(4), 13, 29, 45, 52, 276, 397, 574, 583, 650, 748, 996])
def test_nobody_touches_anybody_and_all_who_live_arrive(seed: int) -> None:
    judge(Chance(seed, 2, 7))


@pytest.mark.parametrize("seed", [*range(2), 13, 109, 190, 319, 667, 688, 1768])
def test_many_robots_in_a_small_hall(seed: int) -> None:
    judge(Chance(seed, 7, 11))

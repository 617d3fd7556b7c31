"""The coordinator in virtual time: robots that do exactly as told, and a planner that answers.

A robot here drives one target in `STEP_S` of what it may drive; what a coordinator would get from
camera, pilots and links is made of that. An independent judge looks at all bodies every step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import planner
from navigation.fleet.coordinator import PATIENCE_S, Coordinator
from navigation.fleet.joining import join_promises
from navigation.fleet.orders import FleetOrders
from navigation.fleet.places_kept import Member
from navigation.fleet.planning import plan_promises
from navigation.fleet.request import FleetAnswer, FleetRequest
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import State, Station
from planner.formats.scene_io import read_scene_text
from planner.motion.trajectory import default_limits
from planner.path import NoPath
from planner.scene import Bounds, FloatArray

RADIUS_M, KEEP_M = 0.08, 0.03
STEP_S = 0.2
HALL = """#@ clearway.scene/1
#@ units m
L 3 (0.02,0.02) (0.02,0.04) (0.04,0.02)
"""
ONE_WAY = """#@ clearway.scene/1
#@ units m
L 4 (0.70,0.00) (0.70,0.68) (1.30,0.68) (1.30,0.00)
L 4 (0.70,0.92) (0.70,1.60) (1.30,1.60) (1.30,0.92)
"""
"""Two rooms and a corridor that is one robot wide."""


@dataclass
class Robot:
    """One that does as it is told: drives, halts at once, and asks where it has no path."""

    place: tuple[float, float]
    state: State = State.IDLE
    stations: tuple[Station, ...] = ()
    plan: PlanAnswer | None = None
    executed: int = 0
    request_id: int = 0
    brakes: int = 0
    """Cycles until it stands."""
    dead: bool = False
    runs_m_s: tuple[float, float] = (0.0, 0.0)
    """A robot that obeys nobody, and how fast it drives along both axes."""

    def go(self, *places: tuple[float, float]) -> None:
        """A new mission."""
        self.stations = tuple(Station(*place) for place in places)
        self.ask()

    def ask(self) -> None:
        self.state, self.plan, self.executed = State.PLANNING, None, 0
        self.request_id += 1

    def drive(self, released: int) -> None:
        """One target further, if it may."""
        if self.dead or self.state is not State.DRIVING or self.plan is None:
            return
        if self.executed < min(released, len(self.plan.targets)):
            target = self.plan.targets[self.executed]
            self.place = (target.x_m, target.y_m)
            self.executed += 1
        if self.executed == len(self.plan.targets):
            if target_is_aside(self.plan):
                self.ask()
                return
            self.stations = self.stations[1:]
            if self.stations:
                self.ask()
            else:
                self.state = State.DONE


def target_is_aside(plan: PlanAnswer) -> bool:
    return plan.targets[-1].station is None


class Fleet:
    """Robots, coordinator and planner; ``late`` cycles pass before the planner answers."""

    def __init__(self, arena: str, places: dict[str, tuple[float, float]], late: int = 1) -> None:
        self.scene = read_scene_text(arena, "arena").with_bounds(Bounds(0.0, 0.0, 2.0, 1.6))
        self.roadmap = planner.build_roadmap(self.scene, RADIUS_M)
        self.robots = {name: Robot(place) for name, place in places.items()}
        self.coordinator = Coordinator(self._clearance_m)
        self.now_s, self.least_gap_m = 0.0, math.inf
        self.requests: list[FleetRequest] = []
        self.stopped: list[str] = []
        """Who was told to stop for a plan of all."""
        self.waited: dict[str, str] = {}
        self._late, self._due = late, 0

    def _clearance_m(self, points: FloatArray) -> float:
        return self.roadmap.path_clearance(points).distance

    def _member(self, one: Robot) -> Member:
        request = None
        if one.state is State.PLANNING:
            request = PlanRequest(one.request_id, (*one.place, 0.0), one.stations, 1)
        at_rest = one.state in (State.IDLE, State.DONE) and not one.dead
        return Member(
            state=one.state, pose=(*one.place, 0.0), pose_age_s=0.0, stands=one.brakes == 0,
            radius_m=RADIUS_M, limits=default_limits(RADIUS_M), max_deviation_m=0.05, reach_m=0.1,
            executed=None if one.plan is None else one.executed, request=request,
            sentence="the cable is out" if one.dead else "", obliging=at_rest,
            velocity=(*one.runs_m_s, 0.0), obeys=one.runs_m_s == (0.0, 0.0),
        )  # fmt: skip

    def _answer(self) -> FleetAnswer | None:
        if not self.requests or self._due == 0:
            return None
        self._due -= 1
        if self._due:
            return None
        request = self.requests[-1]
        plan = join_promises if request.driving else plan_promises
        return plan(self.roadmap, self.scene, request, KEEP_M)

    def step(self) -> FleetOrders:
        """One cycle, and what the robots do in it."""
        self.now_s += STEP_S
        members = {name: self._member(one) for name, one in self.robots.items()}
        orders = self.coordinator.step(self.now_s, members, 1, self._answer())
        if orders.request is not None:
            self.requests.append(orders.request)
            self._due = self._late
        for name, _ in orders.plan_again:
            self.stopped.append(name)
            self.robots[name].ask()
        for name, station in orders.errands.items():
            self.robots[name].stations = (station,)
            self.robots[name].ask()
        for name, answer in orders.answers.items():
            one = self.robots[name]
            assert answer.id == one.request_id
            if isinstance(answer.path, NoPath):
                one.state = State.FAILED
            else:
                one.state, one.plan, one.executed = State.DRIVING, answer, 0
        self.waited |= orders.waits_for
        for name, one in self.robots.items():
            one.brakes = max(0, one.brakes - 1)
            one.place = (
                one.place[0] + STEP_S * one.runs_m_s[0],
                one.place[1] + STEP_S * one.runs_m_s[1],
            )
            release = self.coordinator.release(name)
            one.drive(0 if release is None else release.targets)
        for a, b in combinations(self.robots.values(), 2):
            self.least_gap_m = min(self.least_gap_m, math.dist(a.place, b.place) - 2 * RADIUS_M)
        return orders

    def run(self, seconds: float = 120.0) -> None:
        """Until nobody is under way."""
        end_s = self.now_s + seconds
        going = (State.PLANNING, State.DRIVING)
        while self.now_s < end_s:
            self.step()
            if not any(one.state in going and not one.dead for one in self.robots.values()):
                return
        raise AssertionError({name: one.state for name, one in self.robots.items()})

    def until_driving(self, *names: str) -> None:
        for _ in range(200):
            self.step()
            if all(self.robots[n].state is State.DRIVING for n in names):
                return
        raise AssertionError(f"{names} do not drive")


def at(fleet: Fleet, name: str, place: Sequence[float]) -> bool:
    return math.dist(fleet.robots[name].place, place) < 1e-6


def test_a_new_goal_joins_those_that_drive_and_nobody_is_stopped_for_it() -> None:
    fleet = Fleet(HALL, {"a": (0.3, 0.3), "b": (1.7, 0.3), "c": (1.0, 1.3)}, late=3)
    fleet.robots["a"].go((1.7, 0.8))
    fleet.robots["b"].go((0.3, 0.8))
    fleet.until_driving("a", "b")
    for _ in range(4):
        fleet.step()
    before = {name: held.promise.points for name, held in fleet.coordinator.held.items()}
    fleet.robots["c"].go((1.0, 0.3))
    moved = fleet.robots["a"].executed
    fleet.until_driving("c")
    assert fleet.stopped == []
    assert fleet.robots["a"].executed > moved  # while the planner worked at it, too
    for name, points in before.items():
        assert fleet.coordinator.held[name].promise.points is points
    fleet.run()
    assert at(fleet, "a", (1.7, 0.8))
    assert at(fleet, "b", (0.3, 0.8))
    assert at(fleet, "c", (1.0, 0.3))
    assert fleet.least_gap_m > 0.0
    assert [bool(request.driving) for request in fleet.requests] == [False, True]


def test_while_a_goal_is_planned_nobody_is_sent_more_than_it_has() -> None:
    fleet = Fleet(HALL, {"a": (0.2, 0.2), "b": (1.7, 1.3)}, late=1)
    fleet.robots["a"].go((1.8, 0.2))
    fleet.until_driving("a")
    fleet._late = 1000  # the planner never answers
    fleet.robots["b"].go((0.3, 1.3))
    while not fleet.requests[-1].driving:
        fleet.step()
    (driving,) = fleet.requests[-1].driving
    for _ in range(300):
        fleet.step()
    release = fleet.coordinator.release("a")
    assert release is not None
    assert fleet.robots["a"].executed <= driving.sent


def test_a_robot_in_the_only_way_steps_aside_and_comes_back() -> None:
    fleet = Fleet(ONE_WAY, {"a": (0.2, 0.8), "parked": (1.0, 0.8)})
    fleet.robots["a"].go((1.8, 0.8))
    fleet.run()
    assert at(fleet, "a", (1.8, 0.8))
    assert at(fleet, "parked", (1.0, 0.8))
    assert fleet.robots["parked"].state is State.DONE
    assert fleet.least_gap_m > -0.003


def test_one_steps_aside_while_a_third_drives_on() -> None:
    fleet = Fleet(ONE_WAY, {"a": (0.5, 0.8), "parked": (1.0, 0.8), "c": (0.15, 0.2)})
    fleet.robots["c"].go((0.15, 1.4), (0.15, 0.2), (0.15, 1.4))
    fleet.until_driving("c")
    fleet.robots["a"].go((1.8, 0.8))
    fleet.run()
    assert fleet.stopped == []
    assert at(fleet, "a", (1.8, 0.8))
    assert at(fleet, "parked", (1.0, 0.8))
    assert at(fleet, "c", (0.15, 1.4))
    assert fleet.least_gap_m > -0.003


def test_a_goal_where_another_robot_stands_is_refused_by_name_and_those_that_drive_go_on() -> None:
    fleet = Fleet(HALL, {"a": (0.3, 0.3), "b": (1.7, 0.3), "c": (1.0, 1.3)})
    fleet.robots["a"].go((0.3, 1.3))
    fleet.until_driving("a")
    fleet.robots["b"].go((1.0, 1.25))
    waits = []
    for _ in range(8):
        waits += [why for name, why in fleet.step().waits.items() if name == "b"]
    assert any("waits for the others" in why for why in waits)
    fleet.run()
    assert at(fleet, "a", (0.3, 1.3))
    assert fleet.robots["b"].state is State.FAILED
    assert fleet.stopped == []


def test_a_robot_that_dies_in_the_way_is_planned_around_by_those_that_wait_for_it() -> None:
    fleet = Fleet(HALL, {"a": (0.3, 0.8), "b": (1.7, 0.8)})
    fleet.robots["a"].go((1.7, 0.75))
    fleet.robots["b"].go((0.3, 0.85))
    fleet.until_driving("a", "b")
    while math.dist(fleet.robots["b"].place, (1.7, 0.75)) < 0.4:  # not on the other one's goal
        fleet.step()
    fleet.robots["b"].dead, fleet.robots["b"].state = True, State.FAILED
    fleet.run()
    assert at(fleet, "a", (1.7, 0.75))
    assert fleet.least_gap_m > 0.0


def test_one_that_holds_for_long_is_planned_around_not_sooner() -> None:
    fleet = Fleet(ONE_WAY, {"a": (0.2, 0.8), "b": (1.8, 0.8)})
    fleet.robots["a"].go((1.8, 1.4))
    fleet.robots["b"].go((0.2, 0.2))
    fleet.until_driving("a", "b")
    while not fleet.waited:
        fleet.step()
    (waiting, other) = next(iter(fleet.waited.items()))
    fleet.robots[other].state, fleet.robots[other].dead = State.HOLDING, True
    began_s = fleet.now_s
    while not fleet.stopped:
        fleet.step()
    assert fleet.stopped == [waiting]
    assert fleet.now_s - began_s > PATIENCE_S


def test_a_new_mission_for_one_that_drives_leaves_the_others_to_theirs() -> None:
    fleet = Fleet(HALL, {"a": (0.3, 0.3), "b": (1.7, 0.3), "c": (0.3, 1.3)})
    fleet.robots["a"].go((1.7, 1.3))
    fleet.robots["b"].go((0.3, 0.8))
    fleet.robots["c"].go((1.0, 1.3))
    fleet.until_driving("a", "b", "c")
    for _ in range(3):
        fleet.step()
    fleet.robots["b"].go((1.7, 0.8))
    fleet.run()
    assert fleet.stopped == []
    assert at(fleet, "a", (1.7, 1.3))
    assert at(fleet, "b", (1.7, 0.8))
    assert at(fleet, "c", (1.0, 1.3))
    assert fleet.least_gap_m > 0.0


def test_one_that_was_to_step_aside_and_gets_a_goal_meanwhile_is_not_run_into() -> None:
    fleet = Fleet(ONE_WAY, {"a": (0.2, 0.8), "parked": (1.0, 0.8)})
    fleet.robots["a"].go((1.8, 0.8))
    while fleet.robots["parked"].state is State.IDLE:
        fleet.step()
    fleet.robots["parked"].go((1.0, 0.8))  # to where it stands: in the way of a
    fleet.run()
    assert at(fleet, "a", (1.8, 0.8))
    assert fleet.least_gap_m > -0.003


def test_nobody_is_planned_for_while_one_that_asks_still_brakes() -> None:
    fleet = Fleet(HALL, {"a": (0.3, 0.3), "b": (1.7, 0.3), "c": (1.0, 1.3)})
    fleet.robots["a"].go((1.7, 1.3))
    fleet.robots["b"].go((0.3, 0.8))
    fleet.until_driving("a", "b")
    asked = len(fleet.requests)
    fleet.robots["b"].go((1.7, 0.8))
    fleet.robots["b"].brakes = 4
    fleet.robots["c"].go((1.0, 0.8))
    for _ in range(4):
        fleet.step()
    assert len(fleet.requests) == asked
    fleet.step()
    assert {one.name for one in fleet.requests[-1].travellers} == {"b", "c"}
    fleet.run()
    assert at(fleet, "b", (1.7, 0.8))
    assert at(fleet, "c", (1.0, 0.8))
    assert fleet.stopped == []


def test_a_parked_robot_leaves_the_way_of_a_runaway_and_nobody_is_sent_more_meanwhile() -> None:
    fleet = Fleet(HALL, {"a": (0.2, 0.2), "parked": (1.0, 0.8), "c": (1.0, 1.5)})
    fleet.robots["c"].dead = True
    fleet.robots["a"].go((1.8, 0.2))
    fleet.until_driving("a")
    fleet.robots["c"].runs_m_s = (0.0, -0.16)
    sent = []
    while fleet.robots["c"].place[1] > 0.6:
        fleet.step()
        if fleet.robots["parked"].state is State.DRIVING and not fleet.requests[-1].driving:
            sent.append(fleet.coordinator.held["a"].sent)
    fleet.robots["c"].runs_m_s = (0.0, 0.0)
    assert fleet.least_gap_m > 0.0
    assert sent
    assert set(sent) == {sent[0]}
    fleet.run()
    assert at(fleet, "a", (1.8, 0.2))
    assert at(fleet, "parked", (1.0, 0.8))
    assert fleet.least_gap_m > 0.0

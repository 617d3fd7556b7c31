"""Robots that do exactly as the coordinator tells them, in virtual time, and its planner.

A robot here drives one target in `STEP_S` of what it was given; what a coordinator would get from
camera, pilots and links is made of that. An independent judge looks at all bodies every step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import planner
from navigation.fleet.coordinator import Coordinator
from navigation.fleet.joining import join_promises
from navigation.fleet.members import Member
from navigation.fleet.orders import TrafficOrders
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
RETRY_S = 1.0
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
    given: int = 0
    """Of the plan's targets: what was given to it is not taken back."""
    request_id: int = 0
    brakes: int = 0
    """Cycles until it stands."""
    dead: bool = False
    hidden_until_s: float = -math.inf
    """The camera does not see it until then."""
    seen: tuple[float, float, float] = (math.nan, math.nan, -math.inf)
    """Where it was seen last, and when."""
    at_large: bool = False
    """It may be anywhere: not seen, not heard, and nothing stops it."""
    late_until_s: float = -math.inf
    """It stands until then, although it may drive."""
    asks_again_s: float = math.inf
    """When one that holds asks for a path."""
    asks_for_m_s: float | None = None
    """The fastest that it may drive on its next path."""
    runs_m_s: tuple[float, float] = (0.0, 0.0)
    """A robot that obeys nobody, and how fast it drives along both axes."""

    def go(self, *places: tuple[float, float]) -> None:
        """A new mission."""
        self.stations = tuple(Station(*place) for place in places)
        self.ask()

    def ask(self) -> None:
        self.state, self.plan, self.executed, self.given = State.PLANNING, None, 0, 0
        self.asks_again_s = math.inf
        self.request_id += 1

    def hold(self, until_s: float, share: float = 0.0) -> None:
        """It stands, after this share of the way to its next target, and is to ask then."""
        if self.state is State.DRIVING and self.plan is not None and self.executed < self.given:
            target = self.plan.targets[self.executed]
            x, y = self.place
            self.place = x + share * (target.x_m - x), y + share * (target.y_m - y)
        self.state, self.plan, self.asks_again_s = State.HOLDING, None, until_s

    def drive(self, released: int, now_s: float) -> None:
        """One target further, if it may."""
        if self.dead or self.state is not State.DRIVING or self.plan is None:
            return
        self.given = min(max(self.given, released), len(self.plan.targets))
        if now_s < self.late_until_s:
            return
        if self.executed < self.given:
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
    """Robots, coordinator and planner; ``late`` cycles pass before the planner answers.

    A robot that has no path fails, or with ``patient`` asks again after a second.
    """

    def __init__(
        self,
        arena: str,
        places: dict[str, tuple[float, float]],
        late: int = 1,
        *,
        patient: bool = False,
    ) -> None:
        self.scene = read_scene_text(arena, "arena").with_bounds(Bounds(0.0, 0.0, 2.0, 1.6))
        self.roadmap = planner.build_roadmap(self.scene, RADIUS_M)
        self.robots = {name: Robot(place) for name, place in places.items()}
        self.coordinator = Coordinator(self._clearance_m)
        self.now_s, self.least_gap_m = 0.0, math.inf
        self.revision = self.zones_since = 1
        self.requests: list[FleetRequest] = []
        self.stopped: list[str] = []
        """Who was told to stop for a plan of all."""
        self.waited: dict[str, str] = {}
        self._late, self._due, self._patient = late, 0, patient

    def _clearance_m(self, points: FloatArray) -> float:
        return self.roadmap.path_clearance(points).distance

    def _member(self, one: Robot) -> Member:
        request = None
        if one.state is State.PLANNING:
            request = PlanRequest(
                one.request_id, (*one.place, 0.0), one.stations, self.revision,
                speed_m_s=one.asks_for_m_s,
            )  # fmt: skip
        if self.now_s >= one.hidden_until_s or not math.isfinite(one.seen[2]):
            one.seen = (*one.place, self.now_s)
        x, y, seen_s = one.seen
        at_rest = one.state in (State.IDLE, State.DONE) and not one.dead
        return Member(
            state=one.state, pose=(x, y, 0.0), pose_age_s=self.now_s - seen_s,
            stands=one.brakes == 0, radius_m=RADIUS_M, limits=default_limits(RADIUS_M),
            max_deviation_m=0.05, reach_m=0.1,
            executed=None if one.plan is None else one.executed, request=request,
            sentence="the cable is out" if one.dead else "", obliging=at_rest,
            velocity=(*one.runs_m_s, 0.0), obeys=one.runs_m_s == (0.0, 0.0),
            at_large=one.at_large,
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

    def step(self) -> TrafficOrders:
        """One cycle, and what the robots do in it."""
        self.now_s += STEP_S
        for one in self.robots.values():
            if one.state is State.HOLDING and not one.dead and self.now_s >= one.asks_again_s:
                one.ask()
        members = {name: self._member(one) for name, one in self.robots.items()}
        orders = self.coordinator.step(
            self.now_s, members, self.revision, self._answer(), self.zones_since
        )
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
                if self._patient:
                    one.hold(self.now_s + RETRY_S)
                else:
                    one.state = State.FAILED
            else:
                one.state, one.plan, one.executed, one.given = State.DRIVING, answer, 0, 0
        for name in orders.holds:
            if self.robots[name].state in (State.DRIVING, State.PLANNING):
                self.robots[name].hold(self.now_s + RETRY_S)
        self.waited |= orders.waits_for
        for name, one in self.robots.items():
            one.brakes = max(0, one.brakes - 1)
            one.place = (
                one.place[0] + STEP_S * one.runs_m_s[0],
                one.place[1] + STEP_S * one.runs_m_s[1],
            )
            release = self.coordinator.release(name)
            one.drive(0 if release is None else release.targets, self.now_s)
        for a, b in combinations(self.robots.values(), 2):
            self.least_gap_m = min(self.least_gap_m, math.dist(a.place, b.place) - 2 * RADIUS_M)
        return orders

    def run(self, seconds: float = 120.0) -> None:
        """Until nobody is under way."""
        end_s = self.now_s + seconds
        going = (State.PLANNING, State.DRIVING, *([State.HOLDING] if self._patient else []))
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

"""Robots in the way of one that runs away, judged by a body that drives as it was told.

The runaway keeps its speed and its bend; who is in its way stands, drives on or drives aside.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planner
from navigation.fleet.giving_way import BEGINS_S, HORIZON_S, GivingWay
from navigation.fleet.members import Member
from navigation.fleet.orders import TrafficOrders, holds_of
from navigation.fleet.releases import Held
from navigation.fleet.request import Promise
from navigation.fleet.runaways import Runaway, runaways_of
from navigation.mission.cycle import PlanRequest
from navigation.mission.mission import State, Station
from navigation.mission.targets import Target
from planner.formats.scene_io import read_scene_text
from planner.motion.trajectory import default_limits
from planner.path import Path
from planner.scene import Bounds, FloatArray
from planner.zones.areas import PolygonArea
from planner.zones.rules import rules_for
from planner.zones.zone import Zone

RADIUS_M, KEEP_M = 0.08, 0.03
LIMITS = replace(default_limits(RADIUS_M), speed=0.25, acceleration=0.5)
HALL_SCENE = read_scene_text(
    "#@ clearway.scene/1\n#@ units m\nL 3 (0.02,0.02) (0.02,0.04) (0.04,0.02)\n", "hall"
).with_bounds(Bounds(0.0, 0.0, 2.0, 1.6))
HALL = planner.build_roadmap(HALL_SCENE, RADIUS_M)
HERE = (1.0, 0.8)


def clearance_m(points: FloatArray) -> float:
    return HALL.path_clearance(points).distance


def member(
    x: float, y: float, heading: float = 0.0, state: State = State.PLANNING, speed: float = 0.0
) -> Member:
    velocity = (speed * math.cos(heading), speed * math.sin(heading), 0.0)
    return Member(
        state=state, pose=(x, y, heading), pose_age_s=0.0, stands=speed == 0.0, radius_m=RADIUS_M,
        limits=LIMITS, max_deviation_m=0.05, reach_m=0.1, keep_m=KEEP_M, velocity=velocity,
    )  # fmt: skip


def asks(name: str) -> dict[str, PlanRequest]:
    return {name: PlanRequest(7, (*HERE, 0.0), (Station(0.3, 0.3),), 1)}


def comes(from_rad: float, apart_m: float, speed: float = 0.25, turn: float = 0.0) -> Runaway:
    """One that drives straight at `HERE`, or would but for its bend."""
    x, y = HERE[0] + apart_m * math.cos(from_rad), HERE[1] + apart_m * math.sin(from_rad)
    vx, vy = -speed * math.cos(from_rad), -speed * math.sin(from_rad)
    return Runaway("c", x, y, vx, vy, turn, RADIUS_M)


def promise(name: str, *points: tuple[float, float]) -> Held:
    places = np.array(points)
    targets = tuple(Target(x, y, 0.25, False) for x, y in points[1:])
    path = Path(places, np.ones(len(places)), 1.0, 1.0, points[0], RADIUS_M, (0, 1), (None, None))
    station = Station(*points[-1])
    held = Held(Promise(name, station, places, targets, (), path, None, RADIUS_M))
    held.sent = len(targets)
    return held


def one_cycle(
    one: Member, runaway: Runaway, others: dict[str, Member] | None = None
) -> tuple[GivingWay, TrafficOrders]:
    gives = GivingWay(clearance_m)
    members = {"b": one, "c": member(runaway.x_m, runaway.y_m), **(others or {})}
    return gives, gives.step(1.0, members, {}, asks("b"), [runaway])


def least_gap_m(line: FloatArray, heading: float, runaway: Runaway) -> float:
    """Of a body that turns on the spot and drives the line, seen from outside."""
    length = float(np.hypot(*np.diff(line, axis=0).T).sum())
    dx, dy = line[-1] - line[0]
    turn = abs(math.remainder(math.atan2(dy, dx) - heading, math.tau))
    least, gone, speed, dt = math.inf, 0.0, 0.0, 0.005
    turns_s = turn / LIMITS.angular_rate_rad_s + (
        LIMITS.angular_rate_rad_s / LIMITS.angular_acceleration_rad_s2 if turn > 0.3 else 0.0
    )
    for k in range(int(HORIZON_S / dt)):
        t = k * dt
        if t >= BEGINS_S + turns_s:
            wanted = min(LIMITS.speed, math.sqrt(2.0 * LIMITS.acceleration * max(length - gone, 0)))
            speed = min(wanted, speed + LIMITS.acceleration * dt)
            gone += speed * dt
        place = line[0] + (line[-1] - line[0]) * min(gone / length, 1.0)
        bend = runaway.turn_rate_rad_s * t / 2.0
        chord = math.hypot(runaway.vx_m_s, runaway.vy_m_s) * t * float(np.sinc(bend / math.pi))
        toward = math.atan2(runaway.vy_m_s, runaway.vx_m_s) + bend
        there = runaway.x_m + chord * math.cos(toward), runaway.y_m + chord * math.sin(toward)
        least = min(least, math.dist(there, place) - 2.0 * RADIUS_M)
    return least


@given(
    st.floats(0.0, 2.0 * math.pi), st.floats(-math.pi, math.pi), st.floats(0.85, 0.95),
    st.floats(-0.8, 0.8),
)  # fmt: skip
def test_one_that_stands_in_the_way_is_not_hit_if_it_has_three_seconds(
    from_rad: float, heading: float, apart_m: float, turn: float
) -> None:
    runaway = comes(from_rad, apart_m, turn=turn)
    gives, found = one_cycle(member(*HERE, heading), runaway)
    if not found.answers:  # in its bend it passes
        stays = np.array([HERE, HERE]) + np.array([[0.0, 0.0], [1e-9, 0.0]])
        assert least_gap_m(stays, 0.0, runaway) > 0.0
        return
    line = gives.aside["b"].points
    assert clearance_m(line) >= RADIUS_M
    assert least_gap_m(line, heading, runaway) > 0.0


def test_one_that_cannot_get_away_in_time_stands() -> None:
    _, found = one_cycle(member(*HERE, 0.0), comes(0.0, 0.3))
    assert not found.answers
    assert found.holds["b"] == "c runs away and comes near: it leaves 0.000 m"


def test_one_that_is_passed_at_a_distance_stays() -> None:
    runaway = Runaway("c", 0.2, 1.1, 0.25, 0.0, 0.0, RADIUS_M)
    _, found = one_cycle(member(*HERE), runaway)
    assert found == TrafficOrders()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_nobody_drives_aside_towards_another_robot(side: float) -> None:
    beside = member(HERE[0], HERE[1] + side * 0.22)
    gives, found = one_cycle(member(*HERE), comes(0.0, 0.9), {"d": beside})
    assert found.answers
    assert side * (gives.aside["b"].points[-1, 1] - HERE[1]) < 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_nobody_drives_aside_faster_than_a_slow_zone_allows(side: float) -> None:
    near, far = HERE[1] + side * 0.1, HERE[1] + side * 0.8
    area = PolygonArea(((0.0, near), (2.0, near), (2.0, far), (0.0, far)))
    slow = Zone("people", "slow", area, speed=0.1)
    rules = rules_for([slow], HALL_SCENE, RADIUS_M)
    gives = GivingWay(clearance_m, lambda _robot: rules)
    runaway = comes(0.0, 0.9)
    members = {"b": member(*HERE), "c": member(runaway.x_m, runaway.y_m)}
    found = gives.step(1.0, members, {}, asks("b"), [runaway])
    targets = found.answers["b"].targets
    places = np.array([(one.x_m, one.y_m) for one in targets])
    assert rules.too_fast(places, np.array([one.speed_m_s for one in targets])) is None


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_nobody_drives_aside_to_wait_in_a_no_waiting_zone(side: float) -> None:
    near, far = HERE[1] + side * 0.1, HERE[1] + side * 0.8
    area = PolygonArea(((0.0, near), (2.0, near), (2.0, far), (0.0, far)))
    rules = rules_for([Zone("door", "wait", area)], HALL_SCENE, RADIUS_M)
    gives = GivingWay(clearance_m, lambda _robot: rules)
    runaway = comes(0.0, 0.9)
    members = {"b": member(*HERE), "c": member(runaway.x_m, runaway.y_m)}
    assert gives.step(1.0, members, {}, asks("b"), [runaway]).answers
    assert rules.breach(gives.aside["b"].points) is None


def test_nobody_drives_aside_onto_what_another_robot_was_sent() -> None:
    gives = GivingWay(clearance_m)
    runaway = comes(0.0, 0.9)
    above = promise("d", (0.4, 1.05), (0.8, 1.05), (1.4, 1.05))
    members = {
        "b": member(*HERE), "c": member(runaway.x_m, runaway.y_m),
        "d": member(0.4, 1.05, state=State.DRIVING, speed=0.25),
    }  # fmt: skip
    found = gives.step(1.0, members, {"d": above}, asks("b"), [runaway])
    assert found.answers
    assert gives.aside["b"].points[-1, 1] < HERE[1]


def test_one_that_drives_out_of_the_way_drives_on_and_another_stops_before_it() -> None:
    gives = GivingWay(clearance_m)
    members = {
        "a": member(0.45, 0.8, state=State.DRIVING, speed=0.25),
        "b": member(1.0, 0.6, state=State.DRIVING, speed=0.25),
        "c": member(1.0, 1.4),
    }
    held = {
        "a": promise("a", (0.3, 0.8), (0.4, 0.8), (1.6, 0.8)),
        "b": promise("b", (0.9, 0.6), (1.2, 0.6), (1.8, 0.6)),
    }
    runaway = Runaway("c", 1.0, 1.4, 0.0, -0.25, 0.0, RADIUS_M)
    found = gives.step(1.0, members, held, {}, [runaway])
    assert list(found.holds) == ["a"]
    assert found.plan_again == ()


def test_one_that_drives_into_the_way_is_told_to_leave_its_path() -> None:
    gives = GivingWay(clearance_m)
    runaway = Runaway("c", 1.0, 1.5, 0.0, -0.25, 0.0, RADIUS_M)
    held = {"b": promise("b", (0.9, 0.6), (0.95, 0.6), (1.0, 0.6))}
    members = {"b": member(0.93, 0.6, 0.0, State.DRIVING, 0.1), "c": member(1.0, 1.5)}
    found = gives.step(1.0, members, held, {}, [runaway])
    assert [name for name, _ in found.plan_again] == ["b"]
    assert "driving aside" in found.plan_again[0][1]


def test_a_robot_without_a_mission_drives_aside_and_comes_back_to_its_place() -> None:
    gives = GivingWay(clearance_m)
    idle = replace(member(*HERE, state=State.DONE), obliging=True)
    runaway = comes(0.0, 0.9)
    found = gives.step(1.0, {"b": idle, "c": member(1.9, 0.8)}, {}, {}, [runaway])
    assert found.errands == {"b": Station(*HERE, 0.0)}


def test_who_moves_without_a_permit_or_off_its_way_runs_away() -> None:
    held = {"a": promise("a", (0.4, 0.8), (0.6, 0.8), (1.6, 0.8))}
    drives = member(0.5, 0.8, state=State.DRIVING, speed=0.25)
    assert runaways_of({"a": drives}, held) == []
    off = replace(drives, pose=(0.5, 0.86, 0.0))
    assert [one.name for one in runaways_of({"a": off}, held)] == ["a"]
    without = replace(drives, obeys=False)
    assert [one.name for one in runaways_of({"a": without}, held)] == ["a"]
    assert runaways_of({"a": replace(without, velocity=(0.01, 0.0, 0.0))}, held) == []
    (silent,) = runaways_of({"a": replace(drives, is_silent=True)}, held)
    assert not silent.certain


def test_for_one_that_may_run_away_others_hold_but_leave_no_path() -> None:
    gives = GivingWay(clearance_m)
    perhaps = Runaway("c", 1.0, 1.5, 0.0, -0.25, 0.0, RADIUS_M, certain=False)
    held = {
        "a": promise("a", (0.3, 0.8), (0.4, 0.8), (1.6, 0.8)),
        "b": promise("b", (0.9, 0.6), (0.95, 0.6), (1.0, 0.6)),
    }
    members = {
        "a": member(0.35, 0.8, 0.0, State.DRIVING, 0.25),
        "b": member(0.93, 0.6, 0.0, State.DRIVING, 0.1), "c": member(1.0, 1.5),
    }  # fmt: skip
    found = gives.step(1.0, members, held, {}, [perhaps])
    assert list(found.holds) == ["a", "b"]
    assert found.plan_again == ()


def test_who_drives_on_past_what_it_was_sent_runs_away() -> None:
    held = {"a": promise("a", (0.4, 0.8), (0.6, 0.8), (1.6, 0.8))}
    held["a"].sent = 1
    beyond = member(0.7, 0.8, state=State.DRIVING, speed=0.25)
    assert [one.name for one in runaways_of({"a": beyond}, held)] == ["a"]


def test_a_robot_seen_late_is_no_runaway_where_it_was_then() -> None:
    """A busy computer's poses are older than the reports: false runaways drove others aside."""
    held = {"a": promise("a", *((0.2 + 0.05 * i, 0.5) for i in range(20)))}
    held["a"].executed = 8
    late = replace(member(0.3, 0.5, state=State.DRIVING, speed=0.25), pose_age_s=0.0)
    assert [one.name for one in runaways_of({"a": late}, held)] == ["a"]
    assert runaways_of({"a": replace(late, pose_age_s=0.9)}, held) == []


def test_a_robot_that_drives_aside_holds_for_one_that_is_at_rest_in_its_line() -> None:
    """It drove into the one that had stopped: bodies touched by 0.1 m."""
    drives = replace(member(0.4, 0.5, -0.7, State.DRIVING, 0.25), executed=0)
    line = np.array([(0.45, 0.46), (0.55, 0.37), (0.7, 0.23)])
    stopped = member(0.72, 0.2)
    holds = holds_of({"a": drives, "b": stopped}, {}, {"a": line})
    assert holds["a"].startswith("b is in the path: it leaves 0.000 m")
    assert holds_of({"a": drives, "b": stopped}, {}, {"a": line}, ["b"]) == {}
    past = replace(drives, executed=3, pose=(0.4, 0.5, 0.0))
    assert holds_of({"a": past, "b": stopped}, {}, {"a": line}) == {}

"""The coordinator in virtual time: robots that do exactly as told, and a planner that answers."""

from __future__ import annotations

import math

import pytest

from navigation.fleet import coordinator
from navigation.fleet.gate_waits import PATIENCE_S
from navigation.mission.mission import State
from tests.support.robots.obedient_fleet import HALL, ONE_WAY, Fleet, at


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


def test_a_robot_that_asks_for_a_slower_path_gets_one() -> None:
    fleet = Fleet(HALL, {"a": (0.3, 0.3), "b": (1.7, 1.3)})
    one = fleet.robots["a"]
    one.go((1.7, 0.8))
    fleet.until_driving("a")
    for _ in range(4):
        fleet.step()
    one.asks_for_m_s = 0.1  # the camera's pictures are late
    one.ask()
    fleet.until_driving("a")
    assert one.plan is not None
    assert max(target.speed_m_s for target in one.plan.targets) < 0.101
    fleet.run()
    assert at(fleet, "a", (1.7, 0.8))


def test_while_a_goal_is_planned_nobody_is_sent_more_than_it_has(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(coordinator, "AHEAD", 5)
    fleet = Fleet(HALL, {"a": (0.2, 0.2), "b": (1.7, 1.3)}, late=1)
    fleet.robots["a"].go((1.8, 0.2))
    fleet.until_driving("a")
    fleet._late = 1000  # the planner never answers
    fleet.robots["b"].go((0.3, 1.3))
    while not fleet.requests[-1].driving:
        fleet.step()
    (driving,) = fleet.requests[-1].driving
    said = [fleet.step().waits.get("a") for _ in range(300)]
    release = fleet.coordinator.release("a")
    assert release is not None
    assert fleet.robots["a"].executed == driving.sent < len(driving.promise.targets)
    assert set(said) == {None, "waits while a path is planned for b"}
    assert said[-1] is not None


def test_an_answer_older_than_the_zones_changes_no_promise_and_is_asked_for_again() -> None:
    """Its gates may be in a no-waiting zone that was drawn meanwhile."""
    fleet = Fleet(HALL, {"a": (0.2, 0.8), "b": (1.0, 0.2)}, late=3)
    fleet.robots["a"].go((1.8, 0.8))
    fleet.until_driving("a")
    before = fleet.coordinator.held["a"].promise
    fleet.robots["b"].go((1.0, 1.4))
    fleet.step()
    assert fleet.requests[-1].driving
    fleet.revision = fleet.zones_since = 2
    for _ in range(3):
        fleet.step()
    assert [one.scene_revision for one in fleet.requests] == [1, 1, 2]
    assert fleet.coordinator.held["a"].promise is before
    assert "b" not in fleet.coordinator.held
    fleet.run()
    assert at(fleet, "a", (1.8, 0.8))
    assert at(fleet, "b", (1.0, 1.4))


def test_a_request_that_nobody_waits_for_any_more_keeps_nobody_from_the_next() -> None:
    """A planner that fails answers nothing, and the robots hold and ask again."""
    fleet = Fleet(HALL, {"a": (0.2, 0.8), "b": (1.0, 0.2)}, late=3, patient=True)
    fleet.robots["a"].go((1.8, 0.8))
    fleet.until_driving("a")
    fleet.robots["b"].go((1.0, 1.4))
    fleet.step()
    assert fleet.requests[-1].driving
    fleet._due = 0
    for one in fleet.robots.values():
        one.hold(fleet.now_s + 1.0)
    fleet.run()
    assert at(fleet, "a", (1.8, 0.8))
    assert at(fleet, "b", (1.0, 1.4))


def test_a_robot_whose_mission_ends_on_its_path_has_not_driven_the_rest() -> None:
    fleet = Fleet(HALL, {"a": (0.3, 0.3), "b": (1.7, 0.3)})
    fleet.robots["b"].go((0.3, 0.8))
    fleet.until_driving("b")
    for _ in range(4):
        fleet.step()
    executed = fleet.coordinator.held["b"].executed
    fleet.robots["b"].state, fleet.robots["b"].plan = State.DONE, None
    fleet.step()
    held = fleet.coordinator.held["b"]
    assert (held.broken, held.executed) == (True, executed)
    assert not held.is_finished
    fleet.robots["a"].go((1.7, 0.3))
    fleet.run()
    assert at(fleet, "a", (1.7, 0.3))
    assert fleet.least_gap_m > 0.0


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
    assert any(why.startswith("has no path yet: b and c: their goals are") for why in waits)
    fleet.run()
    assert at(fleet, "a", (0.3, 1.3))
    assert fleet.robots["b"].state is State.FAILED
    assert fleet.stopped == []


def test_a_goal_that_is_refused_changes_no_order_among_those_that_drive() -> None:
    fleet = Fleet(HALL, {"a": (0.2, 0.8), "b": (1.0, 0.2), "c": (1.8, 1.4)}, patient=True)
    fleet.robots["a"].go((1.8, 0.8))
    fleet.robots["b"].go((1.0, 1.4))
    fleet.until_driving("a", "b")
    while not fleet.waited:
        fleet.step()
    ((waits, first),) = fleet.waited.items()
    fleet.robots[first].late_until_s = fleet.now_s + 30.0  # by the clock the other one were first
    fleet.robots["c"].go((0.02, 0.02))
    gates = fleet.coordinator.held[first].promise.gates
    for _ in range(20):
        fleet.step()
    assert fleet.requests[-1].driving
    assert fleet.coordinator.held[first].promise.gates == gates
    assert fleet.robots[waits].state is State.DRIVING
    fleet.robots["c"].state = State.FAILED
    fleet.robots[first].late_until_s = 0.0
    fleet.run()
    assert fleet.least_gap_m > 0.0


def test_what_an_unseen_robot_was_given_stays_taken_after_a_plan_of_the_others() -> None:
    fleet = Fleet(HALL, {"a": (0.3, 0.3), "b": (1.7, 1.3), "c": (0.3, 1.3)}, patient=True)
    fleet.robots["a"].go((1.7, 0.3))
    fleet.until_driving("a")
    for _ in range(4):
        fleet.step()
    fleet.robots["a"].hidden_until_s = math.inf
    seen = fleet.robots["a"].place
    fleet.step()
    fleet.robots["a"].hold(fleet.now_s + 60.0, share=1.0)
    for name, goal in (("b", (1.7, 0.9)), ("c", (0.3, 0.9))):
        fleet.robots[name].go(goal)
        while fleet.robots[name].state is not State.DONE:
            fleet.step()
        taken = [one for one in fleet.requests[-1].taken if one.name == "a"]
        assert not fleet.requests[-1].driving
        assert any(one.x_m > seen[0] + 0.05 for one in taken), name


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


def test_while_one_may_be_anywhere_nobody_drives_and_nobody_is_planned_for() -> None:
    fleet = Fleet(HALL, {"a": (0.3, 0.3), "b": (1.7, 1.3), "c": (0.3, 1.3)}, patient=True)
    fleet.robots["a"].go((1.7, 0.3))
    fleet.robots["b"].go((1.0, 1.3))
    fleet.until_driving("a", "b")
    fleet.robots["a"].at_large = True
    held = fleet.step().holds
    assert held.keys() == {"b"}
    assert held["b"] == "a is not seen and does not answer, and nothing stops it by itself"
    place, asked = fleet.robots["b"].place, len(fleet.requests)
    fleet.robots["a"].hold(math.inf)
    fleet.robots["c"].go((0.8, 1.3))
    for _ in range(100):
        fleet.step()
    assert fleet.robots["b"].place == place
    assert len(fleet.requests) == asked
    fleet.robots["a"].at_large = False
    fleet.robots["a"].hold(fleet.now_s)
    fleet.run()
    assert at(fleet, "b", (1.0, 1.3))
    assert at(fleet, "c", (0.8, 1.3))


def test_the_line_of_one_that_drove_aside_is_kept_while_it_is_not_seen() -> None:
    """Another robot was planned through where it had gone since it was seen last."""
    fleet = Fleet(HALL, {"a": (0.6, 0.8), "b": (0.3, 0.3), "c": (1.6, 0.8)})
    fleet.robots["a"].go((1.8, 0.8))
    fleet.until_driving("a")
    fleet.robots["c"].runs_m_s = (-0.2, 0.0)
    for _ in range(5):
        fleet.step()
        if "a" in fleet.coordinator._giving_way.aside:
            break
    line = fleet.coordinator._giving_way.aside["a"].points
    fleet.robots["a"].hidden_until_s = math.inf
    fleet.robots["a"].hold(math.inf)
    fleet.robots["c"].runs_m_s = (0.0, 0.0)
    fleet.step()
    asked = len(fleet.requests)
    fleet.robots["b"].go((1.7, 0.3))
    for _ in range(50):
        fleet.step()
    kept = [(one.x_m, one.y_m) for one in fleet.requests[asked].taken if one.name == "a"]
    for place in line[1:3].tolist():
        assert min(math.dist(place, one) for one in kept) < 1e-6

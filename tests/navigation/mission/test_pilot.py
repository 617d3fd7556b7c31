"""The pilot in a world of arithmetic: the robot reaches waypoints, the planner draws lines."""

from dataclasses import replace

import pytest

from navigation.mission.cycle import (
    Sight,
)
from navigation.mission.mission import MissionError, MissionProgress, State
from tests.navigation.mission.world import LINKED, PERIOD_S, SEEN, TOUR, World


def test_a_tour_is_driven_and_each_station_counted_once(world: World) -> None:
    world.pilot.give(TOUR)
    visited = []
    for _ in range(60):
        world.cycle()
        visited.append(world.pilot.mission.visited)
    assert world.pilot.mission.state is State.DONE
    assert sorted(visited) == visited
    assert set(visited) == {0, 1, 2}
    assert len(world.uploads) == 1
    assert world.pilot.waypoints_executed == world.pilot.waypoints_sent == 9


def test_nothing_is_permitted_without_a_mission_or_after_it(world: World) -> None:
    assert not any(orders.permit for orders in world.run(20))
    world.pilot.give(TOUR)
    world.run_until(State.DONE)
    assert not any(orders.permit for orders in world.run(20))


@pytest.mark.parametrize(
    "broken",
    [
        {"sight": replace(SEEN, frame_age_s=0.25)},
        {"sight": replace(SEEN, pose_age_s=0.25)},
        {"sight": replace(SEEN, pose=(0.5, 0.9, 0.0))},
        {"robot": replace(LINKED, down_reason="the cable is out")},
        {"robot": replace(LINKED, age_s=1.0)},
    ],
)
def test_a_hold_takes_the_permit_in_the_same_cycle_and_says_why(
    world: World, broken: dict[str, object]
) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    orders = world.pilot.step(
        world.now_s + PERIOD_S,
        broken.get("sight", world.sight),  # type: ignore[arg-type]
        broken.get("robot", world.robot),  # type: ignore[arg-type]
    )
    assert (orders.permit, orders.halt) == (False, True)
    assert world.pilot.mission.state is State.HOLDING
    assert world.pilot.mission.reason


def test_after_a_hold_a_new_plan_is_made_from_where_the_robot_is(world: World) -> None:
    world.pilot.give(TOUR)
    world.run(6)
    world.sight = replace(world.sight, pose_age_s=0.3)
    world.run(5)
    assert world.pilot.mission.state is State.HOLDING
    world.sight = replace(world.sight, pose_age_s=0.03)
    assert not any(orders.permit for orders in world.run(8))  # the cause must stay away
    world.run_until(State.DONE)
    assert len(world.uploads) == 3, "a plan, the turn that proves the robot, a plan"
    assert world.pilot.replans == 1


def test_a_pause_holds_until_resumed(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.pilot.pause()
    assert not any(orders.permit for orders in world.run(100))
    assert world.pilot.mission.reason == "paused by the operator"
    world.pilot.resume()
    assert world.pilot.mission.reason == "continuing as ordered"
    world.cycle()
    assert world.pilot.mission.reason != "paused by the operator"
    world.run_until(State.DONE)


def test_what_else_holds_a_robot_is_said_after_the_pause(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.pilot.pause()
    world.run(10)
    world.sight = replace(world.sight, pose_age_s=0.4)
    world.pilot.resume()
    world.cycle()
    assert "marker was not seen" in world.pilot.mission.reason


def test_stop_is_latched_and_repeated_until_re_armed(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.pilot.stop("the operator pressed STOP")
    stopped = world.run(100)
    assert all(orders.estop and not orders.permit for orders in stopped)
    assert "the operator pressed STOP" in world.pilot.mission.reason
    with pytest.raises(MissionError, match="stopped"):
        world.pilot.give(TOUR)
    world.pilot.resume()
    assert world.cycle().rearm
    assert not any(orders.permit for orders in world.run(20))
    world.pilot.give(TOUR)
    world.run_until(State.DONE)


def test_after_a_stop_one_resume_re_arms_and_a_second_goes_on_with_what_is_left(
    world: World,
) -> None:
    world.pilot.give(TOUR)
    while world.pilot.mission.visited < 1:
        world.cycle()
    world.pilot.stop("the operator pressed STOP")
    world.run(5)
    world.pilot.resume()
    assert not any(orders.permit for orders in world.run(20))
    assert world.pilot.mission.reason == (
        "re-armed by hand: resume to continue with 1 station, or give a new goal"
    )
    world.pilot.resume()
    world.run_until(State.DONE)
    assert world.pilot.mission.visited == 2
    assert world.pilot.waypoints_sent < 2 * len(TOUR) * 5, "the first station was not planned again"


def test_a_robot_that_is_slow_to_leave_its_stop_is_not_stopped_again(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.pilot.stop("the operator pressed STOP")
    world.robot = replace(world.robot, estopped=True)
    world.run(5)
    world.pilot.resume()
    world.cycle()
    world.robot = replace(world.robot, leaving_estop=True)
    world.pilot.resume()
    world.run(100)
    assert world.pilot.mission.state is not State.STOPPED
    world.robot = replace(world.robot, estopped=False, leaving_estop=False)
    world.run_until(State.DONE)


def test_an_emergency_stop_pressed_right_after_the_re_arm_stops_at_once(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.pilot.stop("the operator pressed STOP")
    world.robot = replace(world.robot, estopped=True)
    world.run(5)
    world.pilot.resume()
    assert world.cycle().rearm
    world.pilot.resume()
    assert world.cycle().estop, "the link does not say that this is the old stop"
    assert world.pilot.mission.state is State.STOPPED
    assert "the robot reports an emergency stop" in world.pilot.mission.reason


def test_a_robot_that_stays_in_its_stop_after_being_re_armed_is_stopped_again(
    world: World,
) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.moves = False
    world.robot = replace(world.robot, estopped=True)
    world.run_until(State.STOPPED)
    world.pilot.resume()
    world.pilot.resume()
    world.run(20)
    world.run_until(State.STOPPED)
    assert "the robot reports an emergency stop" in world.pilot.mission.reason


def test_a_failed_mission_is_tried_again_when_resumed(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.robot = replace(world.robot, down_reason="the cable is out")
    world.run_until(State.FAILED, cycles=1000)
    world.robot = replace(world.robot, down_reason=None)
    world.pilot.resume()
    world.run_until(State.DONE)


def test_a_new_plan_is_made_when_asked_for(world: World) -> None:
    world.pilot.replan()
    assert world.pilot.mission.state is State.IDLE
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.pilot.replan()
    assert not world.cycle().permit
    world.run_until(State.DONE)
    assert world.pilot.replans == 1


def test_a_restored_mission_that_was_paused_stays_paused(world: World) -> None:
    world.pilot.restore(MissionProgress(TOUR, visited=1, state=State.HOLDING, paused=True))
    assert not any(orders.permit for orders in world.run(50))
    assert world.pilot.mission.reason == "paused by the operator"
    world.pilot.resume()
    world.run_until(State.DONE)


@pytest.mark.parametrize(
    ("sight", "words"),
    [
        (replace(SEEN, pose=(-0.1, 0.3, 0.0)), "outside the arena"),
        (replace(SEEN, clearance_m=0.05), "clearance is 0.050 m"),
    ],
)
def test_a_robot_where_it_must_not_be_is_stopped(world: World, sight: Sight, words: str) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.sight = sight
    assert world.cycle().estop
    assert words in world.pilot.mission.reason


def test_a_stop_s_reason_names_what_is_so_now_and_keeps_its_cause(world: World) -> None:
    world.pilot.give(TOUR)
    world.sight = replace(SEEN, frame_age_s=5.0, camera_reason="the camera is being opened")
    world.pilot.stop("the operator pressed STOP")
    world.cycle()
    assert "the camera is being opened" in world.pilot.mission.reason
    world.sight = SEEN
    world.cycle()
    assert world.pilot.mission.reason == "the operator pressed STOP"
    world.robot = replace(world.robot, down_reason="the cable was pulled")
    world.cycle()
    assert world.pilot.mission.reason.startswith("the operator pressed STOP; ")
    assert "the cable was pulled" in world.pilot.mission.reason


def test_a_stop_whose_cause_has_gone_still_names_it(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.robot = replace(world.robot, estopped=True)
    world.cycle()
    reason = world.pilot.mission.reason
    assert "the robot reports an emergency stop" in reason
    world.robot = replace(world.robot, estopped=False)
    world.run(3)
    assert world.pilot.mission.state is State.STOPPED
    assert world.pilot.mission.reason == reason


def test_a_robot_that_obeys_the_pilot_s_own_stop_gives_no_second_reason(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.sight = replace(world.sight, doubles=("marker 7 is seen twice",))
    world.cycle()
    world.robot = replace(world.robot, estopped=True)
    world.run(3)
    assert world.pilot.mission.reason == "marker 7 is seen twice"

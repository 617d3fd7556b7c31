"""A station that is skipped is given up for good, and nothing else changes by it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from navigation.mission.mission import MissionError, MissionProgress, State
from planner.path import NoPath
from tests.navigation.mission.world import TOUR, World

FIRST, LAST = TOUR


def driving(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)


def test_a_robot_that_drives_stops_for_a_plan_to_the_next_station(world: World) -> None:
    driving(world)
    world.pilot.skip()
    orders = world.cycle()
    assert (orders.halt, orders.permit) == (True, False), "what it was given is not driven on"
    assert orders.request is not None
    assert orders.request.stations == (LAST,)
    assert world.pilot.mission.reason == "the station at (1, 0.3) m was skipped: on to the next one"
    world.run_until(State.DONE)
    assert (world.pilot.mission.stations, world.pilot.mission.visited) == ((LAST,), 1)


def test_without_its_last_station_a_mission_is_done_and_the_robot_halts(world: World) -> None:
    driving(world)
    while world.pilot.mission.visited == 0:
        world.cycle()
    world.pilot.skip()
    orders = world.cycle()
    assert (orders.halt, orders.permit) == (True, False)
    mission = world.pilot.mission
    assert (mission.state, mission.stations, mission.visited) == (State.DONE, (FIRST,), 1)
    assert mission.reason == "the last station, at (1, 1) m, was skipped; 1 visited before it"
    assert not any(orders.permit for orders in world.run(20))


def test_a_station_that_is_reached_before_the_next_cycle_is_visited_and_no_other_is_skipped(
    world: World,
) -> None:
    driving(world)
    while world.robot.executed < 4:
        world.cycle()
    while not any(t.station == 1 for t in world.targets[: world.robot.executed]):
        world.cycle()
    assert world.pilot.mission.visited == 0, "the pilot has not heard of it yet"
    world.pilot.skip()
    world.run_until(State.DONE)
    assert (world.pilot.mission.stations, world.pilot.mission.visited) == (TOUR, 2)


def test_a_station_without_a_path_is_skipped_by_a_robot_that_holds(world: World) -> None:
    world.no_path = NoPath("the goal is walled in")
    world.pilot.give(TOUR)
    world.run_until(State.HOLDING)
    world.pilot.skip()
    world.no_path = None
    world.run_until(State.DONE)
    assert world.pilot.mission.stations == (LAST,)


def test_a_paused_robot_stays_paused(world: World) -> None:
    driving(world)
    world.pilot.pause()
    world.run_until(State.HOLDING)
    world.pilot.skip()
    assert not any(orders.permit for orders in world.run(40))
    mission = world.pilot.mission
    assert (mission.state, mission.paused, mission.stations) == (State.HOLDING, True, (LAST,))
    world.pilot.resume()
    world.run_until(State.DONE)


def test_a_stop_stays_latched_and_swallows_a_skip(world: World) -> None:
    driving(world)
    world.pilot.skip()
    world.pilot.stop("a person")
    assert world.cycle().estop
    assert world.pilot.mission.stations == TOUR
    with pytest.raises(MissionError, match="re-arm it first"):
        world.pilot.skip()
    world.pilot.resume()
    world.run(3)
    assert world.pilot.mission.state is State.IDLE
    assert world.pilot.mission.stations == TOUR


def test_a_rearmed_robot_waits_for_resume(world: World) -> None:
    driving(world)
    world.pilot.stop("a person")
    world.cycle()
    world.pilot.resume()
    world.cycle()
    world.pilot.skip()
    assert not any(orders.permit for orders in world.run(40))
    mission = world.pilot.mission
    assert (mission.state, mission.stations) == (State.IDLE, (LAST,))
    assert mission.reason.endswith("was skipped: resume to continue with 1 station")
    world.pilot.resume()
    world.run_until(State.DRIVING)


def test_a_skip_is_for_the_mission_that_it_was_ordered_in(world: World) -> None:
    driving(world)
    world.pilot.skip()
    world.pilot.give((LAST, FIRST))
    world.run_until(State.DONE)
    assert world.pilot.mission.stations == (LAST, FIRST)


def test_two_presses_in_one_cycle_skip_one_station(world: World) -> None:
    driving(world)
    world.pilot.skip()
    world.pilot.skip()
    world.cycle()
    assert world.pilot.mission.stations == (LAST,)


def test_where_nothing_is_left_or_no_station_is_the_next_one_it_is_refused(world: World) -> None:
    with pytest.raises(MissionError, match="no station is left"):
        world.pilot.skip()
    world.pilot.give(TOUR, any_order=True)
    with pytest.raises(MissionError, match="the first plan decides"):
        world.pilot.skip()
    aside = MissionProgress(TOUR, 2, state=State.PLANNING, errand=FIRST)
    assert "no station is left" in aside.cannot_skip, "it comes back to its place"


@pytest.mark.parametrize("state", [s for s in State if s not in (State.STOPPED, State.DONE)])
def test_the_only_station_of_a_mission_in_any_state_leaves_it_done(state: State) -> None:
    mission = MissionProgress((FIRST,), state=state, paused=True).without_next()
    assert (mission.state, mission.stations, mission.paused) == (State.DONE, (), True)
    assert replace(mission, paused=False).remaining == ()

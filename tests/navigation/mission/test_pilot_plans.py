"""The pilot when a plan does not fit: no path, obstacles, other robots, a robot off its goal."""

import math
from dataclasses import replace

import numpy as np
import pytest

from navigation.mission.cycle import (
    RobotReport,
)
from navigation.mission.mission import MissionError, State, Station
from navigation.mission.pilot import Pilot
from navigation.mission.traffic import Mover
from planner.borders.polyline import distance_to_polyline
from planner.path import NoPath
from tests.navigation.mission.world import PERIOD_S, SETTINGS, TOUR, World


def test_no_path_holds_says_why_and_asks_again(world: World) -> None:
    world.no_path = NoPath("the goal is walled in")
    world.pilot.give(TOUR)
    world.run(5)
    assert world.pilot.mission.state is State.HOLDING
    assert "the goal is walled in" in world.pilot.mission.reason
    asked = [o.request for o in world.run(90) if o.request is not None]
    assert 2 <= len(asked) <= 4
    world.no_path = None
    world.run_until(State.DONE)


def test_an_obstacle_on_the_path_holds_the_robot_and_plans_anew(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.sight = replace(world.sight, scene_revision=2)
    world.pilot.new_scene(0.2)
    assert world.pilot.mission.state is State.DRIVING
    world.pilot.new_scene(0.05)
    assert world.pilot.mission.state is State.PLANNING
    assert not world.cycle().permit
    world.run_until(State.DONE)
    assert world.pilot.replans == 1


@pytest.mark.parametrize(
    ("clearance_m", "state"),
    [(0.295, State.DRIVING), (0.16, State.DRIVING), (0.14, State.PLANNING), (0.05, State.PLANNING)],
)
def test_an_obstacle_that_comes_near_the_path_asks_for_a_new_plan(
    world: World, clearance_m: float, state: State
) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.pilot.new_scene(clearance_m)
    assert world.pilot.mission.state is state


def test_an_answer_for_an_older_scene_is_not_driven(world: World) -> None:
    world.pilot.give(TOUR)
    world.run(1)
    world.sight = replace(world.sight, scene_revision=2)
    orders = world.cycle()
    assert orders.upload is None
    assert orders.request is not None
    assert orders.request.scene_revision == 2


def test_a_robot_off_its_goal_is_corrected_then_given_up_honestly(world: World) -> None:
    world.pilot.give(TOUR[:1])
    world.moves = False
    world.run_until(State.DRIVING)
    for _ in range(SETTINGS.corrections + 1):
        world.robot = replace(world.robot, executed=len(world.targets))
        world.run(15)
    assert world.pilot.mission.state is State.FAILED
    assert "the camera sees it 700.0 mm" in world.pilot.mission.reason
    assert len(world.uploads) == SETTINGS.corrections + 1


def test_a_robot_that_does_not_begin_is_held_and_given_a_new_plan(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.moves = False
    world.robot = replace(world.robot, standing_reason="its queue ran dry")
    world.run(29)
    assert world.pilot.mission.state is State.DRIVING
    world.run(4)
    assert world.pilot.mission.state is State.HOLDING
    assert "the robot stands still: its queue ran dry" in world.pilot.mission.reason
    world.moves = True
    world.robot = replace(world.robot, standing_reason=None)
    world.run_until(State.DONE)
    assert world.pilot.replans == 1


def test_a_robot_that_turns_and_comes_no_nearer_is_planned_again_and_then_given_up(
    world: World,
) -> None:
    """A robot that had missed a target in a narrow bend turned on the spot for ever."""
    world.pilot.give(TOUR)
    world.moves = False
    world.run_until(State.DRIVING)
    states: list[tuple[State, str]] = []
    for number in range(round(60.0 / PERIOD_S)):
        seen = world.sight.evidence
        turned = replace(seen, wheels_rad=0.05 * number)
        world.sight = replace(world.sight, evidence=turned)
        world.cycle()
        told = world.pilot.mission.state, world.pilot.mission.reason
        if not states or states[-1] != told:
            states.append(told)
    assert (State.PLANNING, "the robot came no nearer for 8 s: planning again") in states
    assert states[-1][0] is State.FAILED
    assert "comes no nearer to (" in states[-1][1]
    assert 3 <= world.pilot.replans <= 4


def test_a_mission_that_holds_for_too_long_fails_with_the_reason(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.robot = replace(world.robot, down_reason="the cable is out")
    world.run_until(State.FAILED, cycles=1000)
    assert world.now_s > 30.0
    assert "given up after 30 s" in world.pilot.mission.reason
    assert "the cable is out" in world.pilot.mission.reason


@pytest.mark.parametrize("missing", ["robot", "camera"])
def test_a_mission_whose_devices_have_not_come_yet_is_not_given_up(
    world: World, missing: str
) -> None:
    robot, sight = world.robot, world.sight
    if missing == "robot":
        world.robot = RobotReport(age_s=math.inf, down_reason="there is no such device")
    else:
        world.sight = replace(sight, frame_age_s=math.inf, pose_age_s=math.inf, pose=None)
    world.pilot.give(TOUR)
    world.run(3000)
    assert world.now_s > 90.0
    assert world.pilot.mission.state is State.HOLDING
    assert not world.pilot.has_met_its_devices
    world.robot, world.sight = robot, sight
    world.run_until(State.DONE)
    assert world.pilot.has_met_its_devices


def test_a_goal_that_cannot_be_reached_fails_in_the_end(world: World) -> None:
    world.no_path = NoPath("the goal is walled in")
    world.pilot.give(TOUR)
    world.run_until(State.FAILED, cycles=2000)
    assert world.pilot.no_path
    assert "the goal is walled in" in world.pilot.mission.reason


def test_a_pause_is_never_given_up(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.pilot.pause()
    world.run(1500)
    assert world.pilot.mission.state is State.HOLDING


def test_a_robot_that_comes_near_holds_ours_until_it_has_passed(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    crossing = Mover(8, 0.6, 0.0, 0.0, 0.3, 0.1)
    world.sight = replace(world.sight, others=(crossing,))
    orders = world.cycle()
    assert not orders.permit
    assert world.pilot.mission.state is State.HOLDING
    assert world.pilot.mission.reason.startswith("robot 8 comes too near")
    assert not any(orders.permit for orders in world.run(60)), "it is still there"
    world.sight = replace(world.sight, others=(replace(crossing, y_m=1.5),))
    world.run_until(State.DONE)


def test_a_robot_that_stands_in_the_way_is_planned_around(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.moves = False
    world.sight = replace(world.sight, others=(Mover(8, 0.8, 0.3, 0.0, 0.0, 0.1),))
    orders = world.cycle()
    assert "blocks the path" in world.pilot.mission.reason
    assert "planning around it" in world.pilot.mission.reason
    assert orders.request is not None
    assert [disc.robot_id for disc in orders.request.avoid] == [8]
    assert not orders.permit


def test_the_reason_for_no_path_is_the_planners_and_names_no_other_robot(world: World) -> None:
    world.no_path = NoPath("no path is wide enough")
    world.sight = replace(world.sight, others=(Mover(8, 0.8, 0.3, 0.0, 0.0, 0.1),))
    world.pilot.give(TOUR)
    world.run(3)
    assert world.pilot.mission.reason == "no safe plan: no path is wide enough"


def test_a_part_that_has_failed_holds_the_robot(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.sight = replace(world.sight, failed="the planner failed: division by zero")
    assert not world.cycle().permit
    assert world.pilot.mission.reason == "the planner failed: division by zero"
    world.sight = replace(world.sight, failed=None)
    world.run_until(State.DONE)


def test_a_station_outside_the_arena_is_refused(world: World) -> None:
    with pytest.raises(MissionError, match=r"station 2 at \(3, 1\) m: outside the arena, x 0\.\.2"):
        world.pilot.give((Station(1.0, 1.0), Station(3.0, 1.0)))


def test_mission_numbers_wrap_and_are_never_zero() -> None:
    world = World(Pilot(SETTINGS, first_mission_id=0xFFFFFFFF))
    world.pilot.give(TOUR)
    world.run_until(State.DONE)
    assert world.uploads == [1]


def test_the_distance_to_a_polyline_is_that_of_its_nearest_piece() -> None:
    line = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
    assert distance_to_polyline(line, (0.5, 0.2)) == pytest.approx(0.2)
    assert distance_to_polyline(line, (2.0, 2.0)) == pytest.approx(math.sqrt(2))
    assert distance_to_polyline(line[:1], (3.0, 4.0)) == pytest.approx(5.0)

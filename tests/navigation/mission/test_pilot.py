"""The pilot in a world of arithmetic: the robot reaches waypoints, the planner draws lines."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from navigation.mission.cycle import (
    Orders,
    PilotSettings,
    PlanAnswer,
    PlanRequest,
    RobotReport,
    Sight,
)
from navigation.mission.mission import Mission, MissionError, State, Station
from navigation.mission.pilot import Pilot
from navigation.mission.running_plan import distance_to_polyline
from navigation.mission.targets import Target
from navigation.mission.traffic import Mover, TrafficLimits
from navigation.mission.watch import SafetyLimits
from planner.path import NoPath, Path
from planner.scene import Bounds

SETTINGS = PilotSettings(
    limits=SafetyLimits(0.2, 0.2, 0.3, 0.05, 0.1, 0.01),
    bounds_m=Bounds(0.0, 0.0, 2.4, 1.8),
    goal_tolerance_m=0.005,
    goal_tolerance_rad=0.02,
    settle_s=0.3,
    retry_s=1.0,
    robot_grace_s=1.0,
    replan_distance_m=0.15,
    give_up_s=30.0,
    traffic=TrafficLimits(radius_m=0.1, speed_m_s=0.3, acceleration_m_s2=0.5, keep_m=0.03),
    corrections=2,
)
PERIOD_S = 1 / 30
SEEN = Sight(0.03, 0.03, (0.3, 0.3, 0.0), 1, 0.3)
LINKED = RobotReport(age_s=0.02, down_reason=None, place_m=(0.3, 0.3))


class World:
    """Answers plans at once; the robot reaches one waypoint a cycle while the lease permits."""

    def __init__(self, pilot: Pilot) -> None:
        self.pilot, self.now_s = pilot, 0.0
        self.sight, self.robot = SEEN, LINKED
        self.answer: PlanAnswer | None = None
        self.no_path: NoPath | None = None
        self.targets: tuple[Target, ...] = ()
        self.uploads: list[int] = []
        self.moves = True

    def cycle(self) -> Orders:
        self.now_s += PERIOD_S
        orders = self.pilot.step(self.now_s, self.sight, self.robot, self.answer)
        self.answer = None if orders.request is None else self.plan(orders.request)
        if orders.upload is not None:
            mission_id, self.targets = orders.upload
            self.uploads.append(mission_id)
            self.robot = replace(self.robot, mission_id=mission_id, executed=0)
        elif orders.permit and self.moves and self.robot.executed < len(self.targets):
            t = self.targets[self.robot.executed]
            self.robot = replace(self.robot, executed=self.robot.executed + 1)
            self.move(t)
        return orders

    def move(self, target: Target) -> None:
        """The robot is at a target, and camera and wheels have seen it turn alike."""
        assert self.sight.pose is not None
        heading_rad = target.heading_rad or 0.0
        turned_rad = math.remainder(heading_rad - self.sight.pose[2], math.tau)
        seen = self.sight.evidence
        self.sight = replace(
            self.sight,
            pose=(target.x_m, target.y_m, heading_rad),
            evidence=replace(
                seen,
                wheels_rad=seen.wheels_rad + turned_rad,
                camera_rad=seen.camera_rad + turned_rad,
            ),
        )
        self.robot = replace(self.robot, place_m=(target.x_m, target.y_m))

    def plan(self, request: PlanRequest) -> PlanAnswer:
        if self.no_path is not None:
            return PlanAnswer(request.id, request.scene_revision, self.no_path)
        stops = [request.start[:2], *((s.x, s.y) for s in request.stations)]
        targets, points = [], []
        for leg, (a, b) in enumerate(pairwise(stops)):
            for t in np.linspace(0.0, 1.0, 5)[leg > 0 :]:
                x, y = a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])
                station = leg if t == 0 else leg + 1 if t == 1 else None
                heading = request.stations[leg].heading_rad
                targets.append(Target(x, y, 0.3, t == 1, heading, station=station))
                points.append((x, y))
        polyline = np.array(points)
        length = float(np.hypot(*np.diff(polyline, axis=0).T).sum())
        path = Path(
            polyline, np.full(len(polyline), 0.3), length, 0.3, stops[0], 0.1, (0,), (None,)
        )
        return PlanAnswer(request.id, request.scene_revision, path, targets=tuple(targets))

    def run(self, cycles: int) -> list[Orders]:
        return [self.cycle() for _ in range(cycles)]

    def run_until(self, state: State, cycles: int = 200) -> None:
        for _ in range(cycles):
            self.cycle()
            if self.pilot.mission.state is state:
                return
        pytest.fail(f"never {state}: {self.pilot.mission}")


@pytest.fixture
def world() -> World:
    return World(Pilot(SETTINGS, first_mission_id=7))


TOUR = (Station(1.0, 0.3), Station(1.0, 1.0, heading_rad=1.0))


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
    world.pilot.resume()
    world.run_until(State.DONE)


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
        "re-armed by hand: resume goes on with 1 station, go gives a new mission"
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
    world.pilot.restore(Mission(TOUR, visited=1, state=State.HOLDING, paused=True))
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
    assert "the robot stands: its queue ran dry" in world.pilot.mission.reason
    world.moves = True
    world.robot = replace(world.robot, standing_reason=None)
    world.run_until(State.DONE)
    assert world.pilot.replans == 1


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
    assert "stands in the way" in world.pilot.mission.reason
    assert "planning around it" in world.pilot.mission.reason
    assert orders.request is not None
    assert [disc.robot_id for disc in orders.request.avoid] == [8]
    assert not orders.permit


def test_while_another_robot_leaves_no_way_the_reason_names_it(world: World) -> None:
    world.no_path = NoPath("no way is wide enough")
    world.sight = replace(world.sight, others=(Mover(8, 0.8, 0.3, 0.0, 0.0, 0.1),))
    world.pilot.give(TOUR)
    world.run(3)
    assert world.pilot.mission.reason == "no safe plan around robot 8: no way is wide enough"


def test_a_part_that_has_failed_holds_the_robot(world: World) -> None:
    world.pilot.give(TOUR)
    world.run_until(State.DRIVING)
    world.sight = replace(world.sight, failed="the planner failed: division by zero")
    assert not world.cycle().permit
    assert world.pilot.mission.reason == "the planner failed: division by zero"
    world.sight = replace(world.sight, failed=None)
    world.run_until(State.DONE)


def test_a_station_outside_the_arena_is_refused(world: World) -> None:
    with pytest.raises(MissionError, match=r"station 2 at \(3, 1\) m: outside the arena"):
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

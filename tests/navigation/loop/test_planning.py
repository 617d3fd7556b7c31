"""The planner as the daemon uses it: answers, checks of the running path, the newest wins."""

import math
import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from navigation.loop.planning import ArenaPlanner, PlannerThread, PlanSettings, SceneCheck
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.mission.mission import Station
from navigation.mission.traffic import Disc
from planner.borders.polyline import arc_lengths, distance_to_polyline, points_at
from planner.motion.smooth import SmoothError
from planner.motion.trajectory import default_limits
from planner.path import NoPath, Path
from planner.scene import Bounds, CircleRecord, FloatArray, Scene, SceneObject, SegmentRecord
from tests.support.oracles.bends import bends_of
from tests.support.waiting import wait_until

RADIUS_M, MARGIN_M = 0.09, 0.02
SETTINGS = PlanSettings(RADIUS_M, MARGIN_M, None, "balanced", default_limits(RADIUS_M))
BOUNDS = Bounds(0.0, 0.0, 2.0, 1.0)


def limited(**changes: Any) -> PlanSettings:
    return replace(SETTINGS, limits=replace(SETTINGS.limits, **changes))


def scene_of(*discs: tuple[float, float, float]) -> Scene:
    objects = tuple(SceneObject(i, (CircleRecord((x, y), r),)) for i, (x, y, r) in enumerate(discs))
    return Scene("m", BOUNDS, objects)


def planner_with(*discs: tuple[float, float, float]) -> ArenaPlanner:
    arena_planner = ArenaPlanner(SETTINGS)
    arena_planner.see(scene_of(*discs), 1)
    return arena_planner


ACROSS = PlanRequest(1, (0.2, 0.5, 0.0), (Station(1.0, 0.8), Station(1.8, 0.5, 0.0, 1.0)), 1)


def test_a_plan_keeps_the_radius_and_visits_every_station_in_order() -> None:
    answer = planner_with((1.0, 0.4, 0.15)).answer(ACROSS)
    assert isinstance(answer.path, Path)
    assert answer.path.min_clearance >= RADIUS_M
    assert [t.station for t in answer.targets if t.station is not None][-2:] == [1, 2]
    last = answer.targets[-1]
    assert (last.x_m, last.y_m, last.heading_rad) == pytest.approx((1.8, 0.5, 0.0))
    assert last.dwell_s == 1.0
    assert last.stops


def test_stations_in_any_order_take_their_dwell_along() -> None:
    stations = (Station(1.6, 0.5, dwell_s=3.0), Station(0.6, 0.5), Station(1.8, 0.8))
    request = PlanRequest(1, (0.2, 0.5, 0.0), stations, 1, any_order=True)
    answer = planner_with().answer(request)
    assert isinstance(answer.path, Path)
    assert answer.path.order == (1, 0)
    stops = {t.x_m: t.dwell_s for t in answer.targets if t.station is not None}
    assert stops[1.6] == 3.0
    assert stops[1.8] == 0.0


def test_a_plan_leads_around_other_robots_and_the_roadmap_knows_nothing_of_them() -> None:
    arena_planner = planner_with()
    robot = Disc(1.0, 0.45, 0.2, robot_id=8, moves=False)
    answer = arena_planner.answer(
        PlanRequest(1, (0.2, 0.5, 0.0), (Station(1.8, 0.5),), 1, avoid=(robot,))
    )
    assert isinstance(answer.path, Path)
    points = np.array([(t.x_m, t.y_m) for t in answer.targets])
    assert distance_to_polyline(points, (1.0, 0.45)) >= 0.2 + RADIUS_M
    assert arena_planner.clearance_m((1.0, 0.45)) == pytest.approx(0.45)


def test_one_that_moves_and_closes_the_only_way_is_waited_for_on_the_way() -> None:
    arena_planner = planner_with((1.0, 0.0, 0.3), (1.0, 1.0, 0.3))
    gate = Disc(1.0, 0.5, 0.15, robot_id=8, moves=True)
    asked = PlanRequest(1, (0.2, 0.5, 0.0), (Station(1.8, 0.5),), 1, avoid=(gate,))
    assert isinstance(arena_planner.answer(asked).path, Path)
    parked = replace(asked, avoid=(replace(gate, moves=False),))
    assert isinstance(arena_planner.answer(parked).path, NoPath)


def test_a_refusal_names_the_robot_at_rest_that_closes_the_only_path_and_no_other() -> None:
    arena_planner = planner_with(*[(1.0, y, 0.1) for y in (0.0, 0.2, 0.8, 1.0)])
    closes, far = Disc(1.0, 0.5, 0.15, 8, False), Disc(1.7, 0.2, 0.1, 9, False)
    moves = Disc(0.3, 0.9, 0.05, 7, True)
    across = replace(ACROSS, stations=(Station(1.8, 0.5),))
    refused = arena_planner.answer(replace(across, avoid=(far, closes, moves))).path
    assert isinstance(refused, NoPath)
    assert refused.reason.endswith(", because robot 8 is in the way")
    outside = replace(ACROSS, stations=(Station(2.8, 0.5),), avoid=(far, closes))
    refused = arena_planner.answer(outside).path
    assert isinstance(refused, NoPath)
    assert refused.reason == f"the goal (2.8, 0.5) lies outside the bounds, {BOUNDS.ranges}"


def test_before_the_first_scene_there_is_no_plan_and_no_clearance() -> None:
    arena_planner = ArenaPlanner(SETTINGS)
    assert isinstance(arena_planner.answer(ACROSS).path, NoPath)
    assert arena_planner.clearance_m((0.5, 0.5)) is None
    assert arena_planner.path_clearance_m(np.zeros((2, 2))) is None


def test_a_wall_of_discs_is_no_path_with_its_bottleneck() -> None:
    wall = [(1.0, 0.05 + 0.15 * i, 0.06) for i in range(7)]
    request = PlanRequest(1, (0.2, 0.5, 0.0), (Station(1.8, 0.5),), 1)
    answer = planner_with(*wall).answer(request)
    assert isinstance(answer.path, NoPath)
    assert answer.path.bottleneck is not None
    assert answer.path.bottleneck.width == pytest.approx(0.03, abs=2e-3)
    assert answer.path.widest_radius == 0.0  # the margin alone is wider


def test_the_margin_is_kept_where_no_station_lies_within_it() -> None:
    # the gap is 0.2 m wide: room for the radius 0.09, not for 0.09 + 0.02
    arena_planner = planner_with((1.0, 0.15, 0.15), (1.0, 0.75, 0.25))
    request = PlanRequest(1, (0.2, 0.4, 0.0), (Station(1.8, 0.4),), 1)
    answer = arena_planner.answer(request)
    assert isinstance(answer.path, NoPath)
    assert "0.22 m wide" in answer.path.reason


def nearer_than(points: FloatArray, arena_planner: ArenaPlanner, need_m: float) -> FloatArray:
    """Places along a polyline, a millimetre apart, that are nearer to a border than that."""
    lengths = arc_lengths(points)
    dense = points_at(points, lengths, np.arange(0.0, float(lengths[-1]), 1e-3))
    assert arena_planner.roadmap is not None
    return dense[arena_planner.roadmap.clearance(dense) < need_m - 1e-6]


@pytest.mark.parametrize("turning_radius_m", [0.0, 0.2])
@pytest.mark.parametrize("goal", [(1.8, 0.098), (1.902, 0.902), (1.0, 0.348)])
def test_the_margin_is_given_up_around_a_station_within_it_and_nowhere_else(
    goal: tuple[float, float], turning_radius_m: float
) -> None:
    arena_planner = ArenaPlanner(limited(turning_radius=turning_radius_m))
    arena_planner.see(scene_of((1.0, 0.15, 0.1), (0.5, 0.7, 0.2)), 1)
    request = PlanRequest(1, (0.2, 0.1, 0.0), (Station(*goal),), 1)
    answer = arena_planner.answer(request)
    assert isinstance(answer.path, Path)
    assert RADIUS_M <= answer.path.min_clearance < RADIUS_M + MARGIN_M
    near = nearer_than(answer.path.points, arena_planner, RADIUS_M + MARGIN_M)
    assert len(near)
    away = np.minimum(*(np.hypot(*(near - end).T) for end in ((0.2, 0.1), goal)))
    assert away.max() < 0.03
    said = [r for r in answer.path.remarks if "the margin of 0.02 m is given up" in r]
    assert len(said) == 2
    assert "the goal" in said[1]
    assert "the start (0.2, 0.1): 0.1 m from the nearest border" in said[0]


def test_a_station_within_the_margin_is_refused_where_that_is_strict() -> None:
    arena_planner = ArenaPlanner(replace(SETTINGS, margin="strict"))
    arena_planner.see(scene_of(), 1)
    request = PlanRequest(1, (0.2, 0.5, 0.0), (Station(1.8, 0.098),), 1)
    answer = arena_planner.answer(request)
    assert isinstance(answer.path, NoPath)
    assert "nearer than the radius and margin of 0.11 m" in answer.path.reason
    nearer = ArenaPlanner(SETTINGS)
    nearer.see(scene_of(), 1)
    answer = nearer.answer(replace(request, stations=(Station(1.8, 0.08),)))
    assert isinstance(answer.path, NoPath)
    assert "nearer than the radius of 0.09 m" in answer.path.reason


def test_a_station_in_a_corridor_within_the_margin_has_no_way_out() -> None:
    walls = tuple(
        SceneObject(i, (SegmentRecord((0.3, y), (1.7, y)),)) for i, y in enumerate((0.4, 0.6))
    )
    arena_planner = ArenaPlanner(SETTINGS)
    arena_planner.see(Scene("m", BOUNDS, walls), 1)
    request = PlanRequest(1, (1.0, 0.5, 0.0), (Station(1.85, 0.2),), 1)
    answer = arena_planner.answer(request)
    assert isinstance(answer.path, NoPath)
    assert "no straight way" in answer.path.reason


def test_the_clearance_of_a_running_path_is_judged_in_the_new_scene() -> None:
    arena_planner = planner_with()
    line = np.array([(0.3, 0.5), (1.7, 0.5)])
    before = arena_planner.path_clearance_m(line)
    arena_planner.see(scene_of((1.0, 0.62, 0.05)), 2)
    after = arena_planner.path_clearance_m(line)
    assert before == pytest.approx(0.3)
    assert after == pytest.approx(0.07)


def test_the_thread_answers_and_the_newest_request_wins() -> None:
    checks: list[SceneCheck] = []
    answers: list[PlanAnswer] = []
    answered = threading.Event()

    def on_answer(answer: PlanAnswer) -> None:
        answers.append(answer)
        answered.set()

    thread = PlannerThread(ArenaPlanner(SETTINGS), checks.append, on_answer)
    thread.see(scene_of((1.0, 0.4, 0.15)), 5, np.array([(0.2, 0.9), (1.8, 0.9)]))
    thread.ask(ACROSS)
    thread.ask(PlanRequest(2, ACROSS.start, ACROSS.stations, 5))
    thread.start()
    assert answered.wait(30.0)
    thread.stop()
    assert thread.failure() is None
    assert [a.id for a in answers] == [2]
    assert answers[0].scene_revision == 5
    assert [c.revision for c in checks] == [5]
    assert checks[0].path_clearance_m == pytest.approx(0.1)


def broken_scene() -> Scene:
    """A scene that no constructor lets through: the planner's own errors have to end well too."""
    scene = scene_of((1.0, 0.4, 0.15))
    (record,) = scene.objects[0].records
    object.__setattr__(record, "center", (math.nan, 0.4))
    return scene


def test_an_error_in_the_thread_reaches_the_control_loop() -> None:
    thread = PlannerThread(ArenaPlanner(SETTINGS), lambda _: None, lambda _: None)
    thread.see(broken_scene(), 1, None)
    thread.start()
    thread.stop(30.0)
    assert (thread.failure() or "").startswith("ValueError: ")


@pytest.mark.parametrize("error", [SmoothError("keep = 0: too little"), ZeroDivisionError("x / 0")])
def test_a_request_that_fails_is_answered_and_the_thread_plans_on(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers: list[PlanAnswer] = []
    answered = threading.Event()

    def on_answer(answer: PlanAnswer) -> None:
        answers.append(answer)
        answered.set()

    def fail(*_: Any, **__: Any) -> Path:
        raise error

    thread = PlannerThread(ArenaPlanner(SETTINGS), lambda _: None, on_answer)
    thread.see(scene_of((1.0, 0.4, 0.15)), 3, None)
    thread.start()
    with monkeypatch.context() as patch:
        patch.setattr("navigation.loop.planning.smooth_path", fail)
        thread.ask(ACROSS)
        assert answered.wait(30.0)
    answered.clear()
    thread.ask(replace(ACROSS, id=2))
    assert answered.wait(30.0)
    thread.stop()
    assert thread.failure() is None
    refused, planned = answers
    assert isinstance(refused.path, NoPath)
    assert str(error) in refused.path.reason
    assert (refused.id, refused.scene_revision) == (1, 3)
    assert isinstance(planned.path, Path)


def test_a_path_beside_the_extension_of_a_wall_is_planned_and_smoothed() -> None:
    """Its clearance came out as 0, and smoothing it ended the planner's thread."""
    wall = SegmentRecord((3.7, 3.7), (0.7, 0.7))
    arena_planner = ArenaPlanner(replace(SETTINGS, radius_m=0.1, margin_m=0.0))
    arena_planner.see(Scene("m", Bounds(0.0, 0.0, 8.0, 8.0), (SceneObject(0, (wall,)),)), 1)
    for start in np.linspace(3.8, 4.5, 8):
        request = PlanRequest(1, (start, start, 0.0), (Station(start + 1.4, start + 1.4),), 1)
        answer = arena_planner.answer(request)
        assert isinstance(answer.path, Path)
        want = math.sqrt(2.0) * (start - 3.7)
        assert answer.path.min_clearance == pytest.approx(want, abs=1e-9)


def test_after_an_error_a_new_thread_plans_again() -> None:
    answered = threading.Event()
    thread = PlannerThread(ArenaPlanner(SETTINGS), lambda _: None, lambda _: answered.set())
    thread.see(broken_scene(), 1, None)
    thread.start()
    assert wait_until(lambda: thread.failure() is not None, 30.0)
    thread.restart()
    assert thread.failure() is None
    thread.see(scene_of((1.0, 0.4, 0.15)), 2, None)
    thread.ask(ACROSS)
    assert answered.wait(30.0)
    thread.stop()


# Staying with the way that is driven.


def middle(shift_m: float) -> Scene:
    """A disc in the middle: the ways on both sides are as long but for the shift."""
    return scene_of((1.0, 0.5 + shift_m, 0.2))


STRAIGHT_ON = PlanRequest(1, (0.2, 0.5, 0.0), (Station(1.8, 0.5),), 1)


def is_left(answer: PlanAnswer) -> bool:
    assert isinstance(answer.path, Path)
    return float(np.interp(1.0, answer.path.points[:, 0], answer.path.points[:, 1])) > 0.5


def test_the_noise_of_a_scene_does_not_make_plans_jump() -> None:
    """Anew, a shift of two millimetres decides; asked again, the plan stays on its side."""
    sides = {}
    for shift_m in (-0.002, 0.002):
        arena_planner = ArenaPlanner(SETTINGS)
        arena_planner.see(middle(shift_m), 1)
        sides[shift_m] = is_left(arena_planner.answer(STRAIGHT_ON))
        for revision, shift in enumerate((-shift_m, shift_m, -shift_m), start=2):
            arena_planner.see(middle(shift), revision)
            assert is_left(arena_planner.answer(STRAIGHT_ON)) is sides[shift_m]
    assert sides[-0.002] is not sides[0.002]


def test_a_preview_and_another_mission_do_not_hold_a_plan_on_its_side() -> None:
    arena_planner = ArenaPlanner(SETTINGS)
    arena_planner.see(middle(-0.002), 1)
    first = is_left(arena_planner.answer(STRAIGHT_ON, preview=True))
    arena_planner.see(middle(0.002), 2)
    assert is_left(arena_planner.answer(STRAIGHT_ON)) is not first
    elsewhere = replace(STRAIGHT_ON, stations=(Station(1.8, 0.51),))
    arena_planner.see(middle(-0.002), 3)
    assert is_left(arena_planner.answer(elsewhere)) is first


def test_a_way_past_stations_that_were_visited_is_stayed_with() -> None:
    arena_planner = ArenaPlanner(SETTINGS)
    arena_planner.see(middle(-0.002), 1)
    tour = replace(STRAIGHT_ON, stations=(Station(0.5, 0.5), *STRAIGHT_ON.stations))
    first = is_left(arena_planner.answer(tour))
    arena_planner.see(middle(0.002), 2)
    assert is_left(arena_planner.answer(replace(STRAIGHT_ON, start=(0.5, 0.5, 0.0)))) is first


def test_a_robot_that_cannot_turn_on_the_spot_is_told_where_it_would_have_to() -> None:
    """It faces away from its goal: no plan, with the reason, and no failure of the planner."""
    arena_planner = ArenaPlanner(limited(turns_on_spot=False, turning_radius=0.2))
    arena_planner.see(scene_of(), 3)
    backwards = PlanRequest(5, (0.2, 0.5, math.pi), (Station(1.8, 0.5),), 3)
    answer = arena_planner.answer(backwards)
    assert isinstance(answer.path, NoPath)
    assert "cannot turn on the spot" in answer.path.reason
    assert (answer.id, answer.scene_revision) == (5, 3)
    assert answer.trajectory is None
    assert isinstance(arena_planner.answer(replace(backwards, start=(0.2, 0.5, 0.0))).path, Path)


@pytest.mark.parametrize("radius_m", [0.1, 0.2, 0.35])
def test_between_its_stops_a_plan_bends_no_tighter_than_the_robot_can(radius_m: float) -> None:
    """Judged by its own waypoints: three on an arc of radius R turn by their distance over R."""
    arena_planner = ArenaPlanner(limited(turning_radius=radius_m))
    arena_planner.see(scene_of((0.6, 0.3, 0.18), (1.2, 0.7, 0.18)), 1)
    answer = arena_planner.answer(PlanRequest(1, (0.15, 0.5, 0.0), (Station(1.85, 0.5),), 1))
    assert answer.trajectory is not None
    bends = bends_of(answer.trajectory)
    assert 0.2 / radius_m < max(bends) <= 1.02 / radius_m

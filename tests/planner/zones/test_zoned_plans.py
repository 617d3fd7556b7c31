"""Plans of one robot by zones, judged by plain geometry along the whole path."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import planner
from planner import Bounds, NoPath, Path, Scene
from planner.motion.trajectory import default_limits
from planner.roadmap.roadmap import Roadmap
from planner.zones.areas import BandArea, CircleArea, PolygonArea
from planner.zones.lanes import cheapest
from planner.zones.zone import Zone
from planner.zones.zoned_roadmap import ZonedRoadmap, with_zones
from tests.planner.zones.plain_geometry import dense, distances, to_line

RADIUS = 0.1
START, GOAL = (0.3, 1.0), (3.7, 1.0)


def scene_of(*discs: tuple[float, float, float]) -> Scene:
    return Scene.from_polygons([], discs, bounds=Bounds(0.0, 0.0, 4.0, 2.0), units="m")


@pytest.fixture(scope="module")
def roadmap() -> Roadmap:
    return planner.build_roadmap(scene_of((1.2, 0.9, 0.2), (2.6, 1.2, 0.25)), RADIUS)


def planned(zoned: ZonedRoadmap, *ends: tuple[float, float], **options: object) -> Path:
    path = zoned.plan(*(ends or (START, GOAL)), **options)  # type: ignore[arg-type]
    assert isinstance(path, Path), path
    return path


def refused(zoned: ZonedRoadmap, *ends: tuple[float, float]) -> str:
    answer = zoned.plan(*(ends or (START, GOAL)))
    assert isinstance(answer, NoPath)
    return answer.reason


def test_without_zones_the_path_is_the_roadmaps_own(roadmap: Roadmap) -> None:
    path, own = planned(with_zones(roadmap, [])), roadmap.plan(START, GOAL)
    assert isinstance(own, Path)
    assert np.array_equal(path.points, own.points)


def test_a_body_stays_out_of_a_keep_out_zone_and_clearances_are_those_to_walls(
    roadmap: Roadmap,
) -> None:
    desk = Zone("desk", "keep_out", CircleArea((2.0, 1.0), 0.3))
    path = planned(with_zones(roadmap, [desk]), margin=0.02)
    assert distances(desk.area, dense(path.points)).min() >= RADIUS + 0.02 - 1e-9
    assert path.clearances == pytest.approx(roadmap.clearance(path.points))
    assert path.min_clearance == pytest.approx(roadmap.path_clearance(path.points).distance)
    smooth = planner.round_corners(path, with_zones(roadmap, [desk]), margin=0.02)
    assert distances(desk.area, dense(smooth.points)).min() >= RADIUS - 1e-9


@pytest.mark.parametrize("seed", range(40))
def test_no_random_keep_out_zone_is_entered_and_a_refusal_is_right(seed: int) -> None:
    rng = np.random.default_rng(seed)
    discs = [(*rng.uniform((0.6, 0.2), (3.4, 1.8)), rng.uniform(0.05, 0.25)) for _ in range(5)]
    roadmap = planner.build_roadmap(scene_of(*discs), RADIUS)
    zones = []
    for number in range(int(rng.integers(1, 5))):
        x, y = rng.uniform((0.8, 0.0), (3.2, 2.0))
        turns = np.sort(rng.uniform(0.0, math.tau, 3)) + rng.uniform(0.0, 1.0)
        corners = np.column_stack([x + 0.4 * np.cos(turns), y + 0.4 * np.sin(turns)])
        area = PolygonArea(corners.tolist()) if number % 2 else CircleArea((x, y), 0.3)
        zones.append(Zone(str(number), "keep_out", area))
    zoned = with_zones(roadmap, zones)
    answer = zoned.plan(START, GOAL)
    # an obstacle of the same shape is what no path can avoid either
    things = [thing for one in zoned.rules.grounds for thing in one.objects]
    solid = Scene("m", roadmap.scene.bounds, (*roadmap.scene.objects, *things))  # type: ignore[attr-defined]
    other = planner.build_roadmap(solid, RADIUS).plan(START, GOAL)
    assert bool(answer) == bool(other)
    if isinstance(answer, Path):
        for zone in zones:
            assert distances(zone.area, dense(answer.points)).min() >= RADIUS - 1e-9
    elif roadmap.plan(START, GOAL):
        assert "keep-out zone" in answer.reason


def test_a_refusal_names_the_zone(roadmap: Roadmap) -> None:
    wall = Zone("wall", "keep_out", PolygonArea(((1.9, -1.0), (2.1, -1.0), (2.1, 3.0), (1.9, 3.0))))
    goal = Zone("goal", "keep_out", CircleArea(GOAL, 0.3))
    near = Zone("near", "keep_out", CircleArea((GOAL[0], GOAL[1] - 0.15), 0.1))
    door = Zone("door", "wait", CircleArea(GOAL, 0.1))
    assert refused(with_zones(roadmap, [wall])) == (
        "the only path leads through keep-out zone 'wall'"
    )
    assert refused(with_zones(roadmap, [goal])) == "the goal (3.7, 1) is in keep-out zone 'goal'"
    assert refused(with_zones(roadmap, [near])) == (
        "the goal (3.7, 1) is 0.05 m from keep-out zone 'near', nearer than the radius of 0.1 m"
    )
    assert refused(with_zones(roadmap, [door])) == "the goal (3.7, 1) is in no-waiting zone 'door'"
    via = with_zones(roadmap, [Zone("door", "wait", CircleArea((2.0, 1.7), 0.1))])
    assert "station 1 (2, 1.7) is in no-waiting zone" in getattr(
        via.plan(START, GOAL, via=[(2.0, 1.7)]), "reason", ""
    )


def test_a_robot_in_a_keep_out_zone_leaves_it_by_the_shortest_path_out(roadmap: Roadmap) -> None:
    desk = Zone("desk", "keep_out", CircleArea((0.5, 1.0), 0.4))
    path = planned(with_zones(roadmap, [desk]))
    assert path.remarks[0].startswith("leaves keep-out zone 'desk' by the shortest path out, 0.")
    depth = distances(desk.area, dense(path.points))
    out = int(np.argmax(depth >= RADIUS - 1e-6))
    assert depth[out:].min() >= RADIUS - 1e-6, "it does not come back"
    driven = np.hypot(*np.diff(dense(path.points)[: out + 1], axis=0).T).sum()
    # the shortest free line of 3600 directions and 1 mm
    turns = np.linspace(0.0, math.tau, 3600, endpoint=False)
    lengths = np.arange(0.0, 1.0, 0.001)
    ends = np.array(START) + lengths[:, None, None] * np.column_stack(
        [np.cos(turns), np.sin(turns)]
    )
    free = (distances(desk.area, ends.reshape(-1, 2)) >= RADIUS).reshape(ends.shape[:2])
    free &= roadmap.clearance(ends.reshape(-1, 2)).reshape(free.shape) >= RADIUS
    shortest = lengths[np.argmax(free.any(axis=1))]
    assert driven == pytest.approx(shortest, rel=0.02, abs=0.01)


def test_a_robot_that_cannot_leave_a_keep_out_zone_is_told(roadmap: Roadmap) -> None:
    floor = Zone("all", "keep_out", PolygonArea(((-1, -1), (5, -1), (5, 3), (-1, 3))))
    assert refused(with_zones(roadmap, [floor]), START, (9.0, 9.0)).startswith(
        "the goal (9, 9) lies outside the bounds"
    ) or "in keep-out zone" in refused(with_zones(roadmap, [floor]))


@pytest.mark.parametrize("seed", range(30))
def test_no_path_is_driven_against_a_one_way_zone(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    roadmap = planner.build_roadmap(scene_of((1.2, 0.9, 0.2), (2.6, 1.2, 0.25)), RADIUS)
    line = rng.uniform((0.4, 0.2), (3.6, 1.8), (2, 2))
    zone = Zone("hall", "one_way", BandArea(line.tolist(), float(rng.uniform(0.1, 0.6))))
    zoned = with_zones(roadmap, [zone])
    for ends in ((START, GOAL), (GOAL, START), (tuple(line[1]), tuple(line[0]))):
        if any(roadmap.clearance([end])[0] < RADIUS for end in ends):
            continue
        answer = zoned.plan(*ends)
        if not isinstance(answer, Path):
            assert "against one-way zone 'hall'" in answer.reason
            continue
        points = dense(answer.points)
        steps, middles = np.diff(points, axis=0), 0.5 * (points[1:] + points[:-1])
        inside = to_line(middles, line) < 0.5 * zone.area.width  # type: ignore[union-attr]
        unit = (line[1] - line[0]) / np.hypot(*(line[1] - line[0]))
        back = -np.minimum(steps[inside] @ unit, 0.0).sum()
        assert back <= 0.05 * RADIUS


def test_a_one_way_zone_is_driven_along_and_avoided_against(roadmap: Roadmap) -> None:
    empty = planner.build_roadmap(scene_of(), RADIUS)
    hall = Zone("hall", "one_way", BandArea(((0.5, 1.0), (3.5, 1.0)), 0.4))
    along, back = (planned(with_zones(empty, [hall]), *e) for e in ((START, GOAL), (GOAL, START)))
    assert along.length == pytest.approx(3.4)
    assert to_line(dense(back.points), np.array([(0.5, 1.0), (3.5, 1.0)])).max() > 0.2
    assert back.length < 4.2


def test_a_lane_is_taken_where_its_cost_is_worth_the_detour(roadmap: Roadmap) -> None:
    empty = planner.build_roadmap(scene_of(), RADIUS)
    line = ((0.4, 1.5), (3.6, 1.5))
    for cost, takes in ((0.5, True), (0.95, False)):
        lane = Zone("lane", "lane", BandArea(line, 0.2), cost=cost)
        path = planned(with_zones(empty, [lane]))
        on_lane = to_line(dense(path.points), np.array(line)) < 0.1
        assert (on_lane.mean() > 0.5) == takes


def test_a_slow_zone_is_driven_around_where_that_takes_less_time() -> None:
    empty = planner.build_roadmap(scene_of(), RADIUS)
    for speed, around in ((0.01, True), (0.28, False)):
        slow = Zone("slow", "slow", CircleArea((2.0, 1.0), 0.3), speed=speed)
        path = planned(with_zones(empty, [slow], speed=0.3))
        outside = distances(slow.area, dense(path.points)).min() >= RADIUS - 1e-6
        assert outside == around


@pytest.mark.parametrize("width", [0.005, 0.05, 0.5])
def test_no_waypoint_or_piece_is_faster_than_a_slow_zone_allows(width: float) -> None:
    empty = planner.build_roadmap(scene_of(), RADIUS)
    slow = Zone("slow", "slow", PolygonArea(((2, 0), (2 + width, 0), (2 + width, 2), (2, 2))),
                speed=0.03)  # fmt: skip
    zoned = with_zones(empty, [slow], speed=0.2)
    path = planned(zoned)
    trajectory = planner.time_path(
        path, default_limits(RADIUS), clearance=empty.clearance, speed_limits=zoned.speed_limits
    )
    for a, b in pairwise(trajectory.waypoints):
        length = math.dist((a.x, a.y), (b.x, b.y))
        line = np.array([(a.x, a.y), (b.x, b.y)])
        if length and distances(slow.area, dense(line, 1e-4)).min() < RADIUS - 1e-4:
            inside = distances(slow.area, dense(line, 1e-4)) < RADIUS
            least_s = length * inside.mean() / 0.03
            assert b.time_s - a.time_s >= 0.98 * least_s - 1e-3


def test_zones_change_the_roadmap_of_the_search_only(roadmap: Roadmap) -> None:
    desk = Zone("desk", "keep_out", CircleArea((2.0, 1.0), 0.3))
    zoned = with_zones(roadmap, [desk])
    assert zoned.walls is roadmap
    assert zoned.scene is roadmap.scene
    assert zoned.clearance([(2.0, 1.0)]) == roadmap.clearance([(2.0, 1.0)])
    moved = zoned.with_zones([Zone("desk", "keep_out", CircleArea((2.0, 0.4), 0.3))])
    fresh = with_zones(roadmap, moved.zones)
    assert planned(moved).length == pytest.approx(planned(fresh).length)
    other = scene_of((1.2, 0.9, 0.2))
    changed = zoned.updated(other)
    fresh = with_zones(planner.build_roadmap(other, RADIUS), zoned.zones)
    assert planned(changed).length == pytest.approx(planned(fresh).length)


def test_wrong_arguments_are_refused_by_name(roadmap: Roadmap) -> None:
    with pytest.raises(TypeError, match="zones"):
        with_zones(roadmap, ["desk"])  # type: ignore[list-item]
    with pytest.raises(TypeError, match="roadmap"):
        with_zones(roadmap.scene, [])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="speed = -1: must be > 0"):
        with_zones(roadmap, [], speed=-1.0)
    twice = [Zone("a", "wait", CircleArea((0, 0), 1))] * 2
    with pytest.raises(ValueError, match="two zones have the name 'a'"):
        with_zones(roadmap, twice)


def alley(*line: tuple[float, float], width: float) -> Zone:
    return Zone("alley", "one_way", BandArea(line, width))


def test_a_lane_leads_nobody_against_a_one_way_zone_that_it_runs_through() -> None:
    road = Zone("road", "lane", BandArea((START, GOAL), 0.4), cost=0.2)
    against = alley((2.5, 1.0), (1.5, 1.0), width=0.2)
    zoned = with_zones(planner.build_roadmap(scene_of(), RADIUS), [road, against])
    assert zoned.rules.breach(planned(zoned).points) is None
    back = planned(zoned, GOAL, START)
    assert back.length == pytest.approx(3.4), "along lane and one-way zone"


def test_a_robot_inside_a_one_way_zone_leaves_it_in_its_direction() -> None:
    strip = alley((0.975, 0.24), (2.969, 0.954), width=1.0)
    zoned = with_zones(planner.build_roadmap(scene_of(), RADIUS), [strip])
    answer = zoned.plan((1.49, 0.24), (1.06, 0.335), via=[(0.352, 0.328)])
    assert isinstance(answer, NoPath) or zoned.rules.breach(answer.points) is None


def test_a_line_that_crosses_itself_is_not_driven_against_on_either_piece() -> None:
    bend = alley((3.0, 0.241), (3.346, 2.0), (1.5, 1.385), (3.0, 0.241), (3.001, 0.241), width=0.1)
    roadmap = planner.build_roadmap(scene_of((1.2, 0.9, 0.2), (2.6, 1.2, 0.25)), RADIUS)
    zoned = with_zones(roadmap, [bend])
    answer = zoned.plan((2.3877, 0.1292), (1.6814, 1.8203))
    assert isinstance(answer, NoPath) or zoned.rules.breach(answer.points) is None


def test_the_path_out_of_a_keep_out_zone_leads_against_no_one_way_zone() -> None:
    desk = Zone("desk", "keep_out", CircleArea((1.0, 1.0), 0.3))
    against = alley((3.0, 1.0), (0.2, 1.0), width=0.4)
    zoned = with_zones(planner.build_roadmap(scene_of(), RADIUS), [desk, against])
    path = planned(zoned, (1.25, 1.0), (3.7, 0.3))
    assert path.remarks, "leaves the desk"
    assert zoned.rules.breach(path.points) is None


def test_beyond_a_corner_of_a_one_way_zone_its_first_piece_gives_the_direction() -> None:
    """Rounding chose the piece, and a fleet's plan broke its own rule there."""
    corner = (0.6660837761432674, 0.3239986572227769)
    bend = alley((0.3287, 1.4757), corner, (1.5801, 0.6246), width=0.5)
    first = np.array(corner) - (0.3287, 1.4757)
    (one,) = with_zones(planner.build_roadmap(scene_of(), RADIUS), [bend]).rules.of("one_way")
    angles = np.linspace(-2.7, -1.5, 200)
    beyond = np.array(corner) + 0.2 * np.column_stack([np.cos(angles), np.sin(angles)])
    expected = np.broadcast_to(first / np.hypot(*first), beyond.shape)
    assert one.directions(beyond) == pytest.approx(expected)


@pytest.mark.parametrize("kind", ["one_way", "lane"])
def test_a_finely_drawn_line_is_driven_as_a_coarse_one_and_has_no_more_nodes(kind: str) -> None:
    coarse = np.array([(0.6, 0.3), (2.0, 1.7), (3.4, 0.3)])
    share = np.linspace(0.0, 2.0, 801)
    fine = np.column_stack([np.interp(share, [0.0, 1.0, 2.0], coarse[:, i]) for i in range(2)])
    asked: list[int] = []
    costs = []
    for line in (coarse, fine):
        area = BandArea(tuple(map(tuple, line.tolist())), 0.3)
        zone = Zone("a", kind, area, cost=0.3 if kind == "lane" else None)  # type: ignore[arg-type]
        zoned = with_zones(planner.build_roadmap(scene_of(), RADIUS), [zone])
        path = planned(zoned, (0.6, 0.4), (3.4, 0.4))
        assert zoned.rules.breach(path.points) is None
        costs.append(zoned.rules.cost(path.points))
        pieces = list[np.ndarray]()
        cheapest(
            START, GOAL, zoned.rules, lambda one, into=pieces: into.append(one) or True,
            lambda *ends: np.array(ends), 0.15,
        )  # fmt: skip
        asked.append(len(pieces))
    assert costs[1] <= 1.02 * costs[0]
    nodes = 3.96 / 0.3 + 5
    assert asked[1] <= 7 * nodes, (
        "of 800 places few are nodes; each has six gates and a piece to the next"
    )

"""From a scene to waypoints: every limit and the clearance hold, by the waypoints alone.

The oracle differentiates what the waypoints say and measures distances by its own means; between
two waypoints the robot drives the straight line.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import planner
from planner.motion.smooth import smooth_path
from planner.motion.trajectory import default_limits, time_path
from planner.path import Limits, NoPath, Path, TimedWaypoint, Trajectory
from planner.scene import Bounds, FloatArray, Scene, SegmentRecord
from tests.support.scenes.planner_scenes import random_scene, scene_of, slow_distance

TIGHT = 1.0 + 1e-6
SECOND = 1e-7


def _limits(radius: float, rng: np.random.Generator) -> Limits:
    """Moderate limits, each up to three times tighter or looser."""
    names = ("speed", "acceleration", "lateral_acceleration", "angular_rate_rad_s", "jerk")
    plain = default_limits(radius)
    changes = {n: getattr(plain, n) * 3.0 ** rng.uniform(-1.0, 1.0) for n in names}
    return replace(plain, **changes, chord_tolerance=radius * float(rng.uniform(0.01, 0.2)))


def _plans(seed: int) -> list[tuple[Scene, float, Path, Limits, Trajectory]]:
    rng = np.random.default_rng(seed + 31_000)
    scene, radius = random_scene(rng), float(rng.uniform(1.5, 6.0))
    roadmap = planner.build_roadmap(scene, radius)
    b = scene.bounds
    places = rng.uniform([b.x_min, b.y_min], [b.x_max, b.y_max], (200, 2))
    places = places[slow_distance(scene, places) >= radius][:6]
    made = []
    for (a, c), prefer in zip(
        zip(places[::2], places[1::2], strict=False), ("length", 0.5, 1.0), strict=False
    ):
        heading = float(rng.uniform(-math.pi, math.pi))
        path = roadmap.plan(tuple(a), (*c, heading), prefer=prefer)
        if isinstance(path, Path):
            smooth = smooth_path(path, roadmap.path_clearance, roadmap.clearance, keep=radius)
            limits = _limits(radius, rng)
            timed = time_path(smooth, limits, clearance=roadmap.clearance)
            made.append((scene, radius, smooth, limits, timed))
    return made


@cache
def every_plan() -> list[tuple[Scene, float, Path, Limits, Trajectory]]:
    """The plans of 30 scenes, made once."""
    return [plan for seed in range(30) for plan in _plans(seed)]


def _drives(timed: Trajectory) -> list[tuple[TimedWaypoint, TimedWaypoint, float, float, float]]:
    """Pairs of waypoints: seconds, way and turn between them."""
    found = []
    for a, b in pairwise(timed.waypoints):
        turn = (b.heading_rad - a.heading_rad + math.pi) % math.tau - math.pi
        way = math.dist((a.x, a.y), (b.x, b.y))
        found.append((a, b, b.time_s - a.time_s - a.dwell_s, way, abs(turn)))
    return found


def _dense(waypoints: FloatArray, step: float) -> FloatArray:
    parts = [
        a + np.linspace(0.0, 1.0, max(2, math.ceil(math.dist(a, b) / step)))[:, None] * (b - a)
        for a, b in pairwise(waypoints)
    ]
    return np.concatenate(parts)


def _places(timed: Trajectory) -> FloatArray:
    return np.array([(w.x, w.y) for w in timed.waypoints])


def test_there_are_plans_of_every_preference_to_look_at() -> None:
    assert len(every_plan()) >= 60


def test_no_straight_line_between_waypoints_comes_nearer_than_the_radius() -> None:
    for scene, radius, path, _, timed in every_plan():
        assert path.min_clearance >= radius * (1.0 - SECOND)
        nearest = slow_distance(scene, _dense(_places(timed), 0.05 * radius)).min()
        assert nearest >= radius * (1.0 - SECOND)


def test_waypoints_leave_the_path_by_no_more_than_the_tolerance() -> None:
    for _, radius, path, limits, timed in every_plan():
        for point in _dense(_places(timed), 0.5 * radius):
            a, d = path.points[:-1], np.diff(path.points, axis=0)
            t = np.clip(((point - a) * d).sum(1) / np.maximum((d * d).sum(1), 1e-300), 0.0, 1.0)
            off = np.hypot(*(a + t[:, None] * d - point).T).min()
            assert off <= limits.chord_tolerance * TIGHT + 1e-8


def test_waypoints_are_no_further_apart_than_the_spacing() -> None:
    for *_, limits, timed in every_plan():
        assert max(way for *_, way, _ in _drives(timed)) <= limits.spacing * TIGHT


def test_speed_and_acceleration_hold() -> None:
    for *_, limits, timed in every_plan():
        for a, b, seconds, way, _ in _drives(timed):
            assert max(a.speed, b.speed) <= limits.speed * TIGHT
            assert way <= limits.speed * seconds * TIGHT + SECOND
            assert abs(b.speed - a.speed) <= limits.acceleration * seconds * TIGHT + SECOND


def test_jerk_holds() -> None:
    """Means of an acceleration over two stretches differ by at most jerk times their middles'."""
    for *_, limits, timed in every_plan():
        drives = _drives(timed)
        for (a, b, first, way, _), (_, c, second, after, _) in pairwise(drives):
            if min(first, second) <= SECOND or min(way, after) == 0.0 or b.dwell_s > 0.0:
                continue
            change = abs((c.speed - b.speed) / second - (b.speed - a.speed) / first)
            assert change <= limits.jerk * 0.5 * (first + second) * TIGHT + 1e-5 * limits.jerk


def test_angular_rate_and_lateral_acceleration_hold() -> None:
    for *_, limits, timed in every_plan():
        for a, b, seconds, way, turn in _drives(timed):
            assert turn <= limits.angular_rate_rad_s * seconds * TIGHT + 1e-6
            if way > 0.0 and seconds > 0.0:
                slower = min(way / seconds, a.speed, b.speed)
                assert slower * turn / seconds <= limits.lateral_acceleration * TIGHT + 1e-9


def test_curves_are_driven_no_tighter_than_the_slower_end_allows() -> None:
    """Curvature times speed is the angular rate: where the robot moves, it is bounded by that."""
    for *_, limits, timed in every_plan():
        for a, b, _, way, turn in _drives(timed):
            slower = min(a.speed, b.speed)
            if way > 0.0 and slower > 0.0:
                assert turn / way <= limits.angular_rate_rad_s / slower * TIGHT + 1e-6 / way


def test_narrow_places_are_driven_slowly() -> None:
    for scene, radius, _, limits, timed in every_plan():
        spare = slow_distance(scene, _places(timed)) - radius
        room = limits.slow_clearance - radius
        allowed = limits.slow_speed + (limits.speed - limits.slow_speed) * np.clip(
            spare / room, 0.0, 1.0
        )
        speeds = np.array([w.speed for w in timed.waypoints])
        assert (speeds <= np.maximum(allowed, limits.slow_speed) * TIGHT + SECOND).all()


def test_plans_begin_and_end_standing_with_the_heading_asked_for() -> None:
    for *_, path, _, timed in every_plan():
        first, last = timed.waypoints[0], timed.waypoints[-1]
        assert first.speed == last.speed == 0.0
        assert (last.x, last.y) == pytest.approx(tuple(path.points[-1]), abs=1e-9)
        turn = last.heading_rad - path.headings_rad[-1]
        assert math.cos(turn) == pytest.approx(1.0, abs=1e-9)
        assert timed.duration_s == pytest.approx(last.time_s)


def test_no_way_overshoots_a_junction_and_turns_back() -> None:
    """Retraction met a chain 2e-3 beside where the way along it began: the robot turned twice."""
    outer = [(100.0, 100.0), (300.0, 100.0), (300.0, 300.0)]
    inner = [(0.0, 127.72), (100.0, 127.72), (272.28, 127.72), (272.28, 300.0)]
    made = [SegmentRecord(a, b) for line in (outer, inner) for a, b in pairwise(line)]
    scene = scene_of(*made, bounds=Bounds(0.0, 0.0, 400.0, 300.0))
    rng = np.random.default_rng(0)
    for radius in (5.0, 8.0, 11.0):
        roadmap = planner.build_roadmap(scene, radius)
        for start, goal in rng.uniform(0.0, [400.0, 300.0], (40, 2, 2)):
            for prefer in ("clearance", "balanced"):
                path = roadmap.plan(start, goal, prefer=prefer)
                if isinstance(path, NoPath):
                    continue
                steps = np.diff(path.points, axis=0)
                back = (steps[1:] * steps[:-1]).sum(axis=1) < 0.0
                size = np.hypot(*steps.T)
                folded = back & (np.minimum(size[1:], size[:-1]) < 0.05)
                assert not folded.any(), path.points[1:-1][folded]

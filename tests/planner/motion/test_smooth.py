"""Rounded corners keep the clearance; the oracle measures segment against segment."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planner.formats.scene_io import read_scene_text
from planner.motion.smooth import SmoothError, smooth_path
from planner.motion.trajectory import default_limits, time_path
from planner.path import Path
from planner.roadmap.roadmap import build_roadmap

RADIUS = 1.0


@dataclass(frozen=True)
class Least:
    distance: float
    at: tuple[float, float]


@dataclass(frozen=True)
class Pins:
    """Obstacles that are points: distances are as simple as can be."""

    places: np.ndarray

    def path_clearance(self, line: np.ndarray) -> Least:
        best = Least(math.inf, (math.nan, math.nan))
        for a, b in pairwise(line):
            d = b - a
            squared = float(d @ d)
            for pin in self.places:
                t = min(max(float((pin - a) @ d) / squared, 0.0), 1.0) if squared else 0.0
                foot = a + t * d
                gap = float(np.hypot(*(pin - foot)))
                if gap < best.distance:
                    best = Least(gap, (float(foot[0]), float(foot[1])))
        return best

    def clearance(self, points: np.ndarray) -> np.ndarray:
        return np.hypot(*(points[:, None] - self.places[None]).transpose(2, 0, 1)).min(axis=1)


FAR = Pins(np.array([[1000.0, 1000.0]]))


def make_path(points, pins: Pins, stations=None, radius: float = RADIUS) -> Path:
    points = np.array(points, dtype=float)
    least = pins.path_clearance(points)
    stations = stations or (0, len(points) - 1)
    return Path(
        points=points,
        clearances=pins.clearance(points),
        length=float(np.hypot(*np.diff(points, axis=0).T).sum()),
        min_clearance=least.distance,
        min_clearance_at=least.at,
        robot_radius=radius,
        stations=stations,
        headings_rad=(None,) * len(stations),
    )


def sharpest_turn(points: np.ndarray) -> float:
    steps = np.diff(points, axis=0)
    direction = np.arctan2(steps[:, 1], steps[:, 0])
    turns = np.abs((np.diff(direction) + math.pi) % math.tau - math.pi)
    return float(turns.max(initial=0.0))


def test_a_corner_in_the_open_becomes_a_curve():
    path = make_path([(0, 0), (20, 0), (20, 20)], FAR)
    smooth = smooth_path(path, FAR.path_clearance, FAR.clearance, keep=RADIUS)
    assert sharpest_turn(path.points) == pytest.approx(math.pi / 2)
    assert sharpest_turn(smooth.points) < math.radians(12)
    assert smooth.length < path.length
    assert not smooth.points.flags.writeable
    assert tuple(smooth.points[0]) == (0.0, 0.0)
    assert tuple(smooth.points[-1]) == (20.0, 20.0)


def test_a_corner_that_hugs_an_obstacle_stays():
    pins = Pins(np.array([[19.0, 1.0]]))
    path = make_path([(0, 0), (20, 0), (20, 20)], pins)
    assert path.min_clearance == pytest.approx(1.0)
    smooth = smooth_path(path, pins.path_clearance, pins.clearance)
    assert pins.path_clearance(smooth.points).distance >= path.min_clearance


def test_a_corner_near_an_obstacle_gets_the_longest_cut_that_fits():
    pins = Pins(np.array([[18.6, 1.4]]))
    path = make_path([(0, 0), (20, 0), (20, 20)], pins)
    smooth = smooth_path(path, pins.path_clearance, pins.clearance, keep=RADIUS)
    free = smooth_path(make_path(path.points, FAR), FAR.path_clearance, FAR.clearance, keep=RADIUS)
    assert RADIUS <= pins.path_clearance(smooth.points).distance < path.min_clearance
    assert free.length < smooth.length < path.length


coordinate = st.integers(-30, 30).map(float)
place = st.tuples(coordinate, coordinate)


@settings(max_examples=100, deadline=None)
@given(
    st.lists(place, min_size=2, max_size=8, unique=True),
    st.lists(place, min_size=1, max_size=5),
    st.booleans(),
)
def test_smoothing_never_loses_clearance_nor_moves_a_station(points, pins, keep_all):
    oracle = Pins(np.array(pins) + 0.37)
    stations = (0, len(points) // 2, len(points) - 1)
    least = oracle.path_clearance(np.array(points))
    assume(least.distance > 0.1)
    radius = 0.5 * least.distance
    path = make_path(points, oracle, stations, radius)
    keep = None if keep_all else radius
    smooth = smooth_path(path, oracle.path_clearance, oracle.clearance, keep=keep)
    floor = path.min_clearance if keep_all else radius
    found = oracle.path_clearance(smooth.points)
    assert found.distance >= floor - 1e-10
    assert found.distance >= radius
    assert smooth.min_clearance == found.distance
    assert smooth.length <= path.length + 1e-9
    for before, after in zip(path.stations, smooth.stations, strict=True):
        np.testing.assert_allclose(smooth.points[after], path.points[before], atol=1e-12)
    np.testing.assert_allclose(smooth.clearances, oracle.clearance(smooth.points))


def test_a_path_without_corners_is_left_alone():
    path = make_path([(0, 0), (5, 0), (10, 0)], FAR)
    smooth = smooth_path(path, FAR.path_clearance, FAR.clearance)
    np.testing.assert_array_equal(smooth.points, path.points)


def test_a_turn_back_is_left_alone():
    path = make_path([(0, 0), (10, 0), (0, 0)], FAR)
    smooth = smooth_path(path, FAR.path_clearance, FAR.clearance)
    np.testing.assert_array_equal(smooth.points, path.points)


@pytest.mark.parametrize("keep", [0.5, math.nan, math.inf])
def test_keeping_less_than_the_radius_is_refused(keep):
    path = make_path([(0, 0), (10, 0)], FAR)
    with pytest.raises(SmoothError, match="keep = "):
        smooth_path(path, FAR.path_clearance, FAR.clearance, keep=keep)


def test_a_planned_path_is_smoothed_against_the_scene_itself():
    scene = read_scene_text(
        "#@ clearway.scene/1\n#@ bounds given 0 0 100 80\n"
        "L 4 (20,20)(40,20)(40,60)(20,60)\nL 4 (60,20)(80,20)(80,60)(60,60)\n"
    )
    roadmap = build_roadmap(scene, 4.0)
    path = roadmap.plan((10, 10), (90, 70), prefer="clearance")
    smooth = smooth_path(path, roadmap.path_clearance, roadmap.clearance)
    assert smooth.min_clearance >= path.min_clearance - 1e-9
    assert smooth.length < path.length
    boxes = [(20, 20, 40, 60), (60, 20, 80, 60)]
    for x, y in smooth.points:
        gaps = [
            math.hypot(max(x0 - x, 0, x - x1), max(y0 - y, 0, y - y1)) for x0, y0, x1, y1 in boxes
        ]
        assert min(*gaps, x, y, 100 - x, 80 - y) >= path.min_clearance - 1e-9


def bends(path: Path) -> np.ndarray:
    """The radius at every inner point: that of the circle through it and its neighbours."""
    a, b, c = path.points[:-2], path.points[1:-1], path.points[2:]
    u, v, w = b - a, c - b, c - a
    area2 = np.abs(u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0])
    sides = np.hypot(*u.T) * np.hypot(*v.T) * np.hypot(*w.T)
    return np.where(area2 > 1e-9, sides / (2.0 * np.maximum(area2, 1e-300)), np.inf)


@pytest.mark.parametrize("turn_deg", [10.0, 45.0, 90.0, 120.0])
@pytest.mark.parametrize("turning_radius", [0.5, 2.0, 5.0])
def test_cuts_are_no_tighter_than_the_turning_radius(turn_deg, turning_radius):
    a = math.radians(turn_deg)
    corner = [(0, 0), (20, 0), (20 + 20 * math.cos(a), 20 * math.sin(a))]
    path = make_path(corner, FAR)
    smooth = smooth_path(
        path, FAR.path_clearance, FAR.clearance, keep=RADIUS, turning_radius=turning_radius
    )
    assert len(smooth.points) > 4
    assert bends(smooth).min() >= turning_radius
    assert smooth.length < path.length
    limits = replace(default_limits(RADIUS), turning_radius=turning_radius)
    driven = time_path(smooth, limits).waypoints
    assert all(w.speed > 0.0 for w in driven[1:-1])


def test_a_corner_without_room_for_the_turning_radius_stays():
    path = make_path([(0, 0), (3, 0), (3, 3)], FAR)
    smooth = smooth_path(path, FAR.path_clearance, FAR.clearance, keep=RADIUS, turning_radius=4.0)
    assert smooth.points.tolist() == path.points.tolist()
    limits = replace(default_limits(RADIUS), turning_radius=4.0)
    standing = [(w.x, w.y) for w in time_path(smooth, limits).waypoints[1:-1] if w.speed == 0.0]
    assert set(standing) == {(3.0, 0.0)}


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=3, max_size=7),
    st.floats(0.3, 4.0),
)
def test_no_cut_of_any_path_is_too_tight_or_too_near(corners, turning_radius):
    points = [p for i, p in enumerate(corners) if i == 0 or p != corners[i - 1]]
    assume(len(points) >= 3)
    pins = Pins(np.array([[2.3, 1.7], [-4.1, 3.3], [30.0, 30.0]]))
    path = make_path([(3.0 * x, 3.0 * y) for x, y in points], pins)
    assume(path.min_clearance >= RADIUS)
    smooth = smooth_path(path, pins.path_clearance, pins.clearance, turning_radius=turning_radius)
    assert smooth.min_clearance >= path.min_clearance - 1e-9
    corners_left = {tuple(p) for p in path.points.tolist()}
    tight = bends(smooth) < turning_radius * (1 - 1e-6)
    assert {tuple(p) for p in smooth.points[1:-1][tight].tolist()} <= corners_left


@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_a_turning_radius_that_is_none_is_refused(value):
    path = make_path([(0, 0), (3, 0), (3, 3)], FAR)
    with pytest.raises(SmoothError, match="turning_radius = "):
        smooth_path(path, FAR.path_clearance, FAR.clearance, turning_radius=value)

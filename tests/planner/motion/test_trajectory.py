"""Timed waypoints keep every limit; the oracle differentiates what the waypoints say."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planner.motion.speed_profile import plan_speed
from planner.motion.trajectory import TrajectoryError, default_limits, time_path, turning_time
from planner.path import Limits
from planner.shared.angles import wrap_angle
from tests.planner.motion.trajectories import (
    LIMITS,
    RADIUS,
    check_bounds,
    distance_to_polyline,
    heading,
    make_path,
    polylines,
)


@settings(max_examples=80, deadline=None)
@given(polylines, heading, heading, st.floats(0.1, 1.0))
def test_every_limit_holds_between_any_two_waypoints(points, first, last, clearance):
    path = make_path(points, clearance, headings=(first, last))
    check_bounds(time_path(path, LIMITS), LIMITS)


@settings(max_examples=50, deadline=None)
@given(polylines, st.floats(0.1, 0.2))
def test_the_line_through_the_waypoints_keeps_the_paths_clearance(points, clearance):
    path = make_path(points, clearance)
    assume(path.length > 0)
    waypoints = np.array([(w.x, w.y) for w in time_path(path, LIMITS).waypoints])
    spare = min(LIMITS.chord_tolerance, clearance - RADIUS)
    assert distance_to_polyline(path.points, waypoints).max() <= spare + 1e-8
    dense = np.concatenate(
        [a + np.linspace(0, 1, 20)[:, None] * (b - a) for a, b in pairwise(waypoints)]
    )
    assert distance_to_polyline(dense, path.points).max() <= spare + 1e-8


@settings(max_examples=40, deadline=None)
@given(polylines)
def test_waypoints_are_no_further_apart_than_the_spacing(points):
    path = make_path(points)
    waypoints = time_path(path, LIMITS).waypoints
    for a, b in pairwise(waypoints):
        assert math.dist((a.x, a.y), (b.x, b.y)) <= LIMITS.spacing * (1 + 1e-9)


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_speed_profile_keeps_speed_acceleration_and_jerk_everywhere(data):
    count = data.draw(st.integers(1, 40))
    cells = data.draw(st.lists(st.floats(0.001, 0.3), min_size=count, max_size=count))
    limits = data.draw(st.lists(st.floats(0.02, 1.0), min_size=count, max_size=count))
    acceleration, jerk = data.draw(st.floats(0.2, 2)), data.draw(st.floats(0.5, 20))
    lengths = np.concatenate([[0.0], np.cumsum(cells)])
    profile = plan_speed(lengths, np.array(limits), acceleration, jerk)
    times = np.linspace(0.0, profile.duration_s, 20_001)
    dt = times[1]
    position = profile.position(times)
    speed = np.diff(position) / dt
    assert position[0] == pytest.approx(0.0, abs=1e-12)
    assert position[-1] == pytest.approx(lengths[-1], rel=1e-9)
    assert speed.min() > -1e-7
    acc = np.diff(speed) / dt
    noise = 1e-14 * lengths[-1] * max(profile.duration_s, 1) / profile.window_s / dt**2
    assert np.abs(acc).max() <= acceleration * (1 + 1e-6) + 10 * noise
    # jerk over steps of 40 samples, where rounding no longer matters
    step = 40
    coarse = np.diff(position[::step], 3) / (step * dt) ** 3
    assert np.abs(coarse).max() <= jerk * (1 + 1e-3) + noise / dt
    middle = 0.5 * (position[1:] + position[:-1])
    cell = np.clip(np.searchsorted(lengths, middle, side="right") - 1, 0, count - 1)
    inside = (position[:-1] >= lengths[cell]) & (position[1:] <= lengths[cell + 1])
    assert np.all(speed[inside] <= np.array(limits)[cell[inside]] * (1 + 1e-6) + 1e-7)
    np.testing.assert_allclose(profile.speed(times[1:] - dt / 2), speed, atol=1e-4)


@given(st.floats(0.05, 20), st.integers(1, 400), st.floats(0.1, 1))
def test_times_and_positions_are_inverse(length, cells, speed):
    lengths = np.linspace(0.0, length, cells + 1)
    profile = plan_speed(lengths, np.full(cells, speed), 0.6, 3.0)
    at = np.union1d(lengths, np.linspace(0.0, length, 17))
    np.testing.assert_allclose(profile.position(profile.time_at(at)), at, atol=1e-9)


def test_a_long_straight_leg_reaches_full_speed_and_takes_the_least_time():
    path = make_path([(0, 0), (10, 0)])
    trajectory = time_path(path, LIMITS)
    window = 2 * LIMITS.acceleration / LIMITS.jerk
    least = 10 / LIMITS.speed + LIMITS.speed / LIMITS.acceleration + window
    assert trajectory.duration_s == pytest.approx(least, rel=1e-3)
    assert max(w.speed for w in trajectory.waypoints) == pytest.approx(LIMITS.speed)


def test_narrow_places_slow_the_robot_down_to_the_slow_speed():
    points = [(x / 10, 0) for x in range(101)]
    clearance = np.minimum(1.0, RADIUS + np.abs(np.linspace(-5, 5, 101)) * 0.3)
    waypoints = time_path(make_path(points, clearance), LIMITS).waypoints
    near = [w.speed for w in waypoints if abs(w.x - 5) < 0.02]
    assert max(near) <= LIMITS.slow_speed * 1.1
    assert max(w.speed for w in waypoints) > 0.45


def test_a_clearance_callable_slows_the_robot_between_the_points_of_the_path():
    path = make_path([(0, 0), (10, 0)])

    def clearance(points):
        return np.maximum(np.abs(points[:, 0] - 5), RADIUS)

    free, slowed = (time_path(path, LIMITS, clearance=c) for c in (None, clearance))
    assert slowed.duration_s > free.duration_s + 0.5
    for w in slowed.waypoints:
        room = (abs(w.x - 5) - RADIUS) / (LIMITS.slow_clearance - RADIUS)
        allowed = LIMITS.slow_speed + (LIMITS.speed - LIMITS.slow_speed) * min(max(room, 0), 1)
        assert w.speed <= allowed + 0.06


def test_a_sharp_corner_is_turned_on_the_spot():
    waypoints = time_path(make_path([(0, 0), (2, 0), (2, 2)]), LIMITS).waypoints
    at_corner = [w for w in waypoints if (w.x, w.y) == (2.0, 0.0)]
    assert [w.speed for w in at_corner] == [0.0, 0.0]
    assert [w.heading_rad for w in at_corner] == pytest.approx([0.0, math.pi / 2])
    turn = at_corner[1].time_s - at_corner[0].time_s
    assert turn == pytest.approx(turning_time(math.pi / 2, 1.5, 4.0))


def test_a_robot_that_cannot_turn_on_the_spot_takes_the_corner_slowly():
    limits = replace(LIMITS, turns_on_spot=False)
    trajectory = time_path(make_path([(0, 0), (2, 0), (2, 2)]), limits)
    check_bounds(trajectory, limits)
    assert all(w.speed > 0 for w in trajectory.waypoints[1:-1])


def test_a_finely_sampled_circle_is_driven_without_a_stop():
    angle = np.linspace(0, math.pi, 200)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    trajectory = time_path(make_path(points, RADIUS + 0.02), replace(LIMITS, slow_speed=0.5))
    check_bounds(trajectory, LIMITS)
    assert all(w.speed > 0 for w in trajectory.waypoints[1:-1])
    assert max(w.speed for w in trajectory.waypoints) == pytest.approx(0.5, rel=0.01)


def test_a_path_without_clearance_to_spare_keeps_all_its_vertices():
    angle = np.linspace(0, 1, 50)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    waypoints = time_path(make_path(points, RADIUS), LIMITS).waypoints
    places = {(w.x, w.y) for w in waypoints}
    assert all(tuple(p) in places for p in points)


@given(heading, heading)
def test_start_and_goal_headings_are_reached_standing(first, last):
    path = make_path([(0, 0), (1, 0)], headings=(first, last))
    waypoints = time_path(path, LIMITS).waypoints
    assert waypoints[0].station == 0
    assert waypoints[-1].station == 1
    expected = (first if first is not None else 0.0, last if last is not None else 0.0)
    for waypoint, wanted in zip((waypoints[0], waypoints[-1]), expected, strict=True):
        assert abs(wrap_angle(waypoint.heading_rad - wanted)) <= 1e-6
        assert waypoint.speed == 0.0
        assert -math.pi < waypoint.heading_rad <= math.pi


def test_stations_are_passed_or_dwelt_at_as_asked():
    points = [(0, 0), (1, 0), (2, 0), (3, 0)]
    path = make_path(points, stations=(0, 1, 2, 3), headings=(None, None, math.pi / 2, None))
    trajectory = time_path(path, LIMITS, dwell_s=(0.5, 0, 2.0, 1.0))
    check_bounds(trajectory, LIMITS)
    stations = {w.station: w for w in trajectory.waypoints if w.station is not None}
    assert list(stations) == [0, 1, 2, 3]
    assert [w.dwell_s for w in stations.values()] == [0.5, 0, 2.0, 1.0]
    assert stations[1].speed > 0.0
    assert (stations[2].speed, stations[2].heading_rad) == (0.0, math.pi / 2)
    assert trajectory.duration_s == pytest.approx(stations[3].time_s + 1.0)
    assert trajectory.waypoints[1].time_s > 0.5


@pytest.mark.parametrize("stations", [(0, 0), (0, 0, 0), (0, 0, 1, 1), (0, 1, 1, 1)])
def test_stations_on_one_spot_are_all_reported_in_order(stations):
    points = [(1.0, 1.0), (2.0, 1.0)][: max(stations) + 1]
    trajectory = time_path(make_path(points, stations=stations), LIMITS)
    found = [w.station for w in trajectory.waypoints if w.station is not None]
    assert found == list(range(len(stations)))
    check_bounds(trajectory, LIMITS)


def test_repeated_points_change_nothing():
    once = time_path(make_path([(0, 0), (1, 0), (1, 1)]), LIMITS)
    twice = time_path(make_path([(0, 0), (0, 0), (1, 0), (1, 0), (1, 1), (1, 1)]), LIMITS)
    assert once == twice


@given(st.floats(-math.pi, math.pi), st.floats(-5, 5))
def test_turning_and_moving_the_path_does_not_change_the_times(angle, shift):
    points = np.array([(0, 0), (1, 0.2), (1.5, 1), (2, 1)])
    c, s = math.cos(angle), math.sin(angle)
    moved = points @ np.array([[c, s], [-s, c]]) + shift
    a = time_path(make_path(points), LIMITS)
    b = time_path(make_path(moved), LIMITS)
    assert b.duration_s == pytest.approx(a.duration_s, rel=1e-6)


@pytest.mark.parametrize("field", [f for f in Limits.__slots__ if not f.startswith("turn")])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_limits_must_be_positive_and_finite(field, value):
    with pytest.raises(TrajectoryError, match=rf"limits\.{field} = "):
        time_path(make_path([(0, 0), (1, 0)]), replace(LIMITS, **{field: value}))


def test_other_bad_requests_are_refused():
    path = make_path([(0, 0), (1, 0)])
    with pytest.raises(TrajectoryError, match="3 dwells for 2 stations"):
        time_path(path, LIMITS, dwell_s=(1, 2, 3))
    with pytest.raises(TrajectoryError, match="must be >= 0"):
        time_path(path, LIMITS, dwell_s=(0, math.nan))
    with pytest.raises(TrajectoryError, match="more than 1000000 waypoints"):
        time_path(path, replace(LIMITS, spacing=1e-9))
    turned = make_path([(0, 0), (1, 0)], headings=(None, 1.0))
    with pytest.raises(TrajectoryError, match="cannot turn on the spot"):
        time_path(turned, replace(LIMITS, turns_on_spot=False))
    with pytest.raises(TrajectoryError, match="must be > 0"):
        default_limits(-1.0)


def test_default_limits_scale_with_the_robot():
    small = time_path(make_path([(0, 0), (1, 0), (1, 1)]), default_limits(0.1))
    large_path = make_path([(0, 0), (1000, 0), (1000, 1000)], 1000.0, radius=100.0)
    large = time_path(large_path, default_limits(100.0))
    assert large.duration_s == pytest.approx(small.duration_s, rel=1e-9)


def test_an_angle_a_hair_beyond_half_a_turn_is_brought_into_the_range() -> None:
    """The difference to pi was rounded to a whole turn, and the heading to -pi."""
    for angle in (-math.pi, math.nextafter(-math.pi, 0.0), math.nextafter(math.pi, 4.0), math.pi):
        for turns in range(-3, 4):
            assert -math.pi < wrap_angle(angle + turns * math.tau) <= math.pi
            (wrapped,) = wrap_angle(np.array([angle + turns * math.tau]))
            assert -math.pi < wrapped <= math.pi

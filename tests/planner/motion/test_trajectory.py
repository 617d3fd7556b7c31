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
from planner.motion.stops_and_bends import Track, speed_cells, wrap_angle, wrap_angles
from planner.motion.trajectory import TrajectoryError, default_limits, time_path, turning_time
from planner.path import Limits, Path, Trajectory

RADIUS = 0.1
LIMITS = Limits(
    speed=0.5,
    acceleration=0.6,
    lateral_acceleration=0.4,
    angular_rate_rad_s=1.5,
    angular_acceleration_rad_s2=4.0,
    jerk=3.0,
    spacing=0.2,
    chord_tolerance=0.005,
    slow_clearance=0.3,
    slow_speed=0.1,
)


def make_path(points, clearance=1.0, stations=None, headings=None, radius=RADIUS) -> Path:
    points = np.array(points, dtype=float).reshape(-1, 2)
    clearances = np.broadcast_to(np.asarray(clearance, dtype=float), len(points)).copy()
    stations = stations or (0, len(points) - 1)
    return Path(
        points=points,
        clearances=clearances,
        length=float(np.hypot(*np.diff(points, axis=0).T).sum()),
        min_clearance=float(clearances.min()),
        min_clearance_at=tuple(points[int(clearances.argmin())]),
        robot_radius=radius,
        stations=stations,
        headings_rad=headings or (None,) * len(stations),
        order=tuple(range(len(stations) - 2)),
    )


def distance_to_polyline(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    best = np.full(len(points), np.inf)
    for a, b in pairwise(line):
        d = b - a
        squared = float(d @ d)
        t = np.clip((points - a) @ d / squared, 0, 1) if squared > 0 else np.zeros(len(points))
        best = np.minimum(best, np.hypot(*(points - a - t[:, None] * d).T))
    return best


def check_bounds(trajectory: Trajectory, limits: Limits) -> None:
    """Mean values between waypoints never exceed the limits of what they average."""
    at_rest = (trajectory.waypoints[0].speed, trajectory.waypoints[-1].speed)
    assert at_rest == (0.0, 0.0)
    for a, b in pairwise(trajectory.waypoints):
        dt = b.time_s - a.time_s - a.dwell_s
        way = math.dist((a.x, a.y), (b.x, b.y))
        turn = abs(wrap_angle(b.heading_rad - a.heading_rad))
        assert dt >= 0.0
        if way > 0.0 or turn > 1e-5:
            assert dt > 0.0
        tight = 1.0 + 1e-6
        assert way <= limits.speed * dt * tight + 1e-9
        assert max(a.speed, b.speed) <= limits.speed * tight
        assert abs(b.speed - a.speed) <= limits.acceleration * dt * tight + 1e-9
        assert turn <= limits.angular_rate_rad_s * dt * tight + 1e-6
        if way > 0.0 and dt > 0.0:
            # the mean of v omega over the stretch: no more than the lateral limit
            assert turn / dt * way / dt <= limits.lateral_acceleration * 1.3 + 1e-6
        else:
            assert way == 0.0


coordinate = st.integers(-40, 40).map(lambda k: k / 10)
polylines = st.lists(st.tuples(coordinate, coordinate), min_size=2, max_size=9)
heading = st.none() | st.floats(-math.pi, math.pi)


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


def _driven(path: Path, limits: Limits, clearance=None):
    """Each leg as it is driven: times, lengths along it, and the heading there, densely."""
    track = Track(path, limits, clearance, (0.0,) * len(path.stations))
    for leg in track.legs():
        if not len(leg.lengths):
            continue
        nodes = speed_cells(leg, limits.spacing)
        speed, gentle = track.speed_limits(leg, nodes)
        profile = plan_speed(nodes, speed, limits.acceleration, limits.jerk, gentle)
        times = np.linspace(0.0, profile.duration_s, 40_001)
        lengths = profile.position(times)
        yield times, lengths, leg.headings(lengths)


def _check_motion(path: Path, limits: Limits) -> None:
    """Differences of what is driven, over steps at which rounding no longer matters."""
    for times, lengths, heading in _driven(path, limits):
        step = 20
        dt = float(times[1]) * step
        s, h = lengths[::step], heading[::step]
        speed, rate = np.diff(s) / dt, np.diff(h) / dt
        acceleration, spin, jerk = np.diff(speed) / dt, np.diff(rate) / dt, np.diff(s, 3) / dt**3
        tiny = 1e-12 * max(1.0, float(s[-1]), float(np.abs(h).max()))
        assert speed.max() <= limits.speed * (1 + 1e-6) + tiny / dt
        assert np.abs(acceleration).max() <= limits.acceleration * (1 + 1e-6) + tiny / dt**2
        assert np.abs(jerk).max() <= limits.jerk * (1 + 1e-3) + 8 * tiny / dt**3
        assert np.abs(rate).max() <= limits.angular_rate_rad_s * (1 + 1e-6) + tiny / dt
        grip = limits.lateral_acceleration
        assert np.abs(rate * speed).max() <= grip * (1 + 1e-3) + tiny / dt
        most = limits.angular_acceleration_rad_s2
        assert np.abs(spin).max() <= most * (1 + 1e-3) + 4 * tiny / dt**2


def _arc(radius: float, sweep: float, count: int) -> np.ndarray:
    a = np.linspace(0.0, sweep, count)
    return radius * np.c_[np.sin(a), 1.0 - np.cos(a)]


def _bends() -> dict[str, np.ndarray]:
    line = np.array([[-2.0, 0.0]])
    s_bend = np.concatenate([line, _arc(0.7, 2.0, 60)])
    a = s_bend[-1]
    c, s = math.cos(2.0), math.sin(2.0)
    back = _arc(0.5, 2.2, 50) * (1.0, -1.0) @ np.array([[c, s], [-s, c]]) + a
    return {
        "corner": np.array([(0, 0), (2, 0), (2, 2)]),
        "gentle corner": np.array([(0, 0), (2, 0), (4, 0.4)]),
        "arc": _arc(1.0, 3.0, 200),
        "coarse arc": _arc(1.0, 3.0, 20),
        "tight arc": _arc(0.3, 3.0, 60),
        "line into arc": np.concatenate([line, _arc(0.6, 3.0, 90)]),
        "S": np.concatenate([s_bend, back[1:]]),
        "zigzag": np.array([(i * 0.6, 0.25 * (i % 2)) for i in range(9)]),
    }


@pytest.mark.parametrize("spin", [0.6, 4.0])
@pytest.mark.parametrize("on_spot", [True, False])
@pytest.mark.parametrize("name", list(_bends()))
def test_rates_and_accelerations_keep_their_limits_at_every_moment(name, on_spot, spin):
    limits = replace(LIMITS, turns_on_spot=on_spot, angular_acceleration_rad_s2=spin)
    for clearance in (1.0, RADIUS + 0.05):
        _check_motion(make_path(_bends()[name], clearance), limits)


@settings(max_examples=60, deadline=None)
@given(polylines, st.booleans(), st.floats(0.5, 6.0), st.floats(0.1, 1.0))
def test_no_polyline_makes_the_robot_break_its_limits(points, on_spot, spin, clearance):
    limits = replace(LIMITS, turns_on_spot=on_spot, angular_acceleration_rad_s2=spin)
    _check_motion(make_path(points, clearance), limits)


def test_a_bend_is_entered_slower_where_the_robot_is_slow_to_turn():
    path = make_path(np.concatenate([[(-3.0, 0.0)], _arc(0.8, 3.0, 100)]))
    times = [
        time_path(path, replace(LIMITS, angular_acceleration_rad_s2=a)).duration_s
        for a in (100.0, 4.0, 0.5)
    ]
    assert times[0] <= times[1] < times[2]


def test_headings_turn_by_as_much_as_the_path_and_end_in_its_direction():
    for points in _bends().values():
        for _, _, heading in _driven(make_path(points), replace(LIMITS, turns_on_spot=False)):
            ends = np.diff(points[[0, 1, -2, -1]], axis=0)[[0, 2]]
            wanted = np.arctan2(ends[:, 1], ends[:, 0])
            assert wrap_angle(heading[0] - wanted[0]) == pytest.approx(0.0, abs=0.06)
            assert wrap_angle(heading[-1] - wanted[1]) == pytest.approx(0.0, abs=0.06)


def _tightest(path: Path, limits: Limits) -> float:
    """The least radius that is driven: way over turn, between moments that are close."""
    least = math.inf
    for _, lengths, heading in _driven(path, limits):
        turn, way = np.abs(np.diff(heading[::40])), np.diff(lengths[::40])
        moving = way > 1e-6
        least = min(least, float((way[moving] / np.maximum(turn[moving], 1e-12)).min()))
    return least


@pytest.mark.parametrize("name", list(_bends()))
def test_no_bend_is_tighter_than_the_turning_radius(name):
    path = make_path(_bends()[name])
    free = _tightest(path, LIMITS)
    for radius in (0.3, 0.65, 3.0):
        limits = replace(LIMITS, turning_radius=radius)
        assert _tightest(path, limits) >= radius * (1 - 1e-3)
        check_bounds(time_path(path, limits), limits)
        if free > radius * 1.01:
            assert time_path(path, limits) == time_path(path, LIMITS)


def test_a_bend_that_is_wide_enough_is_driven_without_a_stop():
    path = make_path(_arc(1.0, 3.0, 200))
    trajectory = time_path(path, replace(LIMITS, turning_radius=0.95))
    assert all(w.speed > 0 for w in trajectory.waypoints[1:-1])


def test_a_robot_that_can_neither_bend_nor_turn_is_told_where():
    limits = replace(LIMITS, turns_on_spot=False, turning_radius=0.5)
    with pytest.raises(
        TrajectoryError, match=r"at \(1\.999\d*, 0\) the path bends with a .* 0\.01"
    ):
        time_path(make_path([(0, 0), (2, 0), (2, 2)]), limits)
    wide = make_path(_arc(1.0, 3.0, 200))
    assert time_path(wide, limits).duration_s > 0.0


@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_the_turning_radius_must_be_finite_and_not_negative(value):
    with pytest.raises(TrajectoryError, match=r"limits\.turning_radius = "):
        time_path(make_path([(0, 0), (1, 0)]), replace(LIMITS, turning_radius=value))


def test_an_angle_a_hair_beyond_half_a_turn_is_brought_into_the_range() -> None:
    """The difference to pi was rounded to a whole turn, and the heading to -pi."""
    for angle in (-math.pi, math.nextafter(-math.pi, 0.0), math.nextafter(math.pi, 4.0), math.pi):
        for turns in range(-3, 4):
            assert -math.pi < wrap_angle(angle + turns * math.tau) <= math.pi
            (wrapped,) = wrap_angles(np.array([angle + turns * math.tau]))
            assert -math.pi < wrapped <= math.pi

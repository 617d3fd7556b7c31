"""Rates, accelerations and bends keep their limits at every moment, not at waypoints only."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.motion.speed_profile import plan_speed
from planner.motion.stops_and_bends import CutPath, speed_cells
from planner.motion.trajectory import TrajectoryError, time_path
from planner.path import Limits, Path
from planner.shared.angles import wrap_angle
from tests.planner.motion.trajectories import (
    LIMITS,
    RADIUS,
    check_bounds,
    make_path,
    polylines,
)


def _driven(path: Path, limits: Limits, clearance=None):
    """Each leg as it is driven: times, lengths along it, and the heading there, densely."""
    track = CutPath(path, limits, clearance, (0.0,) * len(path.stations))
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

"""Limits, paths and lines for the tests of motion, and the check of what waypoints say."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from planner.motion.stops_and_bends import wrap_angle
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

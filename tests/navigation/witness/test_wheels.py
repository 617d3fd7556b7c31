"""The wheels' motion at a time, against interpolation between the reports by NumPy."""

from __future__ import annotations

import numpy as np

from navigation.witness.wheels import SPEED_LAG_S, WheelTrack
from tests.support.robots.moving_robot import status


def driven() -> tuple[WheelTrack, np.ndarray, np.ndarray]:
    """A robot that gets faster and turns, its reports' times and way by trapezoids."""
    times_s = np.arange(0.0, 3.0, 0.05)
    speeds = 0.1 * times_s
    track = WheelTrack()
    for time_s, speed_m_s in zip(times_s, speeds, strict=True):
        track.see(status(time_s, speed_m_s, 0.5), time_s)
    ways_m = np.concatenate([[0.0], np.cumsum((speeds[1:] + speeds[:-1]) / 2.0 * 0.05)])
    return track, times_s - SPEED_LAG_S, ways_m


def test_the_motion_at_a_time_lies_between_the_reports_around_it() -> None:
    track, knots_s, ways_m = driven()
    for time_s in np.random.default_rng(1).uniform(knots_s[0], knots_s[-1], 200):
        motion = track.at(time_s)
        assert motion is not None
        assert abs(motion.way_m - np.interp(time_s, knots_s, ways_m)) < 1e-9
        assert abs(motion.turn_rad - 0.5 * (time_s - knots_s[0])) < 1e-9


def test_the_motion_at_a_report_is_the_reports() -> None:
    track, _, ways_m = driven()
    for time_s, way_m in ((track.oldest_s, ways_m[0]), (track.newest_s, ways_m[-1])):
        motion = track.at(time_s)
        assert motion is not None
        assert abs(motion.way_m - way_m) < 1e-9


def test_nothing_is_known_before_the_first_report_and_after_the_last() -> None:
    track, _, _ = driven()
    assert track.at(track.oldest_s - 1e-6) is None
    assert track.at(track.newest_s + 1e-6) is None
    assert WheelTrack().at(0.0) is None


def test_ways_at_many_times_are_those_at_each() -> None:
    track, knots_s, _ = driven()
    times_s = np.linspace(knots_s[0], track.newest_s, 50)
    ways_m, turns_rad = track.ways_at(times_s)
    for i, time_s in enumerate(times_s):
        motion = track.at(time_s)
        assert motion is not None
        assert (motion.way_m, motion.turn_rad) == (ways_m[i], turns_rad[i])

"""The gate and the velocity filter, against motions that are known exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vision.markers.tracking import MarkerTrack, Pose, TrackLimits, wrap


def circle(time_s: float, speed: float = 0.4, radius: float = 0.5) -> Pose:
    angle = speed * time_s / radius
    return radius * math.cos(angle), radius * math.sin(angle), wrap(angle + math.pi / 2.0)


def test_a_first_sighting_is_not_believed_before_a_second() -> None:
    track = MarkerTrack(TrackLimits())
    assert track.offer((0.0, 0.0, 0.0), 0.0) is None
    assert track.offer((0.001, 0.0, 0.0), 0.033) is not None


def test_two_ghosts_far_apart_never_make_a_track() -> None:
    track = MarkerTrack(TrackLimits())
    for i in range(20):
        assert track.offer((float(i % 2), 0.0, 0.0), i * 0.033) is None


@pytest.mark.parametrize("noise_m", [0.0, 0.0003])
def test_the_velocity_follows_a_circle(noise_m: float) -> None:
    rng = np.random.default_rng(1)
    track = MarkerTrack(TrackLimits())
    worst = turn = 0.0
    for i in range(300):
        time_s = i / 30.0
        x, y, heading = circle(time_s)
        dx, dy = rng.normal(0.0, noise_m, 2) if noise_m else (0.0, 0.0)
        velocity = track.offer((x + dx, y + dy, heading), time_s)
        if velocity is not None and i > 30:
            vx, vy = 0.4 * math.cos(heading), 0.4 * math.sin(heading)
            worst = max(worst, math.hypot(velocity.vx - vx, velocity.vy - vy))
            turn = max(turn, abs(velocity.turn_rate_rad_s - 0.8))
    assert worst < 0.04
    assert turn < 0.02


@given(st.floats(-3.0, 3.0), st.floats(-1.0, 1.0))
def test_turning_the_arena_turns_the_velocity(angle: float, speed: float) -> None:
    plain, turned = MarkerTrack(TrackLimits()), MarkerTrack(TrackLimits())
    c, s = math.cos(angle), math.sin(angle)
    for i in range(12):
        x, y, heading = speed * i / 30.0, 0.3 * i / 30.0, 0.1 * i
        a = plain.offer((x, y, heading), i / 30.0)
        b = turned.offer((c * x - s * y, s * x + c * y, wrap(heading + angle)), i / 30.0)
        assert (a is None) == (b is None)
        if a is not None and b is not None:
            assert b.vx == pytest.approx(c * a.vx - s * a.vy, abs=1e-9)
            assert b.vy == pytest.approx(s * a.vx + c * a.vy, abs=1e-9)
            assert b.turn_rate_rad_s == pytest.approx(a.turn_rate_rad_s, abs=1e-6)


def running_track(frames: int = 10) -> MarkerTrack:
    track = MarkerTrack(TrackLimits())
    for i in range(frames):
        track.offer((0.01 * i, 0.0, 0.0), i / 30.0)
    return track


def test_an_impossible_jump_is_refused_and_the_track_goes_on() -> None:
    track = running_track()
    assert track.offer((1.5, 1.0, 0.0), 10 / 30.0) is None
    assert track.refused == 1
    assert track.offer((0.11, 0.0, 0.0), 11 / 30.0) is not None
    assert track.refused == 0


def test_an_impossible_turn_is_refused() -> None:
    assert running_track().offer((0.1, 0.0, math.pi), 10 / 30.0) is None


def test_a_robot_that_was_carried_is_believed_at_its_new_place() -> None:
    track = running_track()
    assert track.offer((1.5, 1.0, 2.0), 10 / 30.0) is None
    velocity = track.offer((1.5, 1.0, 2.0), 11 / 30.0)
    assert velocity is not None
    assert (velocity.vx, velocity.vy) == (0.0, 0.0)
    assert track.predict(11 / 30.0) == pytest.approx((1.5, 1.0, 2.0))


def test_after_a_long_absence_a_robot_is_confirmed_again() -> None:
    track = running_track()
    assert track.predict(5.0) is None
    assert track.offer((0.1, 0.0, 0.0), 5.0) is None
    assert track.offer((0.1, 0.0, 0.0), 5.033) is not None


def test_a_sighting_from_the_past_is_refused() -> None:
    track = running_track()
    assert track.offer((0.05, 0.0, 0.0), 0.1) is None
    assert track.offer((0.09, 0.0, 0.0), 9 / 30.0) is None


def test_the_prediction_runs_on_with_the_velocity() -> None:
    track = running_track(40)
    predicted = track.predict(39 / 30.0 + 0.1)
    assert predicted is not None
    assert predicted[0] == pytest.approx(0.39 + 0.03, abs=1e-3)


@given(st.floats(-1e4, 1e4))
def test_wrapped_angles_are_the_same_direction_in_the_half_open_range(angle: float) -> None:
    turned = wrap(angle)
    assert -math.pi < turned <= math.pi
    assert math.cos(turned) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(turned) == pytest.approx(math.sin(angle), abs=1e-9)

"""When two discs on straight lines touch: the closed forms against sampling."""

from __future__ import annotations

import math

import numpy as np
import pytest

from planner.fleet.motions.motion_kernels import do_steps_touch, forbidden_delays, near_times
from planner.fleet.motions.track_kernels import least_distance
from tests.support.oracles.fleet_judge import closest_approach


@pytest.mark.parametrize("case", range(60))
def test_forbidden_delays_are_those_of_a_sampled_plane(case: int) -> None:
    rng = np.random.default_rng(case)
    place = rng.uniform(-2.0, 2.0, 2) - rng.uniform(-2.0, 2.0, 2)
    angle, other = rng.uniform(0.0, 2.0 * np.pi, 2)
    if case % 4 == 0:
        other = angle
    if case % 4 == 1:
        other = angle + math.pi
    lasts, takes = rng.uniform(0.1, 4.0, 2)
    gap = rng.uniform(0.1, 1.5)
    v = np.array([math.cos(angle), math.sin(angle)])
    w = np.array([math.cos(other), math.sin(other)]) * (case % 7 != 0)
    low, high = forbidden_delays(*place, (*v, lasts), (*w, takes), gap)
    s, t = np.meshgrid(np.linspace(0.0, lasts, 401), np.linspace(0.0, takes, 401))
    x, y = place[0] + s * v[0] - t * w[0], place[1] + s * v[1] - t * w[1]
    near = np.hypot(x, y) < gap
    if not near.any():
        assert low > high or high - low < 0.05
        return
    delays = (t - s)[near]
    assert low <= delays.min() + 1e-9
    assert high >= delays.max() - 1e-9
    assert delays.min() - low < 0.08
    assert high - delays.max() < 0.08


def test_a_standing_disc_is_near_always_or_never() -> None:
    assert near_times(0.5, 0.0, 0.0, 0.0, 3.0, 1.0) == (0.0, 3.0)
    begin, end = near_times(1.0, 0.0, 0.0, 0.0, 3.0, 1.0)
    assert begin > end


def test_two_that_begin_together_may_touch_for_an_instant() -> None:
    still = (0.0, 0.0, 0.0, 0.0, 0.0)
    assert not do_steps_touch(still, (-2.0, 1.0, 1.0, 0.0, 4.0), 1.0)
    assert do_steps_touch(still, (-2.0, 0.99, 1.0, 0.0, 4.0), 1.0)
    # the first to arrive stands in the way of the one that comes later
    assert do_steps_touch((0.0, 0.0, 1.0, 0.0, 1.0), (5.0, 0.0, -1.0, 0.0, 3.5), 1.0)


@pytest.mark.parametrize("case", range(30))
def test_closest_approach_of_tracks_is_that_of_the_judge(case: int) -> None:
    rng = np.random.default_rng(case)
    tracks = []
    for _ in range(2):
        rows = int(rng.integers(1, 7))
        times = np.concatenate([[0.0], np.cumsum(rng.choice([0.0, 0.7, 1.3], rows - 1))])
        xy = np.repeat(rng.uniform(0.0, 3.0, (rows, 2)), 1, axis=0)
        xy[1:][np.diff(times) == 0.0] = xy[0]
        still = np.flatnonzero(np.diff(times) == 0.0) + 1
        for k in still:
            xy[k] = xy[k - 1]
        tracks.append(np.column_stack([times, xy]))
    found, _ = least_distance(*tracks)
    assert found == pytest.approx(closest_approach(*tracks), abs=1e-12)

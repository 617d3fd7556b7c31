"""The sequential test: what moves is noticed in time, what trembles never."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vision.watch.drift import DRIFT_THRESHOLD, REACTION_S, DriftTest, of_most, step_limit

LIMIT_PX = 2.0
RATE_HZ = 30.0


def run(away_px: list[float], rate_hz: float = RATE_HZ) -> tuple[DriftTest, list[bool]]:
    test, fired = DriftTest(1, LIMIT_PX), []
    for i, away in enumerate(away_px):
        test.update(np.array([away]), 1.0 / rate_hz, i / rate_hz)
        fired.append(bool(test.moved[0]))
    return test, fired


@pytest.mark.parametrize("rate_hz", [5.0, 15.0, 30.0, 60.0])
@pytest.mark.parametrize("away_px", [3.0, 8.0, math.inf])
def test_three_pixels_are_noticed_within_a_second_and_not_by_one_picture(
    away_px: float, rate_hz: float
) -> None:
    quiet = round(rate_hz)
    test, fired = run([0.05] * quiet + [away_px] * round(rate_hz), rate_hz)
    began_s, noticed_s = quiet / rate_hz, fired.index(True) / rate_hz
    assert noticed_s - began_s < 1.0 - 1.0 / rate_hz
    assert sum(fired[: quiet + 1]) == 0
    assert test.since_s[0] == pytest.approx(began_s)


@pytest.mark.parametrize("mean_px", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("noise_px", [0.02, 0.1, 0.25])
@pytest.mark.parametrize("rate_hz", [10.0, 30.0, 60.0])
def test_the_bound_on_false_alarms_holds_for_the_steps_as_they_are_cut(
    mean_px: float, noise_px: float, rate_hz: float
) -> None:
    """Lorden's bound needs a mean of exp(step) of at most 1 while nothing has moved.

    The step is read off the test itself: from the middle of its range, where it is not cut.
    """
    x = np.linspace(mean_px - 8 * noise_px, mean_px + 8 * noise_px, 4001)
    test = DriftTest(len(x), LIMIT_PX)
    test.sums[:] = DRIFT_THRESHOLD / 2
    test.update(x, 1.0 / rate_hz, 0.0)
    steps = test.sums - DRIFT_THRESHOLD / 2
    assert np.abs(steps).max() <= step_limit(1.0 / rate_hz) + 1e-12
    density = np.exp(-0.5 * ((x - mean_px) / noise_px) ** 2)
    assert float((np.exp(steps) * density).sum() / density.sum()) <= 1.0


def test_ten_minutes_of_noise_at_the_edge_of_what_is_allowed_raise_no_alarm() -> None:
    rng = np.random.default_rng(5)
    test = DriftTest(50, LIMIT_PX)
    for i in range(360):  # 50 cameras side by side, 12 s each
        test.update(np.abs(rng.normal(LIMIT_PX / 2, 0.25, 50)), 1 / RATE_HZ, i / RATE_HZ)
        assert not test.moved.any()


def test_a_flash_is_no_knock_and_shaking_is_none() -> None:
    _, fired = run([0.0] * 30 + [math.inf] * 5 + [0.0] * 30)
    assert not any(fired)
    shaking = [abs(2.0 * math.sin(2 * math.pi * 7.0 * i / RATE_HZ)) for i in range(900)]
    assert not any(run(shaking)[1])


def test_what_says_nothing_changes_nothing() -> None:
    test, _ = run([3.0] * 6)
    before = test.sums.copy()
    test.update(np.array([math.nan]), 1 / RATE_HZ, 1.0)
    assert test.sums == before


def test_it_ends_when_all_is_back_and_not_before() -> None:
    _, fired = run([3.0] * 60 + [1.8] * 60 + [0.1] * 60)
    assert all(fired[30:120])
    back = fired[120:].index(False) / RATE_HZ
    assert REACTION_S * 0.9 < back < 2 * REACTION_S


def test_a_slow_creep_is_noticed_before_it_is_three_pixels() -> None:
    """0.1 px a second: the reference never creeps along."""
    away = [0.1 * i / RATE_HZ for i in range(900)]
    _, fired = run(away)
    assert LIMIT_PX / 2 < away[fired.index(True)] <= LIMIT_PX


@given(
    st.lists(st.floats(0.0, 0.5), min_size=3, max_size=20),
    st.lists(st.floats(5.0, 1e6), max_size=20),
)
def test_fewer_than_half_of_the_points_move_nothing_and_more_do(
    still: list[float], moved: list[float]
) -> None:
    most = of_most(np.array(still + moved))
    if 2 * len(moved) <= len(still) + len(moved):
        assert most <= 0.5
    else:
        assert most >= 5.0

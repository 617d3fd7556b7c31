"""Where a robot has been: every row, or one every so far, in a buffer that never grows."""

from __future__ import annotations

import numpy as np

from navigation.track import Track


def test_a_full_buffer_keeps_the_newest_rows_in_their_order() -> None:
    track = Track(3)
    for n in range(5):
        track.add(float(n), 0.1 * n, 0.0, 0.0)
    np.testing.assert_array_equal(track.rows()[:, 0], [2.0, 3.0, 4.0])


def test_with_a_least_step_rows_lie_that_far_apart_and_the_last_is_the_newest() -> None:
    track = Track(100, least_m=0.01)
    steps_m = np.cumsum(np.full(200, 0.003))
    for n, x_m in enumerate(steps_m):
        track.add(float(n), float(x_m), 0.0, 0.0)
    track.add(500.0, float(steps_m[-1]), 0.0, 1.5)
    rows = track.rows()
    gaps = np.diff(rows[:, 1])
    assert np.all(gaps[:-1] >= 0.01)
    assert gaps.max() < 0.014
    np.testing.assert_array_equal(rows[-1], [500.0, steps_m[-1], 0.0, 1.5])


def test_one_that_stands_takes_no_more_than_two_rows_in_a_full_buffer_too() -> None:
    track = Track(4, least_m=0.01)
    for n in range(6):
        track.add(float(n), float(n), 0.0, 0.0)
    for n in range(50):
        track.add(10.0 + n, 5.001, 0.0, 0.1 * n)
    np.testing.assert_array_equal(track.rows()[:, 1], [3.0, 4.0, 5.0, 5.001])
    assert track.rows()[-1, 0] == 59.0

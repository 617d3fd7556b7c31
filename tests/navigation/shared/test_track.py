"""Where a robot has been: every row, or one every so far, in a buffer that never grows."""

from __future__ import annotations

import numpy as np

from navigation.shared.track import Track, driven_pieces, is_jump, with_breaks


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


# What the robot drove, and what it did not.


def drive(x_m: float, since_s: float, seconds: float = 2.0, speed_m_s: float = 0.3) -> np.ndarray:
    """Thirty rows a second, along x from there."""
    times = np.arange(0.0, seconds, 1.0 / 30.0)
    noise = np.random.default_rng(1).normal(0.0, 0.001, (len(times), 2))
    return np.c_[since_s + times, x_m + speed_m_s * times + noise[:, 0], noise[:, 1], 0.0 * times]


def test_a_robot_that_drives_is_in_one_piece_though_pictures_are_missing() -> None:
    rows = drive(0.0, 0.0)
    (piece,) = driven_pieces(np.delete(rows, [*range(10, 20), 40, 41, 42], axis=0), 0.3)
    assert len(piece) == len(rows) - 13
    assert driven_pieces(np.empty((0, 4)), 0.3) == []


def test_one_that_is_seen_elsewhere_in_the_next_picture_has_jumped() -> None:
    rows = np.vstack([drive(0.0, 0.0), drive(1.0, 2.0)])
    one, other = driven_pieces(rows, 0.3)
    assert len(one) == len(other) == 60
    assert is_jump((0.0, 0.0, 0.0), (1.0 / 30.0, 0.0, 0.1), 0.3)
    assert not is_jump((0.0, 0.0, 0.0), (1.0 / 30.0, 0.0, 0.03), 0.3)


def test_what_lies_between_was_not_driven_where_nobody_saw_it() -> None:
    rows = np.vstack([drive(0.0, 0.0), drive(0.8, 20.0)])
    assert len(driven_pieces(rows, 0.3)) == 2
    stood = np.vstack([drive(0.0, 0.0), drive(0.6, 20.0)])
    assert len(driven_pieces(stood, 0.3)) == 1, "it stands where it stood"


def test_pieces_in_one_array_have_a_row_of_nan_between_them() -> None:
    pieces = [drive(0.0, 0.0), drive(1.0, 5.0), drive(2.0, 9.0)]
    rows = with_breaks(pieces)
    assert np.flatnonzero(np.isnan(rows[:, 0])).tolist() == [60, 121]
    np.testing.assert_array_equal(rows[~np.isnan(rows[:, 0])], np.vstack(pieces))
    assert with_breaks([]).shape == (0, 4)

"""Figures in sentences are short, true to half a digit, and never make two lengths look alike."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.shared.figures import at_most, placed, sized

lengths = st.floats(1e-9, 1e9)
any_lengths = st.floats(0.0, 1e300)


@pytest.mark.parametrize(
    ("length", "words"),
    [
        (0.0214886, "0.0215 m"),
        (0.3, "0.3 m"),
        (1234.56, "1235 m"),
        (0.0, "0 m"),
        (773.2, "773 m"),
        (-0.4, "-0.4 m"),
        (1e300, "1e+300 m"),
        (5.55e-17, "5.55e-17 m"),
        (-2e-9, "-2e-09 m"),
        (0.0000123, "0.0000123 m"),
    ],
)
def test_a_length_has_three_significant_digits_and_all_before_the_point(length, words):
    assert sized(length, "m") == words


@given(lengths)
def test_a_length_in_words_is_off_by_half_of_its_third_digit_at_most(length):
    assert math.isclose(float(sized(length)), length, rel_tol=5.1e-3)


@given(lengths, lengths)
def test_two_lengths_that_differ_look_different(one, other):
    assert (sized(one, beside=other) == sized(other, beside=one)) == (one == other)


def test_a_place_has_as_many_decimals_in_x_as_in_y():
    assert placed(1.5971, 1.2285) == "(1.6, 1.23)"
    assert placed(640.0, 3.456) == "(640, 3)"
    assert placed(-0.0001, 2.0) == "(0, 2)"


@given(lengths)
def test_what_is_at_most_a_length_does_not_look_longer(length):
    assert length * (1 - 1.01e-2) <= float(at_most(length)) <= length * (1 + 1e-5)


@given(any_lengths, any_lengths)
def test_no_figure_is_longer_than_its_digits_an_exponent_and_its_units(one, other):
    for words in (sized(one, "m"), at_most(one, "m")):
        assert len(words) <= len("1.23457e+300 m")
    assert len(sized(one, "m", beside=other)) <= len("-1.2345678901234567e+300 m")
    assert len(placed(one, -other)) <= len("(1.23457e+300, -1.23457e+300)")


@given(any_lengths)
def test_the_least_lengths_do_not_look_longer_either(length):
    assert float(at_most(length)) <= length * (1 + 1e-5)


def test_a_place_next_to_the_origin_is_written_with_exponents():
    assert placed(5.55e-17, 0.0) == "(5.55e-17, 0)"
    assert placed(5.55e-17, 2.0) == "(0, 2)"


def test_what_is_a_rounding_next_to_another_length_is_none():
    assert sized(5.55e-17, "m", beside=0.4) == "0 m"
    assert sized(5.55e-7, "m", beside=0.4) == "5.55e-07 m"

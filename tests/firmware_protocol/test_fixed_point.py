"""Whole-number geometry against floating point, and against the firmware's own."""

from __future__ import annotations

import ctypes
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.fixed_point import (
    Place,
    angle_of,
    between,
    heading_of,
    measured,
    root,
    scale,
    turned,
    wrapped,
)
from tests.support.c_robot import library, missing_tool

TURN = 2.0**32
ANGLE_ERROR = 3.1e-5 / math.tau * TURN
"""The last step of turning is atan(2**-15)."""
coordinates = st.integers(-(2**29), 2**29)
angles = st.integers(-(2**31), 2**31 - 1)
words = st.integers(-(2**31), 2**31 - 1)


@given(coordinates, coordinates)
def test_length_and_bearing_are_those_of_floating_point(x: int, y: int) -> None:
    length, bearing = measured(x, y)
    assert abs(length - math.hypot(x, y)) <= 1.0 + 3e-5 * math.hypot(x, y)
    if (x, y) != (0, 0):
        off = wrapped(bearing - round(math.atan2(y, x) / math.tau * TURN))
        assert abs(off) <= ANGLE_ERROR


@given(coordinates, coordinates, angles)
def test_a_turned_vector_is_that_of_floating_point(x: int, y: int, angle: int) -> None:
    c, s = math.cos(angle / TURN * math.tau), math.sin(angle / TURN * math.tau)
    got = turned(x, y, angle)
    allowed = 1.0 + 5e-5 * math.hypot(x, y)
    assert math.dist(got, (c * x - s * y, s * x + c * y)) <= allowed


@given(st.integers(-31416, 31416))
def test_a_heading_comes_back_from_its_binary_angle(heading: int) -> None:
    assert heading_of(angle_of(heading)) in (
        heading,
        -heading if abs(heading) == 31416 else heading,
    )
    assert abs(wrapped(angle_of(heading) - round(heading * 1e-4 / math.tau * TURN))) < 1000


def test_places_far_apart_are_as_far_as_numbers_go() -> None:
    far = 2**31 - 1
    assert between(Place(-far, far), Place(far, -far)) == (2**29, -(2**29))
    assert between(Place(1, 2), Place(4, -2)) == (3, -4)


@pytest.mark.skipif(missing_tool() is not None, reason="needs a C compiler")
class TestTheFirmware:
    """``fixed.c`` gives the same numbers."""

    @given(coordinates, coordinates, angles)
    @settings(max_examples=300)
    def test_measures_and_turns_alike(self, x: int, y: int, angle: int) -> None:
        vector = (ctypes.c_int32 * 3)(x, y, 0)
        library().cw_measure(vector)
        assert (vector[0], vector[2]) == measured(x, y)
        vector = (ctypes.c_int32 * 3)(x, y, angle)
        library().cw_turn(vector)
        assert (vector[0], vector[1]) == turned(x, y, angle)

    @given(words, st.integers(0, 0xFFFF))
    def test_scales_alike(self, number: int, part: int) -> None:
        assert library().cw_scale(ctypes.c_int32(number), ctypes.c_uint16(part)) == scale(
            number, part
        )

    @given(st.integers(0, 2**32 - 1))
    def test_takes_roots_alike(self, square: int) -> None:
        library().cw_root.restype = ctypes.c_uint16
        assert library().cw_root(ctypes.c_uint32(square)) == root(square)

    @given(words, st.integers(-31416, 31416))
    def test_converts_headings_alike(self, angle: int, heading: int) -> None:
        library().cw_heading_of.restype = ctypes.c_int16
        assert library().cw_heading_of(ctypes.c_int32(angle)) == heading_of(angle)
        assert library().cw_angle_of(ctypes.c_int16(heading)) == angle_of(heading)

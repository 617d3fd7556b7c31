"""Whole-number geometry against floating point, and against the firmware's own."""

from __future__ import annotations

import ctypes
import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.robot.clearway.fixed import (
    VECTOR,
    angle_of,
    aside,
    clip,
    heading_of,
    measure,
    part,
    root,
    scale,
    sine,
    turn,
    word,
)
from firmware_protocol.robot.clearway.waypoints import begin_leg
from tests.support.robots.c_robot import library, missing_tool

TURN = 2.0**16
ANGLE_ERROR = 7e-4 / math.tau * TURN
"""Of the arc tangent's polynomial; 0.04 degrees."""
SINE_ERROR = 1.6e-4
"""Of the sine's polynomial, in each of two directions, and an angle's resolution."""
coordinates = st.integers(-(2**30), 2**30)
angles = st.integers(0, 2**16 - 1)
words = st.integers(-(2**30), 2**30)


def measured(x: int, y: int) -> tuple[int, int]:
    """A vector's length and bearing."""
    VECTOR[0], VECTOR[1] = x, y
    bearing = measure()
    return VECTOR[0], bearing


def turned(x: int, y: int, angle: int) -> tuple[int, int]:
    """The vector turned by an angle."""
    VECTOR[0], VECTOR[1] = x, y
    turn(angle)
    return VECTOR[0], VECTOR[1]


def between(start: tuple[int, int], end: tuple[int, int]) -> tuple[int, int]:
    """The vector from one place to a waypoint at another."""
    begin_leg(bytearray(struct.pack("<ii", *end)), 0, *start)
    return VECTOR[0], VECTOR[1]


@given(coordinates, coordinates)
def test_length_and_bearing_are_those_of_floating_point(x: int, y: int) -> None:
    length, bearing = measured(x, y)
    assert abs(length - math.hypot(x, y)) <= 1.0 + SINE_ERROR * math.hypot(x, y)
    if abs(x) + abs(y) > 2000:
        assert aside(bearing - round(math.atan2(y, x) / math.tau * TURN)) <= ANGLE_ERROR + 1


@given(coordinates, coordinates, angles)
def test_a_turned_vector_is_that_of_floating_point(x: int, y: int, angle: int) -> None:
    c, s = math.cos(angle / TURN * math.tau), math.sin(angle / TURN * math.tau)
    got = turned(x, y, angle)
    allowed = 2.0 + SINE_ERROR * math.hypot(x, y)
    assert math.dist(got, (c * x - s * y, s * x + c * y)) <= allowed


def test_every_sine_is_that_of_floating_point_and_the_quarters_are_whole() -> None:
    errors = [abs(sine(a) / 16384 - math.sin(a / TURN * math.tau)) for a in range(65536)]
    assert max(errors) < 1.1e-4
    assert [sine(a) for a in (0, 16384, 32768, 49152)] == [0, 16385, 0, -16385]


@given(st.integers(-31416, 31416))
def test_a_heading_comes_back_from_its_binary_angle_to_the_wires_resolution(heading: int) -> None:
    back = heading_of(angle_of(heading))
    assert min(abs(back - heading), abs(abs(back - heading) - 62832)) <= 1
    assert aside(angle_of(heading) - round(heading * 1e-4 / math.tau * TURN)) <= 1


def test_any_two_places_of_the_wire_have_a_vector() -> None:
    far = 2**31 - 1
    dx, dy = between((-far, far), (far, -far))
    assert (dx, dy) == (2**30 - 1, 1 - 2**30)
    length, bearing = measured(dx, dy)
    assert length == pytest.approx(2**30 * math.sqrt(2), rel=SINE_ERROR)
    assert bearing == pytest.approx(7 / 8 * TURN, abs=ANGLE_ERROR)
    assert between((4, 8), (16, -8)) == (3, -4)


@given(st.integers(-(2**33), 2**33))
def test_a_word_is_the_lower_half_of_a_number(number: int) -> None:
    assert -(2**31) <= word(number) < 2**31
    assert (word(number) - number) % 2**32 == 0


@given(words, st.integers(-16384, 16384))
def test_scaling_is_exact_though_it_goes_in_halves(number: int, share: int) -> None:
    assert scale(number, share) == number * share + 0x2000 >> 14


@given(angles, angles)
def test_a_part_is_exact_though_it_goes_in_halves(number: int, share: int) -> None:
    assert part(number, share) == number * share >> 16


@given(st.integers(0, 2**30 - 1))
def test_a_root_is_the_whole_part_of_the_square_root(square: int) -> None:
    assert root(square) == math.isqrt(square)


@pytest.mark.skipif(missing_tool() is not None, reason="needs a C compiler")
class TestTheFirmware:
    """``fixed.c`` gives the same numbers."""

    @given(coordinates, coordinates, angles)
    @settings(max_examples=300)
    def test_measures_and_turns_alike(self, x: int, y: int, angle: int) -> None:
        library().cw_measure.restype = ctypes.c_uint16
        vector = (ctypes.c_int32 * 2)(x, y)
        bearing = library().cw_measure(vector)
        assert (vector[0], bearing) == measured(x, y)
        vector = (ctypes.c_int32 * 2)(x, y)
        library().cw_turn(vector, ctypes.c_uint16(angle))
        assert (vector[0], vector[1]) == turned(x, y, angle)

    def test_has_the_same_sines(self) -> None:
        library().cw_sine.restype = ctypes.c_int16
        ours = [sine(angle) for angle in range(65536)]
        assert [library().cw_sine(ctypes.c_uint16(angle)) for angle in range(65536)] == ours

    @given(words, st.integers(-16385, 16385))
    def test_scales_alike(self, number: int, share: int) -> None:
        got = library().cw_scale(ctypes.c_int32(number), ctypes.c_int16(share))
        assert got == scale(number, share)

    @given(words, st.integers(0, 0x7FFF))
    def test_clips_alike(self, number: int, most: int) -> None:
        library().cw_clip.restype = ctypes.c_int16
        got = library().cw_clip(ctypes.c_int32(number), ctypes.c_int16(most))
        assert got == clip(number, most)

    @given(st.integers(0, 2**30 - 1))
    def test_takes_roots_alike(self, square: int) -> None:
        library().cw_root.restype = ctypes.c_uint16
        assert library().cw_root(ctypes.c_uint32(square)) == root(square)

    @given(angles, st.integers(-31416, 31416))
    def test_converts_headings_alike(self, angle: int, heading: int) -> None:
        library().cw_heading_of.restype = ctypes.c_int16
        library().cw_angle_of.restype = ctypes.c_uint16
        assert library().cw_heading_of(ctypes.c_uint16(angle)) == heading_of(angle)
        assert library().cw_angle_of(ctypes.c_int16(heading)) == angle_of(heading)

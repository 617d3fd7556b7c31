"""Wheels that do not turn below a least speed: what they are ordered and what they are driven."""

from __future__ import annotations

import ctypes
from itertools import groupby

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.micropython.clearway import pulses as micropython
from firmware_protocol.robot.controller import CYCLE_MAX_US
from firmware_protocol.robot.wheel_pulses import WheelPulses
from firmware_protocol.wire.drive_settings import PULSE_US, DriveSettings
from tests.support.robots.c_robot import library, missing_tool

CYCLE_US = 10_000
LEAST = 8 * 20
leasts = st.integers(0, 1600)
orders = st.integers(-2000, 2000)
cycles = st.lists(st.tuples(st.integers(0, CYCLE_MAX_US), orders, orders), max_size=60)


@given(leasts, cycles)
def test_a_wheel_is_never_driven_more_slowly_than_it_turns(
    least: int, steps: list[tuple[int, int, int]]
) -> None:
    pulses = WheelPulses(least)
    for dt_us, *ordered in steps:
        for order, driven in zip(ordered, pulses.next(dt_us, *ordered), strict=True):
            assert driven == 0 or abs(driven) >= least
            assert driven == order or abs(driven) in (0, least)
            assert driven * order >= 0, "the other way round"
            assert order != 0 or driven == 0, "a stop is one at once"


@given(leasts, cycles)
def test_what_is_driven_differs_from_what_is_ordered_by_less_than_a_pulse_and_a_cycle(
    least: int, steps: list[tuple[int, int, int]]
) -> None:
    pulses, owed, going = WheelPulses(least), [0, 0], [(0, 0), (0, 0)]
    for dt_us, *ordered in steps:
        for side in (0, 1):
            order, driven = going[side]
            owed[side] += (order - driven) * dt_us
            assert abs(owed[side]) <= least * (PULSE_US + CYCLE_MAX_US)
        driven_at = pulses.next(dt_us, *ordered)
        going = list(zip(ordered, driven_at, strict=True))


@pytest.mark.parametrize("order", [1, 10, 37, 80, 120, 159])
def test_a_pulse_is_long_enough_to_break_a_wheel_loose(order: int) -> None:
    pulses = WheelPulses(LEAST)
    seen = [pulses.next(CYCLE_US, -order, order) for _ in range(20_000)]
    for side in (0, 1):
        runs = [(speed, len(list(same))) for speed, same in groupby(row[side] for row in seen)]
        assert min(count for speed, count in runs[1:-1] if speed) * CYCLE_US >= PULSE_US
        driven, ordered = abs(sum(row[side] for row in seen)), order * len(seen)
        assert abs(driven - ordered) * CYCLE_US <= LEAST * (PULSE_US + CYCLE_US)


def test_a_robot_turns_by_one_wheel_s_pulse_at_a_time() -> None:
    pulses = WheelPulses(LEAST)
    seen = [pulses.next(CYCLE_US, -LEAST // 16, LEAST // 16) for _ in range(4_000)]
    assert {(0, 0), (-LEAST, 0), (0, LEAST)} == set(seen)


def test_a_robot_that_stops_is_not_kept_moving_by_pulses() -> None:
    pulses = WheelPulses(LEAST)
    while pulses.next(CYCLE_US, 80, 80) == (0, 0):
        pass
    assert pulses.stop(CYCLE_US, LEAST, 80) == (LEAST, 0)
    assert pulses.stop(CYCLE_US, 80, 80) == (0, 0)
    assert pulses.next(CYCLE_US, 8, 8) == (0, 0), "nothing of before is caught up on"


@given(cycles)
def test_wheels_that_turn_however_slowly_are_driven_as_ordered(
    steps: list[tuple[int, int, int]],
) -> None:
    pulses = WheelPulses(0)
    assert all(pulses.next(*step) == step[1:] for step in steps)


@given(st.integers(0, 200), orders, orders, st.integers(-(2**27), 2**27), st.booleans())
def test_it_is_the_same_in_c_and_in_micropython(
    least_mm_s: int, order: int, driven: int, owed: int, ahead: bool
) -> None:
    ours = WheelPulses(8 * least_mm_s)
    side = 0 if ahead else 1
    ours._owed[side], ours._driven[side], ours._ordered[side] = owed, driven, driven
    wanted = ours.next(0, order, order)[side]
    assert micropython.pulsed(8 * least_mm_s, order, driven, owed, ahead) == wanted
    if missing_tool() is None:
        lib = library()
        lib.cw_pulsed.restype = ctypes.c_int16
        numbers = DriveSettings(least_wheel_m_s=least_mm_s / 1000).whole_numbers()
        set_settings(lib, numbers)
        assert lib.cw_pulsed(order, driven, ctypes.c_int32(owed), ctypes.c_bool(ahead)) == wanted


def set_settings(lib: ctypes.CDLL, numbers: tuple[int, ...]) -> None:
    """As `cw_settings` lies: a u32 and nine u16."""

    class Settings(ctypes.Structure):
        _fields_ = (("track_um", ctypes.c_uint32), ("others", ctypes.c_uint16 * 9))

    place = Settings.in_dll(lib, "cw_robot_settings")
    place.track_um, place.others[:] = numbers[0], numbers[1:]

"""Wheels that do not turn below a least speed: what they are ordered and what they are driven."""

from __future__ import annotations

import ctypes
from itertools import groupby

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.robot.clearway.pulses import PULSE_US, WheelPulses, pulsed
from firmware_protocol.robot.clearway.robot import DT_MAX_US
from firmware_protocol.wire.drive_settings import DriveSettings
from tests.support.robots.c_robot import library, missing_tool

CYCLE_US = 10_000
LEAST = 8 * 20
leasts = st.integers(0, 1600)
orders = st.integers(-2000, 2000)
cycles = st.lists(st.tuples(st.integers(0, DT_MAX_US), orders, orders), max_size=60)


def driven(pulses: WheelPulses, dt_us: int, left: int, right: int) -> tuple[int, int]:
    """Both wheels' speeds after new orders."""
    pulses.next(dt_us, left, right)
    return pulses.driven[0], pulses.driven[1]


def stopped(pulses: WheelPulses, left: int, right: int) -> tuple[int, int]:
    """The same for a robot that stops."""
    pulses.stop(left, right)
    return pulses.driven[0], pulses.driven[1]


@given(leasts, cycles)
def test_a_wheel_is_never_driven_more_slowly_than_it_turns(
    least: int, steps: list[tuple[int, int, int]]
) -> None:
    pulses = WheelPulses(least)
    for dt_us, *ordered in steps:
        for order, speed in zip(ordered, driven(pulses, dt_us, *ordered), strict=True):
            assert speed == 0 or abs(speed) >= least
            assert speed == order or abs(speed) in (0, least)
            assert speed * order >= 0, "the other way round"
            assert order != 0 or speed == 0, "a stop is one at once"


@given(leasts, cycles)
def test_what_is_driven_differs_from_what_is_ordered_by_less_than_a_pulse_and_a_cycle(
    least: int, steps: list[tuple[int, int, int]]
) -> None:
    pulses, owed, going = WheelPulses(least), [0, 0], [(0, 0), (0, 0)]
    for dt_us, *ordered in steps:
        for side in (0, 1):
            order, speed = going[side]
            owed[side] += (order - speed) * dt_us
            assert abs(owed[side]) <= least * (PULSE_US + DT_MAX_US)
        going = list(zip(ordered, driven(pulses, dt_us, *ordered), strict=True))


@pytest.mark.parametrize("order", [1, 10, 37, 80, 120, 159])
def test_a_pulse_is_long_enough_to_break_a_wheel_loose(order: int) -> None:
    pulses = WheelPulses(LEAST)
    seen = [driven(pulses, CYCLE_US, -order, order) for _ in range(20_000)]
    for side in (0, 1):
        runs = [(speed, len(list(same))) for speed, same in groupby(row[side] for row in seen)]
        assert min(count for speed, count in runs[1:-1] if speed) * CYCLE_US >= PULSE_US
        done, ordered = abs(sum(row[side] for row in seen)), order * len(seen)
        assert abs(done - ordered) * CYCLE_US <= LEAST * (PULSE_US + CYCLE_US)


def test_a_robot_turns_by_one_wheel_s_pulse_at_a_time() -> None:
    pulses = WheelPulses(LEAST)
    seen = [driven(pulses, CYCLE_US, -LEAST // 16, LEAST // 16) for _ in range(4_000)]
    assert {(0, 0), (-LEAST, 0), (0, LEAST)} == set(seen)


def test_a_robot_that_stops_is_not_kept_moving_by_pulses() -> None:
    pulses = WheelPulses(LEAST)
    while driven(pulses, CYCLE_US, 80, 80) == (0, 0):
        pass
    assert stopped(pulses, LEAST, 80) == (LEAST, 0)
    assert stopped(pulses, 80, 80) == (0, 0)
    assert driven(pulses, CYCLE_US, 8, 8) == (0, 0), "nothing of before is caught up on"


@given(cycles)
def test_wheels_that_turn_however_slowly_are_driven_as_ordered(
    steps: list[tuple[int, int, int]],
) -> None:
    pulses = WheelPulses(0)
    assert all(driven(pulses, *step) == step[1:] for step in steps)


@pytest.mark.skipif(missing_tool() is not None, reason=f"needs {missing_tool()}")
@given(st.integers(0, 200), orders, orders, st.integers(-(2**27), 2**27), st.booleans())
def test_it_is_the_same_in_c(
    least_mm_s: int, order: int, before: int, owed: int, ahead: bool
) -> None:
    lib = library()
    lib.cw_pulsed.restype = ctypes.c_int16
    set_settings(lib, DriveSettings(least_wheel_m_s=least_mm_s / 1000).whole_numbers())
    in_c = lib.cw_pulsed(order, before, ctypes.c_int32(owed), ctypes.c_bool(ahead))
    assert in_c == pulsed(8 * least_mm_s, order, before, owed, ahead)


def set_settings(lib: ctypes.CDLL, numbers: tuple[int, ...]) -> None:
    """As `cw_settings` lies: a u32 and nine u16."""

    class Settings(ctypes.Structure):
        _fields_ = (("track_um", ctypes.c_uint32), ("others", ctypes.c_uint16 * 9))

    place = Settings.in_dll(lib, "cw_robot_settings")
    place.track_um, place.others[:] = numbers[0], numbers[1:]

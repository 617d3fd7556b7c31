"""The searches' clock is stopped while kernels are compiled."""

from __future__ import annotations

import time

import pytest
from numba.core import event

from planner.shared.search_clock import COMPILING, search_clock_s


def test_time_passes_while_nothing_is_compiled() -> None:
    began_s, clock_s = time.monotonic(), search_clock_s()
    time.sleep(0.02)  # time that counts
    assert search_clock_s() - clock_s == pytest.approx(time.monotonic() - began_s, abs=0.01)


def test_no_time_passes_while_a_kernel_is_compiled_and_another_within_it() -> None:
    clock_s = search_clock_s()
    event.start_event(COMPILING)
    event.start_event(COMPILING)
    time.sleep(0.05)  # time that does not count, compiling both
    event.end_event(COMPILING)
    time.sleep(0.05)  # the same, compiling one
    assert search_clock_s() - clock_s < 0.02, "nor in between"
    event.end_event(COMPILING)
    assert search_clock_s() - clock_s < 0.02

"""Another clock's stamps on ours, from when the messages come."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vision.camera.arrival_clock import DRIFT, ArrivalClock


def test_held_up_messages_are_dated_by_their_stamps() -> None:
    rng, clock = np.random.default_rng(4), ArrivalClock()
    off = []
    for i in range(2000):
        sent_s = 0.05 * i
        delay_s = 0.01 + (0.0 if i % 10 == 0 else rng.exponential(0.05))
        found_s = clock.time_of(1000.0 + sent_s, sent_s + delay_s)
        assert found_s <= sent_s + delay_s + 1e-9
        off.append(found_s - sent_s - 0.01)
    assert np.abs(off[20:]).max() < 0.5 * DRIFT + 1e-9


@pytest.mark.parametrize("drift", [-1e-3, 1e-3])
def test_a_clock_that_goes_wrong_is_followed(drift: float) -> None:
    clock = ArrivalClock()
    for i in range(20_000):
        sent_s = 0.05 * i
        found_s = clock.time_of(7.0 + sent_s * (1.0 + drift), sent_s + 0.01)
    assert found_s == pytest.approx(sent_s + 0.01, abs=2e-3)


def test_before_the_first_message_there_is_no_offset() -> None:
    assert ArrivalClock().offset_s == math.inf

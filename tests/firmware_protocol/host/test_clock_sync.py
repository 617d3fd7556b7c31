"""The robot's clock as the host estimates it, from exchanges over a line that delays."""

from firmware_protocol.host.line.clock_sync import WRAP_US, ClockEstimate


def exchange(
    clock: ClockEstimate, now_s: float, offset_s: float, there: float, back: float
) -> None:
    received_us = int((now_s + there + offset_s) * 1e6) % WRAP_US
    clock.add(now_s, received_us, (received_us + 100) % WRAP_US, now_s + there + 100e-6 + back)


def test_clock_offset_is_found_among_slow_exchanges() -> None:
    clock = ClockEstimate()
    for i in range(20):
        slow = 0.05 if i % 3 == 1 else 0.0
        exchange(clock, float(i), 123.4, 0.002 + slow, 0.002)
    assert abs(clock.offset_s(20.0) - 123.4) < 1e-5


def test_clock_drift_is_found() -> None:
    clock = ClockEstimate()
    for i in range(30):
        exchange(clock, float(i), 5.0 + 100e-6 * i, 0.001, 0.001)
    assert abs(clock.drift - 100e-6) < 5e-6
    assert abs(clock.offset_s(40.0) - (5.0 + 100e-6 * 40)) < 1e-4


def test_the_robots_clock_may_wrap() -> None:
    clock = ClockEstimate()
    offset_s = WRAP_US / 1e6 - 5.0
    for i in range(10):
        exchange(clock, float(i), offset_s, 0.001, 0.001)
    assert abs(clock.offset_s(9.0) - offset_s) < 1e-5

"""The thread that measures delays, on clocks of a test."""

from __future__ import annotations

from navigation.run.devices.wakeups import Wakeups, asleep_s
from tests.support.waiting import wait_until


def test_the_time_that_the_computer_slept_is_a_delay() -> None:
    """The monotonic clock stands still meanwhile."""
    slept = [100.0]
    wakeups = Wakeups(lambda: 5.0, lambda: slept[0])
    wakeups.start()
    try:
        assert not wait_until(lambda: wakeups.worst_s() > 0.0, 0.2)
        slept[0] += 7200.0
        assert wait_until(lambda: wakeups.worst_s() > 7199.0, 10.0)
        assert not wait_until(lambda: wakeups.worst_s() > 0.0, 0.2)
    finally:
        wakeups.stop()


def test_a_computer_that_does_not_sleep_has_slept_no_longer() -> None:
    before_s = asleep_s()
    # the least of many: between its two clocks another program may run
    assert min(abs(asleep_s() - before_s) for _ in range(100)) < 0.01

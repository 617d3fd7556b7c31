"""Waiting for what happens in another process or thread, in real time."""

import time
from collections.abc import Callable

LOOK_EVERY_S = 0.01


def wait_until(holds: Callable[[], bool], seconds: float = 10.0) -> bool:
    """Whether it held within so many seconds; ends as soon as it does.

    Sleeps between looks: a process on the far side of a pseudo-terminal gives no sign to wait
    for, and looking without a pause would take the processor from it.
    """
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        if holds():
            return True
        time.sleep(LOOK_EVERY_S)
    return holds()

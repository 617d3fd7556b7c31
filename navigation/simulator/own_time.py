"""Progress of a simulated robot's time, and waiting for it.

On a busy processor a simulated robot falls behind and catches up in a burst. Pictures, dated by the
clock, must not show an earlier place: readers of the pose wait until the robot has caught up.
Seconds of a monotonic clock.
"""

from __future__ import annotations

import math
import threading

BEHIND_MAX_S = 0.5
"""Longest time made up after the machine slept; the rest is skipped."""


class OwnTime:
    """Time advanced by the robot's thread; any thread may wait for it."""

    def __init__(self, step_s: float) -> None:
        self._step_s = step_s
        self._done_s = 0.0
        self._runs = False
        self._changed = threading.Condition()
        self.lost_s = 0.0
        """Part of the clock's time that was skipped."""

    def begin(self, now_s: float) -> None:
        """Switch the robot on; it is waited for only from here to :meth:`end`."""
        with self._changed:
            self._done_s, self._runs = now_s, True

    def end(self) -> None:
        """Stop the robot's time."""
        with self._changed:
            self._runs = False
            self._changed.notify_all()

    @property
    def since_s(self) -> float:
        """Time reached, after which work remains; infinity while the robot is off."""
        return self._done_s if self._runs else math.inf

    def limit(self, now_s: float) -> None:
        """Skip work too far behind the clock."""
        gone_s = now_s - BEHIND_MAX_S - self._done_s
        if gone_s > 0.0:
            self.lost_s += gone_s
            self._done_s += gone_s

    def next_step_s(self, now_s: float) -> float | None:
        """End of the next step; None if the clock has not reached it."""
        end_s = self._done_s + self._step_s
        return end_s if end_s <= now_s else None

    def due_in_s(self, now_s: float) -> float:
        """Seconds until the next step can be made."""
        return max(0.0, self._done_s + self._step_s - now_s)

    def done(self, end_s: float) -> None:
        """Complete the step that ends at ``end_s``."""
        with self._changed:
            self._done_s = end_s
            self._changed.notify_all()

    def wait_for(self, now_s: float) -> None:
        """Wait until the robot's time has stopped or is less than a step behind ``now_s``.

        Ends after ``BEHIND_MAX_S`` in any case.
        """
        with self._changed:
            # same sum as in next_step_s: with other rounding, each would wait for the other
            self._changed.wait_for(
                lambda: not self._runs or self.next_step_s(now_s) is None, BEHIND_MAX_S
            )

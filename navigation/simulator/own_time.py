"""How far the time of a simulated robot has come, and who waits for it.

A real robot's time never waits for its computer. A simulated one falls behind where the
processor is busy and makes up for it in a burst; meanwhile a picture, which is dated by the
clock, must not show it where it was before: whoever asks where it is waits for it to be there.
Seconds of a monotonic clock.
"""

from __future__ import annotations

import math
import threading

BEHIND_MAX_S = 0.5
"""A machine that slept longer than this does not make the robot jump: the rest is let go."""


class OwnTime:
    """The robot's thread sets it on, step by step; any thread waits for it."""

    def __init__(self, step_s: float) -> None:
        self._step_s = step_s
        self._done_s = 0.0
        self._runs = False
        self._changed = threading.Condition()
        self.lost_s = 0.0
        """How much of the clock's time was let go."""

    def begin(self, now_s: float) -> None:
        """The robot is switched on; only from here to :meth:`end` is it waited for."""
        with self._changed:
            self._done_s, self._runs = now_s, True

    def end(self) -> None:
        """The robot's time stands still from now on."""
        with self._changed:
            self._runs = False
            self._changed.notify_all()

    @property
    def since_s(self) -> float:
        """How far it has come: what is later is still to be done; infinity while it is off."""
        return self._done_s if self._runs else math.inf

    def limit(self, now_s: float) -> None:
        """Let go what lies too far behind the clock."""
        gone_s = now_s - BEHIND_MAX_S - self._done_s
        if gone_s > 0.0:
            self.lost_s += gone_s
            self._done_s += gone_s

    def next_step_s(self, now_s: float) -> float | None:
        """The end of the next step; None where the clock is not there yet."""
        end_s = self._done_s + self._step_s
        return end_s if end_s <= now_s else None

    def due_in_s(self, now_s: float) -> float:
        """How long the clock still goes until the next step can be made."""
        return max(0.0, self._done_s + self._step_s - now_s)

    def done(self, end_s: float) -> None:
        """The step that ends then is made."""
        with self._changed:
            self._done_s = end_s
            self._changed.notify_all()

    def wait_for(self, now_s: float) -> None:
        """Return when the robot's time is less than a step behind ``now_s``, or stands still."""
        with self._changed:
            # by the same sum as there: rounded otherwise, one would wait for what the other leaves
            self._changed.wait_for(
                lambda: not self._runs or self.next_step_s(now_s) is None, BEHIND_MAX_S
            )

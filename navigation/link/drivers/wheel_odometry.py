"""Travel of two wheels from the counts of two encoders, through wraps, resets and damage.

Counts that the wheels could not have reached are left out; if the counts stay there, they are a new
beginning: the robot was switched off and on.
"""

from __future__ import annotations

from typing import Final

SLACK: Final = 1.5
"""Factor by which a wheel may seem to exceed its highest speed: late reports come in twos."""
SLACK_M: Final = 0.01
DOUBTS: Final = 3
"""Number of counts far off in a row that make a new beginning."""


class WheelOdometry:
    """Odometry of two wheels. ``modulus`` is where the counts wrap, None if they do not."""

    def __init__(self, metres_per_count: float, wheel_m_s: float, modulus: int | None) -> None:
        self._metres_per_count = metres_per_count
        self._wheel_m_s = wheel_m_s
        self._modulus = modulus
        self._counts: tuple[int, int] | None = None
        self._counted_s = 0.0
        self._doubts = 0
        self.left_m = 0.0
        self.right_m = 0.0

    def forget(self) -> None:
        """Make the next counts a new beginning: the time in between is unknown."""
        self._counts = None

    def count(
        self, left: int, right: int, now_s: float, directions: tuple[int, int] | None = None
    ) -> bool:
        """Take the newest counts; False if they are impossible and were left out.

        ``directions``: 1, -1 or 0 for each wheel whose encoder senses none; with 0 nothing is
        counted.
        """
        before = self._counts
        if before is not None:
            moved = [self._since(new, old) for new, old in zip((left, right), before, strict=True)]
            if directions is not None:
                moved = [abs(by) * way for by, way in zip(moved, directions, strict=True)]
            most_m = SLACK * self._wheel_m_s * (now_s - self._counted_s) + SLACK_M
            if max(map(abs, moved)) * self._metres_per_count > most_m:
                self._doubts += 1
                if self._doubts < DOUBTS:
                    return False
                moved = [0, 0]
            self.left_m += moved[0] * self._metres_per_count
            self.right_m += moved[1] * self._metres_per_count
        self._counts, self._counted_s, self._doubts = (left, right), now_s, 0
        return True

    def _since(self, new: int, old: int) -> int:
        if self._modulus is None:
            return new - old
        half = self._modulus // 2
        return (new - old + half) % self._modulus - half

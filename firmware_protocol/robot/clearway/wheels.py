"""Sums that most boards share: encoder counts into micrometres, speeds into a driver's range."""

from array import array

MOST_COUNTS = 2000
"""Largest count between two control cycles of these robots."""


class Odometer:
    """Travel of both wheels from running counts; ``nm_per_count`` each."""

    def __init__(self, nm_per_count: int) -> None:
        self._nm = nm_per_count
        self._before = array("i", (0, 0))
        self._rest_nm = array("i", (0, 0))
        self._begun = bytearray(2)

    def travel_um(self, side: int, count: int) -> int:
        """Travel since that side's last call, rounded down; the rest is carried on."""
        since = count - self._before[side]
        self._before[side] = count
        if not self._begun[side] or not -MOST_COUNTS < since < MOST_COUNTS:
            self._begun[side] = 1
            return 0  # the first call, or an encoder that was reset
        nm = since * self._nm + self._rest_nm[side]
        um = nm // 1000
        self._rest_nm[side] = nm - um * 1000
        return um


class Duty:
    """A wheel's speed as a number up to ``most`` at ``full_mm_s``; fractions are carried on."""

    def __init__(self, full_mm_s: int, most: int) -> None:
        self._full = full_mm_s * 8
        self._most = most
        self._rest = array("i", (0, 0))

    def of(self, side: int, speed: int) -> int:
        """The driver's number for a speed in eighths of mm/s."""
        wanted = speed * self._most + self._rest[side]
        duty = wanted // self._full
        self._rest[side] = wanted - duty * self._full
        return max(-self._most, min(self._most, duty))

"""The robot's motion by its own wheels, from the speeds in its reports.

The pose in STATUS is drawn to the camera's and is no second witness; speed and turning rate are the
wheels' alone. They are integrated between reports (trapezoids) and dated by the robot's own clock,
so that a report delayed on the line is not a late motion. Motion in a longer gap is unknown: a new
stretch begins there. Metres, radians, seconds of our clock.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from typing import Final, NamedTuple

import numpy as np

from firmware_protocol.host.line.clock_sync import WRAP_US
from firmware_protocol.wire.messages import Status
from planner.scene import FloatArray

SPEED_LAG_S: Final = 0.03
"""Smoothing of the robot's measured speeds (``SMOOTHING_US`` of its controller)."""
LONGEST_GAP_S: Final = 0.35
"""Gap after which the motion of the wheels is unknown: seven lost reports, one every 50 ms."""
REDATED_S: Final = 0.02
"""A report that shows the clock's offset to be smaller by more than this puts earlier dates in
doubt: a new stretch begins."""
OFFSETS: Final = 20
"""The least delay of the last second dates the reports, which follows a robot whose clock is slow
(0.5 % with a ceramic resonator)."""
OVERTAKEN_S: Final = 10.0
"""A report older than the last one by no more was overtaken on the line. By more, the robot's clock
has come round: it was not heard, or this computer slept, for up to 71.6 minutes."""
KEPT_S: Final = 4.0
LONGEST_GUESS_S: Final = 0.2
"""Time after the last report for which its speeds are assumed to hold."""
STANDING_M_S: Final = 0.004
STANDING_RAD_S: Final = 0.03
"""Speeds below which wheels count as still: one late step of the encoders in a report."""


class WheelMotion(NamedTuple):
    """Motion of the wheels since the stretch began, and their speed.

    ``way_m`` and ``turn_rad`` are signed sums, ``driven_m`` and ``turned_rad`` count every motion
    as positive.
    """

    way_m: float
    turn_rad: float
    driven_m: float
    turned_rad: float
    speed_m_s: float
    turn_rad_s: float


BEGUN: Final = WheelMotion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Motion at the beginning of a stretch."""


class WheelTrack:
    """Motion over time, fed with the robot's reports.

    ``report_age_s`` is a report's age on arrival by the shortest path: its bytes' time on the wire.
    """

    def __init__(self, report_age_s: float = 0.0) -> None:
        self._lag_s = SPEED_LAG_S + report_age_s
        self._offsets_s: deque[float] = deque(maxlen=OFFSETS)
        self._boot_id: int | None = None
        self._robot_us = 0
        self._robot_s = 0.0
        self._arrived_s = -math.inf
        self._knots: deque[tuple[float, WheelMotion]] = deque()
        self._table: FloatArray | None = None
        """Columns of the knots, for `ways_at`; None once outdated."""
        self.stretch = 0
        """Number of stretches without a gap; sums of different stretches cannot be compared."""
        self.ended: WheelMotion | None = None
        """Motion over the whole stretch before this one, as far as it was reported."""
        self.unreported = False
        """True if reports are missing between that stretch and this one."""
        self.turn_rad = 0.0
        """Turn of the robot by its wheels over all stretches."""
        self.driven_m = 0.0
        """Distance driven over all stretches, forwards and backwards."""

    def see(self, status: Status, arrived_s: float) -> None:
        """Take a report; one that is not newer than the last changes nothing."""
        dt_s = (status.time_us - self._robot_us) % WRAP_US / 1e6
        older_s = (self._robot_us - status.time_us) % WRAP_US / 1e6
        silent_s, self._arrived_s = arrived_s - self._arrived_s, arrived_s
        another_clock = status.boot_id != self._boot_id or silent_s > OVERTAKEN_S
        if older_s <= OVERTAKEN_S and not another_clock:
            return
        if another_clock or dt_s > OVERTAKEN_S:
            self._boot_id = status.boot_id
            self._robot_us, self._robot_s = status.time_us, 0.0
            self._offsets_s.clear()
            self._offsets_s.append(arrived_s)
            self._begin(status, arrived_s, unreported=True)
            return
        self._robot_us, self._robot_s = status.time_us, self._robot_s + dt_s
        known_s = min(self._offsets_s)
        self._offsets_s.append(arrived_s - self._robot_s)
        offset_s = min(self._offsets_s)
        at_s = self._robot_s + offset_s
        last = self._knots[-1][1]
        way_m = dt_s * (last.speed_m_s + status.speed_m_s) / 2.0
        turn_rad = dt_s * (last.turn_rad_s + status.turn_rad_s) / 2.0
        if dt_s > LONGEST_GAP_S:
            self._begin(status, at_s, unreported=True)
            return
        self.turn_rad += turn_rad
        self.driven_m += abs(way_m)
        motion = WheelMotion(
            last.way_m + way_m,
            last.turn_rad + turn_rad,
            last.driven_m + abs(way_m),
            last.turned_rad + abs(turn_rad),
            status.speed_m_s,
            status.turn_rad_s,
        )
        self._add(at_s, motion)
        if known_s - offset_s > REDATED_S:
            self._begin(status, at_s, unreported=False)

    @property
    def newest_s(self) -> float:
        """End of the known motion; -infinity before the first report."""
        return self._knots[-1][0] if self._knots else -np.inf

    @property
    def oldest_s(self) -> float:
        """Start of the known motion; infinity before the first report."""
        return self._knots[0][0] if self._knots else np.inf

    @property
    def stand(self) -> bool:
        """True if the wheels were still in the last report, or none came yet."""
        if not self._knots:
            return True
        now = self._knots[-1][1]
        return abs(now.speed_m_s) < STANDING_M_S and abs(now.turn_rad_s) < STANDING_RAD_S

    @property
    def stood_first(self) -> bool:
        """True if the wheels were still when the known track begins."""
        first = self._knots[0][1] if self._knots else None
        return first is None or (first.speed_m_s == 0.0 and first.turn_rad_s == 0.0)

    def at(self, time_s: float) -> WheelMotion | None:
        """Motion at a time; None outside of what is known."""
        if not self.oldest_s <= time_s <= self.newest_s:
            return None
        after = bisect_right(self._knots, time_s, key=_time_of)
        before_s, before = self._knots[after - 1]
        if before_s == time_s:
            return before
        after_s, motion = self._knots[after]
        span_s, since_s = after_s - before_s, time_s - before_s
        return WheelMotion(
            *((b - a) / span_s * since_s + a for a, b in zip(before, motion, strict=True))
        )

    def ways_at(self, times_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """``way_m`` and ``turn_rad`` (n,) at times; beyond what is known, those at its ends."""
        table = self._table
        if table is None:
            knots = [(t, motion.way_m, motion.turn_rad) for t, motion in self._knots]
            table = self._table = np.array(knots).T
        knots_s, ways_m, turns_rad = table
        return np.interp(times_s, knots_s, ways_m), np.interp(times_s, knots_s, turns_rad)

    def since(self, time_s: float, now_s: float) -> tuple[float, float]:
        """Distance and turn of the wheels from a time to now, the last speeds assumed to last for a
        moment; zeros if unknown."""
        then = self.at(time_s)
        if then is None:
            return 0.0, 0.0
        last = self._knots[-1][1]
        guess_s = min(max(0.0, now_s - self.newest_s), LONGEST_GUESS_S)
        way_m = last.way_m - then.way_m + guess_s * last.speed_m_s
        return way_m, last.turn_rad - then.turn_rad + guess_s * last.turn_rad_s

    def _begin(self, status: Status, at_s: float, *, unreported: bool) -> None:
        self.stretch += 1
        self.unreported = unreported
        self.ended = self._knots[-1][1] if self._knots else None
        self._knots.clear()
        motion = BEGUN._replace(speed_m_s=status.speed_m_s, turn_rad_s=status.turn_rad_s)
        self._add(at_s, motion)

    def _add(self, at_s: float, motion: WheelMotion) -> None:
        at_s -= self._lag_s
        if self._knots:
            at_s = max(at_s, self._knots[-1][0] + 1e-6)
        self._knots.append((at_s, motion))
        while self._knots[0][0] < at_s - KEPT_S:
            self._knots.popleft()
        self._table = None


def _time_of(knot: tuple[float, WheelMotion]) -> float:
    return knot[0]

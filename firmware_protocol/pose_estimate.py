"""Where the robot is: wheel odometry, corrected by camera poses that are already old.

- Odometry moves the estimate at every step; a short history remembers where it was.
- A fix speaks of the past: it is compared with the history at its own time, a part of the
  difference is taken over, and the motion since then is laid on top again.
- Metres, radians, heading in (-pi, pi]; times in seconds of the robot's clock.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

from firmware_protocol.messages import PoseFix, wrap_angle

POSITION_GAIN: Final = 0.25
HEADING_GAIN: Final = 0.2
DRIFT_GAIN: Final = 0.5
"""Radians per metre learned from a heading difference of one radian, per metre driven."""
DRIFT_MAX: Final = 0.6
"""Radians per metre: wheels that differ by 7 % on a track of 0.12 m."""
HISTORY_STEP_S: Final = 0.04
HISTORY_LENGTH: Final = 8
JUMP_M: Final = 0.15
JUMP_RAD: Final = 0.5
JUMPS_BELIEVED: Final = 5
"""So many fixes in a row that are far off mean that the robot was moved by hand."""


class Pose(NamedTuple):
    """Position and heading."""

    x_m: float
    y_m: float
    heading_rad: float


class _Past(NamedTuple):
    time_s: float
    pose: Pose


class PoseEstimate:
    """Fuses wheel travel and camera poses."""

    def __init__(self, track_m: float) -> None:
        self.track_m = track_m
        self.pose = Pose(0.0, 0.0, 0.0)
        self.known = False
        self.fix_time_s = -math.inf
        self.rejected = 0
        self._history: deque[_Past] = deque(maxlen=HISTORY_LENGTH)
        self._jumps = 0
        self._drift_rad_per_m = 0.0
        self._travel_m = 0.0

    def advance(self, now_s: float, left_m: float, right_m: float) -> None:
        """The wheels moved by these distances since the last call, which ends now."""
        ds = (left_m + right_m) / 2.0
        turn = (right_m - left_m) / self.track_m + self._drift_rad_per_m * ds
        self._travel_m += ds
        middle = self.pose.heading_rad + turn / 2.0
        self.pose = Pose(
            self.pose.x_m + ds * math.cos(middle),
            self.pose.y_m + ds * math.sin(middle),
            wrap_angle(self.pose.heading_rad + turn),
        )
        if not self._history or now_s - self._history[-1].time_s >= HISTORY_STEP_S:
            self._history.append(_Past(now_s, self.pose))

    def correct(self, fix: PoseFix, now_s: float) -> bool:
        """Take a camera pose of ``fix.age_s`` ago; False where it was not used."""
        seen_s = now_s - fix.age_s
        then = self._at(seen_s, now_s)
        if then is None:
            self.rejected += 1
            return False
        dx, dy = fix.x_m - then.x_m, fix.y_m - then.y_m
        turn = wrap_angle(fix.heading_rad - then.heading_rad)
        far = math.hypot(dx, dy) > JUMP_M or abs(turn) > JUMP_RAD
        if self.known and far:
            self._jumps += 1
            if self._jumps < JUMPS_BELIEVED:
                self.rejected += 1
                return False
        snap = not self.known or far
        self._jumps = 0
        self._shift(then, dx, dy, turn, snap)
        self.known = True
        self.fix_time_s = max(self.fix_time_s, seen_s)
        return True

    def _shift(self, then: Pose, dx: float, dy: float, turn: float, snap: bool) -> None:
        gain, heading_gain = (1.0, 1.0) if snap else (POSITION_GAIN, HEADING_GAIN)
        if not snap:
            learned = self._drift_rad_per_m + DRIFT_GAIN * turn * self._travel_m
            self._drift_rad_per_m = max(-DRIFT_MAX, min(DRIFT_MAX, learned))
        self._travel_m = 0.0
        rotation = heading_gain * turn
        self.pose = _moved(self.pose, then, gain * dx, gain * dy, rotation)
        for index, past in enumerate(self._history):
            moved = _moved(past.pose, then, gain * dx, gain * dy, rotation)
            self._history[index] = _Past(past.time_s, moved)

    def _at(self, time_s: float, now_s: float) -> Pose | None:
        """The estimate at a past time, interpolated; None where it is forgotten."""
        later = _Past(now_s, self.pose)
        for past in reversed(self._history):
            if past.time_s <= time_s:
                return _between(past, later, time_s)
            later = past
        if not self._history or time_s >= later.time_s - HISTORY_STEP_S:
            return later.pose
        return None


def _moved(pose: Pose, about: Pose, dx: float, dy: float, turn: float) -> Pose:
    """``pose`` turned about ``about`` and shifted: the motion between both is kept."""
    c, s = math.cos(turn), math.sin(turn)
    rx, ry = pose.x_m - about.x_m, pose.y_m - about.y_m
    return Pose(
        about.x_m + dx + c * rx - s * ry,
        about.y_m + dy + s * rx + c * ry,
        wrap_angle(pose.heading_rad + turn),
    )


def _between(a: _Past, b: _Past, time_s: float) -> Pose:
    span = b.time_s - a.time_s
    t = min(1.0, (time_s - a.time_s) / span) if span > 0.0 else 1.0
    return Pose(
        a.pose.x_m + t * (b.pose.x_m - a.pose.x_m),
        a.pose.y_m + t * (b.pose.y_m - a.pose.y_m),
        wrap_angle(a.pose.heading_rad + t * wrap_angle(b.pose.heading_rad - a.pose.heading_rad)),
    )

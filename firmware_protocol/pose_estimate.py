"""Where the robot is: wheel odometry, corrected by camera poses that are already old.

- Odometry moves the estimate at every step; a short history remembers where it was.
- A fix speaks of the past: it is compared with the history at its own time, a part of the
  difference is taken over, and the motion since then is laid on top again.
- Micrometres, binary angles (``fixed_point``), microseconds of the robot's clock; the twin of
  ``firmware/estimate.c``, with the same arithmetic.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from firmware_protocol.fixed_point import (
    Place,
    angle_of,
    between,
    heading_of,
    mrad,
    scale,
    turned,
    wrapped,
)
from firmware_protocol.messages import PoseFix
from firmware_protocol.wire_values import UM_PER_M, heading_to_wire

POSITION_SHIFT: Final = 2
"""A fix's difference in position counts a quarter."""
HEADING_GAIN: Final = 13_107
"""Of 65536: a fifth."""
DRIFT_MAX: Final = 419_904
"""Binary angle per micrometre, times 1024: 0.6 rad/m, wheels that differ by 7 % on 0.12 m."""
HISTORY_STEP_US: Final = 40_000
HISTORY_LENGTH: Final = 8
JUMP_UM: Final = 150_000
JUMP_ANGLE: Final = mrad(500) >> 16
JUMPS_BELIEVED: Final = 5
"""So many fixes in a row that are far off mean that the robot was moved by hand."""


class Pose(NamedTuple):
    """Position and heading, as people read them."""

    x_m: float
    y_m: float
    heading_rad: float


class RobotPose(NamedTuple):
    """Position, and heading as a binary angle."""

    place: Place
    heading: int


class _Past(NamedTuple):
    time_us: int
    pose: RobotPose


class PoseEstimate:
    """Fuses wheel travel and camera poses."""

    def __init__(self) -> None:
        self.now = RobotPose(Place(0, 0), 0)
        self.known = False
        self.fix_us: int | None = None
        """When the camera saw what was used last."""
        self.rejected = 0
        self._history: list[_Past] = []
        """The newest first."""
        self._jumps = 0
        self._drift = 0
        """Binary angle per micrometre, times 1024."""
        self._travel_um = 0

    @property
    def pose(self) -> Pose:
        """Where the robot is, to the wire's resolution."""
        (x_um, y_um), heading = self.now
        heading_rad = max(-math.pi, min(math.pi, heading_of(heading) / 1e4))
        return Pose(x_um / UM_PER_M, y_um / UM_PER_M, heading_rad)

    def advance(self, travel_um: int, turn: int, now_us: int) -> None:
        """The robot drove and turned by so much since the last call, which ends now."""
        if travel_um != 0 or turn != 0:
            (x_um, y_um), heading = self.now
            drift = self._drift >> 4
            drifted = scale(travel_um, abs(drift)) * 1024
            turn = wrapped(turn - drifted if drift < 0 else turn + drifted)
            dx, dy = turned(travel_um, 0, wrapped(heading + (turn >> 1)))
            self._travel_um = wrapped(self._travel_um + travel_um)
            place = Place(wrapped(x_um + dx), wrapped(y_um + dy))
            self.now = RobotPose(place, wrapped(heading + turn))
        if not self._history or now_us - self._history[0].time_us >= HISTORY_STEP_US:
            self._history.insert(0, _Past(now_us, self.now))
            del self._history[HISTORY_LENGTH:]

    def correct(self, fix: PoseFix, now_us: int) -> bool:
        """Take a camera pose of ``fix.age_s`` ago; False where it was not used."""
        seen_us = now_us - round(fix.age_s * 1e6)
        then = self._at(seen_us, now_us)
        if then is None:
            self.rejected += 1
            return False
        seen = Place(round(fix.x_m * UM_PER_M), round(fix.y_m * UM_PER_M))
        dx, dy = between(then.place, seen)
        turn = wrapped(angle_of(heading_to_wire(fix.heading_rad)) - then.heading)
        high = turn >> 16
        if self.known:
            if abs(dx) > JUMP_UM or abs(dy) > JUMP_UM or abs(high) > JUMP_ANGLE:
                self._jumps += 1
                if self._jumps < JUMPS_BELIEVED:
                    self.rejected += 1
                    return False
            else:
                learned = scale(self._travel_um, abs(high))
                learned = self._drift + 2 * (-learned if high < 0 else learned)
                self._drift = max(-DRIFT_MAX, min(DRIFT_MAX, learned))
                dx = (dx + 2) >> POSITION_SHIFT
                dy = (dy + 2) >> POSITION_SHIFT
                turn = scale(turn, HEADING_GAIN)
        self._jumps = 0
        self._travel_um = 0
        self.now = _moved(self.now, then.place, dx, dy, turn)
        self._history = [
            _Past(past.time_us, _moved(past.pose, then.place, dx, dy, turn))
            for past in self._history
        ]
        self.known = True
        self.fix_us = seen_us if self.fix_us is None else max(self.fix_us, seen_us)
        return True

    def _at(self, time_us: int, now_us: int) -> RobotPose | None:
        """The estimate at a past time, interpolated; None where it is forgotten."""
        later = _Past(now_us, self.now)
        for past in self._history:
            if past.time_us <= time_us:
                return _between(past, later, time_us)
            later = past
        if not self._history or time_us >= later.time_us - HISTORY_STEP_US:
            return later.pose
        return None


def _moved(pose: RobotPose, about: Place, dx: int, dy: int, turn: int) -> RobotPose:
    """``pose`` turned about ``about`` and shifted: the motion between both is kept."""
    rx, ry = turned(*between(about, pose.place), turn)
    place = Place(wrapped(about.x_um + dx + rx), wrapped(about.y_um + dy + ry))
    return RobotPose(place, wrapped(pose.heading + turn))


def _between(a: _Past, b: _Past, time_us: int) -> RobotPose:
    since, span = time_us - a.time_us, b.time_us - a.time_us
    while span > 0xFFFF:
        span >>= 1
        since >>= 1
    part = (since << 16) // span if since < span else 0xFFFF
    (ax, ay), heading = a.pose
    (bx, by), later = b.pose
    place = Place(_blended(ax, bx, part), _blended(ay, by, part))
    return RobotPose(place, _blended(heading, later, part))


def _blended(start: int, end: int, part: int) -> int:
    return wrapped(start + scale(wrapped(end - start), part))

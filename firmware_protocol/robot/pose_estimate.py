"""Where the robot is: wheel odometry, corrected by camera poses that are already old.

- Odometry moves the estimate at every step; a short history remembers how far the wheels had
  moved it, corrections left out.
- A fix speaks of the past: what the wheels did since is laid on top of it, and a part of the
  difference from the estimate is taken over.
- Micrometres, binary angles (``fixed_point``), microseconds of the robot's clock; the history in
  16 bits, modulo 2**16: 256 um, 2**16 a turn, 256 us. The twin of ``firmware/estimate.c``, with
  the same arithmetic.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from firmware_protocol.wire.fixed_point import (
    Place,
    angle_of,
    heading_of,
    turned,
    wrapped,
    wrapped_short,
)
from firmware_protocol.wire.messages import PoseFix
from firmware_protocol.wire.values import UM_PER_M, heading_to_wire

GAIN_SHIFT: Final = 2
"""A fix's difference counts a quarter."""
DRIFT_MAX: Final = 419_904
"""Binary angle per micrometre, times 1024: 0.6 rad/m, wheels that differ by 7 % on 0.12 m."""
HISTORY_STEP: Final = 156
"""40 ms."""
HISTORY_LENGTH: Final = 9
JUMP_UM: Final = 150_000
JUMP_SHIFT: Final = 11
"""Of a heading: 0.45 rad."""
JUMPS_BELIEVED: Final = 5
"""So many fixes in a row that are far off mean that the robot was moved by hand."""


class Pose(NamedTuple):
    """Position and heading, as people read them."""

    x_m: float
    y_m: float
    heading_rad: float


class RobotPose(NamedTuple):
    """Position, and heading as a binary angle of 2**32 a turn."""

    place: Place
    heading: int


class _Past(NamedTuple):
    """How far the wheels had moved the robot, and when."""

    x: int
    y: int
    angle: int
    time: int


class PoseEstimate:
    """Fuses wheel travel and camera poses."""

    def __init__(self) -> None:
        self.now = RobotPose(Place(0, 0), 0)
        self.known = False
        self.fix_us: int | None = None
        """When the camera saw what was used last."""
        self.rejected = 0
        self._moved = (0, 0, 0)
        """The wheels' part of the motion, without any correction."""
        self._history = [_Past(0, 0, 0, 0)] * HISTORY_LENGTH
        """The newest first, which is the last step's."""
        self._jumps = 0
        self._drift = 0
        """Binary angle per micrometre, times 1024."""
        self._travel_um = 0

    @property
    def pose(self) -> Pose:
        """Where the robot is, to the wire's resolution."""
        (x_um, y_um), heading = self.now
        heading_rad = max(-math.pi, min(math.pi, heading_of(heading >> 16) / 1e4))
        return Pose(x_um / UM_PER_M, y_um / UM_PER_M, heading_rad)

    def advance(self, travel_um: int, turn: int, now_us: int) -> None:
        """The robot drove and turned by so much since the last call, which ends now."""
        history = self._history
        if (history[0].time - history[1].time) & 0xFFFF >= HISTORY_STEP:
            history[1:] = history[:-1]
        x, y, moved = self._moved
        if travel_um != 0 or turn != 0:
            (x_um, y_um), heading = self.now
            self._travel_um = wrapped(self._travel_um + travel_um)
            turn = wrapped(turn + ((travel_um * (self._drift >> 4) + 0x2000 >> 14) << 8))
            dx, dy = turned(travel_um, 0, wrapped(heading + (turn >> 1)) >> 16)
            self.now = RobotPose(
                Place(wrapped(x_um + dx), wrapped(y_um + dy)), wrapped(heading + turn)
            )
            x, y, moved = self._moved = (x + dx, y + dy, moved + turn)
        history[0] = _Past(x >> 8, y >> 8, moved >> 16, now_us >> 8)

    def correct(self, fix: PoseFix, seen_us: int) -> bool:
        """Take a camera pose of that time; False where it was not used."""
        since = self._moved_since(seen_us >> 8)
        if since is None:
            self.rejected += 1
            return False
        (x_um, y_um), heading = self.now
        seen = angle_of(heading_to_wire(fix.heading_rad)) << 16
        dx = wrapped(round(fix.x_m * UM_PER_M) - x_um + (since[0] << 8))
        dy = wrapped(round(fix.y_m * UM_PER_M) - y_um + (since[1] << 8))
        turn = wrapped(seen - heading + (since[2] << 16))
        near = abs(dx) <= JUMP_UM and abs(dy) <= JUMP_UM and abs(turn) >> JUMP_SHIFT <= JUMP_UM
        if self.known and not near:
            self._jumps += 1
            if self._jumps < JUMPS_BELIEVED:
                self.rejected += 1
                return False
        elif self.known:
            drift = self._drift + ((self._travel_um * (turn >> 16) + 0x2000 >> 14) >> 1)
            if abs(drift) <= DRIFT_MAX:
                self._drift = drift
            dx, dy, turn = ((shift + 2) >> GAIN_SHIFT for shift in (dx, dy, turn))
        self.now = RobotPose(Place(wrapped(x_um + dx), wrapped(y_um + dy)), wrapped(heading + turn))
        self._jumps = 0
        self._travel_um = 0
        self.known = True
        self.fix_us = seen_us if self.fix_us is None else max(self.fix_us, seen_us)
        return True

    def _moved_since(self, time: int) -> tuple[int, int, int] | None:
        """What the wheels have done since, interpolated; None where it is forgotten."""
        now = later = self._history[0]
        for past in self._history:
            since = wrapped_short(time - past.time)
            if since >= 0:
                break
            later = past
        else:
            return None
        part = 0
        if later is not past:
            part = (since << 14) // ((later.time - past.time) & 0xFFFF)
        return (
            _since(now.x, past.x, later.x, part),
            _since(now.y, past.y, later.y, part),
            _since(now.angle, past.angle, later.angle, part),
        )


def _since(now: int, past: int, later: int, part: int) -> int:
    return wrapped_short(now - past - (wrapped_short(later - past) * part + 0x2000 >> 14))

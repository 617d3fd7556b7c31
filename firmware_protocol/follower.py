"""The follower: drives a differential-drive robot along the queued waypoints.

- Between waypoints: pure pursuit (Coulter, 1992) of the polyline through them; beyond a stop
  the last line is extended, so that the robot runs straight into its target.
- Speed: at every waypoint ahead at most its own, zero at stops, sharp corners and the end of
  the queue, and in between no more than the brakes can take back.
- A corner sharper than TURN_ENTER is taken standing. At a stop the robot settles, drives the
  last millimetres where needed, turns to the heading asked for, and dwells.
- Whole numbers only, the same as in ``firmware/follower.c``: micrometres, binary angles, speeds
  in mm/s times 1024 (``fixed_point``). Turning is half the difference of the wheels' speeds,
  "spin", positive to the left. No clock, no I/O: one :meth:`Follower.step` per control cycle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final, NamedTuple

from firmware_protocol.drive_settings import DriveConstants, DriveSettings
from firmware_protocol.fixed_point import (
    Place,
    angle_of,
    between,
    measured,
    mrad,
    root,
    scale,
    turned,
    wrapped,
)
from firmware_protocol.pose_estimate import RobotPose
from firmware_protocol.waypoint_record import HEADING_FREE, Target

TURN_ENTER: Final = mrad(800)
TURN_STANDING: Final = mrad(200)
"""A robot that stands turns first where it would otherwise swing out."""
STANDING_Q10: Final = 20 << 10
TURN_EXIT: Final = mrad(40)
PASS_RADIUS_UM: Final = 5_000
"""A waypoint without a radius of its own counts as passed within this distance."""
START_RADIUS_UM: Final = 20_000
"""The first waypoint after START counts as passed within this distance: a plan begins where
the robot stood a moment ago."""
STOP_TOLERANCE_UM: Final = 3_000
TURNED_TOLERANCE_UM: Final = 4_500
HEADING_TOLERANCE: Final = mrad(6)
SETTLE_US: Final = 250_000
STUCK_US: Final = 3_000_000
DOCK_ATTEMPTS: Final = 8
CRAWL_Q10: Final = 10 << 10
DOCK_SPEED_Q10: Final = 60 << 10
DOCK_BEARING: Final = mrad(150)
SHORT_UM: Final = 1_000
"""A line shorter than this has no direction."""
FAR_UM: Final = 1 << 28
"""268 m; a line counts as no longer."""
BRAKES_FAR_UM: Final = 0x3FFFFF


class Phase(IntEnum):
    """What the follower is doing for the waypoint at the head of the queue."""

    TRACK = 0
    """Following the line."""
    TURN = 1
    """Turning on the spot towards the line."""
    SETTLE = 2
    """Standing, until the pose is sure."""
    DOCK = 3
    """Driving the last millimetres."""
    ALIGN = 4
    """Turning to the final heading."""
    DWELL = 5
    """Standing as long as asked."""


class Trouble(Enum):
    """Why the follower gives up."""

    OFF_PATH = "too far from the line"
    STUCK = "no progress"


@dataclass(frozen=True, slots=True)
class Step:
    """One cycle's answer: how many waypoints were executed, and any trouble."""

    executed: int = 0
    trouble: Trouble | None = None


class _Sight(NamedTuple):
    """The way to the waypoint at the queue's head, and where the robot is on it."""

    leg: tuple[int, int]
    """Length and direction."""
    distance_um: int
    """Of the robot from the waypoint."""
    remaining_um: int
    """Along the leg; negative behind the waypoint."""
    beside_um: int
    """Beside the leg, or behind its beginning."""


class Follower:
    """Keeps the phase and the line's start; the queue and the pose are passed in."""

    def __init__(self, settings: DriveSettings) -> None:
        self.constants = DriveConstants.of(settings)
        self.phase = Phase.TRACK
        self.speed_q10 = 0
        self.spin_q10 = 0
        self._bend = 0
        """Spin over speed, times 16384: as steered last."""
        self._from = Place(0, 0)
        self._from_speed_mm_s = 0
        self._first = True
        self._attempts = 0
        self._docking = False
        self._still_us = 0
        self._progress = RobotPose(Place(0, 0), 0)
        self._progress_us = 0

    def begin(self, pose: RobotPose) -> None:
        """A START: the line begins where the robot is."""
        self.phase = Phase.TRACK
        self._from = pose.place
        self._from_speed_mm_s = 0
        self._first = True
        self._new_target()
        self._progress, self._progress_us = pose, 0

    def halt(self, dt_us: int, pose: RobotPose, targets: Sequence[Target]) -> Step:
        """A stop under control: slow down, along the line as long as there is one."""
        if self.speed_q10 <= 0 or self.phase is not Phase.TRACK:
            self._stand(0, dt_us)
            return Step()
        executed, sight = self._pass_waypoints(pose, targets)
        if sight is not None and self.phase is Phase.TRACK:
            self._steer(pose, targets[executed:], sight)
        self._drive_along(0, dt_us)
        return Step(executed)

    def freeze(self) -> None:
        """An emergency stop: zero at once."""
        self.speed_q10 = self.spin_q10 = 0

    def step(self, dt_us: int, pose: RobotPose, still: bool, targets: Sequence[Target]) -> Step:
        """One control cycle towards ``targets``, of which the first is next.

        ``still``: the wheels stand, as their encoders say.
        """
        executed, sight = self._pass_waypoints(pose, targets)
        targets = targets[executed:]
        trouble = None
        if sight is None:
            self._progress_us = 0
            self._stand(0, dt_us)
            return Step(executed)
        match self.phase:
            case Phase.TRACK | Phase.TURN:
                trouble = self._track(dt_us, pose, targets, sight)
            case Phase.SETTLE:
                self._settle(dt_us, still, targets[0], sight)
            case Phase.DOCK:
                self._dock(dt_us, pose, targets[0])
            case Phase.ALIGN:
                self._align(dt_us, pose, still, targets[0], sight)
            case Phase.DWELL:
                self._stand(0, dt_us)
                self._still_us += dt_us
                if self._still_us > targets[0].dwell * 100_000:
                    executed += 1
                    self.phase = Phase.TRACK
                    self._leave(targets[0])
        stuck = trouble is None and (self._attempts > DOCK_ATTEMPTS or self._is_stuck(dt_us, pose))
        return Step(executed, Trouble.STUCK if stuck else trouble)

    # The line.

    def _look(self, pose: RobotPose, target: Target) -> _Sight:
        distance, _ = measured(*between(pose.place, target.place))
        length, direction = measured(*between(self._from, target.place))
        if length < SHORT_UM // 10:
            return _Sight((length, direction), distance, 0, 0)
        along, beside = turned(*between(self._from, pose.place), wrapped(-direction))
        return _Sight((length, direction), distance, length - along, max(abs(beside), -along))

    def _pass_waypoints(
        self, pose: RobotPose, targets: Sequence[Target]
    ) -> tuple[int, _Sight | None]:
        """How many waypoints have been passed, and the way to the next one if there is one."""
        passed = 0
        while passed < len(targets):
            target = targets[passed]
            sight = self._look(pose, target)
            if self.phase > Phase.TURN:
                return passed, sight
            if target.flags:
                if self._first and sight.distance_um <= START_RADIUS_UM:
                    self.phase = Phase.SETTLE
                return passed, sight
            radius = max(target.acceptance * 100, PASS_RADIUS_UM)
            if self._first:
                radius = max(radius, START_RADIUS_UM)
            if passed + 1 < len(targets) and _next_leg(sight.leg, target, targets[passed + 1])[0]:
                radius = START_RADIUS_UM if self._first else STOP_TOLERANCE_UM
            if sight.distance_um > radius and sight.remaining_um > 0:
                return passed, sight
            self._leave(target)
            self._first = False
            passed += 1
        return passed, None

    def _track(
        self, dt_us: int, pose: RobotPose, targets: Sequence[Target], sight: _Sight
    ) -> Trouble | None:
        if targets[0].flags and sight.remaining_um <= SHORT_UM:
            self.phase = Phase.SETTLE
            self._stand(0, dt_us)
            return None
        if sight.beside_um > self.constants.max_deviation_um:
            return Trouble.OFF_PATH
        speed, off = self._steer(pose, targets, sight)
        enter = TURN_STANDING if self.speed_q10 < STANDING_Q10 else TURN_ENTER
        if abs(off) > (TURN_EXIT if self.phase is Phase.TURN else enter):
            self.phase = Phase.TURN
            self._stand(self._turn_towards(off), dt_us)
            return None
        self.phase = Phase.TRACK
        self._first = False
        self._drive_along(max(speed, CRAWL_Q10), dt_us)
        return None

    def _steer(self, pose: RobotPose, targets: Sequence[Target], sight: _Sight) -> tuple[int, int]:
        """Steer to the pursued point (``_bend``); the speed allowed, and the point's bearing."""
        pursued, speed = self._walk(targets, sight)
        distance, bearing = measured(*between(pose.place, pursued))
        off = wrapped(bearing - pose.heading)
        _, sine = turned(32768, 0, abs(off) if off != -0x80000000 else off)
        # pure pursuit: the bend is twice the bearing's sine over the distance
        bend = (self.constants.track_eighths * _unsigned(sine) >> 1) // max(1, distance >> 3)
        bend = min(bend, 0xFFFF)
        self._bend = -bend if off < 0 else bend
        coarse = bend >> 4
        if coarse:
            speed = min(
                speed,
                root(self.constants.bend_limit // coarse) * 1024,
                (self.constants.max_spin_mm_s << 20) // coarse,
            )
        return speed, off

    def _walk(self, targets: Sequence[Target], sight: _Sight) -> tuple[Place, int]:
        """Along the line ahead: the point that is pursued, and what speed the waypoints allow.

        Each waypoint allows its own speed plus what the brakes take back on the way there.
        """
        constants = self.constants
        lookahead = constants.lookahead_um
        lookahead += scale(abs(self.speed_q10), constants.lookahead_ms) * 64
        either = max(self._from_speed_mm_s, targets[0].speed_mm_s)
        fast = constants.max_speed_mm_s
        # a line is driven at the speed of its faster end
        fast = min(fast, either) if either else fast
        square = fast * fast
        leg, ahead = sight.leg, sight.remaining_um
        pursued: Place | None = None
        for index, target in enumerate(targets):
            corner, following = False, leg
            last = index + 1 >= len(targets) or target.flags != 0
            if not last:
                corner, following = _next_leg(leg, target, targets[index + 1])
            last = last or corner
            ahead = max(0, min(FAR_UM, ahead))
            if pursued is None and (last or ahead >= lookahead):
                dx, dy = turned(lookahead - ahead, 0, leg[1])
                pursued = Place(wrapped(target.place.x_um + dx), wrapped(target.place.y_um + dy))
            allowed = braked(ahead, constants.brake_mm_s2)
            if last:
                assert pursued is not None
                return pursued, approach(min(allowed, square), ahead)
            if pursued is not None and allowed >= square:
                return pursued, root(square) * 1024
            square = min(square, allowed + target.speed_mm_s * target.speed_mm_s)
            ahead += following[0]
            leg = following
        raise AssertionError("a line without an end")

    # The stop.

    def _stands_long_enough(self, dt_us: int, still: bool) -> bool:
        self._stand(0, dt_us)
        if not still or self.speed_q10 != 0 or self.spin_q10 != 0:
            self._still_us = 0
            return False
        self._still_us += dt_us
        return self._still_us >= SETTLE_US

    def _is_there(self, target: Target, sight: _Sight, tolerance_um: int) -> bool:
        """Whether the robot stands near enough; otherwise it docks."""
        self._still_us = 0
        if sight.distance_um <= max(target.acceptance * 100, tolerance_um):
            return True
        self.phase, self._docking = Phase.DOCK, False
        self._attempts += 1
        return False

    def _settle(self, dt_us: int, still: bool, target: Target, sight: _Sight) -> None:
        if self._stands_long_enough(dt_us, still) and self._is_there(
            target, sight, STOP_TOLERANCE_UM
        ):
            self.phase = Phase.DWELL if target.heading == HEADING_FREE else Phase.ALIGN

    def _dock(self, dt_us: int, pose: RobotPose, target: Target) -> None:
        """Drive straight to the target, forwards or backwards, turning towards it first."""
        forward, sideways = turned(*between(pose.place, target.place), wrapped(-pose.heading))
        back = forward < 0
        if back:
            forward, sideways = -forward, -sideways
        if not self._docking and abs(sideways) > STOP_TOLERANCE_UM * 3 // 10:
            _, off = measured(forward, sideways)
            if abs(off) > DOCK_BEARING:
                self._stand(self._turn_towards(off), dt_us)
                return
        self._docking = True
        if forward < 700:
            self._stand(0, dt_us)
            self.phase, self._still_us = Phase.SETTLE, 0
            return
        speed = max(CRAWL_Q10, min(DOCK_SPEED_Q10, 4 * forward))
        self._slew_speed(-speed if back else speed, dt_us)
        self._slew_spin(0, dt_us)

    def _align(
        self, dt_us: int, pose: RobotPose, still: bool, target: Target, sight: _Sight
    ) -> None:
        off = wrapped(angle_of(target.heading) - pose.heading)
        if abs(off) > HEADING_TOLERANCE:
            self._still_us = 0
            self._stand(self._turn_towards(off), dt_us)
        elif self._stands_long_enough(dt_us, still) and self._is_there(
            target, sight, TURNED_TOLERANCE_UM
        ):
            self.phase = Phase.DWELL

    # Both.

    def _turn_towards(self, off: int) -> int:
        arc_um = scale(self.constants.perimeter_um, abs(off) >> 16)
        spin = approach(braked(arc_um, self.constants.spin_brake_mm_s2), arc_um)
        spin = max(min(spin, self.constants.max_spin_mm_s * 1024), self.constants.min_spin_q10)
        return -spin if off < 0 else spin

    def _slew_speed(self, wanted: int, dt_us: int) -> None:
        """Move the commanded speed towards this, no faster than the settings allow."""
        step = dt_us * self.constants.speed_per_cycle >> 12
        self.speed_q10 += max(-step, min(step, wanted - self.speed_q10))

    def _slew_spin(self, wanted: int, dt_us: int) -> None:
        step = dt_us * self.constants.spin_per_cycle >> 12
        self.spin_q10 += max(-step, min(step, wanted - self.spin_q10))

    def _stand(self, spin: int, dt_us: int) -> None:
        self._slew_speed(0, dt_us)
        self._slew_spin(spin, dt_us)

    def _drive_along(self, speed: int, dt_us: int) -> None:
        self._slew_speed(speed, dt_us)
        spin = scale(self.speed_q10, abs(self._bend)) * 4
        self._slew_spin(-spin if self._bend < 0 else spin, dt_us)

    def _leave(self, target: Target) -> None:
        """``target`` is executed: the line to the next one begins there."""
        self._from = target.place
        self._from_speed_mm_s = target.speed_mm_s
        self._new_target()

    def _new_target(self) -> None:
        self._attempts = 0
        self._still_us = 0
        self._docking = False

    def _is_stuck(self, dt_us: int, pose: RobotPose) -> bool:
        was = self._progress
        if (
            self.phase in (Phase.SETTLE, Phase.DWELL)
            or abs(wrapped(pose.place.x_um - was.place.x_um)) > 3_000
            or abs(wrapped(pose.place.y_um - was.place.y_um)) > 3_000
            or abs(wrapped(pose.heading - was.heading)) > mrad(30)
        ):
            self._progress, self._progress_us = pose, 0
            return False
        self._progress_us += dt_us
        return self._progress_us > STUCK_US


def _next_leg(
    leg: tuple[int, int], target: Target, following: Target
) -> tuple[bool, tuple[int, int]]:
    """Whether the line bends at ``target`` too much to be driven, and the leg behind it.

    A short leg keeps the direction of the one before.
    """
    length, direction = measured(*between(target.place, following.place))
    if length < SHORT_UM:
        direction = leg[1]
    corner = leg[0] >= SHORT_UM and abs(wrapped(direction - leg[1])) > TURN_ENTER
    return corner, (length, direction)


def braked(distance_um: int, brake_mm_s2: int) -> int:
    """The square of the speed in mm/s that brakes take back within a distance.

    Brakes are believed to be 2 % weaker than they are, so that a thousand may be 1024.
    """
    return ((min(distance_um, BRAKES_FAR_UM) >> 6) * brake_mm_s2) >> 4


def approach(square: int, distance_um: int) -> int:
    """The speed towards a stop, from the square of what the brakes allow.

    The square root alone would arrive with a jerk that slow motors cannot follow, so near the
    stop the speed is four times the distance left, a second.
    """
    return min(root(square) * 1024, 4 * distance_um)


def _unsigned(number: int) -> int:
    return number & 0xFFFFFFFF

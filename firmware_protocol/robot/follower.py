"""The follower: drives a differential-drive robot along the queued waypoints.

- Between waypoints: pure pursuit (Coulter, 1992) of the polyline through them; beyond a stop
  the last line is extended, so that the robot runs straight into its target.
- Speed: at every waypoint ahead at most its own, zero at stops, sharp corners and the end of
  the queue, and in between no more than the brakes can take back.
- A corner sharper than TURN_ENTER is taken standing. At a stop the robot settles, drives the
  last millimetres where needed, turns to the heading asked for, and dwells.
- Where the robot is on the line and what lies ahead: `line`.
- Whole numbers only, the same as in ``firmware/follower.c``: lengths are counts of 64 um and end
  at 2 m, further than any brake or look ahead; angles 2**16 a turn (``fixed_point``); speeds
  eighths of mm/s. Turning is half the difference of the wheels' speeds, "spin", positive to the
  left. No clock, no I/O: one :meth:`Follower.step` per control cycle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final

from firmware_protocol.robot.line import (
    FAR,
    SHORT,
    TURN_ENTER,
    Sight,
    approach,
    braked,
    length,
    look,
    next_leg,
    walk,
)
from firmware_protocol.robot.pose_estimate import RobotPose
from firmware_protocol.wire.drive_settings import DriveConstants, DriveSettings
from firmware_protocol.wire.fixed_point import (
    HALF_TURN,
    Place,
    angle_of,
    aside,
    between,
    clip,
    measured,
    mrad,
    part_of,
    sine,
    turned,
)
from firmware_protocol.wire.waypoint_record import HEADING_FREE, Target

TURN_STANDING: Final = mrad(200)
"""A robot that stands turns first where it would otherwise swing out."""
STANDING: Final = 20 * 8
TURN_EXIT: Final = mrad(40)
PASS_RADIUS: Final = length(5_000)
"""A waypoint without a radius of its own counts as passed within this distance."""
START_RADIUS: Final = length(20_000)
"""The first waypoint after START counts as passed within this distance: a plan begins where
the robot stood a moment ago."""
STOP_TOLERANCE: Final = length(2_000)
TURNED_TOLERANCE: Final = length(3_000)
SETTLE_US: Final = 250_000
STOOD_UM: Final = 1_000
"""A robot that travels further while it settles does not stand: 4 mm/s. One late step of both
encoders, 250 um, is no movement."""
CLEARLY_UM: Final = 2_000
"""What counts as the travel of wheels that clearly turn."""
STUCK_US: Final = 3_000_000
PROGRESS: Final = 12
"""Of 256 um: 3 mm."""
PROGRESS_ANGLE: Final = mrad(30)
DOCK_ATTEMPTS: Final = 8
CRAWL: Final = 10 * 8
DOCK_SPEED: Final = 60 * 8
DOCK_BEARING: Final = mrad(150)
SIDEWAYS: Final = length(900)
DOCKED: Final = length(700)
MOST_SPIN: Final = 2_000 * 8
BEND_MAX: Final = 0x7FFF


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


class Follower:
    """Keeps the phase and the line's start; the queue and the pose are passed in."""

    def __init__(self, settings: DriveSettings) -> None:
        self.constants = DriveConstants.of(settings)
        self.phase = Phase.TRACK
        self.speed = 0
        self.spin = 0
        self._bend = 0
        """Spin over speed, times 16384: as steered last."""
        self._dt_us = 0
        self._from = Place(0, 0)
        self._from_speed_mm_s = 0
        self._first = True
        self._attempts = 0
        self._docking = False
        self._still_us = 0
        self._stood_um = 0
        """Travelled while standing."""
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
        self._dt_us = dt_us
        if self.speed <= 0 or self.phase is not Phase.TRACK:
            self._stand()
            return _NOTHING
        executed, sight = self._pass_waypoints(pose, targets)
        if sight is not None and self.phase is Phase.TRACK:
            self._steer(pose, targets[executed:], sight)
        self._drive_along(0)
        return Step(executed)

    def freeze(self) -> None:
        """An emergency stop: zero at once."""
        self.speed = self.spin = 0

    def step(
        self, dt_us: int, pose: RobotPose, ahead_um: int | None, targets: Sequence[Target]
    ) -> Step:
        """One control cycle towards ``targets``, of which the first is next.

        ``ahead_um``: what the wheels have travelled in it; None where they clearly turn.
        """
        self._dt_us = dt_us
        executed, sight = self._pass_waypoints(pose, targets)
        if sight is None:
            self._progress_us = 0
            self._stand()
            return Step(executed)
        targets = targets[executed:] if executed else targets
        target, trouble = targets[0], None
        match self.phase:
            case Phase.TRACK | Phase.TURN:
                trouble = self._track(pose, targets, sight)
            case Phase.SETTLE:
                if self._has_settled(ahead_um, target, sight, STOP_TOLERANCE):
                    self.phase = Phase.DWELL if target.heading == HEADING_FREE else Phase.ALIGN
            case Phase.DOCK:
                self._dock(pose, target)
            case Phase.ALIGN:
                self._align(pose, ahead_um, target, sight)
            case Phase.DWELL:
                self._stand()
                self._still_us += dt_us
                if self._still_us >= target.dwell * 100_000:
                    executed += 1
                    self.phase = Phase.TRACK
                    self._leave(target)
        if trouble is None and (self._attempts > DOCK_ATTEMPTS or self._is_stuck(pose)):
            trouble = Trouble.STUCK
        return Step(executed, trouble) if executed or trouble else _NOTHING

    # The line.

    def _pass_waypoints(
        self, pose: RobotPose, targets: Sequence[Target]
    ) -> tuple[int, Sight | None]:
        """How many waypoints have been passed, and the way to the next one if there is one."""
        passed = 0
        while passed < len(targets):
            target = targets[passed]
            sight = look(self._from, pose, target)
            if self.phase > Phase.TURN:
                return passed, sight
            if target.flags:
                if self._first and sight.distance <= START_RADIUS:
                    self.phase = Phase.SETTLE
                return passed, sight
            radius = max(target.acceptance * 25 >> 4, PASS_RADIUS)
            if passed + 1 < len(targets) and next_leg(sight.leg, target, targets[passed + 1])[0]:
                radius = STOP_TOLERANCE
            if self._first:
                radius = max(radius, START_RADIUS)
            if sight.distance > radius and sight.remaining > 0:
                return passed, sight
            self._leave(target)
            self._first = False
            passed += 1
        return passed, None

    def _track(self, pose: RobotPose, targets: Sequence[Target], sight: Sight) -> Trouble | None:
        if targets[0].flags and sight.remaining <= SHORT:
            self.phase = Phase.SETTLE
            self._stand()
            return None
        if sight.beside > self.constants.max_deviation:
            return Trouble.OFF_PATH
        speed, off = self._steer(pose, targets, sight)
        enter = TURN_STANDING if self.speed < STANDING else TURN_ENTER
        if aside(off) > (TURN_EXIT if self.phase is Phase.TURN else enter):
            self.phase = Phase.TURN
            self._turn_towards(off)
            return None
        self.phase = Phase.TRACK
        self._first = False
        self._drive_along(max(speed, CRAWL))
        return None

    def _steer(self, pose: RobotPose, targets: Sequence[Target], sight: Sight) -> tuple[int, int]:
        """Steer to the pursued point (``_bend``); the speed allowed, and the point's bearing."""
        constants = self.constants
        pursued, square, stop = walk(
            constants, self.speed, self._from_speed_mm_s, pose, targets, sight
        )
        distance, bearing = measured(*pursued)
        off = bearing - (pose.heading >> 16) & 0xFFFF
        # pure pursuit: the bend is twice the bearing's sine over the distance
        bend = constants.track * sine(aside(off)) // (clip(distance >> 4, FAR) or 1)
        bend = min(bend, BEND_MAX)
        self._bend = -bend if off & HALF_TURN else bend
        coarse = (bend >> 4) + 1
        speed = approach(min(square, constants.bend_limit // coarse), stop)
        return min(speed, (constants.max_spin_mm_s << 13) // coarse), off

    # The stop.

    def _has_settled(
        self, ahead_um: int | None, target: Target, sight: Sight, tolerance: int
    ) -> bool:
        """Whether the robot has stood long enough, and stands near enough; otherwise it docks."""
        self._stand()
        stood_um = self._stood_um if self._still_us else 0
        stood_um += ahead_um if ahead_um is not None else CLEARLY_UM
        if abs(stood_um) > STOOD_UM or self.speed != 0 or self.spin != 0:
            self._still_us = 0
            return False
        self._stood_um = stood_um
        self._still_us += self._dt_us
        if self._still_us < SETTLE_US:
            return False
        self._still_us = 0
        if sight.distance <= max(target.acceptance * 25 >> 4, tolerance):
            return True
        self.phase, self._docking = Phase.DOCK, False
        self._attempts += 1
        return False

    def _dock(self, pose: RobotPose, target: Target) -> None:
        """Drive straight to the target, forwards or backwards, turning towards it first."""
        x, y = turned(*between(pose.place, target.place), -(pose.heading >> 16))
        back = x < 0
        if back:
            x, y = -x, -y
        forward = clip(x >> 4, FAR)
        if not self._docking and abs(clip(y >> 4, FAR)) > SIDEWAYS:
            _, off = measured(x, y)
            if aside(off) > DOCK_BEARING:
                self._turn_towards(off)
                return
        self._docking = True
        if forward < DOCKED:
            self._stand()
            self.phase, self._still_us = Phase.SETTLE, 0
            return
        speed = max(CRAWL, min(DOCK_SPEED, 2 * forward))
        self._move(-speed if back else speed, 0)

    def _align(self, pose: RobotPose, ahead_um: int | None, target: Target, sight: Sight) -> None:
        off = angle_of(target.heading) - (pose.heading >> 16) & 0xFFFF
        if aside(off) > self.constants.heading_tolerance:
            self._still_us = 0
            self._turn_towards(off)
        elif self._has_settled(ahead_um, target, sight, TURNED_TOLERANCE):
            self.phase = Phase.DWELL

    # Both.

    def _turn_towards(self, off: int) -> None:
        constants = self.constants
        arc = part_of(constants.perimeter, aside(off))
        spin = approach(braked(arc, constants.spin_brake_mm_s2), arc)
        spin = max(min(spin, constants.max_spin_mm_s * 8), constants.min_spin)
        self._move(0, -spin if off & HALF_TURN else spin)

    def _move(self, speed: int, spin: int) -> None:
        """Move the commanded speeds towards these, no faster than the settings allow."""
        step = self._dt_us * self.constants.speed_per_cycle >> 16
        self.speed += clip(speed - self.speed, step)
        step = self._dt_us * self.constants.spin_per_cycle >> 16
        self.spin += clip(spin - self.spin, step)

    def _stand(self) -> None:
        self._move(0, 0)

    def _drive_along(self, speed: int) -> None:
        step = self._dt_us * self.constants.speed_per_cycle >> 16
        self.speed += clip(speed - self.speed, step)
        self._move(self.speed, clip(self.speed * self._bend >> 14, MOST_SPIN))

    def _leave(self, target: Target) -> None:
        """``target`` is executed: the line to the next one begins there."""
        self._from = target.place
        self._from_speed_mm_s = target.speed_mm_s
        self._new_target()

    def _new_target(self) -> None:
        self._attempts = 0
        self._still_us = 0
        self._docking = False

    def _is_stuck(self, pose: RobotPose) -> bool:
        was = self._progress
        if (
            self.phase in (Phase.SETTLE, Phase.DWELL)
            or aside((pose.place.x_um >> 8) - (was.place.x_um >> 8)) > PROGRESS
            or aside((pose.place.y_um >> 8) - (was.place.y_um >> 8)) > PROGRESS
            or aside((pose.heading >> 16) - (was.heading >> 16)) > PROGRESS_ANGLE
        ):
            self._progress, self._progress_us = pose, 0
            return False
        self._progress_us += self._dt_us
        return self._progress_us > STUCK_US


_NOTHING: Final = Step()

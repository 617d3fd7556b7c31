"""The follower: drives a differential-drive robot along the queued waypoints.

- Between waypoints: pure pursuit (Coulter, 1992) of the polyline through them; beyond a stop
  the last line is extended, so that the robot runs straight into its target.
- Speed: at every waypoint ahead at most its own, zero at stops, sharp corners and the end of
  the queue, and in between no more than the brakes can take back.
- A corner sharper than TURN_ENTER_RAD is taken standing. At a stop the robot settles, drives
  the last millimetres where needed, turns to the heading asked for, and dwells.
- Metres, radians, seconds. No clock, no I/O: one :meth:`Follower.step` per control cycle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

from firmware_protocol.messages import Waypoint, wrap_angle
from firmware_protocol.pose_estimate import Pose

TURN_ENTER_RAD: Final = 0.8
TURN_STANDING_RAD: Final = 0.2
"""A robot that stands turns first where it would otherwise swing out."""
STANDING_M_S: Final = 0.02
TURN_EXIT_RAD: Final = 0.04
PASS_RADIUS_M: Final = 0.005
"""A waypoint without a radius of its own counts as passed within this distance."""
START_RADIUS_M: Final = 0.02
"""The first waypoint after START counts as passed within this distance: a plan begins where
the robot stood a moment ago."""
STOP_TOLERANCE_M: Final = 0.003
HEADING_TOLERANCE_RAD: Final = 0.006
SETTLE_S: Final = 0.25
STUCK_S: Final = 3.0
DOCK_ATTEMPTS: Final = 8
CRAWL_M_S: Final = 0.01
DOCK_SPEED_M_S: Final = 0.06
APPROACH_PER_S: Final = 4.0
"""Near a stop the speed is this times the distance left."""


@dataclass(frozen=True, slots=True)
class DriveSettings:
    """What the robot is and can do; every value > 0."""

    track_m: float = 0.12
    max_speed_m_s: float = 0.5
    acceleration_m_s2: float = 0.5
    lateral_m_s2: float = 0.6
    max_turn_rad_s: float = 2.5
    turn_acceleration_rad_s2: float = 8.0
    lookahead_m: float = 0.04
    lookahead_s: float = 0.15
    max_deviation_m: float = 0.15


class Phase(Enum):
    """What the follower is doing for the waypoint at the head of the queue."""

    TRACK = "following the line"
    TURN = "turning on the spot towards the line"
    SETTLE = "standing, until the pose is sure"
    DOCK = "driving the last millimetres"
    ALIGN = "turning to the final heading"
    DWELL = "standing as long as asked"


class Trouble(Enum):
    """Why the follower gives up."""

    OFF_PATH = "too far from the line"
    STUCK = "no progress"


@dataclass(frozen=True, slots=True)
class Step:
    """One cycle's answer: speeds, how many waypoints were executed, and any trouble."""

    speed_m_s: float
    turn_rad_s: float
    executed: int = 0
    trouble: Trouble | None = None


class Follower:
    """Keeps the phase and the line's start; the queue and the pose are passed in."""

    def __init__(self, settings: DriveSettings) -> None:
        self.settings = settings
        self.phase = Phase.TRACK
        self.speed_m_s = 0.0
        self.turn_rad_s = 0.0
        self._from = (0.0, 0.0)
        self._from_speed_m_s = 0.0
        self._first = True
        self._attempts = 0
        self._docking = False
        self._still_s = 0.0
        self._progress_pose = Pose(0.0, 0.0, 0.0)
        self._progress_s = 0.0

    def begin(self, pose: Pose) -> None:
        """A START: the line begins where the robot is."""
        self.phase = Phase.TRACK
        self._from = (pose.x_m, pose.y_m)
        self._from_speed_m_s = 0.0
        self._first = True
        self._new_target()
        self._progress_pose, self._progress_s = pose, 0.0

    def halt(self, dt_s: float, pose: Pose, targets: Sequence[Waypoint]) -> Step:
        """A stop under control: slow down, along the line as long as there is one."""
        if self.speed_m_s <= 0.0 or self.phase is not Phase.TRACK:
            self._slew(0.0, 0.0, dt_s)
            return Step(self.speed_m_s, self.turn_rad_s)
        executed = self._pass_waypoints(pose, targets)
        targets = targets[executed:]
        if targets and self.phase is Phase.TRACK:
            curvature, _ = self._steer(pose, targets)
        else:
            curvature = self.turn_rad_s / self.speed_m_s
        self._slew(0.0, None, dt_s, curvature)
        return Step(self.speed_m_s, self.turn_rad_s, executed)

    def freeze(self) -> None:
        """An emergency stop: zero at once."""
        self.speed_m_s = self.turn_rad_s = 0.0

    def step(
        self, dt_s: float, pose: Pose, measured_m_s: float, targets: Sequence[Waypoint]
    ) -> Step:
        """One control cycle of ``dt_s`` towards ``targets``, of which the first is next."""
        executed = self._pass_waypoints(pose, targets)
        targets = targets[executed:]
        trouble = None
        if not targets:
            self._progress_s = 0.0
            self._slew(0.0, 0.0, dt_s)
            return Step(self.speed_m_s, self.turn_rad_s, executed)
        match self.phase:
            case Phase.TRACK | Phase.TURN:
                trouble = self._track(dt_s, pose, targets)
            case Phase.SETTLE:
                self._slew(0.0, 0.0, dt_s)
                self._settle(dt_s, pose, measured_m_s, targets[0])
            case Phase.DOCK:
                self._dock(dt_s, pose, targets[0])
            case Phase.ALIGN:
                self._align(dt_s, pose, measured_m_s, targets[0])
            case Phase.DWELL:
                self._slew(0.0, 0.0, dt_s)
                self._still_s += dt_s
                if self._still_s >= targets[0].dwell_s:
                    executed += 1
                    self._leave(targets[0])
                    self.phase = Phase.TRACK
                    self._new_target()
        if trouble is None and self._attempts > DOCK_ATTEMPTS:
            trouble = Trouble.STUCK
        if trouble is None and self._is_stuck(dt_s, pose):
            trouble = Trouble.STUCK
        return Step(self.speed_m_s, self.turn_rad_s, executed, trouble)

    # The line.

    def _pass_waypoints(self, pose: Pose, targets: Sequence[Waypoint]) -> int:
        passed = 0
        while self.phase in (Phase.TRACK, Phase.TURN) and passed < len(targets):
            target = targets[passed]
            after = targets[passed + 1] if passed + 1 < len(targets) else None
            distance = math.hypot(target.x_m - pose.x_m, target.y_m - pose.y_m)
            if _stops(target):
                if self._first and distance <= START_RADIUS_M:
                    self.phase = Phase.SETTLE
                break
            radius = max(target.acceptance_m, PASS_RADIUS_M)
            if self._first:
                radius = max(radius, START_RADIUS_M)
            if self._is_corner(target, after):
                radius = STOP_TOLERANCE_M if not self._first else START_RADIUS_M
            if distance > radius and self._remaining(pose, target) > 0.0:
                break
            self._leave(target)
            self._new_target()
            self._first = False
            passed += 1
        return passed

    def _track(self, dt_s: float, pose: Pose, targets: Sequence[Waypoint]) -> Trouble | None:
        target = targets[0]
        remaining = self._remaining(pose, target)
        if _stops(target) and remaining <= 0.001:
            self.phase = Phase.SETTLE
            self._slew(0.0, 0.0, dt_s)
            return None
        if self._deviation(pose, target) > self.settings.max_deviation_m:
            return Trouble.OFF_PATH
        curvature, off = self._steer(pose, targets)
        enter = TURN_STANDING_RAD if abs(self.speed_m_s) < STANDING_M_S else TURN_ENTER_RAD
        if abs(off) > (TURN_EXIT_RAD if self.phase is Phase.TURN else enter):
            self.phase = Phase.TURN
            self._slew(0.0, self._turn_towards(off), dt_s)
            return None
        self.phase = Phase.TRACK
        speed = self._speed_limit(remaining, targets)
        if abs(curvature) > 1e-6:
            lateral = math.sqrt(self.settings.lateral_m_s2 / abs(curvature))
            speed = min(speed, lateral, self.settings.max_turn_rad_s / abs(curvature))
        self._first = False
        self._slew(max(speed, CRAWL_M_S), None, dt_s, curvature)
        return None

    def _steer(self, pose: Pose, targets: Sequence[Waypoint]) -> tuple[float, float]:
        """The curvature that leads to the pursued point, and its bearing."""
        x, y = self._lookahead(pose, targets)
        dx, dy = x - pose.x_m, y - pose.y_m
        off = wrap_angle(math.atan2(dy, dx) - pose.heading_rad)
        return 2.0 * math.sin(off) / max(1e-6, math.hypot(dx, dy)), off

    def _speed_limit(self, remaining: float, targets: Sequence[Waypoint]) -> float:
        """What the waypoints ahead allow here: each its speed plus what the brakes take back."""
        brake = 2.0 * 0.8 * self.settings.acceleration_m_s2
        allowed = self.settings.max_speed_m_s
        # a line is driven at the speed of its faster end; stops have none of their own
        either = max(self._from_speed_m_s, targets[0].speed_m_s)
        allowed = min(allowed, either) if either > 0.0 else allowed
        ahead = max(0.0, remaining)
        horizon = allowed * allowed / brake
        for index, target in enumerate(targets):
            after = targets[index + 1] if index + 1 < len(targets) else None
            if _stops(target) or after is None or self._is_corner(target, after, targets, index):
                # the square root alone would arrive with a jerk that slow motors cannot follow
                return min(allowed, math.sqrt(brake * ahead), APPROACH_PER_S * ahead)
            allowed = min(allowed, math.sqrt(target.speed_m_s**2 + brake * ahead))
            if ahead > horizon:
                break
            ahead += math.hypot(after.x_m - target.x_m, after.y_m - target.y_m)
        return allowed

    def _lookahead(self, pose: Pose, targets: Sequence[Waypoint]) -> tuple[float, float]:
        """The point on the line that is pursued."""
        left = self.settings.lookahead_m + self.settings.lookahead_s * abs(self.speed_m_s)
        start = self._from
        x, y = start
        for index, target in enumerate(targets):
            dx, dy = target.x_m - start[0], target.y_m - start[1]
            length = math.hypot(dx, dy)
            if length < 1e-4:
                continue
            ux, uy = dx / length, dy / length
            along = 0.0
            if index == 0:
                along = (pose.x_m - start[0]) * ux + (pose.y_m - start[1]) * uy
                along = max(0.0, along)
            after = targets[index + 1] if index + 1 < len(targets) else None
            last = after is None or _stops(target)
            if last or along + left <= length or self._is_corner(target, after, targets, index):
                return start[0] + ux * (along + left), start[1] + uy * (along + left)
            left -= max(0.0, length - along)
            start = (target.x_m, target.y_m)
            x, y = start
        return x, y

    def _is_corner(
        self,
        target: Waypoint,
        after: Waypoint | None,
        targets: Sequence[Waypoint] = (),
        index: int = 0,
    ) -> bool:
        """Whether the line bends at ``target`` so much that the robot has to turn standing."""
        if after is None:
            return False
        before = (targets[index - 1].x_m, targets[index - 1].y_m) if index else self._from
        ax, ay = target.x_m - before[0], target.y_m - before[1]
        bx, by = after.x_m - target.x_m, after.y_m - target.y_m
        if math.hypot(ax, ay) < 1e-3 or math.hypot(bx, by) < 1e-3:
            return False
        return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by)) > TURN_ENTER_RAD

    def _remaining(self, pose: Pose, target: Waypoint) -> float:
        """How far along the line the target still is; negative behind it."""
        dx, dy = target.x_m - self._from[0], target.y_m - self._from[1]
        length = math.hypot(dx, dy)
        if length < 1e-4:
            return 0.0
        return ((target.x_m - pose.x_m) * dx + (target.y_m - pose.y_m) * dy) / length

    def _deviation(self, pose: Pose, target: Waypoint) -> float:
        """How far the robot is beside the line, or behind its beginning."""
        dx, dy = target.x_m - self._from[0], target.y_m - self._from[1]
        length = math.hypot(dx, dy)
        if length < 1e-4:
            return 0.0
        x, y = pose.x_m - self._from[0], pose.y_m - self._from[1]
        return max(abs(y * dx - x * dy), -(x * dx + y * dy)) / length

    # The stop.

    def _settle(self, dt_s: float, pose: Pose, measured_m_s: float, target: Waypoint) -> None:
        self._count_standing(dt_s, measured_m_s)
        if self._still_s < SETTLE_S:
            return
        distance = math.hypot(target.x_m - pose.x_m, target.y_m - pose.y_m)
        if distance > max(target.acceptance_m, STOP_TOLERANCE_M):
            self.phase, self._docking = Phase.DOCK, False
            self._attempts += 1
        elif target.heading_rad is None:
            self.phase = Phase.DWELL
        else:
            self.phase = Phase.ALIGN
        self._still_s = 0.0

    def _dock(self, dt_s: float, pose: Pose, target: Waypoint) -> None:
        """Drive straight to the target, forwards or backwards, turning towards it first."""
        dx, dy = target.x_m - pose.x_m, target.y_m - pose.y_m
        c, s = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
        forward, sideways = c * dx + s * dy, c * dy - s * dx
        off = math.atan2(sideways, forward)
        if abs(off) > math.pi / 2.0:
            off = wrap_angle(off + math.pi)
        if not self._docking and abs(off) > 0.15 and abs(sideways) > 0.3 * STOP_TOLERANCE_M:
            self._slew(0.0, self._turn_towards(off), dt_s)
            return
        self._docking = True
        if abs(forward) < 0.0007:
            self._slew(0.0, 0.0, dt_s)
            self.phase, self._still_s = Phase.SETTLE, 0.0
            return
        speed = max(CRAWL_M_S, min(DOCK_SPEED_M_S, APPROACH_PER_S * abs(forward)))
        self._slew(math.copysign(speed, forward), 0.0, dt_s)

    def _align(self, dt_s: float, pose: Pose, measured_m_s: float, target: Waypoint) -> None:
        heading = pose.heading_rad if target.heading_rad is None else target.heading_rad
        off = wrap_angle(heading - pose.heading_rad)
        if abs(off) > HEADING_TOLERANCE_RAD:
            self._still_s = 0.0
            self._slew(0.0, self._turn_towards(off), dt_s)
            return
        self._slew(0.0, 0.0, dt_s)
        self._count_standing(dt_s, measured_m_s)
        if self._still_s < SETTLE_S:
            return
        self._still_s = 0.0
        distance = math.hypot(target.x_m - pose.x_m, target.y_m - pose.y_m)
        if distance > max(target.acceptance_m, 1.5 * STOP_TOLERANCE_M):
            # the turn has moved the robot: once more
            self.phase, self._docking = Phase.DOCK, False
            self._attempts += 1
        else:
            self.phase = Phase.DWELL

    def _count_standing(self, dt_s: float, measured_m_s: float) -> None:
        standing = abs(measured_m_s) < 0.004 and self.speed_m_s == 0.0 == self.turn_rad_s
        self._still_s = self._still_s + dt_s if standing else 0.0

    # Both.

    def _turn_towards(self, off_rad: float) -> float:
        limit = self.settings.turn_acceleration_rad_s2
        rate = min(
            self.settings.max_turn_rad_s,
            math.sqrt(limit * abs(off_rad)),
            APPROACH_PER_S * abs(off_rad),
        )
        return math.copysign(max(0.02, rate), off_rad)

    def _slew(self, speed: float, turn: float | None, dt_s: float, curvature: float = 0.0) -> None:
        """Move the commands towards these, no faster than the settings allow."""
        step = self.settings.acceleration_m_s2 * dt_s
        self.speed_m_s += max(-step, min(step, speed - self.speed_m_s))
        wanted = curvature * self.speed_m_s if turn is None else turn
        step = self.settings.turn_acceleration_rad_s2 * dt_s
        self.turn_rad_s += max(-step, min(step, wanted - self.turn_rad_s))

    def _leave(self, target: Waypoint) -> None:
        """``target`` is executed: the line to the next one begins there."""
        self._from = (target.x_m, target.y_m)
        self._from_speed_m_s = target.speed_m_s

    def _new_target(self) -> None:
        self._attempts = 0
        self._still_s = 0.0
        self._docking = False

    def _is_stuck(self, dt_s: float, pose: Pose) -> bool:
        moved = math.hypot(pose.x_m - self._progress_pose.x_m, pose.y_m - self._progress_pose.y_m)
        turned = abs(wrap_angle(pose.heading_rad - self._progress_pose.heading_rad))
        waiting = self.phase in (Phase.SETTLE, Phase.DWELL)
        if waiting or moved > 0.003 or turned > 0.03:
            self._progress_pose, self._progress_s = pose, 0.0
            return False
        self._progress_s += dt_s
        return self._progress_s > STUCK_S


def _stops(target: Waypoint) -> bool:
    return bool(target.flags)

"""The follower: drives a robot with two wheels along its queued waypoints.

- Between waypoints: pure pursuit (Coulter, 1992) of their polyline, extended beyond a stop.
- Speed: at every waypoint ahead at most its own, zero at stops, sharp corners and the queue's end,
  and what the brakes allow.
- The robot turns on the spot at a corner sharper than TURN_ENTER. At a stop it settles, drives the
  last millimetres if needed, turns to the heading asked for, and dwells.
- Lengths are counts of 64 um and end at 2 m (FAR), angles are 2^16 a turn, speeds eighths of mm/s.
  Turning is half the difference of the wheels' speeds, "spin": positive turns left.
- No clock, no I/O: one `step` or `halt` a control cycle.

The twin of ``follower.c``.
"""

from array import array

from .estimate import TOP
from .fixed import VECTOR, angle_of, aside, clip, measure, part, root, scale, sine, turn
from .native import micropython
from .settings import Settings
from .waypoints import FAR, WaypointQueue, begin_leg, leg_length
from .wire import HEADING_FREE, WAYPOINT_BYTES, get_i16, get_place, get_u16

TRACK, TURN, SETTLE, DOCK, ALIGN, DWELL = 0, 1, 2, 3, 4, 5
"""Phases of reaching a waypoint: follow the line; turn on the spot towards it; stand until the pose
is sure; drive the last millimetres; turn to the final heading; dwell."""
NO_TROUBLE, OFF_PATH, STUCK = 0, 1, 2
"""Reasons to give up: too far from the line, or no progress."""

TURN_ENTER = 8344
"""0.8 rad: a sharper corner is taken standing."""
TURN_STANDING = 2086
"""0.2 rad: a robot at rest turns first if it would otherwise swing out."""
TURN_EXIT = 417
"""0.04 rad."""
STANDING = 20 * 8
CRAWL = 10 * 8
PASS_RADIUS = 5000 // 64
"""Distance within which a waypoint without a radius is passed."""
START_RADIUS = 20000 // 64
"""The same for the first waypoint after START: a plan begins where the robot stood a moment ago."""
SHORT = 1000 // 64
"""Length below which a line has no direction."""
NOWHERE = 128 // 64
"""Length below which a line is none."""

STOP_TOLERANCE, TURNED_TOLERANCE = 2000 // 64, 3000 // 64
SETTLE_US = 250000
STOOD_UM = 1000
"""Travel while settling above which the robot does not stand: 4 mm/s. One late step of both
encoders, 250 um, is no movement."""
CLEARLY = 2000
"""Micrometres that count as the travel of wheels that clearly turn."""
STUCK_US = 3000000
PROGRESS = 12
"""Counts of 256 um: 3 mm."""
TURNED = 312
"""0.03 rad."""
DOCK_ATTEMPTS = 8
DOCK_SPEED = 60 * 8
DOCK_BEARING = 1564
"""0.15 rad."""
SIDEWAYS, DOCKED = 900 // 64, 700 // 64
MOST_SPIN = 2000 * 8
MOST_BEND = 0x7FFF
MOST_MM_S = 4000
"""Limit of a waypoint's speed, so that its square stays below 2^30."""
NO_LIMIT = 1 << 29
"""Above the square of any speed."""
ANY_DISTANCE = 0xFFFF


class Follower:
    """Phase, line and commanded speeds; queue and pose are the robot's."""

    def __init__(self, settings: Settings, queue: WaypointQueue, pose: "array[int]") -> None:
        self._set = settings
        self._queue = queue
        self._pose = pose
        self.speed = 0
        self.spin = 0
        self.trouble = NO_TROUBLE
        self.dt_us = 0
        """Length of the cycle of :meth:`step` or :meth:`halt`."""
        self.phase = TRACK
        self._bend = 0
        """Spin over speed, times 16384, as steered last."""
        self._attempts = 0
        self._first = True
        self._docking = False
        # the line to the next waypoint, measured once
        self._from = array("i", (0, 0))
        self._from_speed_mm_s = 0
        self._is_measured = False
        self._line_length = 0
        self._line_direction = 0
        # the leg in view: that line, then the legs between waypoints
        self._length = 0
        self._direction = 0
        # the robot on its line: distance from the waypoint; remaining along the line, negative
        # behind the waypoint; beside the line or behind its beginning
        self._distance = 0
        self._remaining = 0
        self._beside = 0
        self._stood_um = 0
        """Travel while standing."""
        self._still_us = 0
        self._progress_us = 0
        self._progress = array("H", (0, 0, 0))
        self._off = 0
        """Bearing of the pursued point."""
        self._aim = array("i", (0, 0))

    def begin(self) -> None:
        """On START, begin the line at the robot."""
        self.phase = TRACK
        self._from[0], self._from[1] = self._pose[0], self._pose[1]
        self._from_speed_mm_s = 0
        self._first = True
        self._new_target()
        self._note_progress()

    def freeze(self) -> None:
        """On an emergency stop, zero both speeds."""
        self.speed = 0
        self.spin = 0

    def forget_line(self) -> None:
        """Forget the line: the queue was dropped."""
        self._is_measured = False

    def _new_target(self) -> None:
        self._is_measured = False
        self._attempts = 0
        self._still_us = 0
        self._docking = False

    def _leave(self, at: int) -> None:
        data = self._queue.data
        self._from[0] = get_place(data, at)
        self._from[1] = get_place(data, at + 4)
        self._from_speed_mm_s = get_u16(data, at + 10)
        self._new_target()

    def _note_progress(self) -> None:
        self._progress[0] = self._pose[0] >> 8 & 0xFFFF
        self._progress[1] = self._pose[1] >> 8 & 0xFFFF
        self._progress[2] = self._pose[TOP]
        self._progress_us = 0

    @micropython.native
    def _look(self, at: int) -> None:
        data = self._queue.data
        if not self._is_measured:
            self._is_measured = True
            begin_leg(data, at, self._from[0], self._from[1])
            self._line_direction = measure()
            self._line_length = leg_length()
        self._length, self._direction = self._line_length, self._line_direction
        VECTOR[0] = (self._pose[0] >> 2) - (get_place(data, at) >> 2)
        VECTOR[1] = (self._pose[1] >> 2) - (get_place(data, at + 4) >> 2)
        bearing = measure()
        self._distance = clip(VECTOR[0] >> 4, FAR)
        self._remaining = 0
        self._beside = 0
        if self._length >= NOWHERE:
            VECTOR[1] = 0
            turn(bearing - self._direction)
            self._remaining = -clip(VECTOR[0] >> 4, FAR)
            self._beside = abs(clip(VECTOR[1] >> 4, FAR))
            behind = self._remaining - self._length
            if self._remaining > 0 and behind > self._beside:
                self._beside = behind

    @micropython.native
    def _next_leg(self, after: int) -> bool:
        """Look at the leg to the waypoint there; True if the line bends too much.

        A short leg keeps the last direction.
        """
        was_short = self._length < SHORT
        leg = after // WAYPOINT_BYTES
        self._length = self._queue.lengths[leg]
        if self._length < SHORT:
            return False
        before, self._direction = self._direction, self._queue.directions[leg]
        return not was_short and aside(self._direction - before) > TURN_ENTER

    @micropython.native
    def _slew_speed(self, wanted: int) -> None:
        """Move the speed towards ``wanted``, no faster than the settings allow."""
        self.speed += clip(wanted - self.speed, part(self.dt_us, self._set.speed_per_cycle))

    @micropython.native
    def _slew_spin(self, wanted: int) -> None:
        self.spin += clip(wanted - self.spin, part(self.dt_us, self._set.spin_per_cycle))

    @micropython.native
    def _move(self, speed: int, spin: int) -> None:
        self._slew_speed(speed)
        self._slew_spin(spin)

    @micropython.native
    def _drive_along(self, speed: int) -> None:
        self._slew_speed(speed)
        self._slew_spin(clip(self.speed * self._bend >> 14, MOST_SPIN))

    @micropython.native
    def _approach(self, square: int, distance: int) -> int:
        """Speed towards a stop, from the square of the speed the brakes allow.

        Near the stop it is four times the distance left, a second: the root alone would jerk.
        """
        speed = root(square) << 3
        return distance << 1 if distance < speed >> 1 else speed

    @micropython.native
    def _turn_towards(self, off: int) -> None:
        arc = part(self._set.perimeter, aside(off))
        spin = self._approach(arc * self._set.spin_brake_mm_s2 >> 4, arc)
        spin = min(spin, self._set.max_spin_mm_s * 8)
        spin = max(spin, self._set.min_spin)
        self._move(0, -spin if off & 0x8000 else spin)

    @micropython.native
    def _pass_waypoints(self) -> int:
        queue, data = self._queue, self._queue.data
        passed = 0
        while passed < queue.count:
            at = queue.at(passed)
            self._look(at)
            if self.phase > TURN:
                break
            if data[at + 15]:
                if self._first and self._distance <= START_RADIUS:
                    self.phase = SETTLE
                break
            radius = max(get_u16(data, at + 12) * 25 >> 4 & 0xFFFF, PASS_RADIUS)
            if passed + 1 < queue.count:
                if self._next_leg(queue.at(passed + 1)):
                    radius = STOP_TOLERANCE
                self._length, self._direction = self._line_length, self._line_direction
            if self._first and radius < START_RADIUS:
                radius = START_RADIUS
            if self._distance & 0xFFFF > radius and self._remaining > 0:
                break
            self._leave(at)
            self._first = False
            passed += 1
        return passed

    @micropython.native
    def _steer(self, begin: int) -> int:
        """Find the pursued point, its bearing ``_off`` and the bend; return the allowed speed."""
        queue, data, aim = self._queue, self._queue.data, self._aim
        at = queue.at(begin)
        found = False
        ahead = max(self._remaining, 0)
        lookahead = self._set.lookahead + (abs(self.speed) * self._set.lookahead_ms >> 9)
        fast = self._set.max_speed_mm_s
        either = max(self._from_speed_mm_s, get_u16(data, at + 10))
        if either and either < fast:
            fast = either  # a line is driven at the speed of its faster end
        square = fast * fast
        while True:
            begin += 1
            after = queue.at(begin)
            direction = self._direction
            last = begin >= queue.count or data[at + 15] != 0 or self._next_leg(after)
            if not found and (last or ahead >= lookahead):
                found = True
                VECTOR[0], VECTOR[1] = (lookahead - ahead) * 16, 0
                turn(direction)
                aim[0] = VECTOR[0] + (get_place(data, at) >> 2) - (self._pose[0] >> 2)
                aim[1] = VECTOR[1] + (get_place(data, at + 4) >> 2) - (self._pose[1] >> 2)
            allowed = ahead * self._set.brake_mm_s2 >> 4
            if last or (found and allowed >= square):
                break
            speed = min(get_u16(data, at + 10), MOST_MM_S)
            square = min(square, allowed + speed * speed)
            ahead = min(ahead + self._length, FAR)
            at = after
        VECTOR[0], VECTOR[1] = aim[0], aim[1]
        self._off = measure() - self._pose[TOP] & 0xFFFF
        self._bend = self._bend_to(clip(VECTOR[0] >> 4, FAR) & 0xFFFF)
        return self._allowed_speed(min(square, allowed), ahead if last else ANY_DISTANCE)

    @micropython.native
    def _bend_to(self, distance: int) -> int:
        bend = self._set.track * sine(aside(self._off))
        if distance:
            bend //= distance
        bend = min(bend, MOST_BEND)
        return -bend if self._off & 0x8000 else bend

    @micropython.native
    def _allowed_speed(self, square: int, distance: int) -> int:
        bend = (abs(self._bend) >> 4) + 1
        whole, rest = self._set.bend_limit // bend, self._set.bend_limit % bend
        limit = NO_LIMIT if whole >= NO_LIMIT >> 10 else whole * 1024 + rest * 1024 // bend
        speed = self._approach(min(limit, square), distance)
        return min(speed, (self._set.max_spin_mm_s << 13) // bend)

    @micropython.native
    def _track(self, begin: int) -> None:
        if self._queue.data[self._queue.at(begin) + 15] and self._remaining <= SHORT:
            self.phase = SETTLE
            self._move(0, 0)
            return
        if self._beside > self._set.max_deviation:
            self.trouble = OFF_PATH
            return
        speed = self._steer(begin)
        enter = TURN_STANDING if self.speed < STANDING else TURN_ENTER
        if self.phase == TURN:
            enter = TURN_EXIT
        if aside(self._off) > enter:
            self.phase = TURN
            self._turn_towards(self._off)
            return
        self.phase = TRACK
        self._first = False
        self._drive_along(max(speed, CRAWL))

    @micropython.native
    def _has_settled(self, ahead_um: int, at: int, tolerance: int) -> bool:
        """True if at rest long enough and near enough to the target; if not near, dock."""
        self._move(0, 0)
        if self._still_us == 0:
            self._stood_um = 0
        ahead_um += self._stood_um
        if not -STOOD_UM <= ahead_um <= STOOD_UM or self.speed or self.spin:
            self._still_us = 0
            return False
        self._stood_um = ahead_um
        self._still_us += self.dt_us
        if self._still_us < SETTLE_US:
            return False
        self._still_us = 0
        radius = get_u16(self._queue.data, at + 12) * 25 >> 4 & 0xFFFF
        if self._distance & 0xFFFF <= max(radius, tolerance):
            return True
        self.phase = DOCK
        self._docking = False
        self._attempts += 1
        return False

    @micropython.native
    def _dock(self, at: int) -> None:
        """Drive straight to the target, forwards or backwards, turning towards it first."""
        data = self._queue.data
        VECTOR[0] = (get_place(data, at) >> 2) - (self._pose[0] >> 2)
        VECTOR[1] = (get_place(data, at + 4) >> 2) - (self._pose[1] >> 2)
        turn(-self._pose[TOP])
        back = VECTOR[0] < 0
        if back:
            VECTOR[0], VECTOR[1] = -VECTOR[0], -VECTOR[1]
        ahead = clip(VECTOR[0] >> 4, FAR)
        beside = abs(clip(VECTOR[1] >> 4, FAR))
        off = measure()
        if not self._docking and beside > SIDEWAYS and aside(off) > DOCK_BEARING:
            self._turn_towards(off)
            return
        self._docking = True
        if ahead < DOCKED:
            self._move(0, 0)
            self.phase = SETTLE
            self._still_us = 0
            return
        speed = max(DOCK_SPEED if ahead > DOCK_SPEED // 2 else ahead * 2, CRAWL)
        self._move(-speed if back else speed, 0)

    @micropython.native
    def _is_stuck(self) -> bool:
        pose, progress = self._pose, self._progress
        if (
            self.phase == SETTLE
            or self.phase == DWELL
            or aside((pose[0] >> 8) - progress[0]) > PROGRESS
            or aside((pose[1] >> 8) - progress[1]) > PROGRESS
            or aside(pose[TOP] - progress[2]) > TURNED
        ):
            self._note_progress()
            return False
        self._progress_us += self.dt_us
        return self._progress_us > STUCK_US

    @micropython.native
    def halt(self) -> int:
        """Run one cycle of a controlled stop, along the line if any; return the waypoints
        executed."""
        executed = 0
        if self.speed <= 0 or self.phase != TRACK:
            self._move(0, 0)
        else:
            executed = self._pass_waypoints()
            if executed < self._queue.count and self.phase == TRACK:
                self._steer(executed)
            self._drive_along(0)
        return executed

    @micropython.native
    def step(self, ahead_um: int) -> int:
        """Run one cycle of driving; return the waypoints executed. Sets ``trouble``.

        ``ahead_um``: the wheels' travel, CLEARLY if they clearly turn.
        """
        executed = self._pass_waypoints()
        self.trouble = NO_TROUBLE
        if executed == self._queue.count:
            self._progress_us = 0
            self._move(0, 0)
            return executed
        at, data = self._queue.at(executed), self._queue.data
        if self.phase <= TURN:
            self._track(executed)
        elif self.phase == DOCK:
            self._dock(at)
        elif self.phase == DWELL:
            self._move(0, 0)
            self._still_us += self.dt_us
            if self._still_us >= data[at + 14] * 100000:
                executed += 1
                self.phase = TRACK
                self._leave(at)
        elif self.phase == ALIGN:
            off = angle_of(get_i16(data, at + 8)) - self._pose[TOP] & 0xFFFF
            if aside(off) > self._set.heading_tolerance:
                self._still_us = 0
                self._turn_towards(off)
            elif self._has_settled(ahead_um, at, TURNED_TOLERANCE):
                self.phase = DWELL
        elif self._has_settled(ahead_um, at, STOP_TOLERANCE):
            self.phase = DWELL if get_i16(data, at + 8) == HEADING_FREE else ALIGN
        if self.trouble == NO_TROUBLE and (self._attempts > DOCK_ATTEMPTS or self._is_stuck()):
            self.trouble = STUCK
        return executed


@micropython.native
def smooth(speed: int, travel_um: int, share: int) -> int:
    """Measured speed, drawn to this cycle's travel, 30 ms smooth; 17/64 is 8 over 30."""
    return clip(speed + (travel_um * 17 >> 6) - scale(speed, share), 0x7FFF)

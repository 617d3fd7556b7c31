"""The robot's decisions: queue, states, lease, emergency stop and the follower.

``link`` feeds ``Robot`` checked messages, whose bytes stay in place, and ``frames`` reports its
state. Distances are the encoders' micrometres, speeds eighths of mm/s. Memory is bounded:
QUEUE_SIZE waypoints of 16 bytes.

Times are microseconds modulo 2^30 (17.9 minutes); elapsed time is an unsigned difference, so a
lease lapses while a processor halts.

The twin of ``robot.c``.
"""

from array import array

from .estimate import TIME, Estimate
from .fixed import clip, part
from .follower import CLEARLY, NO_TROUBLE, STUCK, Follower, smooth
from .native import micropython
from .pulses import WheelPulses
from .settings import Settings
from .states import (
    BOOT,
    CLEAR,
    DISARM,
    DONE,
    ESTOP,
    HALT,
    HOLD,
    NEVER,
    RESET,
    RUN,
    SESSION,
    START,
    STOP,
    TRANSITIONS,
    state_after,
)
from .waypoints import QUEUE_SIZE, WaypointQueue
from .wire import WAYPOINT_BYTES, check_bytes, get_time, get_u16

# reason for not being in RUN
BOOTED, NEW_SESSION, PAUSED, CLEARED, MISSION_DONE = 1, 2, 3, 4, 5
LEASE_LAPSED, NO_PERMIT, POSE_STALE, OFF_PATH, STUCK_REASON = 6, 7, 8, 9, 10
ESTOP_HOST, ESTOP_LOCAL, DISARMED, ESTOP_RESET = 11, 12, 13, 14
# outcome of a command
OBEYED, WRONG_MISSION, WRONG_INDEX, WRONG_STATE = 1, 2, 3, 4
NO_LEASE, NO_POSE, SAME_SESSION = 5, 6, 7
END_FLAG = 2
PERMIT, ODOMETRY = 1, 2

LEASE_MAX_MS = 500
"""Longest lease, whatever the host asks for."""
AHEAD_US = 20000
"""Largest error of the host's idea of the robot's clock."""
DISARM_US = 2000000
"""Time without a lease after which HOLD becomes IDLE."""
POSE_STALE_US = 500000
NEVER_US = 65535000
"""Largest age of a pose: STATUS has 16 bits for it."""
NO_POSE_MS = 0xFFFF
NO_TIME = -1
DT_MAX_US = 60000
"""Longest cycle by which commands move."""
SMOOTHING_US = 30000
MOVING = 2
"""Speed below which a robot is at rest: a quarter of a millimetre a second."""
TURNING = 72
"""9 mm/s, from which the wheels clearly turn: one late step of both encoders reads as 8.3."""
# places of the halves of 32-bit numbers, in the order of STATUS and HELLO_ACK
MISSION, ACCEPT_NEXT, EXEC_NEXT, PREFIX_CRC, EXEC_CRC = 0, 2, 4, 6, 8


class Robot:
    """One robot; ``left``, ``right`` (eighths of mm/s) and ``powered`` are its motors' orders."""

    def __init__(self, settings: Settings) -> None:
        self.queue = WaypointQueue()
        self.estimate = Estimate(settings.track_um)
        self.follower = Follower(settings, self.queue, self.estimate.pose)
        self.state = BOOT
        self.reason = BOOTED
        self.news = False
        """Something for STATUS to report soon; its sender sets it back."""
        self.alarm = False
        """The same for a stop, to report at once."""
        self.hurry = False
        """Braking begins: the next cycle is due at once."""
        self.now_us = 0
        self.left = 0
        self.right = 0
        self.powered = False
        self.speed = 0
        """Measured at the wheels; ``spin`` the same for turning."""
        self.spin = 0
        self.done = False
        self.lease_valid = False
        self.numbers = array("H", bytes(20))
        """Mission, accepted, executed, and the CRC of both: halves, the lower first."""
        self._turning_per_spin = settings.turning_per_spin
        self._pulses = WheelPulses(settings.least_wheel)
        self._ended = False
        self._session_after_estop = False
        self._followed_us = NO_TIME
        self._turned_us = NO_TIME
        self._unsummed = 0
        self._lease_us = 0
        self._lease_ttl_ms = 0
        self._lease_pose_age_ms = NO_POSE_MS
        self._lease_flags = 0
        self._index = array("H", (0, 0))
        self._nothing = bytearray(4)
        self.forget_mission(self._nothing, 0)

    def _change(self, event: int, reason: int) -> None:
        after = state_after(self.state, event)
        if after == self.state and event != CLEAR:
            return
        self.state = after
        self.reason = reason
        self.news = True
        if after == HOLD:
            self.alarm = True
            self.hurry = True

    def forget_mission(self, mission: bytearray, at: int) -> None:
        """Begin another mission, given by these four bytes."""
        numbers = self.numbers
        for i in range(10):
            numbers[i] = 0
        numbers[MISSION] = get_u16(mission, at)
        numbers[MISSION + 1] = get_u16(mission, at + 2)
        check_bytes(numbers, PREFIX_CRC, mission, at, 4)
        numbers[EXEC_CRC] = numbers[PREFIX_CRC]
        numbers[EXEC_CRC + 1] = numbers[PREFIX_CRC + 1]
        self.queue.clear()
        self.follower.forget_line()
        self._unsummed = 0
        self.done = False
        self._ended = False
        self.news = True

    def open_session(self) -> None:
        """Open a host's session: the old lease is void, a running robot holds."""
        self.lease_valid = False
        self._lease_us = self.now_us
        self._lease_flags = 0
        self._session_after_estop = True
        self._change(SESSION, NEW_SESSION)

    def _is_mission(self, data: bytearray, at: int) -> bool:
        numbers = self.numbers
        return get_u16(data, at) == numbers[0] and get_u16(data, at + 2) == numbers[1]

    def accept(self, data: bytearray, at: int) -> bool:
        """Queue checked records (mission, first index, count, records); False if it is full.

        Each index is taken once and in order; records of another mission or a later index are
        dropped.
        """
        if not self._is_mission(data, at) or self.state == ESTOP:
            return True
        queue, numbers, index = self.queue, self.numbers, self._index
        index[0] = get_u16(data, at + 4)
        index[1] = get_u16(data, at + 6)
        for i in range(data[at + 8]):
            order = _compare(index, 0, numbers, ACCEPT_NEXT)
            if order == 0:
                if self._ended:
                    return True
                if queue.count == QUEUE_SIZE:
                    return False
                record = at + 10 + WAYPOINT_BYTES * i
                queue.add(data, record)
                self._ended = data[record + 15] & END_FLAG != 0
                self._unsummed += 1
                _count(numbers, ACCEPT_NEXT)
            elif order > 0:
                return True
            _count(index, 0)
        return True

    @micropython.native
    def sum(self) -> bool:
        """Take one accepted waypoint into its CRC; False if all are."""
        if self._unsummed == 0:
            return False
        at = self.queue.at(self.queue.count - self._unsummed)
        self._unsummed -= 1
        check_bytes(self.numbers, PREFIX_CRC, self.queue.data, at, WAYPOINT_BYTES)
        return True

    @micropython.native
    def _since(self, stamp_us: int) -> int:
        """Time since ``stamp_us`` plus AHEAD_US: a stamp slightly ahead is recent."""
        return self.now_us - stamp_us + AHEAD_US & TIME

    @micropython.native
    def _lease_runs(self, issued_us: int, ttl_ms: int) -> bool:
        return self.now_us - issued_us + AHEAD_US & TIME < ttl_ms * 1000 + AHEAD_US

    @micropython.native
    def _pose_age_us(self) -> int:
        estimate = self.estimate
        return self.now_us - estimate.fix_us & TIME if estimate.fix_recent else TIME

    @micropython.native
    def _pose_is_stale(self) -> bool:
        return (
            self._lease_pose_age_ms > POSE_STALE_US // 1000 or self._pose_age_us() > POSE_STALE_US
        )

    def start(self, data: bytearray, at: int) -> int:
        """START: mission and the next waypoint's index; a result.

        The result names a condition that fails.
        """
        if self.state == RUN and self._is_mission(data, at):
            return OBEYED
        if TRANSITIONS[START][self.state] == NEVER or self.done:
            return WRONG_STATE
        if not self._is_mission(data, at) or (self.numbers[0] == 0 and self.numbers[1] == 0):
            return WRONG_MISSION
        self._index[0] = get_u16(data, at + 4)
        self._index[1] = get_u16(data, at + 6)
        if _compare(self._index, 0, self.numbers, EXEC_NEXT) != 0:
            return WRONG_INDEX
        if not self.lease_valid or not self._lease_flags & PERMIT:
            return NO_LEASE
        if not self._lease_flags & ODOMETRY and self._pose_is_stale():
            return NO_POSE
        self.follower.begin()
        self._change(START, 0)
        return OBEYED

    def pause(self) -> int:
        """PAUSE: stop under control, the queue stays; a result."""
        self._change(HALT, PAUSED)
        return OBEYED

    def clear(self, data: bytearray, at: int) -> int:
        """CLEAR: stop under control, drop the queue, begin this mission; a result."""
        if self.state == ESTOP:
            return WRONG_STATE
        none = get_u16(data, at) == 0 and get_u16(data, at + 2) == 0
        if none or not self._is_mission(data, at):
            self.forget_mission(data, at)
            self._change(CLEAR, CLEARED)
        return OBEYED

    def reset_estop(self) -> int:
        """RESET_ESTOP, only in a session younger than the stop; a result."""
        if self.state != ESTOP:
            return WRONG_STATE
        if not self._session_after_estop:
            return SAME_SESSION
        self.forget_mission(self._nothing, 0)
        self._change(RESET, ESTOP_RESET)
        return OBEYED

    def lease(self, data: bytearray, at: int) -> bool:
        """LEASE: prolong or withdraw the permit to drive.

        False for one expired, or older than the present one.
        """
        issued_us = get_time(data, at)
        ttl_ms = min(get_u16(data, at + 4), LEASE_MAX_MS)
        if not self._lease_runs(issued_us, ttl_ms):
            return False
        if self.lease_valid and issued_us - self._lease_us & TIME > TIME >> 1:
            return False
        self._lease_us = issued_us
        self._lease_ttl_ms = ttl_ms
        self._lease_pose_age_ms = get_u16(data, at + 6)
        self._lease_flags = data[at + 8]
        self.lease_valid = True
        self.tick(self.now_us)
        return True

    def see(self, data: bytearray, at: int, angle: int) -> bool:
        """POSE: the camera saw the robot; False if unused: too old, or a jump."""
        seen_us = get_time(data, at + 10)
        age_us = self._since(seen_us)
        if age_us >= POSE_STALE_US + AHEAD_US:
            return False
        if age_us < AHEAD_US:
            seen_us = self.now_us
        return self.estimate.correct(data, at, angle, seen_us)

    def emergency_stop(self, reason: int) -> None:
        """Stop the wheels at once, latched until ``reset_estop``."""
        self._session_after_estop = False
        self._change(STOP, reason)
        self.freeze()

    def freeze(self) -> None:
        """Stop without a ramp; pulses still owed are dropped."""
        self.follower.freeze()
        self._pulses.forget()
        self.left = 0
        self.right = 0
        self.powered = False

    @micropython.native
    def tick(self, now_us: int) -> None:
        """Watch lease and pose between two steps."""
        self.now_us = now_us
        if self.lease_valid and not self._lease_runs(self._lease_us, self._lease_ttl_ms):
            self.lease_valid = False
        estimate = self.estimate
        if estimate.fix_recent and now_us - estimate.fix_us & TIME >= NEVER_US:
            estimate.fix_recent = False
        if self.state == RUN:
            if not self.lease_valid:
                self._change(HALT, LEASE_LAPSED)
            elif not self._lease_flags & PERMIT:
                self._change(HALT, NO_PERMIT)
            elif not self._lease_flags & ODOMETRY and self._pose_is_stale():
                self._change(HALT, POSE_STALE)
        if self.state == HOLD and self._since(self._lease_us) >= DISARM_US + AHEAD_US:
            self._change(DISARM, DISARMED)

    def quiet_us(self) -> int:
        """Time for which ``tick`` changes no state; not positive if it may."""
        since_us = self._since(self._lease_us) - AHEAD_US
        if self.state == HOLD:
            return DISARM_US - since_us
        if self.state != RUN:
            return DISARM_US
        return min(self._lease_ttl_ms * 1000 - since_us, POSE_STALE_US - self._pose_age_us())

    @micropython.native
    def _execute(self, count: int) -> None:
        queue = self.queue
        while count > 0:
            count -= 1
            at = queue.at(0)
            if self._unsummed == queue.count:
                self.sum()  # sum it before it leaves
            check_bytes(self.numbers, EXEC_CRC, queue.data, at, WAYPOINT_BYTES)
            _count(self.numbers, EXEC_NEXT)
            if queue.data[at + 15] & END_FLAG:
                self.done = True
                self.news = True
                if self.state == RUN:
                    self._change(DONE, MISSION_DONE)
            queue.drop_first()

    @micropython.native
    def step(self, now_us: int, left_um: int, right_um: int) -> None:
        """Run one control cycle, 100 a second, by the wheels' travel since the last one."""
        self.hurry = False
        self.tick(now_us)
        self.follow(now_us, left_um, right_um)
        self.turn_wheels(now_us)

    @micropython.native
    def follow(self, now_us: int, left_um: int, right_um: int) -> None:
        """Decide for a cycle that ended at ``now_us``, without checking the lease or moving the
        wheels.

        A robot that gets several cycles at once follows each.
        """
        follower = self.follower
        across = right_um - left_um
        ahead = left_um + (across >> 1)
        dt_us = cycle_us(now_us, self._followed_us)
        follower.dt_us = dt_us
        self._followed_us = now_us
        self.estimate.advance(ahead, across, now_us)
        share = part(dt_us, 35790) if dt_us < SMOOTHING_US else 16384
        self.speed = smooth(self.speed, ahead, share)
        self.spin = smooth(self.spin, across >> 1, share)
        if self.state == ESTOP:
            return
        if self.state == RUN:
            if abs(self.speed) >= TURNING:
                ahead = CLEARLY
            self._execute(follower.step(ahead))
            if follower.trouble != NO_TROUBLE and self.state == RUN:
                self._change(HALT, STUCK_REASON if follower.trouble == STUCK else OFF_PATH)
        else:
            self._execute(follower.halt())

    @micropython.native
    def turn_wheels(self, now_us: int) -> None:
        """Order the wheels by the decisions of ``follow``."""
        dt_us = cycle_us(now_us, self._turned_us)
        self._turned_us = now_us
        if self.state == ESTOP:
            return
        speed, spin, pulses = self.follower.speed, self.follower.spin, self._pulses
        if self.state == RUN:
            pulses.next(dt_us, speed - spin, speed + spin)
        else:
            pulses.stop(speed - spin, speed + spin)
        self.left, self.right = pulses.driven[0], pulses.driven[1]
        self.powered = speed != 0 or spin != 0 or self.state == RUN or self.state == HOLD

    def flags(self) -> int:
        """The flags of STATUS."""
        flags = 1 if abs(self.speed) > MOVING or abs(self.spin) > MOVING else 0
        if self.lease_valid:
            flags |= 2
            if self._lease_flags & PERMIT:
                flags |= 4
        if self.estimate.known:
            flags |= 8
        if self.state == RUN and self.queue.count == 0:
            flags |= 16
        if self.done:
            flags |= 32
        return flags

    def speed_mm_s(self) -> int:
        """The measured speed."""
        return self.speed + 4 >> 3

    def turning_mrad_s(self) -> int:
        """The measured turning."""
        return clip(self.spin * self._turning_per_spin >> 8, 0x7FFF)

    def lease_left_ms(self) -> int:
        """Time left of the lease."""
        if not self.lease_valid:
            return 0
        granted_us = self._lease_ttl_ms * 1000 + AHEAD_US
        return (granted_us - self._since(self._lease_us) + 500) // 1000

    def pose_age_ms(self) -> int:
        """Age of the pose used last."""
        age_us = self._pose_age_us()
        return NO_POSE_MS if age_us >= NEVER_US else (age_us + 500) // 1000


@micropython.native
def cycle_us(now_us: int, last_us: int) -> int:
    """Length of a cycle that moves the commands, at most DT_MAX_US; 0 for the first."""
    return 0 if last_us == NO_TIME else min(now_us - last_us & TIME, DT_MAX_US)


@micropython.native
def _count(halves: "array[int]", at: int) -> None:
    """Add one, modulo 2^32."""
    low = halves[at] + 1
    halves[at] = low & 0xFFFF
    halves[at + 1] = halves[at + 1] + (low >> 16) & 0xFFFF


@micropython.native
def _compare(a: "array[int]", at: int, b: "array[int]", begin: int) -> int:
    """Sign of a - b."""
    if a[at + 1] != b[begin + 1]:
        return 1 if a[at + 1] > b[begin + 1] else -1
    return 0 if a[at] == b[begin] else 1 if a[at] > b[begin] else -1

"""The robot's decisions: queue, states, lease, emergency stop and the follower; sans-IO.

``RobotController`` knows no bytes: ``robot.connection`` feeds it with messages and reports
its state. Time is the robot's own clock in seconds, passed in; distances are metres, as the
wheel encoders measure them. Inside are whole numbers, the same as in ``firmware/robot.c``:
microseconds, micrometres, eighths of mm/s. Memory is bounded: QUEUE_SIZE waypoints of 16 bytes.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

from firmware_protocol.robot.follower import Follower, Trouble
from firmware_protocol.robot.pose_estimate import PoseEstimate
from firmware_protocol.robot.state import TRANSITIONS, RobotEvent, state_after
from firmware_protocol.robot.wheel_pulses import WheelPulses
from firmware_protocol.wire.crc import crc32c
from firmware_protocol.wire.drive_settings import DriveSettings
from firmware_protocol.wire.fixed_point import clip, scale, wrapped
from firmware_protocol.wire.messages import (
    CommandResult,
    Lease,
    LeaseFlag,
    PoseFix,
    RobotState,
    StatusFlag,
    StopReason,
    WaypointFlag,
    Waypoints,
)
from firmware_protocol.wire.mission import mission_seed
from firmware_protocol.wire.waypoint_record import Target

QUEUE_SIZE: Final = 32
LEASE_MAX_US: Final = 500_000
"""However long a lease the host asks for, the robot stops this long after it."""
AHEAD_US: Final = 20_000
"""A host may think the robot's clock so far ahead of what it is."""
DISARM_US: Final = 2_000_000
"""After so long without a lease the robot leaves HOLD for IDLE."""
POSE_STALE_US: Final = 500_000
LEAP_UM: Final = 1 << 20
"""1 m; wheels travel no further in a cycle."""
CYCLE_MAX_US: Final = 60_000
"""A cycle that took longer moves the commands no further than this."""
SMOOTHING_US: Final = 30_000
EIGHTHS_PER_M: Final = 8_000
"""Speeds inside are eighths of mm/s."""
MOVING: Final = 2
"""What is slower does not move: a quarter of a millimetre a second."""
TURNING: Final = 9 * 8
"""One late step of both encoders reads as 8.3 mm/s; from here on the wheels clearly turn."""
_MOST: Final = 32_767
# What `_watch` needs, which runs a thousand times a second: an enumeration is slow to look into.
_PERMIT: Final = int(LeaseFlag.PERMIT)
_ODOMETRY: Final = int(LeaseFlag.ODOMETRY)
_RUN: Final = RobotState.RUN
_HOLD: Final = RobotState.HOLD


class WheelSpeeds(NamedTuple):
    """Wanted speeds of the wheels' rims over the ground; ``powered`` False: motors off."""

    left_m_s: float
    right_m_s: float
    powered: bool


_OFF: Final = WheelSpeeds(0.0, 0.0, powered=False)


class RobotController:
    """Everything the robot decides; one :meth:`step` per control cycle (100 a second)."""

    def __init__(self, settings: DriveSettings | None = None) -> None:
        self.settings = settings or DriveSettings()
        self.state = RobotState.BOOT
        self.reason = StopReason.BOOTED
        self.estimate = PoseEstimate()
        self.follower = Follower(self.settings)
        self._pulses = WheelPulses(self.follower.constants.least_wheel)
        self.mission = 0
        self.accept_next = 0
        self.exec_next = 0
        self.prefix_crc = mission_seed(0)
        self.exec_crc = mission_seed(0)
        self.done = False
        self.news = False
        """Something that STATUS should tell soon; whoever tells it sets this back."""
        self.alarm = False
        """The same for a stop, which it should tell at once."""
        self._speed = 0
        self._spin = 0
        self.wheels = _OFF
        """What the motors are to do now: as :meth:`step` said, or zero since an e-stop."""
        self._records: deque[bytes] = deque(maxlen=QUEUE_SIZE)
        self._targets: deque[Target] = deque(maxlen=QUEUE_SIZE)
        self._ended = False
        self._lease = Lease(0.0, LeaseFlag.NONE)
        self._lease_end_us: int | None = None
        """When the lease runs out; None where there is none."""
        self._issued_us = 0
        """When the last lease was given."""
        self._session_after_estop = False
        self._step_us: int | None = None
        self._turned_us: int | None = None
        self._wheels_um = (0, 0)

    # What the host asks for.

    @property
    def credit(self) -> int:
        """Free places in the queue."""
        return QUEUE_SIZE - len(self._records)

    def open_session(self, now_s: float) -> None:
        """A host has opened a session: the lease of the old one is void."""
        self._lease_end_us = None
        self._issued_us = _us(now_s)
        self._lease = Lease(0.0, LeaseFlag.NONE, self._lease.pose_age_s)
        self._session_after_estop = True
        self._change(RobotEvent.SESSION, StopReason.NEW_SESSION)

    def accept(self, message: Waypoints) -> bool:
        """Queue waypoints; each index is taken once and in order. False where the queue is full.

        What is of no use here (another mission, a later index) is dropped; the host sees in
        STATUS which waypoint comes next.
        """
        if message.mission != self.mission or self.state is RobotState.ESTOP:
            return True
        for index, record in enumerate(message.records, message.first):
            if index < self.accept_next:
                continue
            if index > self.accept_next or self._ended:
                return True
            if self.credit == 0:
                return False
            self._records.append(record)
            self._targets.append(Target.of(record))
            self._ended = bool(record[-1] & WaypointFlag.END)
            self.prefix_crc = crc32c(record, self.prefix_crc)
            self.accept_next += 1
        return True

    def start(self, mission: int, exec_next: int, now_s: float) -> CommandResult:
        """Drive, if everything that has to hold does; otherwise say what does not."""
        if (self.state, RobotEvent.START) not in TRANSITIONS or self.done:
            if self.state is RobotState.RUN and mission == self.mission:
                return CommandResult.DONE
            return CommandResult.WRONG_STATE
        if mission != self.mission or mission == 0:
            return CommandResult.WRONG_MISSION
        if exec_next != self.exec_next:
            return CommandResult.WRONG_INDEX
        if not self._lease_runs(_us(now_s)) or not self._lease.flags & LeaseFlag.PERMIT:
            return CommandResult.NO_LEASE
        if not self._lease.flags & LeaseFlag.ODOMETRY and self._pose_is_stale(_us(now_s)):
            return CommandResult.NO_POSE
        self.follower.begin(self.estimate.now)
        self._change(RobotEvent.START, StopReason.NONE)
        return CommandResult.DONE

    def pause(self) -> CommandResult:
        """Stop under control; the queue stays."""
        self._change(RobotEvent.HALT, StopReason.PAUSED)
        return CommandResult.DONE

    def clear(self, mission: int) -> CommandResult:
        """Stop under control and drop the queue; waypoints of ``mission`` may follow."""
        if self.state is RobotState.ESTOP:
            return CommandResult.WRONG_STATE
        if mission == 0 or mission != self.mission:
            self._forget_mission(mission)
            self._change(RobotEvent.CLEAR, StopReason.CLEARED)
        return CommandResult.DONE

    def lease(self, message: Lease, now_s: float) -> bool:
        """The control loop lived when it gave the lease: prolong, or withdraw, the permit to drive.

        False for one that has run out on its way, or is older than the present one.
        """
        now_us = _us(now_s)
        issued_us = _unrolled(message.issued_us, now_us)
        end_us = issued_us + min(_us(message.ttl_s), LEASE_MAX_US)
        if now_us >= end_us or (self._lease_runs(now_us) and issued_us < self._issued_us):
            return False
        self._lease, self._issued_us, self._lease_end_us = message, issued_us, end_us
        self._watch(now_us)
        return True

    def pose_fix(self, message: PoseFix, now_s: float) -> bool:
        """The camera saw the robot; False where that was not used: too old, or a jump."""
        now_us = _us(now_s)
        seen_us = _unrolled(message.captured_us, now_us)
        if now_us - seen_us >= POSE_STALE_US:
            return False
        return self.estimate.correct(message, min(seen_us, now_us))

    def emergency_stop(self, reason: StopReason = StopReason.ESTOP_HOST) -> None:
        """Wheels to zero at once, latched until :meth:`reset_estop`."""
        self._session_after_estop = False
        self._change(RobotEvent.ESTOP, reason)
        self.freeze()
        self.wheels = _OFF

    def freeze(self) -> None:
        """Forget what the wheels were to do: they stand, and it is not caught up on."""
        self.follower.freeze()
        self._pulses.forget()

    def reset_estop(self) -> CommandResult:
        """Leave ESTOP for IDLE without a mission; only in a session younger than the stop."""
        if self.state is not RobotState.ESTOP:
            return CommandResult.WRONG_STATE
        if not self._session_after_estop:
            return CommandResult.SAME_SESSION
        self._forget_mission(0)
        self._change(RobotEvent.RESET, StopReason.ESTOP_RESET)
        return CommandResult.DONE

    # The control cycle.

    def step(self, now_s: float, left_m: float, right_m: float) -> WheelSpeeds:
        """One cycle: the wheels have travelled so far since boot; how fast they should turn."""
        self.follow(now_s, left_m, right_m)
        return self.turn_wheels(now_s)

    def follow(self, now_s: float, left_m: float, right_m: float) -> None:
        """Decide, without the wheels: for whoever learns of several cycles at once."""
        now_us = _us(now_s)
        left = self._travelled(0, left_m)
        right = self._travelled(1, right_m)
        dt_us = 0
        if self._step_us is None:
            left = right = 0
        else:
            dt_us = max(0, min(CYCLE_MAX_US, now_us - self._step_us))
        self._step_us = now_us
        ahead_um = left + ((right - left) >> 1)
        turn = wrapped((right - left) * self.follower.constants.angle_per_um)
        self.estimate.advance(ahead_um, turn, now_us)
        self._measure(dt_us, ahead_um, (right - left) >> 1)
        self._watch(now_us)
        if self.state is RobotState.ESTOP:
            return
        targets, pose = tuple(self._targets), self.estimate.now
        if self.state is RobotState.RUN:
            turning = abs(self._speed) >= TURNING
            step = self.follower.step(dt_us, pose, None if turning else ahead_um, targets)
            self._execute(step.executed)
            if step.trouble is not None and self.state is RobotState.RUN:
                self._change(RobotEvent.HALT, _TROUBLE[step.trouble])
        else:
            step = self.follower.halt(dt_us, pose, targets)
            self._execute(step.executed)

    def turn_wheels(self, now_s: float) -> WheelSpeeds:
        """What the wheels do from now on, as :meth:`follow` decided."""
        now_us = _us(now_s)
        before_us = now_us if self._turned_us is None else self._turned_us
        self._turned_us = now_us
        if self.state is RobotState.ESTOP:
            return self.wheels
        speed, spin = self.follower.speed, self.follower.spin
        dt_us = max(0, min(CYCLE_MAX_US, now_us - before_us))
        turn = self._pulses.next if self.state is RobotState.RUN else self._pulses.stop
        left, right = turn(dt_us, speed - spin, speed + spin)
        powered = bool(speed or spin) or self.state in (RobotState.RUN, RobotState.HOLD)
        self.wheels = WheelSpeeds(left / EIGHTHS_PER_M, right / EIGHTHS_PER_M, powered)
        return self.wheels

    def tick(self, now_s: float) -> None:
        """Watch the lease between two steps."""
        self._watch(_us(now_s))

    # What the host is told.

    def status_flags(self, now_s: float) -> StatusFlag:
        """The flags of STATUS."""
        flags = StatusFlag.NONE
        if abs(self._speed) > MOVING or abs(self._spin) > MOVING:
            flags |= StatusFlag.MOVING
        if self._lease_runs(_us(now_s)):
            flags |= StatusFlag.LEASE_VALID
            if self._lease.flags & LeaseFlag.PERMIT:
                flags |= StatusFlag.PERMIT
        if self.estimate.known:
            flags |= StatusFlag.POSE_KNOWN
        if self.state is RobotState.RUN and not self._records:
            flags |= StatusFlag.UNDERRUN
        if self.done:
            flags |= StatusFlag.MISSION_DONE
        return flags

    @property
    def speed_m_s(self) -> float:
        """Measured at the wheels, to the wire's resolution."""
        return ((self._speed + 4) >> 3) / 1000

    @property
    def turn_rad_s(self) -> float:
        """The same for turning."""
        return clip(self._spin * self.follower.constants.turning_per_spin >> 8, _MOST) / 1000

    def lease_left_s(self, now_s: float) -> float:
        """How long the lease still runs, in whole milliseconds."""
        now_us = _us(now_s)
        if self._lease_end_us is None or not self._lease_runs(now_us):
            return 0.0
        return (self._lease_end_us - now_us + 500) // 1000 / 1000

    def pose_age_s(self, now_s: float) -> float:
        """Age of the camera pose used last, in whole milliseconds."""
        if self.estimate.fix_us is None:
            return math.inf
        return (max(0, _us(now_s) - self.estimate.fix_us) + 500) // 1000 / 1000

    # Inside.

    def _watch(self, now_us: int) -> None:
        if self.state is _RUN:
            flags = int(self._lease.flags)
            if not self._lease_runs(now_us):
                self._change(RobotEvent.HALT, StopReason.LEASE_LAPSED)
            elif not flags & _PERMIT:
                self._change(RobotEvent.HALT, StopReason.NO_PERMIT)
            elif not flags & _ODOMETRY and self._pose_is_stale(now_us):
                self._change(RobotEvent.HALT, StopReason.POSE_STALE)
        if self.state is _HOLD and now_us - self._issued_us >= DISARM_US:
            self._change(RobotEvent.DISARM, StopReason.DISARMED)

    def _lease_runs(self, now_us: int) -> bool:
        return self._lease_end_us is not None and now_us < self._lease_end_us

    def _pose_is_stale(self, now_us: int) -> bool:
        fix_us = self.estimate.fix_us
        if fix_us is None or now_us - fix_us > POSE_STALE_US:
            return True
        return self._lease.pose_age_s * 1e6 > POSE_STALE_US

    def _travelled(self, side: int, total_m: float) -> int:
        """What a wheel travelled since the last cycle; more than a leap counts as one."""
        total_um, before = round(total_m * 1e6), list(self._wheels_um)
        travel_um = wrapped(total_um - before[side])
        before[side] = total_um
        self._wheels_um = (before[0], before[1])
        return max(-LEAP_UM, min(LEAP_UM, travel_um))

    def _measure(self, dt_us: int, ahead_um: int, spin_um: int) -> None:
        part = dt_us * 35790 >> 16 if dt_us < SMOOTHING_US else 1 << 14
        # 17/64 is 8 over 30
        speed, spin = self._speed, self._spin
        self._speed = clip(speed + (ahead_um * 17 >> 6) - scale(speed, part), _MOST)
        self._spin = clip(spin + (spin_um * 17 >> 6) - scale(spin, part), _MOST)

    def _execute(self, count: int) -> None:
        for _ in range(count):
            record = self._records.popleft()
            self._targets.popleft()
            self.exec_crc = crc32c(record, self.exec_crc)
            self.exec_next += 1
            if record[-1] & WaypointFlag.END:
                self.done = self.news = True
                self._change(RobotEvent.DONE, StopReason.MISSION_DONE)

    def _forget_mission(self, mission: int) -> None:
        self._records.clear()
        self._targets.clear()
        self.mission = mission
        self.accept_next = self.exec_next = 0
        self.prefix_crc = self.exec_crc = mission_seed(mission)
        self.done = self._ended = False
        self.news = True

    def _change(self, event: RobotEvent, reason: StopReason) -> None:
        state = state_after(self.state, event)
        kept = state is self.state and event is not RobotEvent.CLEAR
        self.state = state
        if not kept:
            self.reason = reason
            self.news = True
            self.alarm = self.alarm or state is RobotState.HOLD


_TROUBLE: Final = {Trouble.OFF_PATH: StopReason.OFF_PATH, Trouble.STUCK: StopReason.STUCK}


def _us(seconds: float) -> int:
    return round(seconds * 1e6)


def _unrolled(stamp_us: int, now_us: int) -> int:
    """A stamp of 32 bits as a time of the clock that wraps never: the last one, or just ahead."""
    return now_us + AHEAD_US - (now_us + AHEAD_US - stamp_us) % (1 << 32)

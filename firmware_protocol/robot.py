"""The robot's decisions: queue, states, lease, emergency stop and the follower; sans-IO.

``RobotController`` knows no bytes: ``robot_connection`` feeds it with messages and reports
its state. Time is the robot's own clock in seconds, passed in; distances are metres, as the
wheel encoders measure them. Memory is bounded: QUEUE_SIZE waypoints of 16 bytes.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

from firmware_protocol.crc import crc32c
from firmware_protocol.follower import DriveSettings, Follower, Trouble
from firmware_protocol.messages import (
    CommandResult,
    Lease,
    LeaseFlag,
    PoseFix,
    RobotState,
    StatusFlag,
    StopReason,
    Waypoint,
    WaypointFlag,
    Waypoints,
)
from firmware_protocol.mission import mission_seed
from firmware_protocol.pose_estimate import PoseEstimate
from firmware_protocol.robot_state import TRANSITIONS, RobotEvent

QUEUE_SIZE: Final = 32
LEASE_MAX_S: Final = 0.5
"""However long a lease the host asks for, the robot stops this long after it."""
DISARM_S: Final = 2.0
"""After so long without a lease the robot leaves HOLD for IDLE."""
POSE_STALE_S: Final = 0.5


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
        self.estimate = PoseEstimate(self.settings.track_m)
        self.follower = Follower(self.settings)
        self.mission = 0
        self.accept_next = 0
        self.exec_next = 0
        self.prefix_crc = mission_seed(0)
        self.exec_crc = mission_seed(0)
        self.done = False
        self.speed_m_s = 0.0
        self.turn_rad_s = 0.0
        self.wheels = _OFF
        """What the motors are to do now: as :meth:`step` said, or zero since an e-stop."""
        self._records: deque[bytes] = deque(maxlen=QUEUE_SIZE)
        self._targets: deque[Waypoint] = deque(maxlen=QUEUE_SIZE)
        self._ended = False
        self._lease_s = -math.inf
        """When the lease runs out."""
        self._leased_s = -math.inf
        """When the last lease came."""
        self._lease = LeaseFlag.NONE
        self._host_pose_age_s = math.inf
        self._session_after_estop = False
        self._step_s: float | None = None
        self._wheels_m = (0.0, 0.0)

    # What the host asks for.

    @property
    def credit(self) -> int:
        """Free places in the queue."""
        return QUEUE_SIZE - len(self._records)

    def open_session(self, now_s: float) -> None:
        """A host has opened a session: the lease of the old one is void."""
        self._lease_s = -math.inf
        self._leased_s = now_s
        self._lease = LeaseFlag.NONE
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
            self._targets.append(Waypoint.unpack(record))
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
        if now_s >= self._lease_s or not self._lease & LeaseFlag.PERMIT:
            return CommandResult.NO_LEASE
        if not self._lease & LeaseFlag.ODOMETRY and self._pose_is_stale(now_s):
            return CommandResult.NO_POSE
        self.follower.begin(self.estimate.pose)
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

    def lease(self, message: Lease, now_s: float) -> None:
        """The control loop lives: prolong, or withdraw, the permit to drive."""
        self._lease_s = now_s + min(message.ttl_s, LEASE_MAX_S)
        self._leased_s = now_s
        self._lease = message.flags
        self._host_pose_age_s = message.pose_age_s
        self._watch(now_s)

    def pose_fix(self, message: PoseFix, now_s: float) -> bool:
        """The camera saw the robot; False where the fix was not used."""
        return self.estimate.correct(message, now_s)

    def emergency_stop(self, reason: StopReason = StopReason.ESTOP_HOST) -> None:
        """Wheels to zero at once, latched until :meth:`reset_estop`."""
        if self.state is not RobotState.ESTOP:
            self._session_after_estop = False
        self._change(RobotEvent.ESTOP, reason)
        self.follower.freeze()
        self.wheels = _OFF

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
        dt_s = 0.0 if self._step_s is None else max(0.0, now_s - self._step_s)
        travel = (left_m - self._wheels_m[0], right_m - self._wheels_m[1])
        if self._step_s is None:
            travel = (0.0, 0.0)
        self._step_s, self._wheels_m = now_s, (left_m, right_m)
        self.estimate.advance(now_s, *travel)
        if dt_s > 0.0:
            self._measure(dt_s, *travel)
        self._watch(now_s)
        if self.state is RobotState.ESTOP:
            return self.wheels
        if self.state is RobotState.RUN:
            step = self.follower.step(
                dt_s, self.estimate.pose, self.speed_m_s, tuple(self._targets)
            )
            self._execute(step.executed)
            if step.trouble is not None and self.state is RobotState.RUN:
                self._change(RobotEvent.HALT, _TROUBLE[step.trouble])
        else:
            step = self.follower.halt(dt_s, self.estimate.pose, tuple(self._targets))
            self._execute(step.executed)
        half = step.turn_rad_s * self.settings.track_m / 2.0
        moving = step.speed_m_s != 0.0 or step.turn_rad_s != 0.0
        powered = moving or self.state in (RobotState.RUN, RobotState.HOLD)
        self.wheels = WheelSpeeds(step.speed_m_s - half, step.speed_m_s + half, powered)
        return self.wheels

    def tick(self, now_s: float) -> None:
        """Watch the lease between two steps."""
        self._watch(now_s)

    # What the host is told.

    def status_flags(self, now_s: float) -> StatusFlag:
        """The flags of STATUS."""
        flags = StatusFlag.NONE
        if self.speed_m_s != 0.0 or self.turn_rad_s != 0.0:
            flags |= StatusFlag.MOVING
        if now_s < self._lease_s:
            flags |= StatusFlag.LEASE_VALID
            if self._lease & LeaseFlag.PERMIT:
                flags |= StatusFlag.PERMIT
        if self.estimate.known:
            flags |= StatusFlag.POSE_KNOWN
        if self.state is RobotState.RUN and not self._records:
            flags |= StatusFlag.UNDERRUN
        if self.done:
            flags |= StatusFlag.MISSION_DONE
        return flags

    def lease_left_s(self, now_s: float) -> float:
        """How long the lease still runs."""
        return max(0.0, self._lease_s - now_s)

    def pose_age_s(self, now_s: float) -> float:
        """Age of the camera pose used last."""
        return max(0.0, now_s - self.estimate.fix_time_s)

    # Inside.

    def _watch(self, now_s: float) -> None:
        if self.state is RobotState.RUN:
            if now_s >= self._lease_s:
                self._change(RobotEvent.HALT, StopReason.LEASE_LAPSED)
            elif not self._lease & LeaseFlag.PERMIT:
                self._change(RobotEvent.HALT, StopReason.NO_PERMIT)
            elif not self._lease & LeaseFlag.ODOMETRY and self._pose_is_stale(now_s):
                self._change(RobotEvent.HALT, StopReason.POSE_STALE)
        if self.state is RobotState.HOLD and now_s - self._leased_s >= DISARM_S:
            self._change(RobotEvent.DISARM, StopReason.DISARMED)

    def _pose_is_stale(self, now_s: float) -> bool:
        return max(self._host_pose_age_s, self.pose_age_s(now_s)) > POSE_STALE_S

    def _measure(self, dt_s: float, left_m: float, right_m: float) -> None:
        blend = min(1.0, dt_s / 0.03)
        speed = (left_m + right_m) / 2.0 / dt_s
        turn = (right_m - left_m) / self.settings.track_m / dt_s
        self.speed_m_s += blend * (speed - self.speed_m_s)
        self.turn_rad_s += blend * (turn - self.turn_rad_s)
        if abs(self.speed_m_s) < 1e-4 and abs(self.turn_rad_s) < 1e-3:
            self.speed_m_s = self.turn_rad_s = 0.0

    def _execute(self, count: int) -> None:
        for _ in range(count):
            record = self._records.popleft()
            self._targets.popleft()
            self.exec_crc = crc32c(record, self.exec_crc)
            self.exec_next += 1
            if record[-1] & WaypointFlag.END:
                self.done = True
                self._change(RobotEvent.DONE, StopReason.MISSION_DONE)

    def _forget_mission(self, mission: int) -> None:
        self._records.clear()
        self._targets.clear()
        self.mission = mission
        self.accept_next = self.exec_next = 0
        self.prefix_crc = self.exec_crc = mission_seed(mission)
        self.done = self._ended = False

    def _change(self, event: RobotEvent, reason: StopReason) -> None:
        state = TRANSITIONS.get((self.state, event))
        if state is None:
            return
        kept = state is self.state and event is not RobotEvent.CLEAR
        self.state = state
        if not kept:
            self.reason = reason


_TROUBLE: Final = {Trouble.OFF_PATH: StopReason.OFF_PATH, Trouble.STUCK: StopReason.STUCK}

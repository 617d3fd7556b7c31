"""Numbers used in messages: types, states, reasons, results and flags."""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import Final


class MessageType(IntEnum):
    """The type byte of a frame."""

    HELLO = 0x01
    CONFIRM = 0x02
    WAYPOINTS = 0x10
    START = 0x11
    PAUSE = 0x12
    CLEAR = 0x13
    RESET_ESTOP = 0x14
    LEASE = 0x20
    POSE = 0x21
    TIMESYNC = 0x22
    ESTOP = 0x2E
    HELLO_ACK = 0x81
    CHALLENGE = 0x82
    ACK = 0x90
    STATUS = 0x91
    TIMESYNC_REPLY = 0xA2


class RobotState(IntEnum):
    """The robot's states; ``clearway.states`` has the table of transitions."""

    BOOT = 0
    IDLE = 1
    RUN = 2
    HOLD = 3
    ESTOP = 4


class StopReason(IntEnum):
    """Last reason for not being in RUN."""

    NONE = 0
    BOOTED = 1
    NEW_SESSION = 2
    PAUSED = 3
    CLEARED = 4
    MISSION_DONE = 5
    LEASE_LAPSED = 6
    NO_PERMIT = 7
    POSE_STALE = 8
    OFF_PATH = 9
    STUCK = 10
    ESTOP_HOST = 11
    ESTOP_LOCAL = 12
    DISARMED = 13
    ESTOP_RESET = 14


STOP_SENTENCES: Final = {
    StopReason.NONE: "it has not been stopped",
    StopReason.BOOTED: "it has just booted",
    StopReason.NEW_SESSION: "a new link was made",
    StopReason.PAUSED: "it was ordered to pause",
    StopReason.CLEARED: "its queue was cleared",
    StopReason.MISSION_DONE: "it has finished its mission",
    StopReason.LEASE_LAPSED: "its lease ran out: the control loop went silent",
    StopReason.NO_PERMIT: "the control loop withdrew its permit to drive",
    StopReason.POSE_STALE: "the camera's last pose is too old",
    StopReason.OFF_PATH: "it is too far from its path",
    StopReason.STUCK: "it cannot reach its target",
    StopReason.ESTOP_HOST: "the host pressed the emergency stop",
    StopReason.ESTOP_LOCAL: "the emergency stop on the robot was pressed",
    StopReason.DISARMED: "it disarmed itself after a long silence",
    StopReason.ESTOP_RESET: "the emergency stop was reset",
}
"""Plain words for every reason, after "the robot is stopped because"."""


class ResetCause(IntEnum):
    """Reason for the start of the robot's processor."""

    UNKNOWN = 0
    POWER_ON = 1
    EXTERNAL = 2
    BROWN_OUT = 3
    WATCHDOG = 4


class CommandResult(IntEnum):
    """Outcome of the last command."""

    NONE = 0
    DONE = 1
    WRONG_MISSION = 2
    WRONG_INDEX = 3
    WRONG_STATE = 4
    NO_LEASE = 5
    NO_POSE = 6
    SAME_SESSION = 7


class WaypointFlag(IntFlag):
    """STOP: come to rest here, and turn to the heading, if any. END: the last waypoint."""

    NONE = 0
    STOP = 1
    END = 2


class StatusFlag(IntFlag):
    """Bits of STATUS."""

    NONE = 0
    MOVING = 1
    LEASE_VALID = 2
    PERMIT = 4
    POSE_KNOWN = 8
    UNDERRUN = 16
    MISSION_DONE = 32


class LeaseFlag(IntFlag):
    """Bits of LEASE. PERMIT: may drive. ODOMETRY: may drive without the camera's poses."""

    NONE = 0
    PERMIT = 1
    ODOMETRY = 2

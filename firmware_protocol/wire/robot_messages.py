"""Messages of the robot. SI units; each packs and checks its payload.

``unpack`` raises RemoteError for an invalid one.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from struct import Struct
from typing import Any, ClassVar, Self

from firmware_protocol.wire.errors import RemoteError
from firmware_protocol.wire.plain_message import PlainMessage
from firmware_protocol.wire.values import (
    NO_POSE_MS,
    UM_PER_M,
    clamped,
    heading_from_wire,
    heading_to_wire,
    known,
    saturated,
    unpack_exactly,
)
from firmware_protocol.wire.vocabulary import (
    CommandResult,
    MessageType,
    ResetCause,
    RobotState,
    StatusFlag,
    StopReason,
)


@dataclass(frozen=True, slots=True)
class HelloAck(PlainMessage):
    """The robot's answer: its identity and state. Layout frozen for ever."""

    major: int
    minor: int
    schema: int
    firmware: int
    boot_id: int
    reset_cause: ResetCause
    max_payload: int
    rx_window: int
    queue_size: int
    state: RobotState
    mission: int
    accept_next: int
    exec_next: int
    prefix_crc: int
    """CRC over the mission id and the accepted waypoints, see ``mission``."""
    exec_crc: int
    """The same over the executed waypoints, in order."""

    TYPE: ClassVar[MessageType] = MessageType.HELLO_ACK
    LAYOUT: ClassVar[Struct] = Struct("<BBIIIBBHBBIIIII")

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        v: list[Any] = list(unpack_exactly("HELLO_ACK", cls.LAYOUT, payload))
        v[5], v[9] = known(ResetCause, v[5]), known(RobotState, v[9])
        return cls(*v)


@dataclass(frozen=True, slots=True)
class Challenge(PlainMessage):
    """Number that the host must return to open the session."""

    nonce: int
    """Another one for every session and boot."""

    TYPE: ClassVar[MessageType] = MessageType.CHALLENGE
    LAYOUT: ClassVar[Struct] = Struct("<I")


@dataclass(frozen=True, slots=True)
class TimeSyncReply(PlainMessage):
    """The robot's clock at receipt and at the answer; microseconds, modulo 2**32."""

    host_sent_us: int
    robot_received_us: int
    robot_sent_us: int

    TYPE: ClassVar[MessageType] = MessageType.TIMESYNC_REPLY
    LAYOUT: ClassVar[Struct] = Struct("<III")


@dataclass(frozen=True, slots=True)
class Ack(PlainMessage):
    """Immediate acknowledgement; sequence and credit are in the frame's header."""

    accept_next: int

    TYPE: ClassVar[MessageType] = MessageType.ACK
    LAYOUT: ClassVar[Struct] = Struct("<I")


@dataclass(frozen=True, slots=True)
class RobotCounters:
    """Counts of the robot's receiver since boot, each modulo 2**16."""

    frames: int = 0
    crc_errors: int = 0
    format_errors: int = 0
    """COBS, length and size errors together."""
    overruns: int = 0
    session_errors: int = 0
    gaps: int = 0
    duplicates: int = 0
    rejected: int = 0
    """Whole frames whose content was refused."""


@dataclass(frozen=True, slots=True)
class Status:
    """State of the robot, 20 times a second; cumulative: losing one does no harm."""

    time_us: int
    boot_id: int
    mission: int
    accept_next: int
    exec_next: int
    prefix_crc: int
    exec_crc: int
    state: RobotState
    flags: StatusFlag
    reason: StopReason
    result: CommandResult
    """Outcome of command number ``command``."""
    command: int
    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float
    turn_rad_s: float
    pose_age_s: float
    lease_left_s: float
    counters: RobotCounters = RobotCounters()

    TYPE: ClassVar[MessageType] = MessageType.STATUS
    LAYOUT: ClassVar[Struct] = Struct("<IIIIIIIBBBBHiihhhHH8H")

    def pack(self) -> bytes:
        """The payload; values beyond the wire's range are clamped."""
        return self.LAYOUT.pack(
            *(getattr(self, name) for name in self.__slots__[:12]),
            saturated(self.x_m * UM_PER_M, 0x7FFFFFFF),
            saturated(self.y_m * UM_PER_M, 0x7FFFFFFF),
            heading_to_wire(self.heading_rad),
            saturated(self.speed_m_s * 1e3, 0x7FFF),
            saturated(self.turn_rad_s * 1e3, 0x7FFF),
            clamped(self.pose_age_s, 1e3, NO_POSE_MS),
            clamped(self.lease_left_s, 1e3, 0xFFFF),
            *(count & 0xFFFF for count in astuple(self.counters)),
        )

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        v: list[Any] = list(unpack_exactly("STATUS", cls.LAYOUT, payload))
        heading = heading_from_wire(v[14])
        if heading is None:
            raise RemoteError("STATUS without a heading")
        if v[8] & ~0x3F:
            raise RemoteError(f"STATUS flags {v[8]:#x}: unknown")
        v[7], v[8] = known(RobotState, v[7]), StatusFlag(v[8])
        v[9], v[10] = known(StopReason, v[9]), known(CommandResult, v[10])
        v[12:17] = v[12] / UM_PER_M, v[13] / UM_PER_M, heading, v[15] / 1e3, v[16] / 1e3
        v[17] = math.inf if v[17] == NO_POSE_MS else v[17] / 1e3
        v[18:] = v[18] / 1e3, RobotCounters(*v[19:])
        return cls(*v)

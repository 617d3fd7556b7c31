"""Messages of the host. SI units; each packs and checks its payload.

``unpack`` raises RemoteError for an invalid one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from struct import Struct
from typing import ClassVar, Final, Self

from firmware_protocol.wire.errors import LocalError, RemoteError
from firmware_protocol.wire.framing import MAX_PAYLOAD, VERSION
from firmware_protocol.wire.plain_message import PlainMessage
from firmware_protocol.wire.values import (
    NO_POSE_MS,
    UM_PER_M,
    clamped,
    heading_from_wire,
    heading_to_wire,
    scaled,
    to_um,
    unpack_exactly,
)
from firmware_protocol.wire.vocabulary import LeaseFlag, MessageType, WaypointFlag

MINOR_VERSION: Final = 0
WAYPOINT_BYTES: Final = 16
WAYPOINTS_PER_FRAME: Final = (MAX_PAYLOAD - 10) // WAYPOINT_BYTES


@dataclass(frozen=True, slots=True)
class Hello:
    """Request for a session, sent until it is open. Layout frozen for ever."""

    schema: int
    major: int = VERSION
    minor: int = MINOR_VERSION

    TYPE: ClassVar[MessageType] = MessageType.HELLO
    LAYOUT: ClassVar[Struct] = Struct("<BBI")

    def pack(self) -> bytes:
        """The payload."""
        return self.LAYOUT.pack(self.major, self.minor, self.schema)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        major, minor, schema = unpack_exactly("HELLO", cls.LAYOUT, payload)
        return cls(schema, major, minor)


@dataclass(frozen=True, slots=True)
class Confirm(PlainMessage):
    """The robot's number returned: the host is live, not a recording."""

    nonce: int

    TYPE: ClassVar[MessageType] = MessageType.CONFIRM
    LAYOUT: ClassVar[Struct] = Struct("<I")


@dataclass(frozen=True, slots=True)
class Waypoint:
    """One target: its place, the speed to pass it, and the precision.

    ``heading_rad`` counts only at a stop (flag STOP or END); None is any. ``acceptance_m`` is the
    radius within which the point is reached, at a stop the tolerance, 0 for the robot's own.
    Ranges: |x|, |y| < 2147 m, speed to 65 m/s, acceptance to 6.5 m, dwell to 25.5 s.
    """

    x_m: float
    y_m: float
    speed_m_s: float
    heading_rad: float | None = None
    acceptance_m: float = 0.0
    dwell_s: float = 0.0
    flags: WaypointFlag = WaypointFlag.NONE

    LAYOUT: ClassVar[Struct] = Struct("<iihHHBB")

    def pack(self) -> bytes:
        """Pack the wire's 16 bytes; LocalError if a value does not fit."""
        return self.LAYOUT.pack(
            to_um("x_m", self.x_m),
            to_um("y_m", self.y_m),
            heading_to_wire(self.heading_rad),
            scaled("speed_m_s", self.speed_m_s, 1e3, 0, 0xFFFF),
            scaled("acceptance_m", self.acceptance_m, 1e4, 0, 0xFFFF),
            scaled("dwell_s", self.dwell_s, 10.0, 0, 0xFF),
            self.flags,
        )

    @classmethod
    def unpack(cls, record: bytes) -> Self:
        """Read the 16 bytes; RemoteError if a value is out of range."""
        x, y, heading, speed, acceptance, dwell, flags = unpack_exactly(
            "waypoint", cls.LAYOUT, record
        )
        if flags & ~3:
            raise RemoteError(f"waypoint flags {flags:#x}: only STOP and END are known")
        if -0x80000000 in (x, y):
            raise RemoteError("waypoint at -2**31: not a position")
        return cls(
            x / UM_PER_M,
            y / UM_PER_M,
            speed / 1e3,
            heading_from_wire(heading),
            acceptance / 1e4,
            dwell / 10.0,
            WaypointFlag(flags),
        )


@dataclass(frozen=True, slots=True)
class Waypoints:
    """Up to six consecutive waypoints of a mission, as 16-byte records."""

    mission: int
    first: int
    records: tuple[bytes, ...]

    TYPE: ClassVar[MessageType] = MessageType.WAYPOINTS
    LAYOUT: ClassVar[Struct] = Struct("<IIBB")

    def pack(self) -> bytes:
        """The payload; LocalError for too many waypoints."""
        if not 1 <= len(self.records) <= WAYPOINTS_PER_FRAME:
            raise LocalError(
                f"{len(self.records)} waypoints in a frame: 1 to {WAYPOINTS_PER_FRAME} fit"
            )
        head = self.LAYOUT.pack(self.mission, self.first, len(self.records), 0)
        return head + b"".join(self.records)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload and check every record."""
        if len(payload) < cls.LAYOUT.size:
            raise RemoteError(f"WAYPOINTS of {len(payload)} bytes: at least {cls.LAYOUT.size}")
        mission, first, count, _flags = cls.LAYOUT.unpack_from(payload)
        if not 1 <= count <= WAYPOINTS_PER_FRAME:
            raise RemoteError(f"WAYPOINTS count {count}: must be in [1, {WAYPOINTS_PER_FRAME}]")
        if len(payload) != cls.LAYOUT.size + WAYPOINT_BYTES * count:
            raise RemoteError(f"WAYPOINTS of {len(payload)} bytes do not hold {count} waypoints")
        records = tuple(
            payload[at : at + WAYPOINT_BYTES]
            for at in range(cls.LAYOUT.size, len(payload), WAYPOINT_BYTES)
        )
        for record in records:
            Waypoint.unpack(record)
        return cls(mission, first, records)


@dataclass(frozen=True, slots=True)
class Start(PlainMessage):
    """Drive, from waypoint ``exec_next`` of ``mission``; ``command`` numbers the commands."""

    command: int
    mission: int
    exec_next: int

    TYPE: ClassVar[MessageType] = MessageType.START
    LAYOUT: ClassVar[Struct] = Struct("<HII")


@dataclass(frozen=True, slots=True)
class Pause(PlainMessage):
    """Stop under control and keep the queue."""

    command: int

    TYPE: ClassVar[MessageType] = MessageType.PAUSE
    LAYOUT: ClassVar[Struct] = Struct("<H")


@dataclass(frozen=True, slots=True)
class Clear(PlainMessage):
    """Stop under control, drop the queue; ``mission`` is the next one (0: none)."""

    command: int
    mission: int

    TYPE: ClassVar[MessageType] = MessageType.CLEAR
    LAYOUT: ClassVar[Struct] = Struct("<HI")


@dataclass(frozen=True, slots=True)
class ResetEstop(PlainMessage):
    """Leave the latched stop; obeyed only in a session younger than the stop."""

    command: int

    TYPE: ClassVar[MessageType] = MessageType.RESET_ESTOP
    LAYOUT: ClassVar[Struct] = Struct("<H")


@dataclass(frozen=True, slots=True)
class Lease:
    """Sign that the control loop is alive; with PERMIT the robot may drive for ``ttl_s``.

    ``ttl_s`` counts from ``issued_us`` of the robot's clock, modulo 2**32; ``pose_age_s`` is the
    pose's age then.
    """

    ttl_s: float
    flags: LeaseFlag
    pose_age_s: float = math.inf
    issued_us: int = 0

    TYPE: ClassVar[MessageType] = MessageType.LEASE
    LAYOUT: ClassVar[Struct] = Struct("<IHHB")

    def pack(self) -> bytes:
        """The payload; LocalError for a negative time."""
        ttl = clamped(self.ttl_s, 1e3, 0xFFFF)
        age = clamped(self.pose_age_s, 1e3, NO_POSE_MS)
        return self.LAYOUT.pack(self.issued_us, ttl, age, self.flags)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        issued_us, ttl, age, flags = unpack_exactly("LEASE", cls.LAYOUT, payload)
        if flags & ~3:
            raise RemoteError(f"LEASE flags {flags:#x}: only PERMIT and ODOMETRY are known")
        age_s = math.inf if age == NO_POSE_MS else age / 1e3
        return cls(ttl / 1e3, LeaseFlag(flags), age_s, issued_us)


@dataclass(frozen=True, slots=True)
class PoseFix:
    """The robot's pose by the camera at ``captured_us`` of the robot's clock, modulo 2**32."""

    x_m: float
    y_m: float
    heading_rad: float
    captured_us: int = 0

    TYPE: ClassVar[MessageType] = MessageType.POSE
    LAYOUT: ClassVar[Struct] = Struct("<iihI")

    def pack(self) -> bytes:
        """The payload; LocalError if a value does not fit."""
        x, y = to_um("x_m", self.x_m), to_um("y_m", self.y_m)
        return self.LAYOUT.pack(x, y, heading_to_wire(self.heading_rad), self.captured_us)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        x, y, wire_heading, captured_us = unpack_exactly("POSE", cls.LAYOUT, payload)
        heading = heading_from_wire(wire_heading)
        if heading is None:
            raise RemoteError("POSE without a heading")
        return cls(x / UM_PER_M, y / UM_PER_M, heading, captured_us)


@dataclass(frozen=True, slots=True)
class TimeSync(PlainMessage):
    """Question for the robot's clock; microseconds, modulo 2**32."""

    host_sent_us: int

    TYPE: ClassVar[MessageType] = MessageType.TIMESYNC
    LAYOUT: ClassVar[Struct] = Struct("<I")
